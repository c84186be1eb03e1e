"""Kinds of particles: shares by mass and by number, distributions cut into classes, and what cannot be mixed."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
import pytest

import fbcouple.case.load  # noqa: F401  (registers the checks)
from fbcouple.case.bed.lattice import is_layered, lattice_height, lattice_kinds, lattice_positions
from fbcouple.case.bed.layers import stack
from fbcouple.case.bed.particle_types import count_kinds, draw_kinds, list_kinds, mean_density, mean_kind, solids_volume
from fbcouple.case.bed.positions import start_kinds
from fbcouple.case.checks.registry import find_problems
from fbcouple.case.preflight import estimate
from fbcouple.case.schema.particles import Particles
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.overlap import find_max_overlap


def make(**particles):
    return Particles.model_validate({"diameter": 1e-3, "density": 2500.0} | particles)


def make_case(**changes):
    content = {
        "title": "a mixture",
        "end_time": 1.0,
        "domain": {"size": [0.02, 0.02, 0.05], "cells": [5, 5, 12]},
        "gas": {"density": 1.2, "viscosity": 1.8e-5, "inlet_velocity": 1.0},
        "particles": {"diameter": 1e-3, "density": 2500.0, "count": 1000},
        "contact": {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.1, "wall_friction": 0.1},
        "start": {},
        "exchange": {},
    }
    for section, table in changes.items():
        content[section] = content[section] | table
    return Case.model_validate(content)


def test_without_a_mixture_there_is_one_kind_that_holds_all():
    (kind,) = list_kinds(make(mass=0.075))
    assert (kind.diameter, kind.density, kind.species, kind.share) == (1e-3, 2500.0, 1, 1.0)
    assert count_kinds(make(mass=0.075)) == [57296]


def test_fractions_by_mass():
    """A quarter of the mass in particles of half the diameter and twice the density: a part 1/4 / (3/4 / 4 + 1/4)."""
    particles = make(mass=0.01, mixture=[[0.5e-3, 5000.0, 0.25]])
    counts, kinds = count_kinds(particles), list_kinds(particles)
    masses = [count * kind.mass for count, kind in zip(counts, kinds, strict=True)]
    assert sum(masses) == pytest.approx(0.01, rel=1e-3) and masses[1] == pytest.approx(0.0025, rel=1e-3)
    assert counts[1] / counts[0] == pytest.approx(4 / 3, rel=1e-3)
    assert [kind.species for kind in kinds] == [1, 2]


def test_fractions_by_number():
    mixture = [[2e-3, 1000.0, 0.24], [3e-3, 1000.0, 0.36]]
    assert count_kinds(make(count=10, fractions="number", mixture=mixture)) == [4, 2, 4]


@pytest.mark.parametrize("count", [3, 10, 101, 99_999])
def test_counts_add_up_and_are_within_one_of_their_share(count):
    particles = make(count=count, fractions="number", mixture=[[2e-3, 1000.0, 0.17], [3e-3, 1000.0, 0.21]])
    counts = count_kinds(particles)
    assert sum(counts) == count
    assert np.abs(np.array(counts) - np.array([0.62, 0.17, 0.21]) * count).max() < 1


@pytest.mark.parametrize("classes", [2, 8, 50])
def test_classes_of_a_normal_distribution_keep_its_mean_volume(classes):
    """E[d^3] = m^3 + 3 m s^2 of a normal one, its cut-offs too far off to matter; equal numbers in each class."""
    middle, deviation = 1e-3, 0.1e-3
    spread = {"spread": "normal", "deviation": deviation, "smallest": 0.3e-3, "largest": 1.7e-3, "classes": classes}
    kinds = list_kinds(make(count=1000, fractions="number", **spread))
    assert [kind.share for kind in kinds] == pytest.approx([1 / classes] * classes, rel=1e-3)
    mean = sum(kind.share * kind.diameter**3 for kind in kinds)
    assert mean == pytest.approx(middle**3 + 3 * middle * deviation**2, rel=1e-3)
    assert np.diff([kind.diameter for kind in kinds]).min() > 0


def test_two_classes_of_a_normal_distribution_by_hand():
    """The mean of the upper half lies sqrt(2/pi) s above the mean; the cube's mean hardly above that if s is small."""
    spread = {"spread": "normal", "deviation": 1e-5, "smallest": 0.9e-3, "largest": 1.1e-3, "classes": 2}
    low, high = (kind.diameter for kind in list_kinds(make(count=10, fractions="number", **spread)))
    shift = math.sqrt(2 / math.pi) * 1e-5
    assert high == pytest.approx(1e-3 + shift, abs=1e-7) and low == pytest.approx(1e-3 - shift, abs=1e-7)


