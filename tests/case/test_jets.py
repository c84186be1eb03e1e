"""Inlets on the mesh: what is narrower than its cells comes in slower than the case says, and is told."""

from __future__ import annotations

import math

import pytest
from test_inlets import BACKGROUND, CASE, JET, SLOT, write

from fbcouple.case.bed.fluid_step import gas_step
from fbcouple.case.bed.jets import compare_momentum, find_jet_range
from fbcouple.case.bed.region import find_openings
from fbcouple.case.bed.step_limits import measure_limits
from fbcouple.case.bed.streams import list_streams
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate

THIN = "[[gas.inlets]]\ncircle = [0.04, 0.01, 0.001]\nvelocity = 60.0\n"
PART = math.pi / 4.0 * 5e-4**2 / 0.005**2
"""Of each of the four faces of 5 mm that meet in the middle of the circle."""


def numbers_of(case, folder):
    return {number.name: number for number in estimate(case, folder=folder)}


def test_a_jet_within_a_cell_is_as_fast_as_its_faces_have_it(tmp_path):
    case = load_case(write(tmp_path, BACKGROUND, THIN))
    face = 0.5 * (1.0 - PART) + 60.0 * PART
    numbers = numbers_of(case, tmp_path)
    assert numbers["open inlet velocity"].value == pytest.approx(face, rel=1e-9)
    whole = numbers["superficial velocity"].value / 0.40
    assert numbers["fluid step"].value == pytest.approx(0.2 * 0.005 / max(face, whole), rel=1e-9)
    assert gas_step(case) == numbers["fluid step"].value == gas_step(case, limits=measure_limits(case, tmp_path))
    across = numbers["cells across inlet 2"]
    assert across.value == pytest.approx(0.2) and across.verdict == "warn"
    kept = face**2 / (0.25 * (1.0 - PART) + 3600.0 * PART)
    assert f"has {kept:.3g} of the momentum flux" in across.meaning and kept < 0.05
    assert "cells across inlet 1" not in numbers, "it is all of the floor"


def test_the_spring_is_that_of_the_jet_on_the_mesh(tmp_path):
    """Particles of 0.1 mm are as fast as the jet around them."""
    sets = ["contact.max_overlap=0.05", "particles.diameter=1e-4", "particles.mass=1e-5"]
    thin = load_case(write(tmp_path, BACKGROUND, THIN), sets)
    found = numbers_of(thin, tmp_path)["overlap"]
    assert found.value == pytest.approx(0.05, rel=0.01)
    fine = load_case(write(tmp_path, BACKGROUND, THIN.replace("0.001]", "0.02]")), sets)
    assert fine.contact.stiffness > 100.0 * thin.contact.stiffness


def test_a_jet_on_whole_faces_has_all_of_its_velocity_and_momentum(tmp_path):
    slot = "[[gas.inlets]]\nrectangle = [[0.03, 0.0], [0.05, 0.02]]\nvelocity = 7.0\n"
    case = load_case(write(tmp_path, BACKGROUND, slot))
    numbers = numbers_of(case, tmp_path)
    assert find_jet_range(case, tmp_path) == pytest.approx((0.5, 7.0), rel=1e-12)
    across = numbers["cells across inlet 2"]
    assert across.value == pytest.approx(4.0) and across.verdict == "fit", "in its depth it ends at walls"
    assert "has 1 of the momentum flux" in across.meaning


def test_a_ramp_counts_at_its_fastest_and_on_both_sides_of_a_jump(tmp_path):
    jump = JET.replace("[0.05, 10.0]]", "[0.05, 10.0], [0.05, -4.0]]").replace("0.012]", "0.02]")
    case = load_case(write(tmp_path, BACKGROUND, jump))
    assert find_jet_range(case, tmp_path) == pytest.approx((-4.0, 10.0), rel=1e-9)


def test_a_closed_inlet_is_no_jet(tmp_path):
    case = load_case(write(tmp_path, BACKGROUND, THIN.replace("60.0", "0.0")))
    assert "cells across inlet 2" not in numbers_of(case, tmp_path)
    assert find_jet_range(case, tmp_path)[1] == pytest.approx(0.5)


@pytest.mark.parametrize("table", ["circle", "slot"])
def test_a_profile_on_fine_cells_has_all_of_its_momentum(tmp_path, table):
    (tmp_path / "jet.csv").write_text("x,velocity\n0.02,0\n0.03,3\n0.04,0\n")
    round_ = JET.replace("0.012]", "0.016]") + 'profile = "parabolic"\n'
    text = CASE.replace("[16, 4, 40]", "[160, 40, 4]")
    case = load_case(write(tmp_path, round_ if table == "circle" else SLOT, text=text))
    streams = list_streams(case)
    openings = find_openings(case, tmp_path)
    if table == "slot":
        numbers = numbers_of(case, tmp_path)
        assert "has 1 of the" in numbers["cells across inlet 1"].meaning
        assert numbers["open inlet velocity"].value == pytest.approx(3.0, rel=0.05)
        return
    assert compare_momentum(streams, openings, 0) == pytest.approx(1.0, abs=0.01)
    assert find_jet_range(case, tmp_path)[1] == pytest.approx(20.0, rel=0.01)


def test_a_jet_in_a_side_is_looked_at_with_its_files_alone(tmp_path):
    side = THIN.replace("[0.04, 0.01, 0.001]", "[0.01, 0.1, 0.001]").replace("60.0", "120.0") + 'face = "left"\n'
    case = load_case(write(tmp_path, BACKGROUND, side))
    assert find_jet_range(case, None)[1] == 120.0
    assert find_jet_range(case, tmp_path)[1] == pytest.approx(120.0 * PART, rel=1e-9)
    assert numbers_of(case, tmp_path)["cells across inlet 2"].value == pytest.approx(0.2)


def test_a_jet_in_a_cylinder_is_measured_on_its_triangles(tmp_path):
    text = CASE.replace("[16, 4, 40]", "[16, 16, 40]").replace("[0.08, 0.02", "[0.08, 0.08")
    text = text.replace("[gas]", 'shape = "cylinder"\n[gas]')
    thin = THIN.replace("[0.04, 0.01, 0.001]", "[0.04, 0.04, 0.001]")
    case = load_case(write(tmp_path, thin, text=text))
    triangle = 6 * math.sqrt(3.0) / 4.0 * 0.005**2
    assert find_jet_range(case, tmp_path)[1] == pytest.approx(60.0 * math.pi / 4 * 1e-6 / triangle, rel=1e-6)
    assert find_jet_range(case, None) == find_jet_range(case, tmp_path)
    assert numbers_of(case, tmp_path)["cells across inlet 1"].value == pytest.approx(0.2, rel=0.1)
