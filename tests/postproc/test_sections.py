"""Bubbles that pass a section: spheres of known size, the space above a bed, and what is cut off by the record."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.figures.sections import sections
from fbcouple.postproc.sections import Section, cut_section, find_passing, read_section
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

SPACING, RISE = 1e-3, 0.5
TIMES = np.arange(0.0, 0.6, 2e-3)
X, Y = np.meshgrid((np.arange(100) + 0.5) * SPACING, (np.arange(100) + 0.5) * SPACING)
INSIDE = np.hypot(X - 0.05, Y - 0.05) <= 0.05


def pass_spheres(*spheres):
    """Spheres (x, y, time at the section, diameter) that rise through a section of a cylinder of 100 mm."""
    voidage = np.where(INSIDE, 0.45, np.nan) * np.ones((len(TIMES), 1, 1))
    for x, y, when, diameter in spheres:
        away = np.sqrt((X - x) ** 2 + (Y - y) ** 2 + (RISE * (TIMES[:, None, None] - when)) ** 2)
        voidage[(away < diameter / 2) & INSIDE] = 0.95
    return Section(TIMES, voidage, SPACING**2, X[0], 0.05)


def test_spheres_are_as_large_as_at_their_widest():
    found = find_passing(pass_spheres((0.03, 0.05, 0.2, 0.02), (0.07, 0.05, 0.2, 0.03), (0.05, 0.05, 0.4, 0.04)), 5e-3)
    assert sorted(found.diameters) == pytest.approx([0.02, 0.03, 0.04], rel=0.02) and found.open == 0


def test_what_is_too_small_or_not_whole_is_no_bubble():
    spheres = [(0.03, 0.05, 0.3, 0.004), (0.07, 0.05, 0.0, 0.03), (0.05, 0.05, TIMES[-1], 0.03)]
    assert not find_passing(pass_spheres(*spheres), 5e-3).diameters.size


def test_the_space_above_a_bed_is_no_bubble():
    section = pass_spheres((0.05, 0.05, 0.2, 0.03))
    section.voidage[200:220, INSIDE] = 1.0
    found = find_passing(section, 5e-3)
    assert found.diameters == pytest.approx([0.03], rel=0.02) and found.open == 1


def test_a_set_of_probes_is_put_on_its_grid():
    points = np.array([[0.1, 0.1, 0.05], [0.2, 0.1, 0.05], [0.1, 0.3, 0.05], [0.2, 0.3, 0.05], [0.3, 0.3, 0.05]])
    names = {f"probe_cut_{axis}": ("probe_cut_point", points[:, i]) for i, axis in enumerate("xyz")}
    values = ("probe_cut_time", "probe_cut_point"), np.arange(10.0).reshape(2, 5)
    data = xr.Dataset(names | {"probe_cut_voidage": values}, {"probe_cut_time": [0.0, 0.1]})
    case = {"output": {"probes": [{"name": "cut", "quantities": ["voidage"], "height": 0.05}]}}
    results = SimpleNamespace(data=data, case=case, path="results.nc")
    section = read_section(results, "cut")
    assert (
        section.area == pytest.approx(0.02) and section.height == 0.05 and section.x == pytest.approx([0.1, 0.2, 0.3])
    )
    assert section.voidage[1] == pytest.approx(np.array([[5.0, 6.0, np.nan], [7.0, 8.0, 9.0]]), nan_ok=True)
    with pytest.raises(NotDrawableError, match="no set of probes `other` with the voidage at one height"):
        read_section(results, "other")


def test_a_section_is_cut_to_the_averaging_window():
    section = pass_spheres((0.03, 0.05, 0.2, 0.02), (0.05, 0.05, 0.4, 0.04))
    late = cut_section(section, (0.3, 0.6))
    assert late.times[0] == pytest.approx(0.3) and len(late.voidage) == len(late.times)
    assert find_passing(late, 5e-3).diameters == pytest.approx([0.04], rel=0.02)
    assert cut_section(section, None) is section
    assert not find_passing(cut_section(section, (7.0, 8.0)), 5e-3).diameters.size


def make_results(section, window=(0.0, 0.6)):
    """Results whose set of probes `cut` is the section."""
    points = np.column_stack([X[INSIDE], Y[INSIDE], np.full(INSIDE.sum(), 0.05)])
    names = {f"probe_cut_{axis}": ("probe_cut_point", points[:, i]) for i, axis in enumerate("xyz")}
    values = ("probe_cut_time", "probe_cut_point"), section.voidage[:, INSIDE]
    data = xr.Dataset(names | {"probe_cut_voidage": values}, {"probe_cut_time": TIMES})
    probed = {"name": "cut", "quantities": ["voidage"], "height": 0.05}
    case = {"title": "a bed", "output": {"probes": [probed]}, "particles": {"diameter": 1e-3}}
    data.attrs |= {"averaging_start": window[0], "averaging_end": window[1]}
    return Results(Path("results.nc"), data, case)


def test_the_figure_tells_how_many_of_what_size_pass():
    results = make_results(pass_spheres(*((0.05, 0.05, 0.05 + 0.1 * n, 0.03) for n in range(5))))
    picture = sections(results)
    image, _, sizes = picture.axes
    assert image.get_title(loc="left") == "cut, z = 50 mm: 5 bubbles of 30.2 ± 0 mm, 0 voids cover the section"
    values = image.collections[0].get_array()
    assert values.shape == (100, len(TIMES)) and float(np.nanmax(values)) == pytest.approx(0.95)
    assert sum(bar.get_height() for bar in sizes.patches) == 5
    assert np.allclose([bar.get_x() + bar.get_width() for bar in sizes.patches][-1], 30.0, atol=1.0)


def test_the_figure_is_not_meant_without_a_section_and_not_drawn_before_the_window():
    bare = make_results(pass_spheres())
    bare.case["output"]["probes"] = []
    with pytest.raises(NotMeantError, match="no probes of the voidage at a height"):
        sections(replace(bare, data=bare.data.drop_dims(["probe_cut_point", "probe_cut_time"])))
    with pytest.raises(NotDrawableError, match="no sample of its sections in the averaging window yet"):
        sections(make_results(pass_spheres(), (5.0, 6.0)))
