"""Feeds and outlets of particles that do not fit their case are refused, in words, before anything is written."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.case.bed.feeds import count_fed, find_longest_step, list_zones
from fbcouple.case.checks.registry import find_problems, needed_memory
from fbcouple.case.load import load_case
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
        ("face='top',depth=0.001", HOPPER, "outlet 1: it is 0.001 m thick, at least 0.00224 m is allowed (a diameter)"),
        ("face='top',depth=1.0", HOPPER, "it is 1 m deep and the region 0.162 m high"),
        ("face='top',low=[0.0,0.0,0.0]", HOPPER, "low or high is given and face = top"),
        ("low=[0.0,0.0,0.1]", HOPPER, "low and high are not both given"),
        (f"{BOX},depth=0.01", HOPPER, "depth = 0.01 m is given and no face"),
        (BOX, HOPPER, "outlet 1 takes out what feed 1 brings, their boxes overlap"),
        ("face='floor',low=[0.0,0.0,0.1],high=[0.12,0.0056,0.15]", HOPPER, "have z = 0, 0.1 and 0.15 m are given"),
        ("face='floor',low=[0.0,0.0,0.0],high=[0.02,0.015,0.0]", "patil/c2", "face = floor is for a box without gas"),
    ],
)
def test_outlets(outlet, case, words):
    (problem,) = problems_of(f"particles.outlets=[{{{outlet}}}]", case=case)
    assert problem.startswith("--set: particles.outlets: ") and words in problem


def test_two_openings_in_the_floor():
    opening = "{face='floor',low=[0.0,0.0,0.0],high=[0.02,0.0056,0.0]}"
    (problem,) = problems_of(f"particles.outlets=[{opening},{opening}]")
    assert "two have face = floor; one opening in the floor is allowed" in problem


def test_no_particles_and_none_to_come():
    (problem,) = problems_of("particles.feeds=[]")
    assert "particles.count: 0 is given and no particles.feeds" in problem


def test_what_is_fed_counts_for_the_memory():
    case = load_case(HOPPER)
    assert count_fed(case) == pytest.approx(6790.0, rel=1e-12) and find_problems(case) == []
    assert needed_memory(case) > 6790 * 1000
    flow = load_case(HOPPER, [f"particles.feeds=[{{{BOX},mass_flow=0.1,start=1.0,end=3.0}}]"])
    mass = 2500.0 * 3.141592653589793 / 6.0 * 2.24e-3**3
    assert count_fed(flow) == pytest.approx(0.2 / mass, rel=1e-12)


def test_step_is_short_enough_for_the_thinnest_outlet():
    case = load_case(HOPPER)
    (zone,) = list_zones(case, np.zeros(3), np.array(case.domain.size))
    assert zone.thickness == pytest.approx(7.5 * 2.24e-3) and zone.high[2] == pytest.approx(-1.12e-3)
    assert find_longest_step(case) * (2 * 9.81 * 0.162) ** 0.5 == pytest.approx(0.5 * zone.thickness)
    assert find_longest_step(load_case("patil/c2")) == float("inf")