def test_a_lognormal_distribution_has_its_median_and_its_deviation():
    """By number, ln(d) is normal about ln(median) with ln(1 + deviation/diameter)."""
    spread = {"spread": "lognormal", "deviation": 0.2e-3, "smallest": 0.1e-3, "largest": 5e-3, "classes": 50}
    kinds = list_kinds(make(count=1000, fractions="number", **spread))
    logs = np.log([kind.diameter / 1e-3 for kind in kinds])
    assert np.mean(logs) == pytest.approx(0.0, abs=2e-3)
    assert np.std(logs) == pytest.approx(math.log(1.2), rel=0.01)


@pytest.mark.parametrize("fractions", ["mass", "number"])
@pytest.mark.parametrize("deviation", [1e-5, 1e-6, 1e-7, 1e-9])
@pytest.mark.parametrize("spread", ["normal", "lognormal"])
@pytest.mark.filterwarnings("error")
def test_a_narrow_distribution_between_wide_limits(spread, deviation, fractions):
    """Two halves lie sqrt(2/pi) s off the middle, and 50 classes have its deviation, however narrow it is."""
    wide = {"spread": spread, "deviation": deviation, "smallest": 1e-5, "largest": 5e-3, "fractions": fractions}
    low, high = (kind.diameter for kind in list_kinds(make(count=2000, classes=2, **wide)))
    assert [low - 1e-3, high - 1e-3] == pytest.approx([-math.sqrt(2 / math.pi) * deviation, -(low - 1e-3)], rel=0.05)
    many = list_kinds(make(count=2000, classes=50, **wide))
    assert np.std([kind.diameter for kind in many]) == pytest.approx(deviation, rel=0.05)
    assert sum(count_kinds(make(count=2000, classes=50, **wide))) == 2000
    assert find_problems(make_case(particles=wide | {"classes": 50})) == []


@pytest.mark.parametrize(("deviation", "smallest"), [(0.1e-3, 0.1e-3), (0.1e-3, 1e-6), (0.15e-3, 0.99e-3)])
def test_wider_limits_change_nothing_where_nothing_is_left(deviation, smallest):
    """A cut-off within the distribution still cuts it."""
    spread = {"spread": "normal", "deviation": deviation, "smallest": smallest, "largest": 2e-3, "classes": 8}
    found = [kind.diameter for kind in list_kinds(make(count=1000, fractions="number", **spread))]
    edges = NormalDist(1e-3, deviation)
    low = edges.cdf(smallest)
    middles = [edges.inv_cdf(low + (1.0 - low) * (n + 0.5) / 8) for n in range(8)]
    assert found[1:-1] == pytest.approx(middles[1:-1], rel=2e-3) and min(found) > smallest


@pytest.mark.parametrize("fractions", ["mass", "number"])
def test_a_wide_lognormal_distribution_keeps_its_mean_volume(fractions):
    """E[d^3] by number is m^3 exp(9 s^2/2); by mass 1/E[d^-3] is m^3 exp(-9 s^2/2)."""
    wide = {"spread": "lognormal", "deviation": 0.7e-3, "smallest": 1e-7, "largest": 10.0, "classes": 20}
    kinds = list_kinds(make(count=1000, fractions=fractions, **wide))
    sign = 1.0 if fractions == "number" else -1.0
    mean = sum(kind.share * kind.diameter**3 for kind in kinds)
    assert mean == pytest.approx(1e-9 * math.exp(sign * 4.5 * math.log(1.7) ** 2), rel=5e-3)


