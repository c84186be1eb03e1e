"""Poured beds: of every shape and size of particles, the same each time, poured once, and told where they cannot be."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fbcouple.case.bed.particle_types import count_kinds, list_kinds
from fbcouple.case.bed.positions import start_kinds, start_positions
from fbcouple.case.bed.start_file import read_start
from fbcouple.case.load import load_case
from fbcouple.decks import starts
from fbcouple.decks.pour import pour
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.geometry.overlap import find_max_overlap

CASE = """
title = "a poured bed"
end_time = 0.01
[domain]
size = [0.006, 0.006, 0.02]
cells = [3, 3, 10]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.3
[particles]
diameter = 1e-3
density = 1000.0
count = 150
rotation = true
[contact]
stiffness = 50.0
restitution = 0.5
wall_restitution = 0.5
friction = 0.3
wall_friction = 0.3
[start]
method = "pour"
rest_speed = 5e-3
[exchange]
filter_passes = 1
"""


@pytest.fixture
def bed(tmp_path, monkeypatch):
    """Write the case, and load it with settings; poured beds are kept in the test's folder."""
    monkeypatch.setattr(starts, "cache_folder", lambda: tmp_path / "cache")
    (tmp_path / "case.toml").write_text(CASE)
    return lambda *sets: load_case(str(tmp_path), sets)


def set_up(tmp_path, name, *sets, told=None):
    (case,) = lay_out(str(tmp_path), tmp_path / name, sets, False, True, told).values()
    return case


def test_bed_is_poured_once_and_stands_alone(bed, tmp_path, monkeypatch):
    told: list[str] = []
    case = set_up(tmp_path, "one", told=told.append)
    (kept,) = (tmp_path / "cache/starts").iterdir()
    assert case.start is None and case.particles.positions == kept.name == (tmp_path / "one" / kept.name).name
    assert load_case(str(tmp_path / "one")) == case
    positions = start_positions(case, tmp_path / "one")
    assert len(positions) == 150 and positions[:, 2].max() < 0.01
    assert find_max_overlap(positions, np.full(150, 5e-4), 150) < 0.02
    assert "\nVelocities" not in (tmp_path / "one/DEM/particles.data").read_text()
    origin = json.loads((tmp_path / "one/manifest.json").read_text())["start"]
    assert origin.startswith(f"{kept.name}: poured bed of 150 particles at rest after") and origin[-20:] in told[1]

    monkeypatch.setattr(starts, "pour", lambda case, folder, say: pytest.fail("it was poured before"))
    other = set_up(tmp_path, "two", "gas.inlet_velocity=0.1", "end_time=0.02", told=told.append)
    assert other.particles == case.particles and "poured before" in told[-1]


@pytest.mark.parametrize(
    "setting", ["start.seed=2", "contact.friction=0.4", "domain.size=[0.006, 0.006, 0.03]", "particles.count=151"]
)
def test_what_a_bed_depends_on_makes_another(bed, tmp_path, setting):
    assert starts.expect_start(bed(), tmp_path) != starts.expect_start(bed(setting), tmp_path)


def test_gas_and_exchange_make_no_other_bed(bed, tmp_path):
    one, other = (starts.expect_start(case, tmp_path) for case in (bed(), bed("gas.inlet_velocity=0.1")))
    assert one.particles == other.particles


def test_same_case_gives_the_same_bed_to_the_last_bit(bed, tmp_path):
    one, other = (pour(bed("particles.count=40"), tmp_path).particles.positions for _ in range(2))
    assert (one == other).all()


HIGH = ("particles.count=400", "start.settle_limit=2")


def test_what_finds_no_room_at_once_is_poured_onto_the_rest(bed, tmp_path):
    """A bed that fills nearly half of its box, where random places fill a fifth."""
    poured = pour(bed(*HIGH), tmp_path)
    assert poured.parts > 1 and len(poured.particles.positions) == 400
    assert poured.particles.positions[:, 2].max() < 0.02 - 4e-4


