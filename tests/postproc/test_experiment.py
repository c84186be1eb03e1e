"""A run against measured lines whose distance from it is known."""

import math
import os
from dataclasses import replace

import numpy as np
import pytest

from fbcouple.errors import CaseError
from fbcouple.postproc.experiment import (
    compare_with,
    find_zeros,
    gather_references,
    line_of,
    tell_given,
    tell_unread,
)
from fbcouple.postproc.figures.measured_lines import draw_measured_lines
from fbcouple.postproc.report import report
from fbcouple.results.reader import NotDrawableError, open_results
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
    results.data["solids_velocity_stderr"][2, :, 0, :] = 9.0
    found = compare_with(results, measured_of(results, velocity(X).tolist()))
    assert found.noise == pytest.approx(0.01)
    line = line_of(results, measured_of(results, velocity(X).tolist()).reference)
    assert line == pytest.approx(velocity(results.data["x"].values))


def test_a_part_of_the_depth_counts_with_what_of_each_cell_is_in_it(results):
    """From y = 0 to half of the second of three cells: all of the first, and half of the second."""
    reference = measured_of(results, velocity(X).tolist()).reference
    third = results.size[1] / 3.0
    for row, value in enumerate((0.3, 0.1, 0.4)):
        results.data["solids_fraction"][:, row, :] = value
        results.data["solids_velocity"][:, :, row, :] = float(row + 1)
    front = line_of(results, replace(reference, depth=(0.0, 1.5 * third)))
    assert front == pytest.approx(np.full(front.shape, (0.3 * 1.0 + 0.05 * 2.0) / 0.35))
    back = line_of(results, replace(reference, depth=(2.0 * third, 3.0 * third)))
    assert back == pytest.approx(np.full(back.shape, 3.0))
    plain = line_of(results, replace(reference, quantity="solids_fraction", depth=(0.0, 1.5 * third)))
    assert plain == pytest.approx(np.full(plain.shape, (0.3 + 0.5 * 0.1) / 1.5))


def test_a_part_beyond_the_depth_is_refused(results, tmp_path):
    file = write_line(tmp_path / "front.csv", velocity(X).tolist())
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    with pytest.raises(CaseError, match=r"from y = 0 to 9 m, 0 to .* m is allowed"):
        gather_references([results], [f"solids_velocity@0.025,0:9={file}"])


def test_lines_of_two_parts_are_two_lines(results, tmp_path):
    file = write_line(tmp_path / "both.csv", velocity(X).tolist())
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    lines = gather_references([results], [f"solids_velocity@0.025={file}", f"solids_velocity@0.025,0:0.001={file}"])
    assert [line.reference.depth for line in lines] == [None, (0.0, 0.001)]
    titles = [axes.get_title(loc="left") for axes in draw_measured_lines([results], lines).axes]
    assert titles == ["z = 25 mm", "z = 25 mm, y = 0 to 1 mm"]


def test_a_line_over_the_radius_is_not_of_a_box(results, tmp_path):
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    (tmp_path / "ring.csv").write_text("r,value\n0.001,0.1\n0.002,0.1\n")
    ring = gather_references([results], [f"solids_velocity@0.025,r={tmp_path / 'ring.csv'}"])[-1]
    with pytest.raises(NotDrawableError, match="the bed is a box"):
        compare_with(results, ring)


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


@pytest.fixture
def without_figures(monkeypatch):
    """Reports draw the measured lines alone."""
    for name in ("FIGURES", "COMPARISONS"):
        monkeypatch.setattr(report, name, {})


@pytest.mark.usefixtures("without_figures")
def test_a_run_is_compared_with_the_lines_of_its_own_case_only(results, tmp_path):
    """Another bed names a line at the same height; each has its own row, and its own curve in the picture."""
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    other = open_results(write_whole(tmp_path / "other", references=("voidage@0.025=line.csv",)))
    write_line(other.path.parent / "line.csv", [0.7] * 4)
    plain = open_results(write_whole(tmp_path / "plain"))
    runs = [results, other, plain]
    lines = gather_references(runs, [])
    assert [(line.reference.quantity, set(line.runs)) for line in lines] == [
        ("solids_velocity", {"run"}),
        ("voidage", {"other"}),
    ]
    rows = report.describe(runs, lines)["references"]
    assert [(row["run"], row["line"]) for row in rows] == [
        ("run", "solids velocity at z = 25 mm"),
        ("other", "voidage at z = 25 mm"),
    ]
    drawn = [[line.get_label() for line in axes.lines] for axes in draw_measured_lines(runs, lines).axes]
    assert ["run" in labels for labels in drawn] == [True, False]
    assert ["other" in labels for labels in drawn] == [False, True] and not any("plain" in labels for labels in drawn)