@pytest.mark.filterwarnings("error")
def test_a_distribution_that_cannot_be_calculated_is_told():
    tiny = {"diameter": 1e-150, "spread": "normal", "deviation": 1e-151, "smallest": 1e-152, "largest": 1.0}
    problems = find_problems(make_case(particles=tiny))
    assert [problem for problem in problems if problem.startswith("particles.deviation: 1e-151 m is given; with it no")]


def test_a_distribution_by_mass_has_equal_masses_in_its_classes():
    spread = {"spread": "normal", "deviation": 0.2e-3, "smallest": 0.4e-3, "largest": 1.6e-3, "classes": 4}
    particles = make(mass=0.05, **spread)
    masses = [c * kind.mass for c, kind in zip(count_kinds(particles), list_kinds(particles), strict=True)]
    assert masses == pytest.approx([0.0125] * 4, rel=1e-2) and sum(masses) == pytest.approx(0.05, rel=1e-4)


def test_means_of_a_mixture():
    """One of 1 mm, one of 2 mm: volumes 1 and 8, surfaces 1 and 4; densities 1000 and 2000."""
    particles = make(count=2, density=1000.0, fractions="number", mixture=[[2e-3, 2000.0, 0.5]])
    assert mean_kind(particles).diameter == pytest.approx(1e-3 * 9 / 5)
    assert mean_density(particles) == pytest.approx(17000 / 9)
    assert solids_volume(particles) == pytest.approx(9 * math.pi / 6 * 1e-9)


def test_no_two_particles_of_a_mixed_lattice_touch():
    case = make_case(particles={"mixture": [[0.4e-3, 2500.0, 0.3], [1.6e-3, 1000.0, 0.3]]}, start={"jitter": 0.99})
    assert find_problems(case) == []
    positions, kinds = lattice_positions(case), lattice_kinds(case)
    radii = np.array([kind.diameter / 2 for kind in list_kinds(case.particles)])[kinds]
    distances = np.linalg.norm(positions[:, None] - positions[None], axis=2) + 9.0 * np.eye(len(positions))
    assert (distances - radii[:, None] - radii[None]).min() > 0
    assert (np.minimum(positions, [0.02, 0.02, 1.0] - positions) - radii[:, None]).min() > 0


TEN_TO_ONE = {"diameter": 2e-3, "density": 1000.0, "count": None, "mass": 4e-4, "mixture": [[2e-4, 1000.0, 0.3]]}


def judge_start(case, positions, kinds):
    """All particles are there, inside the box, and no two touch."""
    known = list_kinds(case.particles)
    radii = np.array([kind.diameter / 2 for kind in known])[kinds]
    assert np.bincount(kinds, minlength=len(known)).tolist() == count_kinds(case.particles)
    assert (np.minimum(positions, case.domain.size - positions) - radii[:, None]).min() > 0
    assert find_max_overlap(positions, radii, len(radii)) == 0.0


@pytest.mark.parametrize("jitter", [0.0, 0.99])
def test_a_ten_to_one_mixture_starts_in_layers_of_like_size(jitter):
    """67 of 2 mm in layers of 9 x 4 and 28648 of 0.2 mm in layers of 97 x 48: 2 and 7 layers. Mixed, 798 of 9 x 4."""
    size = {"size": [0.02, 0.01, 0.02], "cells": [5, 2, 5]}
    case = make_case(domain=size, particles=TEN_TO_ONE, start={"jitter": jitter})
    assert find_problems(case) == []
    positions, kinds = lattice_positions(case), lattice_kinds(case)
    judge_start(case, positions, kinds)
    fine, coarse = positions[kinds == 1][:, 2], positions[kinds == 0][:, 2]
    assert (
        lattice_height(case) == pytest.approx(2 * 2.06e-3 + 7 * 0.206e-3)
        and fine.min() < coarse.max()
        and coarse.min() < fine.max()
    )
    again = make_case(domain=size, particles=TEN_TO_ONE, start={"jitter": jitter})
    assert (lattice_positions(again) == positions).all() and (lattice_kinds(again) == kinds).all()
    number = {number.name: number for number in estimate(case)}["start height"]
    assert number.value == lattice_height(case) and "would be 1.644 m high" in number.meaning


