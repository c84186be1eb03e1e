"""What the schema cannot see: parts that do not fit together, and the bounds of box and machine."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.bed.positions import start_positions
from fbcouple.case.checks import bed as bed_checks
from fbcouple.case.checks.registry import find_problems
from fbcouple.case.load import load_case
from fbcouple.case.schema.output import Output
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError


def change(case: Case, **sections: object) -> Case:
    """Copy a case with whole sections, or keys of sections (a dict), replaced."""
    new = {
        name: getattr(case, name).model_copy(update=value) if isinstance(value, dict) else value
        for name, value in sections.items()
    }
    return case.model_copy(update=new)


@pytest.fixture(scope="module")
def good() -> Case:
    """The shipped case without its snapshots and frames, which another case could not have."""
    return load_case("patil/c2").model_copy(update={"output": Output()})


def test_good_case_has_no_problems(good):
    assert find_problems(good) == []


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ({"gas": None, "particles": None, "contact": None, "start": None, "exchange": None}, "gas: neither [gas] nor"),
        ({"gas": None}, "exchange: there is nothing to couple; remove [exchange] or add [gas]"),
        ({"exchange": None}, "exchange: gas and particles need [exchange]"),
        ({"contact": None}, "contact: particles need [contact]"),
        ({"start": None}, "start: particles need a start"),
        ({"particles": None, "exchange": None, "start": None}, "contact: there are no particles; remove [contact]"),
        ({"particles": {"mass": None}}, "particles.mass: neither mass nor count"),
        ({"particles": {"count": 3}}, "particles.mass: mass and count are both given"),
        ({"particles": {"mass": 1e-9}}, "particles.mass: the mass is less than that of half a particle"),
        ({"particles": {"diameter": 0.016}}, "particles.diameter: 0.016 m is given, but the box is 0.015 m along y"),
        ({"particles": {"mass": 0.481}}, "0.64 of its volume holds 366692 (0.48 kg)"),
        ({"particles": {"mass": 0.4}}, "start.spacing: 1.03 is given; the lattice of 77 x 14 sites is 0.2925 m high"),
        (
            {"gas": {"closed_nozzle": (4, 4)}},
            "gas.closed_nozzle: [4, 4] is given on a floor of 35 x 6 faces and cannot",
        ),
        ({"gas": {"closed_nozzle": (35, 6)}}, "leaves no face open"),
        ({"gas": {"closed_nozzle": (37, 4)}}, "give 1, 3, ... 35 along x and 2, 4, 6 along y"),
        ({"gas": {"top": "closed"}}, "gas.inlet_velocity: gas comes in and gas.top is closed; give 0 or open the top"),
        (
            {"gas": {"top": "closed", "inlet_velocity": None, "inlet_ramp": ((0.0, 0.0), (1.0, -0.1))}},
            "gas.inlet_ramp: gas comes in and gas.top is closed",
        ),
        ({"gas": {"inlet_velocity": None}}, "gas.inlet_velocity: neither it nor inlet_ramp is given"),
        ({"gas": {"inlet_ramp": ((0.0, 1.0),)}}, "gas.inlet_velocity: it and inlet_ramp are both given"),
        (
            {"gas": {"inlet_velocity": None, "inlet_ramp": ((0.0, 1.0), (2.0, 1.0), (1.0, 3.0))}},
            "gas.inlet_ramp: row 3 is at 1 s, before the last",
        ),
        (
            {"gas": {"inlet_velocity": None, "inlet_ramp": ((0.0, 1.0), (0.0, 2.0), (0.0, 3.0))}},
            "gas.inlet_ramp: row 2 is at 0 s, as are two more than the last; order the rows by time, two at most",
        ),
        ({"domain": {"periodic": ("x", "x")}}, 'domain.periodic: ["x", "x"] is given; name each axis once'),
        (
            {"domain": {"periodic": ("x", "y")}, "particles": {"diameter": 6.4e-3}},
            "domain.periodic: y is given, and the box is 0.015 m along it, at least 0.016 m is allowed (2.5 diameters)",
        ),
        ({"averages": {"start": 20.0}}, "averages.start: 20 s is given and the run ends at 20 s"),
        ({"averages": {"every": 2.0}}, "averages.every: 2 s is given, at most 1.9 s is allowed"),
        ({"averages": {"start": 19.99}}, "averages.every: 0.002 s is the default, at most 0.001 s is allowed"),
        ({"exchange": {"drag": "huilin"}}, 'exchange.drag: "huilin" is given, allowed are: '),
        ({"domain": {"cells": (10_001, 1_000, 1_000)}, "gas": {"closed_nozzle": None}}, "domain.cells: 1e+10 cells"),
        ({"particles": {"diameter": 1e-5}}, "particles.mass: 5.73e+10 particles need about 3.44e+04 GB, at most 2e+09"),
        ({"particles": {"diameter": 1e-200}}, "too large or too small to calculate with"),
        ({"contact": {"stiffness": 1e40}}, "contact.stiffness: 1e+40 N/m gives a DEM step of"),
    ],
)
def test_parts_that_do_not_fit_together(good, sections, words):
    (problem,) = find_problems(change(good, **sections))
    assert words in problem


def test_unknown_drag_law_is_suggested(good):
    (problem,) = find_problems(change(good, exchange={"drag": "huilin-gidaspov"}))
    assert "did you mean `huilin-gidaspow`" in problem


def test_memory_is_refused_with_the_estimate(good, monkeypatch):
    monkeypatch.setattr(bed_checks, "machine_memory", lambda: 100_000_000)
    (problem,) = find_problems(good)
    assert "domain.cells: 2.31e+04 cells and 5.73e+04 particles need about 0.411 GB, this machine has 0.1 GB" in problem


def test_largest_bed_that_fits_the_box_passes(good):
    """The lattice of 77 x 14 x 242 sites is 0.24926 m high: one more layer would be 0.25029 m."""
    fits = 77 * 14 * 242
    assert find_problems(change(good, particles={"mass": None, "count": fits})) == []
    (problem,) = find_problems(change(good, particles={"mass": None, "count": fits + 1}))
    assert problem.startswith("start.spacing")


def write_positions(folder, rows, header="x,y,z"):
    (folder / "seed.csv").write_text("\n".join([header, *rows]) + "\n")


def seeded(good, count=2, name="seed.csv"):
    return change(good, start=None, particles={"mass": None, "count": count, "positions": name})


def test_positions_file_is_read(good, tmp_path):
    write_positions(tmp_path, ["1,0.04,0.001,0.0005", "2,0.05,0.002,0.0005"], header="name, x, z, y")
    case = seeded(good)
    assert find_problems(case, tmp_path) == []
    np.testing.assert_array_equal(start_positions(case, tmp_path), [[0.04, 0.0005, 0.001], [0.05, 0.0005, 0.002]])


@pytest.mark.parametrize(
    ("rows", "header", "words"),
    [
        (["0.04,0.001,0.001"], "x,y,z", "holds 1 particles and the case 2"),
        (["0.04,0.001,0.001", "0.09,0.001,0.001"], "x,y,z", "1 particles are not inside the box, first is particle 2"),
        (["0.04,0.001,0.001", "0.04,0.0001,0.01"], "x,y,z", "not inside the box"),
        (["0.04,0.001,0.001", "0.04,nan,0.01"], "x,y,z", "line 3 has `nan` for y; give a finite number"),
        (["0.04,0.001,0.001", "0.04,a,0.01"], "x,y,z", "line 3 has `a` for y; give a number"),
        (["0.04,0.001,0.001", "0.04"], "x,y,z", "line 3, `0.04`, has 1 columns and the header, `x,y,z`, 3"),
        ([], "x,y,z", "holds no particles"),
        (["0.04,0.001,0.001"], "x,y,w", "line 1, `x,y,w`, has no column z"),
    ],
)
def test_positions_file_that_is_wrong(good, tmp_path, rows, header, words):
    write_positions(tmp_path, rows, header)
    (problem,) = find_problems(seeded(good), tmp_path)
    assert problem.startswith("particles.positions: seed.csv") and words in problem


@pytest.mark.parametrize(
    "name", ["../seed.csv", "/etc/seed.csv", "a/seed.csv", "..", "a\\seed.csv", "case.toml", "\0.csv"]
)
def test_positions_file_must_lie_beside_the_case(good, tmp_path, name):
    (problem,) = find_problems(seeded(good, name=name), tmp_path)
    assert "the bare name of a .csv, .dump, .liggghts, .lammpstrj, .data or .restart file is allowed" in problem


def test_positions_file_must_exist(good, tmp_path):
    (problem,) = find_problems(seeded(good), tmp_path)
    assert "No such file" in problem


def test_positions_exclude_the_lattice(good, tmp_path):
    write_positions(tmp_path, ["0.04,0.001,0.001", "0.05,0.001,0.001"])
    (problem,) = find_problems(change(seeded(good), start=good.start), tmp_path)
    assert problem.startswith("start: particles.positions says")


def test_wrong_keys_do_not_hide_other_checks(tmp_path):
    sets = ["particles.diameter=-1", "averages.start=30", "gas.closed_nozzle=[36, 6]"]
    with pytest.raises(CaseError) as caught:
        load_case("patil/c2", sets)
    assert [problem.split(": ")[1] for problem in caught.value.problems] == [
        "particles.diameter",
        "gas.closed_nozzle",
        "averages.start",
    ]
