"""A feed in numbers: who is due when, of which kind, and where it finds a place that nobody is in."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.simulation.feed import FeedSource, FreeSpace

BOX = {"low": [0.0, 0.0, 0.02], "high": [0.01, 0.01, 0.03]}


def make_case(feed: dict, **particles) -> Case:
    return Case.model_validate(
        {
            "title": "feed",
            "end_time": 1.0,
            "domain": {"size": [0.01, 0.01, 0.04], "cells": [2, 2, 8], "periodic": ["x"]},
            "particles": {"diameter": 1e-3, "density": 2500.0, "count": 0, "feeds": [BOX | feed]} | particles,
        }
    )


def follow(source: FeedSource, times) -> list[int]:
    """Particles that have come in at each of `times`, if none waits."""
    counts = []
    for time in times:
        while due := source.list_due(time):
            source.take(due)
        counts.append(source.count)
    return counts


def test_rate_counts_whole_particles_between_start_and_end():
    source = FeedSource(make_case({"rate": 100.0, "start": 0.1, "end": 0.5}), 1)
    times = np.arange(101) * 0.01
    wanted = [round(100.0 * (min(time, 0.5) - 0.1)) if time > 0.1 else 0 for time in times]
    assert follow(source, times) == wanted and wanted[-1] == 40


def test_mass_flow_is_met_within_a_particle_at_every_time():
    mixture = {"mixture": [[2e-3, 1000.0, 0.5]], "spread": "normal", "deviation": 2e-4, "smallest": 5e-4}
    case = make_case({"mass_flow": 2e-3}, largest=1.5e-3, **mixture)
    source, masses = FeedSource(case, 1), []
    heaviest = 2500.0 * np.pi / 6 * 1.5e-3**3
    for time in np.linspace(0.0, 1.0, 50):
        while due := source.list_due(time):
            masses += [source._kinds[kind][1].mass for kind in due]
            source.take(due)
        assert 0.0 <= 2e-3 * time - sum(masses) < heaviest
    kinds = {source._draw_kind(number) for number in range(source.count)}
    assert kinds == set(range(8)), "all classes of the spread of species 1, none of species 2"


@pytest.mark.parametrize("ratio", [2.0, 1.5])
def test_parcels_come_at_the_rate_of_their_grains(ratio):
    source = FeedSource(make_case({"rate": 8000.0}, coarse_graining=ratio), 1)
    times = np.arange(101) * 0.01
    wanted = [int(8000.0 * time / ratio**3 + 1e-9) for time in times]
    assert follow(source, times) == wanted
    assert source.find_radii([0]) == pytest.approx(0.5e-3 * ratio)
    waits = FeedSource(make_case({"rate": 8000.0}, coarse_graining=ratio), 1)
    assert waits.count_owed(1.0) == wanted[-1]


def test_nobody_waits_whose_mass_is_not_due_yet():
    spread = {"spread": "lognormal", "deviation": 4e-4, "smallest": 3e-4, "largest": 2e-3}
    source = FeedSource(make_case({"mass_flow": 2e-3}, **spread), 1)
    for time in np.linspace(0.0, 1.0, 200):
        while due := source.list_due(time):
            source.take(due)
        assert source.count_owed(time) == 0
    assert source.count_owed(2.0) == pytest.approx(2e-3 / source._mean_cost, rel=0.1)


def test_those_that_wait_are_owed_and_not_drawn_anew():
    source, other = (FeedSource(make_case({"rate": 1000.0}, mixture=[[2e-3, 1e3, 0.5]]), 1) for _ in range(2))
    due = source.list_due(0.02)
    assert source.count_owed(0.02) == len(due) == 20
    source.take(due[:5])
    assert source.count_owed(0.02) == 15 and source.list_due(0.02) == due[5:]
    other.load(source.save())
    assert other.list_due(0.03) == source.list_due(0.03)
    assert np.array_equal(other.try_places([0], 7), source.try_places([0], 7))
    assert not np.array_equal(source.try_places([0], 8), source.try_places([0], 7))


def test_places_lie_within_the_box_and_over_the_whole_period():
    source = FeedSource(make_case({"rate": 1.0}), 1)
    places = source.try_places([0] * 500, 1).reshape(-1, 3)
    assert (places[:, 1:] >= [0.5e-3, 0.0205]).all() and (places[:, 1:] <= [9.5e-3, 0.0295]).all()
    assert places[:, 0].min() < 1e-5 and places[:, 0].max() > 0.01 - 1e-5
    assert np.abs(places.mean(axis=0) - [5e-3, 5e-3, 0.025]).max() < 1e-4, "evenly"


def test_nobody_comes_in_where_somebody_is_or_across_a_period():
    case = make_case({"rate": 1.0})
    space = FreeSpace(case, MPI.COMM_SELF)
    held, radii = np.array([[0.2e-3, 5e-3, 0.025], [5e-3, 5e-3, 0.025]]), np.array([0.5e-3, 0.5e-3])
    tried = np.array(
        [
            [[9.9e-3, 5e-3, 0.025], [5.9e-3, 5e-3, 0.025], [3e-3, 5e-3, 0.025]],  # two in the way of the first two
            [[3.2e-3, 5e-3, 0.025], [9.7e-3, 1e-3, 0.025], [2e-3, 1e-3, 0.025]],  # the first is the newcomer's
            [[0.3e-3, 1.2e-3, 0.025], [5e-3, 5e-3, 0.025], [5e-3, 5e-3, 0.025]],  # across the period, and taken
            [[8e-3, 8e-3, 0.025]] * 3,  # free, but its turn comes after the one that waits
        ]
    )
    taken: list[np.ndarray] = []
    found = space.choose(tried, np.full(4, 0.5e-3), held, radii, taken)
    assert np.array_equal(found, [[3e-3, 5e-3, 0.025], [9.7e-3, 1e-3, 0.025]]) and len(taken) == 2
    blocked = space.choose(found[:1, None], np.array([0.5e-3]), held, radii, taken)
    assert len(blocked) == 0, "places that others got in this step"


@pytest.mark.parametrize("radius", [0.5e-3, 0.3e-3])
def test_walls_are_asked_with_the_radius(radius):
    space = FreeSpace(make_case({"rate": 1.0}), MPI.COMM_SELF, lambda points, distance: points[:, 2] > 50 * distance)
    tried = np.array([[[5e-3, 5e-3, 0.02], [5e-3, 5e-3, 0.028]]])
    (found,) = space.choose(tried, np.array([radius]), np.empty((0, 3)), np.empty(0), [])
    assert found[2] == (0.028 if radius == 0.5e-3 else 0.02)
