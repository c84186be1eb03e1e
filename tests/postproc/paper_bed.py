"""Results of the paper's beds with analytic means, so that every claim and number about them is known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.linalg import hadamard

from fbcouple.case.load import load_case, write_case
from fbcouple.results.block_means import lay_out_blocks

BLOCKS = 16
DENSITY = 2500.0
MOST = 0.1


def write_bed(run: Path, name: str, sets: tuple[str, ...] = (), **shape: float) -> Path:
    """RUN with the case `patil/NAME` and results of `synthesize`; returns RUN."""
    case = load_case(f"patil/{name}", sets)
    run.mkdir()
    write_case(case, run / "case.toml")
    data = synthesize(case.domain.cells, case.domain.size, **shape)
    data.attrs["case"] = (run / "case.toml").read_text()
    data.to_netcdf(run / "results.nc")
    return run


def synthesize(
    cells: tuple[int, int, int],
    size: tuple[float, float, float],
    height: float = 0.0625,
    unrest: float = 0.06,
    wall_flux: float = -20.0,
    wall_solids: float = 0.5,
    freeboard: float = 0.0,
    agitation: float = 0.1,
    peak: float = 0.0625,
    end: float = 20.0,
    noise: float = 1e-3,
) -> xr.Dataset:
    """Solids up to `height`, denser along the side walls; flux up in the middle; agitation peaks at z = `peak`."""
    x, y, z = ((np.arange(n) + 0.5) * length / n for n, length in zip(cells, size, strict=True))
    above, _, across = np.meshgrid(z, y, x, indexing="ij")
    near = np.minimum(across, size[0] - across) < 5e-3
    solids = np.where(above < height, np.where(near, wall_solids, 0.4), freeboard)
    upward = np.where(near, wall_flux, 5.0) * (above < height)
    time = np.linspace(0.01, end, 2000)
    swing = np.sqrt(2.0) * unrest * np.sin(40.0 * time)
    mean, vector = ("z", "y", "x"), ("component", "z", "y", "x")
    zero = np.zeros_like(upward)
    beating = agitation * np.exp(-(((above - peak) / 0.03) ** 2))
    blocks = lay_out_blocks(range(BLOCKS), [100] * BLOCKS, _make_rows(solids, upward, beating, noise))
    return xr.Dataset(
        {
            "solids_fraction": (mean, solids),
            "solids_fraction_stderr": (mean, np.full_like(solids, noise)),
            "solids_flux": (vector, np.stack([zero, zero, upward])),
            "solids_flux_stderr": (vector, np.full((3, *upward.shape), noise)),
            "agitation": (mean, beating),
            "agitation_stderr": (mean, np.full_like(solids, noise * agitation)),
            "bed_height": ("time", height * (1.0 + 0.5 * swing)),
            "solids_centre_z": ("time", 0.5 * height * (1.0 + swing)),
        }
        | blocks,
        coords={"x": x, "y": y, "z": z, "component": ["x", "y", "z"], "time": time},
        attrs={"averaging_start": 1.0, "averaging_end": end, "complete": 1},
    )


def _make_rows(solids: np.ndarray, upward: np.ndarray, agitation: np.ndarray, noise: float) -> Iterator[np.ndarray]:
    """Blocks above and below the means, wherever solids are, and so far that the means err by `noise`: solids, by
    `MOST` at the most, together everywhere, and flux and agitation layer by layer on their own."""
    zero, mass = np.zeros_like(upward), DENSITY * solids
    signs = hadamard(BLOCKS)[1 + np.arange(len(solids)) % (BLOCKS - 1)]
    for number in range(BLOCKS):
        sign = np.where(solids > 0.0, np.sqrt(BLOCKS - 1.0) * signs[:, number, None, None], 0.0)
        flux = upward + noise * sign
        energy = np.divide(flux**2, mass, out=np.zeros_like(mass), where=mass > 0.0)
        energy += mass * agitation * (1.0 + noise * sign)
        together = np.where(solids > 0.0, np.sqrt(BLOCKS - 1.0) * signs[0, number], 0.0)
        yield np.array([solids + min(noise, MOST) * together, mass, zero, zero, flux, energy]).mean(axis=2)
