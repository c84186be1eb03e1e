"""What the case of a measured bed cannot give is told before it is run."""

from __future__ import annotations

from dataclasses import replace

import pytest
from click.testing import CliRunner

from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.results.variables import HISTORIES
from fbcouple.validate.ahead import NEEDED, find_lacks
from fbcouple.validate.comparisons import COMPARISONS
from fbcouple.validate.runs import require_gives
from fbcouple.validate.source import list_beds, read_bed

BED = """
title = "A bed"
end_time = 20.0
[domain]
size = [0.08, 0.016, 0.2]
cells = [20, 4, 50]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_ramp = [[0.0, 0.0], [10.0, 1.2], [20.0, 0.0]]
[particles]
diameter = 1e-3
density = 2500.0
count = 40000
[contact]
stiffness = 500.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
[averages]
start = 1.0
[output]
references = ["solids_velocity@0.025=line.csv"]
"""
LINES = ["velocity", "velocity, right half"]
SPANS = ["height", "pulses", "beat"]
RAMPS = ["ramp", "ramp in time"]


@pytest.fixture
def lay(write):
    """Write the measured bed with a case that can be run, with texts of it replaced; returns its folder."""

    def lay_bed(*changes: tuple[str, str]):
        folder, text = write(), BED
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (folder / "case.toml").write_text(text)
        return folder

    return lay_bed


def test_everything_that_can_be_compared_says_what_it_needs():
    compared = {name for one in COMPARISONS.values() if isinstance(one.of, dict) for name in one.of} - {
        "species_centre_z"
    }
    assert {*HISTORIES, *compared} <= set(NEEDED)


@pytest.mark.parametrize("name", list_beds())
def test_shipped_beds_give_what_they_are_compared_with(name):
    assert find_lacks(read_bed(name), load_case(name)) == {}


def test_a_bed_that_gives_all_lacks_nothing(lay):
    folder = lay()
    assert find_lacks(read_bed(str(folder)), load_case(str(folder))) == {}


RAMP = "inlet_ramp = [[0.0, 0.0], [10.0, 1.2], [20.0, 0.0]]"
AVERAGES = "[averages]\nstart = 1.0\n"


@pytest.mark.parametrize(
    ("old", "new", "lacking", "told"),
    [
        (RAMP, "inlet_velocity = 1.2", RAMPS, "inlet_velocity is compared, and the case has not a ramp of the inlet"),
        (AVERAGES, "", [*LINES, *SPANS], "solids_velocity@0.0250 is a time mean, and the case has no [averages]"),
    ],
)
def test_what_a_case_lacks_is_told(lay, old, new, lacking, told):
    bed = read_bed(str(lay()))
    found = find_lacks(bed, load_case(str(lay((old, new)))))
    assert [*found] == lacking and told in next(iter(found.values()))


@pytest.mark.parametrize(
    ("setting", "lacking", "told"),
    [
        ("end_time=7.0", RAMPS, "it is of the times 2 to 8 s of the run, which ends at 7 s; let it run longer"),
        ("output.record_every=0.6", SPANS, "gives 31 rows in 1 to 20 s, and 40 are needed; record more often"),
    ],
)
def test_what_a_changed_case_lacks_is_told_and_the_rest_compared(lay, setting, lacking, told):
    said: list[str] = []
    require_gives(read_bed(str(lay())), [setting], said.append)
    assert [words.split(": ")[1] for words in said] == lacking and told in said[0]
    assert all(words.startswith("not compared: ") for words in said)


def test_a_run_that_nothing_can_be_compared_with_is_not_made(lay):
    bed = read_bed(str(lay()))
    ramps = replace(bed, tasks=bed.tasks[-len(RAMPS) :])
    with pytest.raises(CaseError, match=r"--set: ramp: .* ends at 7 s; .*: nothing is left to compare with") as caught:
        require_gives(ramps, ["end_time=7.0"], print)
    assert len(caught.value.problems) == len(RAMPS)


def test_a_bed_whose_own_case_lacks_something_is_refused_before_anything_is_written(lay, tmp_path):
    folder = lay((RAMP, "inlet_velocity = 1.2"))
    done = CliRunner().invoke(cli, ["validate", str(folder), "-o", str(tmp_path / "out")])
    assert done.exit_code == 1 and not (tmp_path / "out").exists()
    assert "measurements (ramp): inlet_velocity is compared, and the case has not a ramp of the inlet" in done.stderr
    assert len(done.stderr.splitlines()) == 2


SECTION = """
[[measurements]]
name = "bubbles"
compare = "bubbles"
of = "cut"
value = 0.02
"""


def test_bubbles_want_a_section(lay):
    folder = lay()
    with (folder / "validation.toml").open("a") as file:
        file.write(SECTION)
    (lack,) = find_lacks(read_bed(str(folder)), load_case(str(folder))).values()
    assert lack == "cut is no set of output.probes with a height and the voidage; give the case such a set"
    probe = 'output.probes=[{name="cut", every=0.01, quantities=["voidage"], height=0.02}]'
    assert find_lacks(read_bed(str(folder)), load_case(str(folder), [probe])) == {}