def test_layers_that_are_too_high_are_told_with_both_heights():
    size = {"size": [0.02, 0.01, 0.005], "cells": [5, 2, 2]}
    (problem,) = find_problems(make_case(domain=size, particles=TEN_TO_ONE))
    assert (
        "the lattice of layers of one kind each is 0.005562 m high" in problem and "mixes the kinds 1.644 m" in problem
    )


def test_a_mixture_that_fits_is_mixed_at_random():
    """Its start is what it was before there were layers, to the last bit."""
    case = make_case(particles={"mixture": [[0.4e-3, 2500.0, 0.3]]})
    kinds = lattice_kinds(case)
    assert (kinds == draw_kinds(case.particles, 1)).all() and not is_layered(case)
    spacing = np.array([0.02 / 19, 0.02 / 19, 1.03e-3])
    shift = np.random.default_rng(1).uniform(-1.0, 1.0, (1000, 3))
    diameters = np.array([1e-3, 0.4e-3])[kinds]
    sites = np.stack(np.unravel_index(np.arange(361), (1, 19, 19))[::-1], axis=1)
    wanted = (sites + 0.5) * spacing + (shift * 0.25 * (spacing - diameters[:, None]))[:361]
    np.testing.assert_array_equal(lattice_positions(case)[:361], wanted)


def test_a_cylinder_takes_a_ten_to_one_mixture_in_layers():
    domain = {"shape": "cylinder", "size": [0.02, 0.02, 0.012], "cells": [6, 6, 4]}
    particles = TEN_TO_ONE | {"mass": 3e-4, "mixture": [[4e-4, 1000.0, 0.3]]}
    case = make_case(domain=domain, particles=particles)
    positions, kinds = lattice_positions(case), lattice_kinds(case)
    judge_start(case, positions, kinds)
    radii = np.array([kind.diameter / 2 for kind in list_kinds(case.particles)])[kinds]
    assert (np.hypot(*(positions[:, :2] - 0.01).T) + radii).max() < 0.01
    low = make_case(domain=domain | {"size": [0.02, 0.02, 0.0022]}, particles=particles)
    with pytest.raises(CaseError, match="sites inside, one with a kind a layer room for"):
        lattice_positions(low)


def test_a_layer_takes_the_kind_of_which_most_is_left():
    """Ten of one kind in layers of 5, three of another one a layer; where none has sites the stack goes up."""
    layers = list(
        stack([10, 3], np.array([1.0, 2.0]), lambda kind, floor: (5, 1)[kind] if floor > 0.5 else 0, 0.0, 99.0)
    )
    assert [(layer.kind, layer.count, layer.floor) for layer in layers] == [
        (1, 1, 1.0),
        (0, 5, 3.0),
        (1, 1, 4.0),
        (0, 5, 6.0),
        (1, 1, 7.0),
    ]
    assert sum(layer.count for layer in stack([10, 3], np.array([1.0, 2.0]), lambda kind, floor: 1, 0.0, 4.0)) < 13


def test_the_order_of_the_kinds_follows_the_seed():
    particles = make(count=500, mixture=[[2e-3, 2500.0, 0.5]])
    assert (draw_kinds(particles, 1) == draw_kinds(particles, 1)).all()
    assert (draw_kinds(particles, 1) != draw_kinds(particles, 2)).any()


