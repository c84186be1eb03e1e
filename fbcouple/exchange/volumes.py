"""The volumes of cells, where amounts become values per volume and the other way round."""

from __future__ import annotations

import numpy as np

from fbcouple.exchange.compiled import compiled
from fbcouple.exchange.momentum import find_loss, spread_over_volume


class EqualVolumes:
    """Cells of one `volume` [m3]."""

    def __init__(self, volume: float) -> None:
        self._volume = volume

    def find_voidage(self, solids: np.ndarray, voidage: np.ndarray) -> None:
        """Set `voidage` (cells,) from the volumes of solids (cells, 1) [m3]."""
        np.subtract(1.0, solids[:, 0] / self._volume, out=voidage)

    def spread(self, rows: np.ndarray, coefficient: np.ndarray, source: np.ndarray) -> None:
        """K (cells,) and S (cells, 3) from the `rows` (cells, 4) of beta~ and beta~ v."""
        spread_over_volume(rows, self._volume, coefficient, source)

    def find_loss(self, gas: np.ndarray, given: tuple[np.ndarray, ...], push: float, lift: float) -> np.ndarray:
        """Force [N], (3,), that the gas (cells, 6) of these cells gave up; `given`: voidage, K and S of its step."""
        loss = np.zeros(3)
        voidage, coefficient, source = given
        find_loss(gas, voidage, coefficient, source, push, lift, loss)
        return self._volume * loss


class OwnVolumes:
    """Cells of their own `volumes` (cells,) [m3]; as EqualVolumes."""

    def __init__(self, volumes: np.ndarray) -> None:
        self._volumes = volumes

    def find_voidage(self, solids: np.ndarray, voidage: np.ndarray) -> None:
        np.subtract(1.0, solids[:, 0] / self._volumes, out=voidage)

    def spread(self, rows: np.ndarray, coefficient: np.ndarray, source: np.ndarray) -> None:
        _spread(rows, self._volumes, coefficient, source)

    def find_loss(self, gas: np.ndarray, given: tuple[np.ndarray, ...], push: float, lift: float) -> np.ndarray:
        loss = np.zeros(3)
        voidage, coefficient, source = given
        _find_loss(gas, voidage, coefficient, source, self._volumes, push, lift, loss)
        return loss


Volumes = EqualVolumes | OwnVolumes


@compiled
def _spread(rows, volumes, coefficient, source):
    for n in range(len(rows)):
        coefficient[n] = rows[n, 0] / volumes[n]
        for axis in range(3):
            source[n, axis] = rows[n, 1 + axis] / volumes[n]


@compiled
def _find_loss(gas, voidage, coefficient, source, volumes, push, lift, loss):
    """Add up V (K u - S - push alpha grad P + alpha lift)."""
    for n in range(len(voidage)):
        solids = push * (1.0 - voidage[n])
        for axis in range(3):
            weight = (1.0 - voidage[n]) * lift if axis == 2 else 0.0
            density = coefficient[n] * gas[n, axis] - source[n, axis] - solids * gas[n, 3 + axis] + weight
            loss[axis] += volumes[n] * density