def test_bed_may_reach_up_to_the_lid_and_not_beyond(bed, tmp_path):
    """The last particles rain in from above the lid, which the bed at rest has to fit under."""
    top = pour(bed(*HIGH), tmp_path).particles.positions[:, 2].max() + 5e-4
    low = f"domain.size=[0.006, 0.006, {top + 5e-4}]"
    made = starts.make_start(bed(*HIGH, low), tmp_path, tmp_path)
    assert top - 2e-3 < start_positions(made, tmp_path)[:, 2].max() < top + 1e-4
    with pytest.raises(CaseError, match=r"start.method: the poured bed: .* particles are not inside the box"):
        starts.make_start(bed(*HIGH, f"domain.size=[0.006, 0.006, {top - 1e-3}]"), tmp_path, tmp_path)


SPREAD = (
    'particles.spread="normal"',
    "particles.deviation=2e-4",
    "particles.smallest=7e-4",
    "particles.largest=1.3e-3",
)


@pytest.mark.parametrize(
    "sets",
    [
        ("particles.mixture=[[6e-4, 3000.0, 0.3]]",),
        (*SPREAD, "particles.classes=3"),
        ('domain.shape="cylinder"', "domain.cells=[4, 4, 8]"),
        ('domain.periodic=["x"]',),
    ],
    ids=["mixture", "spread", "cylinder", "periodic"],
)
def test_bed_of_every_kind_fits_its_case(bed, tmp_path, sets):
    case = bed(*sets)
    made = starts.make_start(case, tmp_path, tmp_path)
    kinds = start_kinds(made, tmp_path)
    assert np.bincount(kinds).tolist() == count_kinds(case.particles)
    radii = np.array([kind.diameter / 2 for kind in list_kinds(case.particles)])[kinds]
    assert find_max_overlap(start_positions(made, tmp_path), radii, len(radii)) < 0.03


def test_bed_over_its_periodic_sides_is_taken(bed, tmp_path):
    """One of its particles is at rest 27 um over a side, where LIGGGHTS had not brought it in yet."""
    size = ("domain.size=[0.004, 0.004, 0.02]", "domain.cells=[2, 2, 10]", 'domain.periodic=["x", "y"]')
    case = bed(*size, "particles.count=60", "start.seed=2")
    made = starts.make_start(case, tmp_path, tmp_path)
    positions, raw = start_positions(made, tmp_path), read_start(tmp_path / "cache/starts" / made.particles.positions)
    assert (positions >= 0.0).all() and (positions[:, :2] <= 0.004).all()
    over = (raw.positions < 0.0) | (raw.positions > [0.004, 0.004, 0.02])
    assert np.abs(positions - raw.positions)[over] == pytest.approx(0.004)
    assert (positions == raw.positions)[~over].all()


def test_bed_that_does_not_come_to_rest_in_time_is_told_and_nothing_is_written(bed, tmp_path):
    with pytest.raises(CaseError, match=r"start.settle_limit: the bed is not at rest after 0.01 s: its particles have"):
        set_up(tmp_path, "run", "start.settle_limit=0.01")
    assert not (tmp_path / "run").exists() and not (tmp_path / "cache").exists()


def test_check_does_not_pour(bed, tmp_path, monkeypatch):
    monkeypatch.setattr(starts, "pour", lambda case, folder, say: pytest.fail("check pours nothing"))
    told: list[str] = []
    case = bed()
    assert starts.make_start(case, tmp_path, tmp_path, told.append, pours=False) is case
    assert told == ["start: the bed is poured by `setup`, which checks what comes out"]


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        (("gravity=0",), 'start.method: "pour" is given and gravity is 0'),
        (("start.run=elsewhere",), 'start.method: "pour" is given and start.run too'),
        (
            ("start.region=[[0, 0.006], [0, 0.006], [0, 0.01]]",),
            r"start.region: is given, which the lattice alone fills",
        ),
        (("start.time=1",), r"start.time: 1 s is given and no start.run"),
        (("start.settle_limit=0",), r"start.settle_limit: 0.* above 0"),
        (("start.method=rain",), r'start.method: "rain" is given'),
    ],
)
def test_options_that_do_not_fit_are_told(bed, sets, told):
    with pytest.raises(CaseError, match=told):
        bed(*sets)
