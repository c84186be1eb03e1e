"""Columns of the start lattice that friction holds upright, and what breaks them up."""

import pytest

from fbcouple.case.bed.stacks import LIFTED, LOOSE, stands_in_columns
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate


def find(*sets, name="patil/c2"):
    return {number.name: number for number in estimate(load_case(name, sets)) if number.name in (LIFTED, LOOSE)}


def test_gas_that_lifts_a_packed_bed_need_not_lift_the_columns_of_the_start():
    """U_mf is 0.56 m/s at a voidage of 0.40 and 1.09 at the 0.52 of the lattice."""
    lifted = find()[LIFTED]
    assert lifted.value == pytest.approx(1.093, abs=0.001) and lifted.verdict == "fit"
    standing = find("gas.inlet_velocity=1.0")[LIFTED]
    assert standing.verdict == "warn" and "particles.rotation = true" in standing.meaning


def test_a_bed_without_gas_that_goes_up_stands_as_it_starts():
    assert find("gas.inlet_velocity=0.0")[LOOSE].verdict == "warn"


@pytest.mark.parametrize(
    "sets",
    ["particles.rotation=true", "contact.friction=0.0", 'start.method="pour"', "particles.mass=1e-4", "gravity=0.0"],
)
def test_what_cannot_stand_is_not_asked(sets):
    assert not stands_in_columns(load_case("patil/c2", [sets]))
