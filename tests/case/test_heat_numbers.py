"""What cells add to conduction by particles that they share, and a constant density leaves out, told before a run."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate

HEAT = [
    *("heat.gas_temperature=293.15", "heat.gas_specific_heat=1010.0", "heat.gas_conductivity=0.026"),
    *("heat.particle_temperature=363.15", "heat.particle_specific_heat=840.0", "heat.particle_conductivity=1.4"),
]
CONDUCTING = [*HEAT, "heat.bed_conduction=zehner-schlunder"]
NAME = "conduction by sharing"


def find(sets, name=NAME):
    return {number.name: number for number in estimate(load_case("patil/c1", sets))}.get(name)


def test_only_beds_that_conduct_are_told():
    assert find([]) is None and find(HEAT) is None
    assert find([*HEAT, "heat.contact_conduction=liggghts"]) is not None


def test_a_particle_in_one_cell_adds_nothing():
    number = find([*CONDUCTING, "exchange.voidage=centre", "exchange.filter_passes=0"])
    assert number.value == 0.0 and number.verdict == "fit"


@pytest.mark.parametrize(("passes", "part"), [(0, 1.0 / 6.0), (2, 1.0 / 6.0 + 1.0)])
def test_shared_particles_add_by_the_square_of_the_cell(passes, part):
    """n h A dx^2 over k, with n h A = 6 (0.6/d^2) 3.8 k; the longest edge of the cells is 5 mm, across the depth."""
    number = find([*CONDUCTING, f"exchange.filter_passes={passes}"])
    assert number.value == pytest.approx(6.0 * 0.6 * 3.8 * 25.0 * part, rel=1e-12)
    assert number.verdict == "warn"


@pytest.mark.parametrize(
    ("spread", "part"),
    [
        (["exchange.voidage=gaussian", "exchange.kernel_width=3.0"], 4.5),
        (["exchange.voidage=centre", "exchange.diffusion_width=3.0"], 4.5),
        (["exchange.voidage=divided"], 0.05),
    ],
    ids=["gaussian", "diffusion", "divided"],
)
@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_parcels_are_shared_by_their_own_diameter(spread, part, ratio):
    """Their widths are in diameters of parcels, what they give and take is that of grains: l^2 times the number."""
    parcels = [] if ratio == 1.0 else [f"particles.coarse_graining={ratio:g}"]
    number = find([*CONDUCTING, "exchange.filter_passes=0", *spread, *parcels])
    assert number.value == pytest.approx(6.0 * 0.6 * 3.8 * part * ratio**2, rel=1e-12)


def test_the_limit_is_a_tenth_of_the_conductivity_of_the_bed():
    """Of 0.026 and 1.4 W/(m K) at voidage 0.4 the bed has 7.282 times the conductivity of the gas, by hand."""
    assert float(find(CONDUCTING).limit.removeprefix("at most ")) == pytest.approx(0.1 * 7.282, abs=6e-4)


@pytest.mark.parametrize(
    ("settings", "expected", "verdict"),
    [
        ([], 293.15 / 363.15, "warn"),
        (["heat.particle_temperature=293.15", "heat.wall_temperature=300.0"], 293.15 / 300.0, "fit"),
        (["heat.wall_temperature=200.0"], 293.15 / 200.0, "warn"),
    ],
)
def test_density_of_the_gas_at_the_farthest_temperature(settings, expected, verdict):
    number = find([*HEAT, *settings], "density of warm gas")
    assert number.value == pytest.approx(expected, rel=1e-12) and number.verdict == verdict
    assert find([], "density of warm gas") is None


def test_what_is_fed_and_what_a_file_says_of_the_start_may_be_the_farthest(tmp_path):
    feed = "particles.feeds=[{low=[0.0,0.0,0.2],high=[0.08,0.015,0.24],rate=100.0,temperature=900.0}]"
    number = find([*HEAT, feed], "density of warm gas")
    assert number.value == pytest.approx(293.15 / 900.0, rel=1e-12) and number.verdict == "warn"
    (tmp_path / "bed.csv").write_text("x,y,z,temperature\n0.02,0.007,0.01,300\n0.03,0.007,0.01,600\n")
    text = 'base = "patil/c1"\nunset = ["particles.mass", "start"]\n[particles]\npositions = "bed.csv"\ncount = 2\n'
    (tmp_path / "case.toml").write_text(text)
    numbers = estimate(load_case(str(tmp_path / "case.toml"), HEAT), folder=tmp_path)
    (number,) = (one for one in numbers if one.name == "density of warm gas")
    assert number.value == pytest.approx(293.15 / 600.0, rel=1e-12)


def test_the_density_of_a_liquid_is_not_that_of_an_ideal_gas():
    assert find([*HEAT, "gas.density=1000.0"], "density of warm gas") is None


def test_an_ideal_gas_fluidizes_as_warm_as_the_particles_make_it():
    ideal = [*HEAT, 'heat.gas_density="ideal"', "heat.particle_temperature=586.3"]
    cold, warm = find(HEAT, "minimum fluidization"), find(ideal, "minimum fluidization")
    assert cold.limit == "below U_f = 1.2" and warm.limit == "below U_f = 2.4"
    assert warm.meaning.endswith("gas that is as warm as the particles at the start.")
    thin = find([f"gas.density={1.165 / 2.0}"], "minimum fluidization")
    assert warm.value == pytest.approx(thin.value, rel=1e-9) and warm.value > cold.value
    assert find(ideal, "DEM step").value < 0.7 * find(HEAT, "DEM step").value
    assert find(ideal, "fluid step").value == pytest.approx(0.5 * find(HEAT, "fluid step").value, rel=1e-6)
