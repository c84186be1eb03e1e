"""Bubbles that pass a section: spheres of known size, the space above a bed, and what is cut off by the record."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.sections import Section, find_passing, read_section
from fbcouple.results.reader import NotDrawableError

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
    return Section(TIMES, voidage, SPACING**2)


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
    assert section.area == pytest.approx(0.02)
    assert section.voidage[1] == pytest.approx(np.array([[5.0, 6.0, np.nan], [7.0, 8.0, 9.0]]), nan_ok=True)
    with pytest.raises(NotDrawableError, match="no set of probes `other` with the voidage at one height"):
        read_section(results, "other")
