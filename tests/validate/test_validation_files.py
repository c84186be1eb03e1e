"""What is wrong with a validation.toml is told in words, all of it at once, before anything is run."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.validate.source import read_bed

TOML = "validation.toml"


@pytest.mark.parametrize(
    ("file", "old", "new", "told"),
    [
        (TOML, 'cost = "nothing"', "", "validation.toml: cost: is missing; add `cost = ...` at the top of the file"),
        (TOML, "wanted = 0.4", "wants = 0.4", r"measurements.wants: \[\[measurements\]\] has no such key.*`wanted`"),
        (
            TOML,
            "wanted = 0.4",
            "wanted = 0.0",
            r"measurements.wanted: \[\[measurements\]\] 1: 0.0 is given, a number above 0 is allowed",
        ),
        (TOML, '"fluctuation"', '"fluctuations"', r"\(pulses\).compare: .* did you mean `fluctuation`"),
        (TOML, 'of = "bed_height"', 'of = "bed_heigth"', r"\(height\).of: .* did you mean `bed_height`"),
        (TOML, "velocity@0.0250", "velocity@0.26", r"\(velocity\).of: .* no line of the case's output.references"),
        (TOML, "solids_velocity@0.0250", "speed@0.02", r"\(velocity\).of: `speed` in `speed@0.02` is given, allowed"),
        (TOML, "[0.04, 0.08]", "[0.08, 0.04]", r"span: \[0.08, 0.04\] is given; give the lower end first"),
        (
            TOML,
            "[0.04, 0.08]",
            "[0.071, 0.08]",
            "no measured point lies in 0.071 to 0.08 m, they are from 0.01 to 0.07",
        ),
        (TOML, "value = 20.0", "", r'\(pulses\).value: is missing; compare = "fluctuation" needs it'),
        (TOML, "value = 20.0", "value = 20.0\norigin = 1.0", r"\(pulses\).origin: .* does not take it"),
        (TOML, 'name = "beat"', 'name = "pulses"', r"\(pulses\).name: two measurements have this name"),
        (TOML, 'file = "ramp.csv"', 'file = "../ramp.csv"', r"\(ramp in time\): .* the bare name of a .csv file"),
        (TOML, 'file = "ramp.csv"', 'file = "rump.csv"', r"\(ramp in time\): rump.csv cannot be read"),
        (
            TOML,
            'of = "velocity"',
            'of = "velocitie"',
            r"peers \(Another code, velocitie\).of: .* did you mean `velocity`",
        ),
        (
            TOML,
            "value = 0.085",
            "value = 0.085\nrms = 0.1",
            r"value, rms is given; give file, value or rms, one of them",
        ),
        (TOML, "value = 0.085", 'file = "peer.csv"', r"\).file: the measurement is one number; give `value`, or `rms`"),
        (TOML, "rms = 0.25", "value = 0.25", r"\).value: the measurement is several points; give `file`, or `rms`"),
        (TOML, "rms = 0.25", 'file = "line.csv"', "line.csv: line 1, `x,value,error`, has no column time"),
        (
            "peer.csv",
            "0.01,0.8\n0.07,1.4",
            "0.071,0.8\n0.08,1.4",
            "peer.csv has no two points with a measured one between",
        ),
        ("ramp.csv", "time [ms]", "time [h]", r"ramp.csv: .*gives time in `h`; units that are read: s, ms"),
        ("ramp.csv", "0,0.24", "0,0,24", "line 2, `0,0,24`, has 3 columns"),
        ("line.csv", "0.01,0.6,0.1", "0.01,0.6,-0.1", "line.csv holds an error below zero"),
        (
            "case.toml",
            "solids_velocity@0.025",
            "solids_volocity@0.025",
            "`solids_volocity` in .* is given, allowed are",
        ),
    ],
)
def test_mistakes_are_told(write, file, old, new, told):
    with pytest.raises(CaseError, match=told):
        read_bed(str(write(file, old, new)))


def test_all_mistakes_are_told_at_once(write):
    folder = write(TOML, 'of = "bed_height"', 'of = "height"')
    path = folder / TOML
    path.write_text(path.read_text().replace("[0.04, 0.08]", "[0.9, 1.0]").replace("rms = 0.25", ""))
    with pytest.raises(CaseError) as caught:
        read_bed(str(folder))
    assert len(caught.value.problems) == 3


def test_files_of_a_base_are_found_beside_it(write, tmp_path):
    other = tmp_path / "variant"
    other.mkdir()
    (other / "case.toml").write_text('base = "../bed/case.toml"\ntitle = "A variant"\n')
    (other / TOML).write_text((write() / TOML).read_text())
    bed = read_bed(str(other))
    assert bed.title == "A variant" and len(bed.tasks) == 7 and len(bed.peers) == 3


def call(*arguments):
    return CliRunner().invoke(cli, ["validate", *map(str, arguments)])


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("mueller/0.8", "neither a measured bed of those that are shipped (anand/hopper, "),
        ("patil/c2", '"patil/c2": is no measured bed, it has no validation.toml; measured are: anand/hopper, '),
    ],
)
def test_what_is_no_measured_bed_is_told(name, told):
    done = call(name)
    assert done.exit_code == 1 and told in done.stderr


@pytest.mark.parametrize(
    "options",
    [("--resume",), ("kharaz/oblique", "--run", "x", "--resume"), ("kharaz/oblique", "--run", "x", "--set", "a=1")],
)
def test_options_that_do_not_fit_are_refused(options):
    assert call(*options).exit_code == 2


def test_mistakes_end_before_anything_is_written(write, tmp_path):
    done = call(write(TOML, '"fluctuation"', '"f"'), "-o", tmp_path / "out")
    assert done.exit_code == 1 and len(done.stderr.splitlines()) == 1 and not (tmp_path / "out").exists()
