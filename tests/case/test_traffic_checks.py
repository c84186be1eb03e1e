"""Feeds and outlets of particles that do not fit their case are refused, in words, before anything is written."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.bed.feeds import count_fed
from fbcouple.case.bed.outlets import find_longest_step, find_reach, find_thickness
from fbcouple.case.bed.passing import find_in_openings
from fbcouple.case.checks.registry import find_problems
from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.memory import find_memory
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError

BOX = "low=[0.0,0.0,0.1],high=[0.12,0.0056,0.15]"
HOPPER = "anand/hopper"


def problems_of(*sets: str, case: str = HOPPER) -> list[str]:
    with pytest.raises(CaseError) as caught:
        load_case(case, list(sets))
    return caught.value.problems


@pytest.mark.parametrize(
    ("feed", "words"),
    [
        (BOX, ["feed 1: neither rate nor mass_flow is given; give one of them"]),
        (f"{BOX},rate=1.0,mass_flow=1.0", ["feed 1: rate and mass_flow are both given"]),
        (f"{BOX},rate=1.0,start=1.0,end=0.5", ["feed 1: it ends at 0.5 s and starts at 1 s"]),
        (f"{BOX},rate=1.0,species=3", ["feed 1: species 3 is given, 1 are there"]),
        ("low=[0.0,0.0,0.1],high=[0.001,0.0056,0.15],rate=1.0", ["holds no particle of 0.00224 m; enlarge it"]),
        ("low=[0.0,0.0,0.1],high=[0.12,0.1,0.15],rate=1.0", ["is not in the region, [0.0, 0.0, 0.0] to [0.12544"]),
        ("low=[0.1,0.0,0.1],high=[0.02,0.0056,0.15],rate=1.0", ["high has to be above low along each axis"]),
    ],
)
def test_feeds(feed, words):
    problems = problems_of(f"particles.feeds=[{{{feed}}}]")
    assert len(problems) == len(words)
    for problem, text in zip(problems, words, strict=True):
        assert problem.startswith("--set: particles.feeds: ") and text in problem


@pytest.mark.parametrize(
    ("outlet", "case", "words"),
    [
        ("face='top',depth=0.001", HOPPER, "it is -0.00012 m thick behind the radius of a particle that is out"),
        (
            "face='top',depth=0.0005",
            "patil/c2",
            "it is 0.0005 m thick, at least 0.001 m is allowed (a diameter)",
        ),
        ("face='top',low=[0.0,0.0,0.0]", HOPPER, "face and low or high are given"),
        ("start=0.1", HOPPER, "none of them is given; give face, patches, or low and high of a box"),
        ("low=[0.0,0.0,0.1]", HOPPER, "low and high are not both given"),
        ("rectangle=[[0.0,0.0],[0.1,0.1]],patches=['a']", HOPPER, "rectangle is given and no face"),
        (f"{BOX},depth=0.01", HOPPER, "depth = 0.01 m is given and no face"),
        (BOX, HOPPER, "outlet 1 takes out what feed 1 brings, their boxes overlap"),
        ("face='front'", HOPPER, "the bed repeats itself there; give another face"),
        ("patches=['drain']", HOPPER, 'patches is given and domain.shape is "box"; give face'),
        ("face='floor',rectangle=[[0.0,0.0],[0.0,0.005]]", HOPPER, "has no area"),
        ("face='left',circle=[0.0028,0.1,0.01]", HOPPER, "which has y from 0 to 0.0056 m and z from 0 to 0.162 m"),
    ],
)
def test_outlets(outlet, case, words):
    (problem,) = problems_of(f"particles.outlets=[{{{outlet}}}]", case=case)
    assert problem.startswith("--set: particles.outlets: ") and words in problem


@pytest.mark.parametrize(("diameter", "verdict"), [(0.02, "warn"), (0.1, "fit")])
def test_what_an_opening_has_of_the_faces_of_a_cylinder_is_told(diameter, verdict):
    sets = [f"particles.outlets=[{{face='floor',circle=[0.05,0.05,{diameter}]}}]"]
    case = load_case("verma/1.02", sets)
    (number,) = [one for one in estimate(case) if one.name == "area of particles.outlets 1"]
    assert number.verdict == verdict and number.limit.endswith("within 10 %")


@pytest.mark.parametrize("other", ["circle=[0.03,0.0028,0.005],", "rectangle=[[0.01,0.0],[0.03,0.003]],", ""])
def test_openings_that_overlap(other):
    opening = "{face='floor',rectangle=[[0.0,0.0],[0.028,0.0056]]}"
    (problem,) = problems_of(f"particles.outlets=[{opening},{{{other}face='floor'}}]")
    assert "outlets 1 and 2 overlap on the face floor; move them apart" in problem
    apart = "{face='floor',rectangle=[[0.028,0.0],[0.04,0.0056]]},{face='floor',circle=[0.06,0.0028,0.005]}"
    load_case(HOPPER, [f"particles.outlets=[{opening},{apart},{{face='left'}}]"])


def test_what_is_out_without_gas_has_passed_the_wall():
    assert find_reach(load_case(HOPPER)) == 1.12e-3 and find_reach(load_case("patil/c2")) == 0.0


def test_no_particles_and_none_to_come():
    (problem,) = problems_of("particles.feeds=[]")
    assert "particles.count: 0 is given and no particles.feeds" in problem


def test_less_than_half_a_parcel_and_none_to_come():
    problems = problems_of("particles.feeds=[]", "particles.count=3", "particles.coarse_graining=2")
    words = "particles.count: 3 is given, less than half a parcel of 8 particles, and no particles.feeds"
    assert any(words in problem for problem in problems)


@pytest.mark.parametrize("few", [["particles.count=0"], ["particles.count=3", "particles.coarse_graining=2"]])
def test_an_empty_start_is_not_poured(few):
    problems = problems_of("start.method=pour", *few)
    assert any('start.method: "pour" is given and the start is empty' in problem for problem in problems)


def test_what_is_fed_counts_for_the_memory():
    case = load_case(HOPPER)
    assert count_fed(case) == pytest.approx(6790.0, rel=1e-12) and find_problems(case) == []
    assert find_memory(case) - SHIPPED.rank_memory == pytest.approx(6790 * SHIPPED.particle_memory)
    flow = load_case(HOPPER, [f"particles.feeds=[{{{BOX},mass_flow=0.1,start=1.0,end=3.0}}]"])
    mass = 2500.0 * 3.141592653589793 / 6.0 * 2.24e-3**3
    assert count_fed(flow) == pytest.approx(0.2 / mass, rel=1e-12)


def test_step_is_short_enough_for_the_thinnest_outlet():
    case = load_case(HOPPER)
    (outlet,) = case.particles.outlets
    assert find_thickness(case, outlet) == pytest.approx(7.5 * 2.24e-3)
    assert find_longest_step(case) * (2 * 9.81 * 0.162) ** 0.5 == pytest.approx(0.5 * 7.5 * 2.24e-3)
    assert find_longest_step(load_case("patil/c2")) == float("inf")


def test_what_feeds_bring_counts_for_the_settled_height_and_late_ones_are_told():
    feed = "particles.feeds=[{{low=[0.0,0.0,0.1],high=[0.12,0.0056,0.15],rate={},start={}}}]"
    numbers = {one.name: one for one in estimate(load_case(HOPPER, [feed.format(1e6, 0.0)]))}
    assert numbers["settled height"].value > 0.162 and numbers["settled height"].verdict is None, "it has an outlet"
    assert "overlap at rest" not in numbers and "start of particles.feeds 1" not in numbers
    closed = estimate(load_case(HOPPER, [feed.format(1e6, 0.0), "particles.outlets=[]"]))
    assert next(one for one in closed if one.name == "settled height").verdict == "warn"
    late = estimate(load_case(HOPPER, [feed.format(10.0, 99.0)]))
    assert next(one for one in late if one.name == "start of particles.feeds 1").verdict == "warn"


@pytest.mark.parametrize("shape", ["box", "cylinder"])
def test_particles_in_an_opening_are_about_to_leave_and_those_at_its_wall_are_not(shape):
    """0.2 mm over the floor, which the margin of 0.4 mm forbids: over the opening, beside it, below the floor."""
    sets = ["domain.shape=cylinder", "domain.size=[0.1,0.1,0.36]", "domain.cells=[16,16,58]"]
    outlet = "particles.outlets=[{face='floor',rectangle=[[0.04,0.04],[0.06,0.06]]}]"
    if shape == "box":
        sets = ["domain.shape=box", "domain.size=[0.1,0.1,0.36]", "domain.cells=[16,16,58]"]
    case = load_case("verma/1.02", [*sets, outlet])
    positions = np.array([[0.05, 0.05, 2e-4], [0.02, 0.05, 2e-4], [0.05, 0.05, -2e-4], [0.05, 0.05, 1e-2]])
    found = find_in_openings(case, Path(), positions, np.full(4, 4e-4))
    assert found.tolist() == [True, False, False, True]
    shut = load_case("verma/1.02", [*sets, outlet.replace("}]", ",start=1.0}]")])
    assert not find_in_openings(shut, Path(), positions, np.full(4, 4e-4)).any()
    assert find_in_openings(shut, Path(), positions, np.full(4, 4e-4), math.inf).tolist() == [True, False, False, True]