def test_a_positions_file_may_say_the_kinds(tmp_path):
    particles = {"count": 2, "fractions": "number", "mixture": [[2e-3, 2500.0, 0.5]], "positions": "start.csv"}
    case = make_case(particles=particles).model_copy(update={"start": None})
    (tmp_path / "start.csv").write_text("x,y,z,kind\n0.01,0.01,0.01,2\n0.01,0.01,0.02,1\n")
    assert find_problems(case, tmp_path) == [] and start_kinds(case, tmp_path).tolist() == [1, 0]
    (tmp_path / "start.csv").write_text("x,y,z,kind\n0.01,0.01,0.01,1\n0.01,0.01,0.02,1\n")
    (problem,) = find_problems(case, tmp_path)
    assert "start.csv holds [2, 0] particles of each kind and the case [1, 1]" in problem
    (tmp_path / "start.csv").write_text("x,y,z,kind\n0.01,0.01,0.01,1.5\n0.01,0.01,0.02,0\n")
    (problem,) = find_problems(case, tmp_path)
    assert "the kind of particle 1 is no whole number from 1" in problem


SPREAD = {"spread": "normal", "deviation": 1e-4, "smallest": 0.7e-3, "largest": 1.3e-3}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"particles": {"mixture": [[1e-3, 1e3, 0.5], [2e-3, 1e3, 0.5]]}},
            "particles.mixture: the fractions add up to 1",
        ),
        ({"particles": {"mixture": [[1e-3, 1e3, 1e-9]]}}, "the bed holds less than one particle of 0.001 m and 1000"),
        ({"particles": {"mixture": [[0.03, 1e3, 0.5]]}}, "particles.diameter: 0.03 m is given, but the box is 0.02 m"),
        ({"particles": {"deviation": 1e-4}}, "particles.deviation: 0.0001 is given and no spread"),
        (
            {"particles": SPREAD | {"largest": None}},
            'particles.largest: nothing is given and spread = "normal" needs it',
        ),
        (
            {"particles": SPREAD | {"smallest": 1.1e-3}},
            "particles.smallest: 0.0011 to 0.0013 m does not hold the diameter",
        ),
        ({"contact": {"pairs": [[1, 2, 0.9, 0.1]]}}, "contact.pairs: species 1 and 2 is given, 1 to 1 are there"),
        ({"contact": {"pairs": [[1, 1, 0.9, 0.1]] * 2}}, "contact.pairs: species 1 and 1 is given twice"),
        ({"contact": {"walls": [[2, 0.9, 0.1]]}}, "contact.walls: species 2 is given, 1 to 1 are there"),
    ],
)
def test_what_does_not_fit_together_is_told(changes, words):
    (problem,) = find_problems(make_case(**changes))
    assert words in problem


def test_a_row_the_other_way_round_is_the_same_pair():
    case = make_case(
        particles={"mixture": [[2e-3, 2500.0, 0.5]]}, contact={"pairs": [[1, 2, 0.9, 0.1], [2, 1, 0.8, 0.1]]}
    )
    (problem,) = find_problems(case)
    assert "species 2 and 1 is given twice" in problem


def test_pre_flight_of_a_mixture():
    """Terminal velocity of the smallest, cells over the largest, drop from weight less buoyancy."""
    case = make_case(particles={"mixture": [[0.5e-3, 2500.0, 0.5], [2e-3, 1000.0, 0.2]]})
    numbers = {number.name: number.value for number in estimate(case)}
    alone = {n.name: n.value for n in estimate(make_case(particles={"diameter": 0.5e-3}))}
    assert numbers["terminal velocity"] == pytest.approx(alone["terminal velocity"], rel=1e-9)
    assert numbers["DEM step"] == pytest.approx(alone["DEM step"], rel=1e-9)
    assert numbers["cell size x"] == pytest.approx(2.0)
    particles = case.particles
    weight = solids_volume(particles) * (mean_density(particles) - 1.2) * 9.81 / 0.0004
    assert numbers["pressure drop"] == pytest.approx(weight)
