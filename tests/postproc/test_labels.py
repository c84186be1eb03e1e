"""No label of a figure is cut at its edge, however long the names of runs are."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from fbcouple.postproc import COMPARISONS, FIGURES
from fbcouple.postproc.differences import Point, draw_error_against_time
from fbcouple.postproc.experiment import gather_references
from fbcouple.postproc.figures.measured_lines import draw_measured_lines, measured_lines
from fbcouple.postproc.style import journal_style, mark_logarithm
from fbcouple.postproc.symbols import SYMBOLS
from fbcouple.results.reader import open_runs
from tests.postproc.whole_run import write_whole

LONG = "patil-c2-with-a-long-name-and-a-friction-of-0.25"
LINE = "x,value,error\n0.02,-0.3,0.05\n0.04,0.0,0.05\n0.06,0.3,0.05\n"
NOT_OF_A_BED = {"impact", "bed_views", "moment_slices", "radial_profiles", "temperature", "throughput", "mixing"}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Three runs of long names, each with a measured line."""
    folder = tmp_path_factory.mktemp("long")
    references = ("solids_velocity@0.025=line.csv", "voidage@0.03=voidage.csv", "agitation@0.03=agitation.csv")
    for number in range(3):
        run = write_whole(folder / f"{LONG}-{number}", (17, 3, 55), shift=0.01 * number, references=references)
        for name in ("line", "voidage", "agitation"):
            (run / f"{name}.csv").write_text(LINE if name == "line" else LINE.replace("-0.3", "0.3"))
    return open_runs(sorted(folder.iterdir()))


def list_cut(figure: Figure) -> list[str]:
    """Texts that are not whole inside of the figure, by more than a dot; of an axis the axis."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    axes = [axis for each in figure.axes if each.axison for axis in (each.xaxis, each.yaxis)]
    of_ticks = {
        text for axis in axes for tick in axis.majorTicks + axis.minorTicks for text in (tick.label1, tick.label2)
    }
    texts = [text for text in figure.findobj(Text) if text not in of_ticks and text.get_visible() and text.get_text()]
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts]
    boxes += [(f"axis {axis.get_label_text()}", axis.get_tightbbox(renderer)) for axis in axes]
    width, height = figure.bbox.width + 1.0, figure.bbox.height + 1.0
    return [
        words
        for words, box in boxes
        if box is not None and (min(box.x0, box.y0) < -1.0 or box.x1 > width or box.y1 > height)
    ]


@pytest.mark.parametrize("name", sorted(set(FIGURES) - NOT_OF_A_BED))
def test_no_label_of_a_figure_is_cut(name, runs):
    with journal_style():
        assert list_cut(FIGURES[name](runs[0])) == []


@pytest.mark.parametrize("scale", [1e-9, 1.4e-4, 1e-3, 1e5, 1e9])
def test_no_number_of_a_colour_bar_takes_the_room_of_its_label(scale, runs):
    data = runs[0].data.assign(agitation=runs[0].data["agitation"] * scale)
    with journal_style():
        assert list_cut(FIGURES["agitation"](replace(runs[0], data=data))) == []


@pytest.mark.parametrize("name", ["solids_fraction", "solids_flux", "agitation", "slices", "voidage_snapshots"])
def test_no_label_of_a_shallow_bed_is_cut_or_upon_another(name, runs):
    """A map 80 mm wide and up to 21 mm high: its colour bar is shorter than any label."""
    data = runs[0].data.assign_coords(z=runs[0].data["z"] * 0.2)
    shallow = replace(runs[0], data=data, case=runs[0].case | {"domain": {"size": [0.08, 0.015, 0.05]}})
    with journal_style():
        figure = FIGURES[name](shallow)
        assert list_cut(figure) == []
    renderer = figure.canvas.get_renderer()
    bar = figure.axes[-1]
    assert bar.yaxis.label.get_window_extent(renderer).y1 <= bar.bbox.y1 + 1.0
    for axis in (bar.yaxis, figure.axes[0].yaxis):
        low, high = sorted(axis.get_view_interval())
        texts = [(tick.get_loc(), tick.label2 if axis is bar.yaxis else tick.label1) for tick in axis.get_major_ticks()]
        boxes = [text.get_window_extent(renderer) for place, text in texts if low <= place <= high]
        heights = sorted((box.y0, box.y1) for box in boxes)
        assert heights
        assert all(below[1] <= above[0] for below, above in pairwise(heights))


@pytest.mark.parametrize("name", ["solids_fraction", "solids_flux", "agitation", "flux_profile", "depth_profiles"])
def test_every_letter_of_a_figure_is_explained(name, runs):
    with journal_style():
        figure = FIGURES[name](runs[0])
    note = figure.texts[1].get_text()
    labels = " ".join(text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()))
    letters = {letter for part, (letter, _) in SYMBOLS.items() if part in labels}
    assert letters and all(f"${letter}$" in note for letter in letters)
    rest = labels
    for part in sorted(SYMBOLS, key=len, reverse=True):
        rest = rest.replace(part, "")
    assert not set(re.findall(r"[A-Za-z]+", " ".join(re.findall(r"\$([^$]*)\$", rest)))) - {
        "langle",
        "rangle",
        "s",
        "m",
    }


@pytest.mark.parametrize("name", sorted(COMPARISONS))
def test_no_label_of_a_comparison_is_cut(name, runs):
    with journal_style():
        assert list_cut(COMPARISONS[name](runs)) == []


def test_no_label_of_measured_lines_and_of_errors_is_cut(runs):
    points = [
        Point(run.label, f"{error} of a quantity with a rather long name at z = 25 mm, measured", 0.1, 0.0, cost)
        for run, cost in zip(runs, (0.1, 0.11, 3.0), strict=True)
        for error in range(11)
    ]
    with journal_style():
        assert list_cut(draw_measured_lines(runs, gather_references(runs, []))) == []
        figure = draw_error_against_time(points, base=0.1)
        assert list_cut(figure) == []
    legend = [(line.get_color(), line.get_marker()) for line in figure.axes[0].get_legend().get_lines()]
    assert len(legend) == 11 and len(set(legend)) == 11, "each error has a look of its own"


def test_a_cut_label_is_seen(runs):
    """The test above can fail."""
    figure = measured_lines(runs[0])
    figure.text(0.9, 0.5, "a label that does not fit into the figure")
    assert list_cut(figure) == ["a label that does not fit into the figure"]


@pytest.mark.parametrize("span", [1.05, 1.4, 2.9, 3.1, 6.0, 9.9, 11.0, 60.0, 110.0, 3e3, 2e4, 1e6])
@pytest.mark.parametrize("low", [1.1e-3, 2.6, 4.4, 8.2e2])
def test_logarithmic_axes_have_three_marks_at_least(low, span):
    axes = Figure().subplots()
    axes.set(xscale="log", xlim=(low, low * span))
    mark_logarithm(axes.xaxis)
    marks = [mark for mark in axes.xaxis.get_majorticklocs() if low <= mark <= low * span]
    assert 3 <= len(marks) <= 9
    assert len(set(axes.xaxis.get_major_formatter().format_ticks(marks))) == len(marks)
