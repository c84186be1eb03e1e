"""Scores of a run whose every number is known: `whole_run` has velocities linear in x, sines and a ramp."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.input_files.measured_lines import Points
from fbcouple.postproc.deviation import find_deviation
from fbcouple.results.reader import NotDrawableError, Results, open_results
from fbcouple.validate.comparisons import Task, compare_impact, compare_separation
from fbcouple.validate.points import take_value
from fbcouple.validate.schema import Measurement
from fbcouple.validate.score import RUN, score
from fbcouple.validate.source import read_bed
from tests.postproc.whole_run import write_whole


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return open_results(write_whole(tmp_path_factory.mktemp("whole") / "run"))


def of(rows, name, by=RUN):
    return next(row for row in rows if row["measurement"] == name and row["by"] == by)


def test_a_run_is_scored_as_by_hand(write, results):
    """The run's line is 1.2 (x/L - 0.5): -0.45, -0.15, 0.15, 0.45 m/s at the four points, all with an error of 0.01."""
    found = score(read_bed(str(write())), results)
    assert found.remarks == []
    line, right = of(found.rows, "velocity"), of(found.rows, "velocity, right half")
    apart = np.array([-1.05, -0.05, -0.05, -0.95])
    rms = math.sqrt(float((apart**2).mean()))
    assert line["rms"] == pytest.approx(rms, abs=1e-6) and line["largest"] == pytest.approx(1.05, abs=1e-6)
    assert line["bias"] == pytest.approx(apart.mean(), abs=1e-6) and line["points"] == 4
    assert line["amplitude"] == pytest.approx(0.9 / 1.5, abs=1e-6)
    assert line["amplitude stderr"] == pytest.approx(0.02 / 1.5), "one point up by 0.01, one down by it"
    assert line["stderr"] == pytest.approx(0.01) and line["error of measurement"] == pytest.approx(0.1)
    assert line["rms stderr"] == pytest.approx(0.01 * float(np.abs(apart).mean()) / rms, rel=1e-6)
    assert line["verdict"] == "BEYOND" and line["wanted"] == 0.4
    assert right["points"] == 2 and right["rms"] == pytest.approx(math.sqrt((0.05**2 + 0.95**2) / 2), abs=1e-6)
    assert right["verdict"] == ""


def test_histories_are_scored_as_by_hand(write, results):
    rows = score(read_bed(str(write())), results).rows
    height, pulses, beat, ramp, curve = (of(rows, n) for n in ("height", "pulses", "beat", "ramp", "ramp in time"))
    assert height["computed"] == pytest.approx(0.07, abs=1e-4) and height["rms"] == pytest.approx(0.01, abs=1e-4)
    assert height["bias"] == pytest.approx(-0.01, abs=1e-4) and 0.0 < height["stderr"] < 1e-3
    assert height["verdict"] == "BEYOND" and height["unit"] == "m" and math.isnan(height["amplitude"])
    assert pulses["computed"] == pytest.approx(math.sqrt(200.0 + 4.0), rel=0.02), "a sine of 20 Pa, noise of 2"
    assert beat["computed"] == pytest.approx(2.5, abs=0.05) and beat["unit"] == "Hz"
    assert ramp["computed"] == pytest.approx(0.12) and ramp["bias"] == pytest.approx(0.02), "1.2 - 0.12 |t - 10|"
    assert curve["points"] == 3 and curve["bias"] == pytest.approx((0.0 + 0.0 + 0.1) / 3, abs=1e-9)
    assert curve["amplitude"] == pytest.approx(0.72 / 0.62) and curve["largest"] == pytest.approx(0.1)


def test_peers_are_scored_as_the_run_is(write, results):
    """A line from 0.8 to 1.4 m/s is 0.2, 1.1, 1.0, 0.0 off; a number, its distance; an rms is taken as it is."""
    rows = score(read_bed(str(write())), results).rows
    line, number, third = (
        of(rows, "velocity", "Another code"),
        of(rows, "height", "Another code"),
        of(rows, "ramp in time", "A third"),
    )
    assert line["rms"] == pytest.approx(math.sqrt((0.04 + 1.21 + 1.0) / 4))
    assert line["amplitude"] == pytest.approx(0.6 / 1.5) and line["source"] == "Somebody else 2021"
    assert math.isnan(line["amplitude stderr"]), "nobody knows how sure the peer's line is"
    assert number["rms"] == pytest.approx(0.005) and number["computed"] == 0.085 and number["verdict"] == ""
    assert third["rms"] == 0.25 and math.isnan(third["largest"])


