"""Error norms between runs whose difference is known, on grids that are nested and on grids that are not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fbcouple.postproc.common_grid import coarsen
from fbcouple.postproc.differences import (
    FIELDS,
    Point,
    compare,
    core_hours,
    draw_error_against_time,
    find_difference,
)
from fbcouple.results.reader import NotDrawableError, open_results, open_runs
from tests.postproc.whole_run import leave_out, write_whole

SOLIDS = "map of the solids fraction"


@pytest.mark.parametrize("cells", [3, 7, 17, 20])
def test_coarsening_keeps_the_integral_and_parabolas(cells):
    edges = np.linspace(0.0, 2.0, 36)
    coarse = np.linspace(0.0, 2.0, cells + 1)

    def means(at):
        parabola = 1.0 * at + 2.0 * at**2 / 2 - 3.0 * at**3 / 3
        return np.diff(parabola) / np.diff(at)

    found = coarsen(np.stack([means(edges), 2.0 * means(edges)]), 1, cells, 2.0)
    assert found[0] == pytest.approx(means(coarse), rel=1e-10) and found[1] == pytest.approx(2.0 * means(coarse))
    wild = np.random.default_rng(1).standard_normal((35, 4))
    assert coarsen(wild, 0, cells, 2.0).mean(axis=0) == pytest.approx(wild.mean(axis=0), abs=1e-12)


def test_a_cell_that_holds_a_part_of_a_gap_is_not_known():
    """Of six cells on four the second and third reach into the third of the six; a line without gaps is a line."""
    values = np.stack([np.array([1.0, 2.0, np.nan, 4.0, 5.0, 6.0]), np.arange(1.0, 7.0)])
    gapped, whole = coarsen(values, 1, 4, 1.0)
    assert gapped == pytest.approx([4.0 / 3.0, np.nan, 13.0 / 3.0, 17.0 / 3.0], nan_ok=True)
    assert whole == pytest.approx([1.25, 2.75, 4.25, 5.75])


def test_the_same_grid_is_left_as_it_is():
    values = np.random.default_rng(2).standard_normal((5, 6))
    assert coarsen(values, 0, 5, 1.0) is values


def make_runs(tmp_path, one, other, **options):
    write_whole(tmp_path / "base", one)
    write_whole(tmp_path / "run", other, **options)
    return open_runs([tmp_path / "base", tmp_path / "run"])


def test_norms_of_a_known_difference(tmp_path):
    """0.1 more solids in 9 of 25 layers: L1 0.036, L2 0.1 sqrt(0.36), largest 0.1, relative to 0.3 sqrt(0.36)."""
    base, run = make_runs(tmp_path, (8, 3, 25), (8, 3, 25), shift=0.1)
    found = find_difference(run, base, SOLIDS)
    assert (found.run, found.base) == ("run", "base")
    assert found.l1 == pytest.approx(0.036) and found.l2 == pytest.approx(0.06) and found.largest == pytest.approx(0.1)
    assert found.relative == pytest.approx(1.0 / 3.0)
    assert found.noise == pytest.approx(0.01 * math.sqrt(2.0)), "standard errors of 0.01 each"


def test_places_outside_of_a_mesh_make_no_difference(tmp_path):
    """Without two of eight columns the norms are those of the other six; on another grid nothing can be told."""
    base, run = (
        replace(each, data=leave_out(each.data, abs(each.data["x"] - 0.04) > 0.03))
        for each in make_runs(tmp_path, (8, 3, 25), (8, 3, 25), shift=0.1)
    )
    found = find_difference(run, base, SOLIDS)
    assert found.l1 == pytest.approx(0.036) and found.l2 == pytest.approx(0.06) and found.largest == pytest.approx(0.1)
    assert found.noise == pytest.approx(0.01 * math.sqrt(2.0))
    finer = open_results(write_whole(tmp_path / "finer", (16, 3, 25)))
    rows, left_out = compare([base, finer])
    assert SOLIDS not in [row.quantity for row in rows]
    assert any(text.startswith(SOLIDS) and "give all runs the same domain.cells" in text for text in left_out)


def test_a_finer_nested_mesh_makes_no_difference_in_what_does_not_depend_on_it(tmp_path):
    """The faces of the coarse mesh are faces of the fine one, so that its cell means are exact whatever the field."""
    base, run = make_runs(tmp_path, (8, 3, 25), (16, 6, 75))
    rows, left_out = compare([base, run])
    assert [row.quantity for row in rows] == list(FIELDS) and left_out == []
    assert max(row.largest for row in rows) < 1e-9


def test_a_run_equals_itself_and_its_noise_is_told(tmp_path):
    base, run = make_runs(tmp_path, (8, 3, 25), (8, 3, 25))
    for name in FIELDS:
        found = find_difference(run, base, name)
        assert found.l1 == found.l2 == found.largest == found.relative == 0.0 and found.noise > 0.0


def test_boxes_that_differ_are_not_compared(tmp_path):
    base, run = make_runs(tmp_path, (8, 3, 25), (8, 3, 25))
    taller = replace(run, data=run.data.assign_coords(z=1.2 * run.data["z"]))
    rows, left_out = compare([base, taller])
    assert rows == [] and left_out == ["run is not compared with base: their boxes differ."]


def test_core_hours_per_simulated_second(tmp_path):
    """7200 core seconds for 20 s are 0.1 core hours a second."""
    run = open_results(write_whole(tmp_path / "run"))
    assert core_hours(run) == pytest.approx(0.1)
    del run.data.attrs["core_seconds"]
    with pytest.raises(NotDrawableError, match="core_seconds"):
        core_hours(run)


def test_error_against_time_shows_every_error_above_zero():
    points = [Point("a", "e1", 0.1, 0.0, 1.0), Point("b", "e1", 0.05, 0.0, 8.0), Point("b", "e2", 0.0, 0.0, 8.0)]
    axes = draw_error_against_time(points, base=20.0).axes[0]
    (line,) = [line for line in axes.lines if line.get_label() == "e1"]
    assert line.get_xydata().tolist() == [[1.0, 0.1], [8.0, 0.05]]
    assert axes.get_xscale() == axes.get_yscale() == "log"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["e1"]
    assert [text.get_text() for text in axes.texts] == ["| a", "b |"], "each run at its run time"
    assert [text.xy[0] for text in axes.texts] == [1.0, 8.0]
    assert any(list(line.get_xdata()) == [20.0, 20.0] for line in axes.lines)