@pytest.mark.usefixtures("without_figures")
def test_a_line_given_for_all_runs_is_told(results, tmp_path):
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    plain = open_results(write_whole(tmp_path / "plain"))
    file = write_line(tmp_path / "voidage.csv", [0.7] * 4)
    lines = gather_references([results, plain], [f"voidage@0.03={file}"])
    assert lines[-1].runs == {"run", "plain"}
    (remark,) = tell_given([results, plain], lines)
    assert remark.startswith(f"voidage@0.03={file}: given by --reference, so all 2 runs are compared with it")
    assert remark in report.describe([results, plain], lines)["remarks_on_comparison"]
    assert tell_given([results], lines) == []


@pytest.mark.usefixtures("without_figures")
def test_columns_that_are_not_looked_at_are_named(results, tmp_path):
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    file = write_line(tmp_path / "voidage.csv", [0.7] * 4)
    text = file.read_text().replace("\n", ",7\n").replace(",7\n", ",runs\n", 1)
    file.write_text(text)
    lines = gather_references([results], [f"voidage@0.03={file}"])
    (remark,) = tell_unread(lines)  # and none of the case's own line
    assert remark.startswith(f"voidage@0.03={file}: its columns 'runs' are not looked at")
    assert remark in report.describe([results], lines)["remarks_on_comparison"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x,value\n-30,0.1\n0,0.2\n30,0.1\n", "x from -30 to 30 m, 0 to 0.08 m is allowed .* mm from the middle"),
        ("x,value\n0,01,0,1\n", "line 2, `0,01,0,1`, has 4 columns"),
        ("x,value\n0.01,45\n", "has 45 at x = 0.01 m, voidage is 0 to 1"),
    ],
)
def test_lines_that_do_not_fit_the_bed_are_refused_however_they_are_named(results, tmp_path, text, told):
    """One check for --reference and for what the case of a run names."""
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    (tmp_path / "given.csv").write_text(text)
    with pytest.raises(CaseError, match=f"run, voidage@0.03=.*: given.csv.*{told}"):
        gather_references([results], [f"voidage@0.03={tmp_path / 'given.csv'}"])
    named = open_results(write_whole(tmp_path / "named", references=("voidage@0.03=given.csv",)))
    (tmp_path / "named/given.csv").write_text(text)
    with pytest.raises(CaseError, match=f"named, voidage@0.03=given.csv: given.csv.*{told}"):
        gather_references([named], [])


def test_a_line_above_the_box_is_refused(results, tmp_path):
    write_line(results.path.parent / "line.csv", velocity(X).tolist())
    file = write_line(tmp_path / "voidage.csv", [0.7] * 4)
    with pytest.raises(CaseError, match=r"is at 30 m, the box is 0.25 m high"):
        gather_references([results], [f"voidage@30={file}"])


@pytest.mark.parametrize(
    ("file", "told"),
    [
        ("../outside.csv", "the bare name of a .csv file is allowed"),
        ("OUTSIDE", "the bare name of a .csv file is allowed"),
        ("link.csv", "is a link that leads out of the folder"),
        ("pipe.csv", "is not a plain file"),
        ("secret", "the bare name of a .csv file is allowed"),
    ],
)
def test_results_of_anybody_name_no_file_elsewhere(tmp_path, file, told):
    outside = write_line(tmp_path / "outside.csv", [0.7] * 4)
    file = file.replace("OUTSIDE", str(outside))
    run = open_results(write_whole(tmp_path / "run", references=(f"voidage@0.03={file}",)))
    (run.path.parent / "link.csv").symlink_to(outside)
    os.mkfifo(run.path.parent / "pipe.csv")
    with pytest.raises(CaseError, match=told):
        gather_references([run], [])


@pytest.mark.parametrize("output", [7, {"references": "voidage@0.03=line.csv"}, {"references": [7]}])
def test_references_that_are_no_texts_are_refused(results, output):
    with pytest.raises(CaseError, match=r"output\.references of its case is no list of texts"):
        gather_references([replace(results, case=results.case | {"output": output})], [])


def test_all_lines_that_cannot_be_read_are_told(results):
    with pytest.raises(CaseError) as caught:
        gather_references([results], ["voidage@0.1=none.csv", "porosity@0.1=a.csv"])
    assert len(caught.value.problems) == 3 and "line.csv cannot be read" in caught.value.problems[0]


def test_zeros_lie_on_the_straight_lines():
    assert find_zeros(np.array([0.0, 1.0, 2.0, 3.0]), np.array([-1.0, 3.0, 1.0, -1.0])) == pytest.approx([0.25, 2.5])
    assert find_zeros(np.array([0.0, 1.0]), np.array([1.0, 2.0])) == []
    assert find_zeros(np.array([5.0, 15.0, 25.0]), np.array([-0.1, 0.0, 0.1])) == [15.0]
    assert find_zeros(np.arange(4.0), np.array([0.0, 1.0, 0.0, 1.0])) == []  # at a wall, and touched only
