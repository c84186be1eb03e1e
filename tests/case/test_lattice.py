"""No particle of the start touches another or a wall, and every layer covers the floor."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.bed.lattice import lattice_height, lattice_positions
from fbcouple.case.load import load_case


def smallest_distance(positions: np.ndarray, reach: float) -> float:
    """Smallest distance [m] of two particles nearer than `reach`: each one against the 27 cells of size `reach`."""
    cell = np.floor(positions / reach).astype(np.int64) + 1
    counts = cell.max(axis=0) + 2
    key = (cell[:, 2] * counts[1] + cell[:, 1]) * counts[0] + cell[:, 0]
    order = np.argsort(key, kind="stable")
    ordered, closest = key[order], np.inf
    for shift in np.ndindex(3, 3, 3):
        dx, dy, dz = np.array(shift) - 1
        other = key + (dz * counts[1] + dy) * counts[0] + dx
        first, end = np.searchsorted(ordered, other, "left"), np.searchsorted(ordered, other, "right")
        for step in range(int((end - first).max())):
            mine = np.flatnonzero(first + step < end)
            theirs = order[first[mine] + step]
            pairs = mine != theirs
            apart = np.linalg.norm(positions[mine[pairs]] - positions[theirs[pairs]], axis=1)
            closest = min(closest, apart.min(initial=np.inf))
    return float(closest)


def test_distance_finds_the_closest_pair():
    positions = np.random.default_rng(3).uniform(0.0, 1.0, (300, 3))
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    assert smallest_distance(positions, 0.2) == apart.min()


@pytest.mark.parametrize(
    "sets",
    [
        [],
        ["start.jitter=0.99", "start.spacing=1.01"],
        ["start.spacing=1.5", "start.seed=7"],
        ["domain.size=[0.08, 0.001, 2.0]", "start.jitter=0.99", "particles.mass=0.01"],
        ["particles.mass=0.125"],
    ],
)
def test_nothing_overlaps_and_all_is_inside(sets):
    case = load_case("patil/c2", sets)
    positions, radius = lattice_positions(case), case.particles.diameter / 2.0
    size = np.array(case.domain.size)
    assert (positions >= radius * (1 - 1e-12)).all() and (positions <= size - radius * (1 - 1e-12)).all()
    assert 2.0 * radius <= smallest_distance(positions, 2.2 * radius)
    assert positions[:, 2].max() + radius <= lattice_height(case) <= size[2]


def test_75_g_fill_the_floor_in_54_layers():
    case = load_case("patil/c2", ["start.jitter=0.0"])
    positions = lattice_positions(case)
    assert positions.shape == (57296, 3) and positions.dtype == np.float64
    assert lattice_height(case) == pytest.approx(54 * 1.03e-3)
    layer = positions[: 77 * 14]
    assert np.unique(layer[:, 0]).size == 77 and np.unique(layer[:, 1]).size == 14
    np.testing.assert_allclose(positions[0], [0.08 / 77 / 2, 0.015 / 14 / 2, 1.03e-3 / 2])
    np.testing.assert_allclose(layer.mean(axis=0), [0.04, 0.0075, 1.03e-3 / 2])


@pytest.mark.parametrize("rest", [14, 28, 154, 500, 539, 1077])
def test_last_layer_is_spread_evenly(rest):
    """Quarters of the floor along x, and halves along y, hold equal shares; 14 is a site in each row, 77 in each."""
    case = load_case("patil/c2", ["start.jitter=0.0", "averages.start=1.0"])
    particles = case.particles.model_copy(update={"mass": None, "count": 77 * 14 + rest})
    last = lattice_positions(case.model_copy(update={"particles": particles}))[77 * 14 :]
    assert len(last) == rest == len(np.unique(last, axis=0))
    quarters = np.histogram(last[:, 0], bins=4, range=(0.0, 0.08))[0]
    halves = np.histogram(last[:, 1], bins=2, range=(0.0, 0.015))[0]
    assert np.abs(quarters - rest / 4).max() <= max(2.0, 0.05 * rest)
    assert np.abs(halves - rest / 2).max() <= 1.0


def test_seed_repeats_and_jitter_moves():
    case, again, other = (load_case("patil/demo", [f"start.seed={seed}"]) for seed in (5, 5, 6))
    np.testing.assert_array_equal(lattice_positions(case), lattice_positions(again))
    moved = lattice_positions(case) - lattice_positions(other)
    assert np.abs(moved).max(axis=0).min() > 0.9 * 0.5 * 0.03e-3
    assert (np.abs(moved).max(axis=0) <= 0.5 * (np.array([0.08 / 77, 0.015 / 14, 1.03e-3]) - 1e-3)).all()