def test_a_peer_is_scored_where_its_line_is_known(write, results):
    """From 20 to 60 mm, 0.8 to 1.4 m/s: 0.95 and 1.25 at the two measured points there, -0.1 and 0.2."""
    bed = read_bed(str(write("peer.csv", "0.01,0.8\n0.07,1.4", "0.02,0.8\n0.06,1.4")))
    found = score(bed, results)
    line = of(found.rows, "velocity", "Another code")
    assert line["points"] == 2 and line["measured"] == pytest.approx(0.05) and line["computed"] == pytest.approx(1.1)
    assert line["rms"] == pytest.approx(math.sqrt((1.05**2 + 1.05**2) / 2))
    assert of(found.rows, "velocity")["points"] == 4
    told = "velocity: Another code is known from 0.02 to 0.06 m and compared at the 2 of 4 measured points there."
    assert found.remarks == [told]


def test_what_is_close_to_what_was_wanted_is_undecided(write, results):
    rms = of(score(read_bed(str(write())), results).rows, "velocity")["rms"]
    for wanted, verdict in ((rms + 0.009, "undecided"), (rms - 0.009, "undecided"), (rms + 0.02, "within")):
        bed = read_bed(str(write("validation.toml", "wanted = 0.4", f"wanted = {wanted!r}")))
        assert of(score(bed, results).rows, "velocity")["verdict"] == verdict


def test_what_a_run_lacks_is_told_and_the_rest_scored(write, results):
    bed = read_bed(str(write("validation.toml", "[0.0, 6.0]", "[0.0, 60.0]")))
    without = Results(results.path, results.data.drop_vars("bed_height"), results.case)
    found = score(bed, without)
    told = sorted(remark.partition(":")[0] for remark in found.remarks)
    assert told == ["height", "ramp"] and "from 0 to 20 s, 2 to 62 s are measured" in " ".join(found.remarks)
    assert math.isnan(of(found.rows, "height")["rms"]) and of(found.rows, "height")["verdict"] == ""
    assert of(found.rows, "velocity")["rms"] > 0.0


def test_a_line_of_another_bed_is_told(write, results):
    bed = read_bed(str(write("line.csv", "0.07,1.4", "0.17,1.4")))
    assert "it is another bed" in score(bed, results).remarks[0]


def test_impacts_are_measured_from_the_normal():
    """At 30 degrees with a rebound of 45, and at 60 with one backwards."""
    before = np.array([[0.5, 0.0, -math.sqrt(0.75)], [0.0, math.sqrt(0.75), -0.5]])
    after = np.array([[0.4, 0.0, 0.4], [0.0, -0.1, 0.5]])
    motion = np.stack([before, after])
    data = xr.Dataset(
        {"tracked_velocity": (("time", "tracked", "component"), motion)}, {"component": ["x", "y", "z"], "time": [0, 1]}
    )
    run = Results(Path("results.nc"), data, {})
    points = Points(np.array([30.0, 45.0, 60.0]), np.zeros(3), None)

    def ask(name):
        return compare_impact(run, Task(Measurement(name="n", compare="impact", of=name, file="f.csv"), points)).values

    slow = -math.degrees(math.atan(0.2))
    assert ask("rebound_angle") == pytest.approx([45.0, (45.0 + slow) / 2, slow])
    assert ask("tangential_restitution")[[0, 2]] == pytest.approx([0.8, -0.1 / math.sqrt(0.75)])
    data["tracked_velocity"][1, 0, 2] = -0.1
    with pytest.raises(NotDrawableError, match=r"not all tracked particles of .* have met the floor"):
        ask("rebound_angle")


def test_separation_is_the_distance_of_two_centres_over_the_height(results):
    """70 mm of bed, 21 mm between the centres: 0.3."""
    time = results.data["time"]
    centres = np.stack([np.full(len(time), 0.045), np.full(len(time), 0.024)], axis=1)
    mixed = Results(results.path, results.data.assign(species_centre_z=(("time", "species"), centres)), results.case)
    task = Task(Measurement(name="n", compare="separation", of="species_centre_z", value=0.5), take_value(0.5, None))
    found = compare_separation(mixed, task)
    assert found.values == pytest.approx([0.3], abs=1e-3) and found.stderr == pytest.approx([0.0])
    three = results.data.assign(species_centre_z=(("time", "species"), np.zeros((len(time), 3))))
    with pytest.raises(NotDrawableError, match="has 3 species"):
        compare_separation(Results(results.path, three, results.case), task)


def test_error_of_amplitude_is_of_the_two_points_that_make_it():
    error = np.array([0.1, 0.5, 0.2])
    away = find_deviation(np.array([3.0, 2.0, 1.0]), np.array([1.0, 4.0, 5.0]), error)
    assert away.amplitude == 0.5 and away.amplitude_error == pytest.approx(0.3 / 4.0)


def test_a_flat_measurement_has_no_amplitude():
    away = find_deviation(np.array([1.0, 2.0]), np.array([1.5, 1.5]), np.array([0.1, 0.1]))
    assert math.isnan(away.amplitude) and math.isnan(away.amplitude_error)
