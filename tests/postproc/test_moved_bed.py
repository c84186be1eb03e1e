"""A bed whose corner is not at zero, as a mesher has it: every figure and number is that of the same bed at zero."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fbcouple.geometry.grid import Grid
from fbcouple.postproc import COMPARISONS, FIGURES, measures
from fbcouple.postproc.figures.depth import depth_lines
from fbcouple.postproc.figures.maps import solids_fraction
from fbcouple.postproc.figures.profiles import vertical_flux
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.tables import tabulate_statistics
from fbcouple.postproc.style import journal_style
from fbcouple.results.reader import open_results
from fbcouple.results.writer import MeshTable, write_results
from tests.postproc.whole_run import SIZE, write_whole

CORNER = (-0.04, 2.0, 0.3)
ALONE = (
    "impact",
    "bed_views",
    "moment_slices",
    "measured_lines",
    "radial_profiles",
    "temperature",
    "throughput",
    "mixing",
)
"""Of frames, which these runs have not, of another case, and of measured lines, which this one has not."""


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    folder = tmp_path_factory.mktemp("moved")
    cells = (17, 3, 55)
    return [
        open_results(write_whole(folder / name / "bed", cells, corner=corner))
        for name, corner in (("here", (0.0, 0.0, 0.0)), ("there", CORNER))
    ]


def pixels(picture):
    picture.canvas.draw()
    return np.asarray(picture.canvas.buffer_rgba()).astype(int)


def test_the_box_is_known_by_its_cells(pair):
    here, there = pair
    assert here.corner == (0.0, 0.0, 0.0) and there.corner == pytest.approx(CORNER)
    assert here.size == SIZE and there.size == pytest.approx(SIZE)
    assert there.share("x") == pytest.approx(here.share("x")) and there.level(0.5) == pytest.approx(0.3 + 0.125)


@pytest.mark.parametrize("name", sorted(set(FIGURES) - set(ALONE)))
def test_the_picture_is_the_same(name, pair):
    with journal_style():
        one, other = (pixels(FIGURES[name](results)) for results in pair)
    assert one[..., :3].std() > 5.0, "blank"
    assert one.shape == other.shape and np.mean(np.abs(one - other).max(axis=-1) > 32) < 1e-4


@pytest.mark.parametrize("name", sorted(COMPARISONS))
def test_the_comparison_is_the_same(name, pair):
    with journal_style():
        one, other = (pixels(COMPARISONS[name]([results, results])) for results in pair)
    assert one.shape == other.shape and np.mean(np.abs(one - other).max(axis=-1) > 32) < 1e-4


def test_the_map_shows_the_whole_bed(pair):
    for results in pair:
        axes = solids_fraction(results).axes[0]
        places = axes.collections[0].get_coordinates()
        assert places[..., 0].min() == 0.0 and places[..., 0].max() == 1.0
        assert axes.get_xlim() == (0.0, 1.0) and axes.get_ylim() == (0.0, pytest.approx(23 / 55))


def test_numbers_are_the_same(pair):
    here, there = ([vertical_flux(run, 0.023).value, *depth_lines(run).values()] for run in pair)
    for one, other in zip(here, there, strict=True):
        assert one == pytest.approx(other, rel=1e-9)
    for measure in (
        measures.freeboard_solids,
        measures.bed_agitation,
        measures.middle_flux,
        measures.wall_flux,
        measures.wall_solids,
        measures.flux_magnitude,
        measures.centre_fluctuation,
        lambda run: measures.agitation_peak(run, 0.25, 0.05)[1],
    ):
        values = [measure(run).value for run in pair]
        assert values[0] == pytest.approx(values[1], rel=1e-9) and math.isfinite(values[0])
    assert tabulate_statistics(pair[0]) == tabulate_statistics(pair[1])
    for name in set(MONITORS) & set(pair[0].data):
        monitor = MONITORS[name]
        assert monitor(pair[0]).value == pytest.approx(monitor(pair[1]).value, rel=1e-9, abs=1e-9)


def test_a_round_mesh_about_its_axis_is_drawn_whole(tmp_path):
    """Places outside of it are empty on both sides alike, and the solids are those of the left and the right half."""
    cells, size = (8, 8, 10), (0.08, 0.08, 0.25)
    grid = Grid(cells, size, origin=(-0.04, -0.04, -0.1))
    z, y, x = np.meshgrid(*(grid.centres(axis) for axis in (2, 1, 0)), indexing="ij")
    inside = np.hypot(x, y) < 0.04
    samples = np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1)
    centres = np.column_stack([axis[inside] for axis in (x, y, z)])
    solids = 0.3 + 5.0 * centres[:, 0]
    means = {"solids_fraction": solids, "solids_fraction_stderr": 0.0 * solids}
    case = write_whole(tmp_path / "other")  # for its case
    text = open_results(case).data.attrs["case"].replace("[0.08, 0.015, 0.25]", "[0.08, 0.08, 0.25]")
    history = [{"time": 0.1, "bed_height": 0.1, "wall": dict.fromkeys(_stages(), 0.0)}]
    table = {"centres": centres, "volumes": np.full(len(centres), 1e-6), "samples": samples}
    about = {"case": text, "averaging_start": 0.0, "averaging_end": 1.0, "complete": 1}
    write_results(tmp_path / "results.nc", grid, means, history, about, mesh=MeshTable(**table))
    results = open_results(tmp_path)
    shown = np.ma.asarray(solids_fraction(results).axes[0].collections[0].get_array())
    assert not shown.mask.any(), "the middle of each column is inside"
    assert pytest.approx(0.3 + 5.0 * grid.centres(0)) == shown[0].data and not results.is_box


def _stages():
    return ("dem", "cfd", "map", "drag", "react", "average", "record", "wait")
