"""The largest overlap and the contacts by a cell list against all pairs."""

import numpy as np
import pytest

from fbcouple.geometry.overlap import add_images, count_contacts, find_max_overlap, find_worst_overlap


def search_all_pairs(positions, radii, count):
    """Largest (r_p + r_q - |x_p - x_q|)/(r_p + r_q), at least 0, over pairs with one or two of the first `count`."""
    distances = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    touch = radii[:, None] + radii[None]
    overlaps = (touch - distances) / touch
    np.fill_diagonal(overlaps, 0.0)
    return max(float(overlaps[:count].max(initial=0.0)), 0.0)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("spread", [0.0, 0.7], ids=["equal", "polydisperse"])
def test_is_that_of_all_pairs(seed, spread):
    rng = np.random.default_rng(seed)
    n = 150
    radii = 5e-4 * (1.0 + spread * rng.uniform(-1, 1, n))
    # From dense to nearly empty, so that some seeds have no contact at all.
    box = np.array([0.008, 0.003, 0.02]) * 1.25**seed
    positions = rng.random((n, 3)) * box - 0.01
    count = int(rng.integers(1, n + 1))
    expected = search_all_pairs(positions, radii, count)
    assert find_max_overlap(positions, radii, count) == pytest.approx(expected, abs=1e-12)


def test_two_spheres():
    """Centres 0.9 diameters apart overlap by a tenth; of radii 1 and 2, 2.4 apart, by 0.6/3."""
    positions = np.array([[0.0, 0.0, 0.0], [0.0, 0.9e-3, 0.0]])
    assert find_max_overlap(positions, np.full(2, 5e-4), 2) == pytest.approx(0.1, rel=1e-12)
    positions = np.array([[0.0, 0.0, 0.0], [2.4, 0.0, 0.0]])
    assert find_max_overlap(positions, np.array([1.0, 2.0]), 2) == pytest.approx(0.2, rel=1e-12)


@pytest.mark.parametrize("direction", [*np.eye(3).tolist(), [-1, 1, 1], [1, -1, 0]])
def test_neighbours_across_the_edge_of_a_bin_count(direction):
    step = np.array(direction) / np.linalg.norm(direction) * 0.99e-3
    chain = np.arange(12)[:, None] * step
    assert find_max_overlap(chain, np.full(12, 5e-4), 12) == pytest.approx(0.01, rel=1e-9)


def test_spheres_that_just_do_not_touch_have_none():
    lattice = np.stack(np.meshgrid(*[np.arange(4)] * 3), axis=-1).reshape(-1, 3) * 1.000001e-3
    assert find_max_overlap(lattice, np.full(64, 5e-4), 64) == 0.0


def test_pairs_of_neighbours_ghosts_are_theirs_to_count():
    positions = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.5, 0.0, 0.0], [0.0, 1.8, 0.0]])
    radii = np.ones(4)
    assert find_max_overlap(positions, radii, 1) == pytest.approx(0.1, rel=1e-12)
    assert find_max_overlap(positions, radii, 2) == pytest.approx(0.75, rel=1e-12)


@pytest.mark.parametrize("rows", [0, 3])
def test_a_rank_without_particles_has_none(rows):
    assert find_max_overlap(np.zeros((rows, 3)), np.ones(rows), 0) == 0.0


def test_both_particles_of_the_largest_overlap_are_named():
    positions = np.array([[9.0, 0.0, 0.0], [0.0, 0.0, 0.0], [9.0, 1.5, 0.0], [0.0, 0.0, 0.4]])
    assert find_worst_overlap(positions, np.ones(4), 4)[1:] == (1, 3)
    assert find_worst_overlap(np.diag([9.0, 19.0, 29.0]), np.ones(3), 3) == (0.0, -1, -1)


@pytest.mark.parametrize("seed", range(6))
def test_images_make_every_pair_across_periodic_sides(seed):
    """Against all pairs by their nearest images, in a box that is periodic along x and y."""
    rng = np.random.default_rng(seed)
    box, radii = np.array([6.0, 5.0, 30.0]), rng.uniform(0.3, 0.8, 40)
    positions = rng.random((40, 3)) * box
    apart = positions[:, None] - positions[None]
    apart[..., :2] -= box[:2] * np.round(apart[..., :2] / box[:2])
    touch = radii[:, None] + radii[None]
    overlaps = np.triu(1.0 - np.linalg.norm(apart, axis=2) / touch, 1)
    points, rows = add_images(positions, np.array([6.0, 5.0, 0.0]), 1.6)
    overlap, one, other = find_worst_overlap(points, radii[rows], 40)
    assert overlap == pytest.approx(overlaps.max(), rel=1e-12) and overlap > 0.0
    assert {int(rows[one]), int(rows[other])} == set(map(int, np.unravel_index(overlaps.argmax(), overlaps.shape)))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("spread", [0.0, 0.7], ids=["equal", "polydisperse"])
def test_contacts_are_counted_once(seed, spread):
    """All pairs that touch; one of an own particle and another rank's counts half, so that all ranks make the whole."""
    rng = np.random.default_rng(seed)
    n = 200
    radii = 5e-4 * (1.0 + spread * rng.uniform(-1, 1, n))
    positions = rng.random((n, 3)) * np.array([0.008, 0.003, 0.02]) * 1.2**seed
    distances = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    touches = np.triu(distances < radii[:, None] + radii[None], 1)
    assert count_contacts(positions, radii, n) == touches.sum() > 0
    own = n // 3
    half = touches[:own, :own].sum() + 0.5 * touches[:own, own:].sum()
    assert count_contacts(positions, radii, own) == half
    assert count_contacts(positions[:0], radii[:0], 0) == 0.0
