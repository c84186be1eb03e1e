"""Measures against theory: of parcels as of the particles that they stand for, and refused where no law is meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.case.load import load_case
from fbcouple.errors import CaseError
from fbcouple.paths import CASES
from fbcouple.results.reader import Results
from fbcouple.study.measures import Finished, find_error

HELD, BEAD = str(CASES / "studies/fixed-bed/case.toml"), str(CASES / "studies/single-particle/case.toml")
TIME = np.linspace(0.0, 0.2, 41)
TWO_SIZES = ("particles.count=100", "particles.mixture=[[2e-3, 1e8, 0.1]]", "particles.fractions=number")
SPREAD = ("particles.spread=normal", "particles.deviation=1e-4", "particles.smallest=8e-4", "particles.largest=1.2e-3")


def make(name: str, *sets: str) -> Finished:
    """A run with a pressure drop of 4 Pa, in which the solids' centre rises by 0.1 m/s."""
    histories = {"pressure_drop": ("time", np.full(41, 4.0)), "solids_centre_z": ("time", 0.02 + 0.1 * TIME)}
    return Finished(Results(Path("none"), xr.Dataset(histories, coords={"time": TIME}), {}), load_case(name, sets))


@pytest.mark.parametrize("sets", [(), ("particles.coarse_graining=2.0",), ("particles.parcels=128",)])
def test_a_held_bed_of_parcels_costs_the_pressure_of_its_particles(sets):
    """1024 spheres of 1 mm at 1.04 diameters, voidage 0.5345, are 128 parcels of 2 mm at the same voidage."""
    found = find_error("bed-pressure", make(HELD, *sets), None)
    assert found.expected == pytest.approx(3.7941066775679965, rel=1e-9)
    assert found.error == pytest.approx(4.0 / 3.7941066775679965 - 1.0)


def test_a_last_layer_that_is_not_full_counts_with_what_it_has():
    full = find_error("bed-pressure", make(HELD), None).expected
    fewer = find_error("bed-pressure", make(HELD, "particles.count=992"), None).expected
    lost = find_error("bed-pressure", make(HELD, "particles.count=512"), None).expected
    assert full - fewer == pytest.approx((full - lost) / 16, rel=1e-9)


@pytest.mark.parametrize("measure", ["terminal-velocity", "path"])
def test_a_parcel_falls_as_its_particles(measure):
    alone = make(BEAD), make(BEAD, "particles.count=8", "particles.coarse_graining=2.0")
    one, parcel = (find_error(measure, run, None) for run in alone)
    assert parcel.expected == pytest.approx(one.expected, rel=1e-9) and parcel.error == pytest.approx(one.error)


@pytest.mark.parametrize("sets", [TWO_SIZES, SPREAD])
@pytest.mark.parametrize("measure", ["bed-pressure", "terminal-velocity", "path"])
def test_several_sizes_are_refused_in_words(measure, sets):
    with pytest.raises(CaseError, match=rf"{measure}: the case has \d kinds of particles .* one is allowed"):
        find_error(measure, make(HELD, *sets), None)


def test_a_lattice_that_does_not_fill_the_floor_is_refused():
    run = make(HELD, "start.region=[[0.0, 0.004], [0.0, 0.008], [0.0, 0.0245]]", "particles.count=64")
    with pytest.raises(CaseError, match=r"bed-pressure needs a box .* without start.region"):
        find_error("bed-pressure", run, None)
