"""How fast diffusion goes in the cells of a mesh: by hand of bricks, by symmetry of tetrahedra."""

from __future__ import annotations

import numpy as np
import pytest
from test_meshes import make_bricks

from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.diffusion import find_box_rate, measure_rates
from fbcouple.geometry.numbering import build_mesh


def test_a_brick_has_two_over_its_edge_squared_and_one_more_where_a_side_is_a_wall():
    rates = measure_rates(make_bricks((4, 3, 1), (0.4, 0.6, 0.25))).reshape(3, 4)
    along_x, along_y, along_z = np.array([3, 2, 2, 3]) / 0.01, np.array([3, 2, 3]) / 0.04, 4.0 / 0.0625
    assert rates == pytest.approx(along_y[:, None] + along_x + along_z, rel=1e-12)
    assert rates.max() == pytest.approx(find_box_rate(np.array([0.1, 0.2, 0.25]), (4, 3, 1), (False,) * 3), rel=1e-12)


def test_a_side_that_repeats_itself_is_no_wall():
    edges = np.array([0.1, 0.2, 0.25])
    assert find_box_rate(edges, (4, 1, 2), (True, True, False)) == pytest.approx(2 / 0.01 + 2 / 0.04 + 3 / 0.0625)


def test_a_lone_tetrahedron_has_its_four_faces():
    """Of a regular one of edge a: area sqrt(3)/4 a^2, volume a^3/(6 sqrt(2)), centre a/(2 sqrt(6)) off a face."""
    corners = 0.5 * np.array([[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]])
    edge = np.sqrt(2.0)
    mesh = build_mesh(corners, [("tetra", np.array([[0, 1, 2, 3]]))], ("walls",), lambda rows: np.zeros(len(rows), int))
    wanted = 4.0 * np.sqrt(3.0) / 4.0 * edge**2 * 2.0 * np.sqrt(6.0) / edge * 6.0 * np.sqrt(2.0) / edge**3
    assert measure_rates(mesh) == pytest.approx([wanted], rel=1e-12)


@pytest.mark.parametrize("elements", ["prisms", "tetrahedra"])
def test_layers_inside_a_cylinder_are_alike(elements):
    low, high = (measure_rates(make_cylinder(0.4, 0.1 * layers, 6, layers, elements)).max() for layers in (3, 7))
    assert low == pytest.approx(high, rel=1e-9)
