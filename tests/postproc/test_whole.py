"""A run that has everything: every figure of the registry, alone and beside another run."""

import numpy as np
import pytest

from fbcouple.postproc import COMPARISONS, FIGURES, draw
from fbcouple.postproc.figures.depth import DEPTH_PLACES, depth_lines, moment_slices, slices
from fbcouple.postproc.figures.layout import MOST_ACROSS
from fbcouple.postproc.figures.maps import agitation, agitations, solids_fluxes, solids_fractions
from fbcouple.postproc.figures.profiles import flux_profiles
from fbcouple.postproc.figures.snapshots import voidage_snapshots
from fbcouple.results.reader import NotDrawableError, open_results, open_runs
from tests.postproc.frames_of_bed import write_frames
from tests.postproc.whole_run import SIZE, write_whole


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_whole(tmp_path_factory.mktemp("whole") / "coarse", (17, 3, 55))


@pytest.fixture(scope="module")
def results(folder):
    return open_results(folder)


@pytest.fixture(scope="module")
def runs(folder, tmp_path_factory):
    other = write_whole(tmp_path_factory.mktemp("other") / "fine", (34, 6, 110), shift=0.1, core_seconds=72000.0)
    return open_runs([folder, other])


def test_every_figure_of_a_bed_is_drawn(folder):
    assert {path.stem for path in draw(folder)} == set(FIGURES) - {
        "impact",
        "bed_views",
        "moment_slices",
        "measured_lines",
        "radial_profiles",
        "mixing",
        "temperature",
        "throughput",
    }


@pytest.mark.parametrize("name", sorted(COMPARISONS))
def test_every_comparison_is_drawn_for_runs_on_two_meshes(name, runs):
    picture = COMPARISONS[name](runs)
    picture.canvas.draw()
    pixels = np.asarray(picture.canvas.buffer_rgba())
    assert pixels[..., :3].std() > 10.0, "blank"
    assert COMPARISONS[name].__doc__


def test_a_row_of_maps_has_one_scale_and_a_name_on_each(runs):
    for make in (solids_fractions, solids_fluxes, agitations):
        picture = make(runs)
        maps, bars = picture.axes[:2], picture.axes[2:]
        assert [axes.get_title() for axes in maps] == ["coarse", "fine"] and len(bars) == 1
        meshes = [axes.collections[0] for axes in maps]
        assert meshes[0].get_clim() == meshes[1].get_clim()
        assert [np.asarray(mesh.get_array()).shape for mesh in meshes] == [(55, 17), (110, 34)]


def test_the_largest_flux_of_the_row_has_the_longest_arrow(runs):
    """Solids fraction 0.3 against 0.4, so 3/4 of the flux; the scale of the arrows is common."""
    arrows = [axes.collections[1] for axes in solids_fluxes(runs).axes[:2]]
    assert arrows[0].scale == arrows[1].scale
    assert arrows[0].V.max() / arrows[1].V.max() == pytest.approx(0.75, rel=1e-6)


def test_more_runs_than_a_row_holds_stand_in_rows_below(runs):
    many = [*runs, *runs, *runs, *runs]
    picture = solids_fractions(many)
    assert len(picture.axes) == 9
    heights = [axes.get_position().y0 for axes in picture.axes[:8]]
    assert len(set(np.round(heights, 6))) == 2 and heights[0] > heights[MOST_ACROSS]


def test_agitation_is_over_the_square_of_the_inlet_velocity_and_empty_above_the_bed(results):
    mesh = agitation(results).axes[0].collections[0]
    shown = np.ma.asarray(mesh.get_array())
    assert shown.compressed() == pytest.approx(0.144 / 1.2**2)
    assert shown.mask[-1].all() and not shown.mask[0].any()


def test_slices_show_the_cells_at_their_places(tmp_path):
    run = open_results(write_whole(tmp_path / "run", (8, 10, 25)))
    run.data["solids_fraction"][:, :, :] = np.arange(10)[None, :, None] / 20.0
    values = [np.unique(np.asarray(axes.collections[0].get_array())) for axes in slices(run).axes[:3]]
    assert [value.tolist() for value in values] == [[0.1], [0.25], [0.4]]


def test_slices_of_a_moment_are_those_of_its_frame(tmp_path):
    """t U_f/d_p = 12 000 is 10 s at 1.2 m/s, later than the three frames; the dense half has voidage 0.4."""
    run = write_whole(tmp_path / "run")
    write_frames(run, SIZE)
    results = open_results(run)
    figure = moment_slices(results)
    assert [axes.get_title() for axes in figure.axes[:3]] == ["y/D = 0.2", "y/D = 0.5", "y/D = 0.8"]
    for axes in figure.axes[:3]:
        values = np.asarray(axes.collections[0].get_array())
        assert values[:12] == pytest.approx(0.6, rel=1e-6) and not values[13:].any()
    assert figure.texts[1].get_text().startswith("t = 0.200 s; up to z = 110 mm of 250 mm; ")
    results.case["output"]["particles_every"] = 10.0
    assert moment_slices(results).texts[1].get_text().startswith("t = 0.100 s;"), "frame 1 is then that of 10 s"


def test_velocity_along_the_depth_is_that_of_its_place(results):
    """The velocity is 1.2 (x/L - 1/2), so over U_f it is x/L - 1/2, the same along the depth."""
    lines = depth_lines(results)
    assert tuple(lines) == DEPTH_PLACES
    for place, line in lines.items():
        assert line == pytest.approx([place - 0.5] * 3, rel=1e-9)


def test_snapshots_span_the_second_half(results):
    titles = [axes.get_title() for axes in voidage_snapshots(results).axes[:5]]
    assert titles[0] == "t = 2.990 s" or titles[0] == "t = 3.000 s"
    assert titles[-1] == "t = 5.990 s"


def test_profiles_of_several_runs_differ_in_more_than_colour(runs):
    lines = flux_profiles(runs).axes[0].lines[:2]
    assert [line.get_label() for line in lines] == ["coarse", "fine"]
    for kind in ("color", "linestyle", "marker"):
        assert getattr(lines[0], f"get_{kind}")() != getattr(lines[1], f"get_{kind}")()


def test_runs_of_one_name_are_told_apart(folder, tmp_path):
    twin = write_whole(tmp_path / "coarse")
    assert [run.label for run in open_runs([folder, twin])] == ["coarse (1)", "coarse (2)"]


def test_all_runs_that_cannot_be_opened_are_told(tmp_path, folder):
    with pytest.raises(Exception) as caught:
        open_runs([tmp_path / "a", folder, tmp_path / "b"])
    assert len(caught.value.problems) == 2


def test_a_hole_where_there_are_solids_is_told(tmp_path):
    run = open_results(write_whole(tmp_path / "run"))
    run.data["agitation"][0, 0, 0] = np.nan
    with pytest.raises(NotDrawableError, match="1 values are not finite where there are solids"):
        agitation(run)
