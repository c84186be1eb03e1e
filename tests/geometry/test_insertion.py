"""Spheres at random places: none touches a wall or another one, across periodic sides too."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.geometry.insertion import insert
from fbcouple.geometry.overlap import add_images, find_max_overlap

BOUNDS = np.array([[0.0, 0.0, 0.0], [8.0, 6.0, 9.0]])


def everywhere(places, radii):
    return np.ones(len(places), bool)


@pytest.mark.parametrize("period", [(0, 0, 0), (8, 0, 0), (8, 6, 0)])
@pytest.mark.parametrize("spread", [1.0, 5.0])
def test_spheres_are_clear_of_each_other_and_of_walls(period, spread):
    """A fifth of the box, of one size and of sizes that are apart by a factor of five."""
    generator = np.random.default_rng(4)
    radii = 0.5 / generator.uniform(1.0, spread, 20_000)
    radii = radii[: np.searchsorted(np.cumsum(4 / 3 * np.pi * radii**3), 0.2 * 8 * 6 * 9)]
    places = insert(radii, BOUNDS, np.array(period, float), everywhere, generator)
    assert np.isfinite(places).all()
    walls = np.array(period) == 0
    assert (places >= BOUNDS[0]).all() and (places <= BOUNDS[1]).all()
    assert ((places >= BOUNDS[0] + radii[:, None]) & (places <= BOUNDS[1] - radii[:, None]))[:, walls].all()
    images, rows = add_images(places, np.array(period, float), 1.0)
    assert find_max_overlap(images, radii[rows], len(radii)) == 0.0
    assert np.ptp(places[:, 2]) > 7.5 and np.abs(places.mean(axis=0) / BOUNDS[1] - 0.5).max() < 0.1


def test_what_finds_no_room_is_told():
    radii = np.full(800, 0.5)
    places = insert(radii, BOUNDS, np.zeros(3), everywhere, np.random.default_rng(1), rounds=20)
    placed = ~np.isnan(places[:, 0])
    assert 150 < placed.sum() < 330 and find_max_overlap(places[placed], radii[placed], int(placed.sum())) == 0.0


def test_walls_of_any_shape_are_asked():
    def in_cylinder(places, radii):
        return np.hypot(places[:, 0] - 4, places[:, 1] - 3) + radii < 3.0

    places = insert(np.full(60, 0.5), BOUNDS, np.zeros(3), in_cylinder, np.random.default_rng(1))
    assert np.isfinite(places).all() and np.hypot(places[:, 0] - 4, places[:, 1] - 3).max() < 2.5


def test_spheres_wider_than_the_box_find_no_room():
    places = insert(np.array([0.5, 3.5]), BOUNDS, np.zeros(3), everywhere, np.random.default_rng(1), rounds=50)
    assert np.isfinite(places[0]).all() and np.isnan(places[1]).all()
