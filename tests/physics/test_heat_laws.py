"""Laws of heat: Nusselt numbers by hand, the decay of a lone sphere, and the conductivity of beds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fbcouple.case.schema.heat import Heat
from fbcouple.physics.heat.conductivity import BED_CONDUCTIVITIES
from fbcouple.physics.heat.nusselt import NUSSELT_LAWS

GUNN, RANZ = NUSSELT_LAWS["gunn"], NUSSELT_LAWS["ranz-marshall"]
ZEHNER = BED_CONDUCTIVITIES["zehner-schlunder"]


def words(option: str) -> set[str]:
    return set(Heat.model_fields[option].annotation.__args__)


def test_every_law_has_a_word_and_every_word_a_law():
    assert words("nusselt") == {*NUSSELT_LAWS, "own"}
    assert words("bed_conduction") == set(BED_CONDUCTIVITIES)


@pytest.mark.parametrize(
    ("eps", "reynolds", "prandtl", "expected"),
    [
        # By hand: (7 - 10 eps + 5 eps^2)(1 + .7 Re^.2 Pr^(1/3)) + (1.33 - 2.4 eps + 1.2 eps^2) Re^.7 Pr^(1/3).
        (1.0, 0.0, 0.7, 2.0),
        (0.4, 0.0, 0.7, 3.8),
        (1.0, 1.0, 1.0, 3.53),
        (0.4, 100.0, 1.0, 3.8 * (1.0 + 0.7 * 2.5118864315) + 0.562 * 25.118864315),
        (0.5, 32.0, 0.8, 3.25 * (1.0 + 1.4 * 0.9283177667) + 0.43 * 2.0**3.5 * 0.9283177667),
    ],
)
def test_gunn_by_hand(eps, reynolds, prandtl, expected):
    assert GUNN(eps, reynolds, prandtl) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("reynolds", "prandtl", "expected"), [(0.0, 0.7, 2.0), (100.0, 1.0, 8.0), (64.0, 0.125, 2.0 + 0.6 * 8.0 * 0.5)]
)
def test_ranz_and_marshall_by_hand(reynolds, prandtl, expected):
    assert RANZ([0.4, 1.0], reynolds, prandtl) == pytest.approx([expected, expected], rel=1e-13)


SPHERES = [(0.051865, 999.06, 0.878612), (0.026, 1007.0, 0.542950)]


@pytest.mark.parametrize(("conductivity", "specific_heat", "rate"), SPHERES)
def test_rate_of_a_lone_sphere_in_a_stream(conductivity, specific_heat, rate):
    """3.6 mm, 8850 kg/m3, 55 J/(kg K) in air at 6 m/s: h A/(m cp), by hand."""
    diameter, viscosity = 3.6e-3, 1.8603e-5
    reynolds, prandtl = 1.1854 * 6.0 * diameter / viscosity, viscosity * specific_heat / conductivity
    coefficient = float(RANZ(1.0, reynolds, prandtl)) * conductivity / diameter
    assert 6.0 * coefficient / (8850.0 * 55.0 * diameter) == pytest.approx(rate, rel=2e-6)


def test_bed_of_steel_in_air():
    """Beaulieu's bed: 42 and 0.027 W/(m K) at voidage 0.42, worked out by hand with ten digits."""
    shape = 1.25 * (0.58 / 0.42) ** (10.0 / 9.0)
    ratio = 42.0 / 0.027
    n = 1.0 - shape / ratio
    inner = shape / n**2 * (1.0 - 1.0 / ratio) * math.log(ratio / shape) - (shape + 1.0) / 2.0 - (shape - 1.0) / n
    by_hand = 0.027 * (1.0 - math.sqrt(0.58) + math.sqrt(0.58) * 2.0 / n * inner)
    found = float(ZEHNER(np.array([0.42]), 0.027, 42.0)[0])
    assert found == pytest.approx(by_hand, rel=1e-12)
    assert found == pytest.approx(0.42, abs=0.01)


@pytest.mark.parametrize("voidage", [0.2, 0.36, 0.5, 0.9, 1.0])
def test_particles_of_the_gas_conduct_as_the_gas(voidage):
    assert ZEHNER(np.array([voidage]), 0.3, 0.3) == pytest.approx([0.3], rel=1e-12)


def test_gas_alone_has_its_own_conductivity():
    voidage = np.array([1.0, np.nextafter(1.0, 2.0), 1.0 - 1e-9])
    assert ZEHNER(voidage, 0.026, 1.4) == pytest.approx(0.026, rel=1e-3)
    assert BED_CONDUCTIVITIES["none"](voidage, 0.026, 1.4) == pytest.approx(0.026 * voidage)


def test_closed_form_and_series_meet():
    """Where particles conduct as B times the gas the closed form is 0/0; it goes through there smoothly."""
    shape = 1.25 * (0.6 / 0.4) ** (10.0 / 9.0)
    ratios = shape / (1.0 - np.linspace(-0.2, 0.2, 4001))
    values = np.array([ZEHNER(np.array([0.4]), 1.0, float(ratio))[0] for ratio in ratios])
    assert np.isfinite(values).all()
    steps = np.diff(values)
    assert np.abs(np.diff(steps)).max() < 1e-6 and (steps > 0).all()
