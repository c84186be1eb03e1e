"""Contact options that do not fit together, each with its text."""

from __future__ import annotations

import math

import pytest

from fbcouple.case.bed.derived import dem_step, hertz_contact_time, hertz_overlap, pair_contact_time
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError

HERTZ = [
    "contact.model=hertz",
    "contact.youngs_modulus=5e6",
    "contact.poisson_ratio=0.25",
    "contact.impact_speed=2",
    "contact.tangential=history",
]


def problems_of(*sets):
    with pytest.raises(CaseError) as caught:
        load_case("patil/c2", sets)
    return caught.value.problems


@pytest.mark.parametrize(
    "sets",
    [
        ["contact.tangential=history"],
        ["contact.tangential=history", "contact.tangential_stiffness=0.75", "contact.tangential_damping=7"],
        ["contact.rolling_friction=0.01", "particles.rotation=true"],
        HERTZ,
        [*HERTZ[:4], "contact.friction=0", "contact.wall_friction=0"],
    ],
)
def test_options_that_fit_together(sets):
    load_case("patil/c2", sets)


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        (
            ["contact.tangential=history", "contact.friction=0", "contact.wall_friction=0"],
            'contact.tangential: "history" is given and friction and wall_friction are 0, so that there is no',
        ),
        (HERTZ[:4], 'contact.tangential: "no-history" is given; with model = "hertz" LIGGGHTS has no viscous limit'),
        (
            [*HERTZ[:1], *HERTZ[2:], "accuracy=none"],
            'contact.youngs_modulus: nothing is given and model = "hertz" needs it',
        ),
        ([*HERTZ[:2], *HERTZ[3:]], 'contact.poisson_ratio: nothing is given and model = "hertz" needs it'),
        ([*HERTZ[:3], *HERTZ[4:]], 'contact.impact_speed: nothing is given and model = "hertz" needs it'),
        (HERTZ[1:2], 'contact.youngs_modulus: 5e+06 is given and model = "hooke" does not look at it'),
        ([*HERTZ, "contact.restitution=0.05"], "contact.restitution: 0.05 is given, above 0.05 is allowed"),
        ([*HERTZ, "contact.tangential_stiffness=0.5"], "contact.tangential_stiffness: 0.5 is given, which only"),
        (["contact.tangential_damping=0.5"], "contact.tangential_damping: 0.5 is given, which only model"),
        (
            [
                "contact.tangential=history",
                "contact.tangential_damping=20",
                "contact.restitution=0.5",
                "contact.steps_per_contact=6",
            ],
            "at most 1 is allowed; give at most",
        ),
        (["contact.rolling_friction=0.01"], "contact.rolling_friction: 0.01 is given and the particles do not rotate"),
        (
            [*HERTZ, "contact.impact_speed=1e-300"],
            "contact.youngs_modulus: 5e+06 Pa at 1e-300 m/s gives a DEM step of 0 s, which time cannot",
        ),
    ],
)
def test_options_that_do_not_fit_together(sets, words):
    assert any(words in problem for problem in problems_of(*sets)), problems_of(*sets)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("pairs=[[1,2,0.9,0.1],[2,2,0.03,0.1]]", "contact.pairs: 0.03 is given in row 2, above 0.05 is allowed"),
        ("walls=[[2,0.05,0.1]]", "contact.walls: 0.05 is given in row 1, above 0.05 is allowed"),
    ],
)
def test_restitution_of_a_row_that_hertz_does_not_take(rows, words):
    two = "particles.mixture=[[0.8e-3,2000.0,0.3]]"
    (problem,) = problems_of(*HERTZ, two, f"contact.{rows}")
    assert words in problem and problem.endswith('with model = "hertz"; raise it.')
    load_case("patil/c2", [two, f"contact.{rows}"])


def test_damping_that_is_named_as_the_most_is_allowed():
    sets = ["contact.tangential=history", "contact.restitution=0.5", "contact.steps_per_contact=6"]
    (problem,) = problems_of(*sets, "contact.tangential_damping=20")
    most = float(problem.split("at most ")[-1].split(",")[0])
    load_case("patil/c2", [*sets, f"contact.tangential_damping={0.99 * most}"])


def test_hertz_contact_by_hand():
    """Unit E*, mass, radius and speed: delta = (15/16)^(2/5) = 0.9745, T_C = 2.9432 delta (Johnson 1985, 11.23-24)."""
    assert hertz_overlap(1.0, 1.0, 1.0, 1.0) == pytest.approx(0.974514, rel=1e-5)
    assert hertz_contact_time(1.0, 1.0, 1.0, 1.0) == pytest.approx(2.868266, rel=1e-5)
    # T_C falls with speed^(1/5), and with the modulus^(2/5).
    assert hertz_contact_time(1.0, 1.0, 1.0, 32.0) == pytest.approx(2.868266 / 2, rel=1e-5)
    assert hertz_contact_time(32.0, 1.0, 1.0, 1.0) == pytest.approx(2.868266 / 4, rel=1e-5)


def test_hertz_sets_the_step_and_the_overlap():
    case = load_case("patil/c2", HERTZ)
    mass = 2500 * math.pi / 6 * 1e-9 / 2
    modulus = 5e6 / (2 * (1 - 0.25**2))
    expected = 2.868266 * (mass**2 / (2.5e-4 * modulus**2 * 2.0)) ** 0.2
    assert pair_contact_time(case.contact, case.particles) == pytest.approx(expected, rel=1e-5)
    assert dem_step(case.contact, case.particles) == pytest.approx(expected / 6, rel=1e-5)
    numbers = {number.name: number.value for number in estimate(case)}
    overlap = 0.974514 * (mass * 1.2**2 / (math.sqrt(2.5e-4) * modulus)) ** 0.4
    assert numbers["overlap"] == pytest.approx(overlap / 1e-3, rel=1e-5)
