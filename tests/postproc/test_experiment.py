"""A run against measured lines whose distance from it is known."""

import math

import numpy as np
import pytest

from fbcouple.errors import CaseError
from postproc.dataset import NotDrawableError, open_results
from postproc.experiment import compare_with, draw_measured_lines, find_zeros, gather_references, line_of
from tests.postproc.whole_run import write_whole

X = (0.012, 0.03, 0.05, 0.068)


def write_line(path, values, errors=None):
    rows = zip(X, values, errors or ("",) * len(X), strict=True)
    head = "x,value" if errors is None else "x,value,error"
    path.write_text(head + "\n" + "\n".join(",".join(map(str, row)).rstrip(",") for row in rows) + "\n")
    return path


def velocity(x):
    """What `whole_run` has: linear in x, 1.2 m/s from wall to wall."""
    return 1.2 * (np.array(x) / 0.08 - 0.5)


@pytest.fixture
def results(tmp_path):
    return open_results(write_whole(tmp_path / "run", references=("solids_velocity@0.025=line.csv",)))


def measured_of(results, values, errors=None):
    write_line(results.path.parent / "line.csv", values, errors)
    (measured,) = gather_references([results], [])
    return measured


def test_a_line_that_is_the_run_has_no_error(results):
    found = compare_with(results, measured_of(results, velocity(X).tolist()))
    assert found.rms == pytest.approx(0.0, abs=1e-9) and found.bias == pytest.approx(0.0, abs=1e-9)
    assert found.measured_zeros == pytest.approx([0.04]) and found.zeros == pytest.approx([0.04])
    assert found.unit == "m s-1" and found.points == 4 and math.isnan(found.error)


def test_rms_bias_and_largest_of_a_known_distance(results):
    """The run lies 0.1, 0.1, -0.1 and 0.2 m/s above: bias 0.075, rms sqrt(0.07/4)."""
    apart = np.array([0.1, 0.1, -0.1, 0.2])
    found = compare_with(results, measured_of(results, (velocity(X) - apart).tolist(), [0.03, 0.03, 0.05, 0.05]))
    assert found.bias == pytest.approx(0.075) and found.rms == pytest.approx(math.sqrt(0.07 / 4))
    assert found.largest == pytest.approx(0.2) and found.error == pytest.approx(math.sqrt(0.0017))
    assert found.noise == pytest.approx(0.01)


def test_particle_quantities_are_weighted_with_the_solids_over_the_depth(results):
    """A depth of which one cell of three has all solids counts with its velocity alone."""
    results.data["solids_fraction"][:, 0, :] = 0.0
    results.data["solids_fraction"][:, 2, :] = 0.0
    results.data["solids_velocity"][2, :, 0, :] = 9.0
    line = line_of(results, measured_of(results, velocity(X).tolist()).reference)
    assert line == pytest.approx(velocity(results.data["x"].values))


def test_gas_quantities_are_plain_means_over_the_depth(results, tmp_path):
    write_line(results.path.parent / "line.csv", [0.0] * 4)
    file = write_line(tmp_path / "voidage.csv", [0.7] * 4)
    measured = gather_references([results], [f"voidage@0.03={file}"])[-1]
    assert compare_with(results, measured).rms == pytest.approx(0.0, abs=1e-12)


def test_a_line_above_the_bed_has_no_particles(results):
    write_line(results.path.parent / "line.csv", [0.0] * 4)
    other = gather_references([results], [f"solids_velocity@0.2={results.path.parent / 'line.csv'}"])[-1]
    with pytest.raises(NotDrawableError, match="no particle ever came"):
        compare_with(results, other)


def test_one_line_named_by_two_runs_is_one_line(results, tmp_path):
    twin = open_results(write_whole(tmp_path / "twin", references=("solids_velocity@0.025=line.csv",)))
    for run in (results, twin):
        write_line(run.path.parent / "line.csv", velocity(X).tolist())
    lines = gather_references([results, twin], [])
    assert len(lines) == 1
    picture = draw_measured_lines([results, twin], lines)
    assert len(picture.axes[0].lines) >= 3


def test_all_lines_that_cannot_be_read_are_told(results):
    with pytest.raises(CaseError) as caught:
        gather_references([results], ["voidage@0.1=none.csv", "porosity@0.1=a.csv"])
    assert len(caught.value.problems) == 3 and "line.csv cannot be read" in caught.value.problems[0]


def test_zeros_lie_on_the_straight_lines():
    assert find_zeros(np.array([0.0, 1.0, 2.0, 3.0]), np.array([-1.0, 3.0, 1.0, -1.0])) == pytest.approx([0.25, 2.5])
    assert find_zeros(np.array([0.0, 1.0]), np.array([1.0, 2.0])) == []
