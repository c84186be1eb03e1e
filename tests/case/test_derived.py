"""Derived and pre-flight numbers against those worked out by hand from the paper's equations."""

from __future__ import annotations

import pytest

from fbcouple.case.bed.derived import (
    cell_size,
    dem_step,
    open_velocity,
    pair_contact_time,
    particle_mass,
)
from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError
from fbcouple.physics.contact import normal_damping


def numbers_of(*sets: str, name: str = "patil/c2"):
    return {number.name: number for number in estimate(load_case(name, sets))}


def test_bed_counts():
    assert particle_count(load_case("patil/c2").particles) == 57296
    assert particle_count(load_case("patil/c2", ["particles.mass=0.125"]).particles) == 95493


def test_contact_of_glass_beads():
    case = load_case("patil/c2", ["contact.stiffness=1000"])
    mass = particle_mass(case.particles)
    assert pair_contact_time(case.contact, case.particles) == pytest.approx(8.04e-5, rel=1e-3)
    assert dem_step(case.contact, case.particles) == pytest.approx(8.0376e-5 / 6, rel=1e-4)
    assert 2 * normal_damping(1000.0, mass / 2, 0.97) == pytest.approx(757.9, abs=0.05)
    assert 2 * normal_damping(1000.0, mass, 0.97) == pytest.approx(535.9, abs=0.05)
    assert normal_damping(1000.0, mass, 1.0) == 0.0


@pytest.mark.parametrize(("name", "ratio"), [("c1", 1.2143), ("c2", 1.1053), ("c3", 1.1053)])
def test_open_faces_carry_the_closed_ones(name, ratio):
    case = load_case(f"patil/{name}")
    assert open_velocity(case) / 1.2 == pytest.approx(ratio, abs=5e-5)


def test_cell_size():
    assert cell_size(load_case("patil/c2")) == pytest.approx([0.08 / 35, 0.0025, 0.25 / 110])


@pytest.mark.parametrize(
    ("number", "value", "tolerance"),
    [
        ("particles", 57296, 0.0),
        ("cells", 23100, 0.0),
        ("minimum fluidization", 0.540, 5e-4),
        ("terminal velocity", 6.680, 5e-4),
        ("pressure drop", 612.8, 0.05),
        ("settled height", 0.0417, 5e-5),
        ("overlap", 0.05, 1e-4),
        ("fluid step", 1.5 * 0.25 / 110 / 3.0, 1e-12),
        ("open inlet velocity", 1.2 * 1.10526, 1e-4),
        ("cell size y", 2.5, 1e-12),
        ("bulk Reynolds number", 1.2 * 0.08 * 1.165 / 2e-5, 1e-9),
        ("DEM steps per contact", 6, 0.0),
    ],
)
def test_preflight_number(number, value, tolerance):
    assert numbers_of()[number].value == pytest.approx(value, abs=tolerance)


def test_gas_response_time_in_a_packed_bed():
    """A packed bed (eps 0.42) at 0.5 m/s loses 10815.99 Pa/m = n beta u/eps, so tau_g = eps rho U/(eps^2 dP/dz)."""
    numbers = numbers_of("gas.inlet_velocity=0.5")
    tau = 0.42 * 1.165 / (10815.99 * 0.42 / (0.5 / 0.42))
    assert numbers["fluid step"].value / numbers["fluid step/tau_g"].value == pytest.approx(tau, rel=1e-6)


@pytest.mark.parametrize(
    ("number", "setting", "verdict"),
    [
        ("minimum fluidization", "gas.inlet_velocity=0.5", "warn"),
        ("minimum fluidization", "gas.inlet_velocity=0.6", "fit"),
        ("terminal velocity", "gas.inlet_velocity=7", "warn"),
        ("DEM steps per contact", "contact.steps_per_contact=5", "warn"),
        ("overlap", "contact.stiffness=100", "warn"),
        ("overlap", "contact.stiffness=10", "unfit"),
        ("cell size x", "exchange.filter_passes=0", "warn"),
        ("cell size x", "domain.cells=[101, 6, 110]", "unfit"),
        ("fluid step/tau_g", "gas.max_courant=0.4", None),
    ],
)
def test_verdict(number, setting, verdict):
    assert numbers_of(setting)[number].verdict == verdict


@pytest.mark.parametrize(("courant", "verdict"), [("0.2", "fit"), ("0.4", "unfit")])
def test_explicit_drag_over_twice_the_response_time_is_unfit(courant, verdict):
    found = numbers_of("exchange.scheme=explicit", f"gas.max_courant={courant}")["fluid step/tau_g"]
    assert found.verdict == verdict


def test_numbers_that_cannot_be_calculated_are_told():
    with pytest.raises(CaseError, match="too large or too small to calculate with"):
        numbers_of("gas.density=1e308")


def test_a_scene_gets_only_its_numbers(tmp_path):
    text = 'title = "gas alone"\nend_time = 1.0\n[domain]\nsize = [1, 1, 1]\ncells = [4, 4, 4]\n'
    (tmp_path / "case.toml").write_text(f"{text}[gas]\ndensity = 1.2\nviscosity = 2e-5\ninlet_velocity = 1\n")
    numbers = numbers_of(name=str(tmp_path))
    assert list(numbers) == ["cells", "fluid step", "open inlet velocity"]
    assert numbers["fluid step"].value == pytest.approx(0.2 * 0.25)
