"""DEM steps of a contact: what a packed bed needs, what a case gets, and what `check` says of it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from fbcouple.case import preflight
from fbcouple.case.bed.contact_steps import FREE, Contacts, Oscillator, count_steps
from fbcouple.case.bed.derived import dem_step, least_steps, steps_per_contact
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate, require_fit
from fbcouple.case.presets import describe_preset
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.errors import CaseError

HERTZ = {"model": "hertz", "youngs_modulus": 5e6, "poisson_ratio": 0.45, "impact_speed": 0.2}
# Settled dry beds of 504 spheres, mu = 0.5, history, rotation: restitution -> the most steps with which the bed never
# came to rest, and the fewest with which it did.
SETTLED = {
    "hooke": {0.1: (12, 16), 0.2: (8, 10), 0.3: (6, 8), 0.4: (6, 7), 0.5: (5, 6), 0.9: (3, 4)},
    "hertz": {0.1: (12, 16), 0.2: (10, 12), 0.3: (8, 10), 0.5: (6, 7)},
}


def make(restitution, particles=None, **contact):
    given = {"wall_restitution": restitution, "friction": 0.5, "wall_friction": 0.5} | contact
    sphere = {"diameter": 1e-3, "density": 2500.0, "count": 100, "rotation": True} | (particles or {})
    return Contact(restitution=restitution, **given), Particles(**sphere)


def grows(motion, steps):
    """Does a motion grow in time steps of T_C over `steps`, velocities of the dashpot half a step late?"""
    spring, damping = motion.spring / steps**2, motion.damping / steps
    position, velocity = 1.0, 0.0
    for _ in range(2000):
        velocity += -spring * position - damping * velocity
        position += velocity
    return abs(position) > 1e6


@pytest.mark.parametrize("motion", [Oscillator(10.0, 0.0), Oscillator(10.0, 2.0), Oscillator(3.0, 25.0)])
def test_a_motion_grows_with_fewer_steps_than_it_needs_and_not_with_more(motion):
    assert grows(motion, 0.99 * motion.steps) and not grows(motion, 1.01 * motion.steps)


@pytest.mark.parametrize(
    ("model", "restitution", "creeps", "rests"),
    [(m, e, *steps) for m, of in SETTLED.items() for e, steps in of.items()],
)
def test_the_limit_is_where_settled_beds_come_to_rest(model, restitution, creeps, rests):
    least = least_steps(*make(restitution, **(HERTZ if model == "hertz" else {})))
    assert creeps < least < rests + 1.5


def test_spin_of_a_cubic_lattice_by_hand():
    """Each sphere has six contacts, of which four slip twice its speed of rotation if all spin alike: 10 of a pair's
    load; beds have less order and more than that, and no more than twice as much."""
    pair = Oscillator(1.0, 0.1)
    limit = count_steps([Contacts(FREE, pair)], [], rotates=True)
    assert (10.0 * pair).steps < limit < (20.0 * pair).steps


def test_a_case_gets_as_many_steps_as_it_needs_and_no_less_than_six():
    assert [steps_per_contact(*make(e)) for e in (1.0, 0.97, 0.5, 0.4, 0.3, 0.1)] == [6, 6, 6, 8, 9, 16]
    assert steps_per_contact(*make(0.3, steps_per_contact=4)) == 4
    assert steps_per_contact(*make(0.3, **HERTZ)) == 11


def test_what_makes_the_limit_higher_and_lower():
    plain = least_steps(*make(0.3))
    assert least_steps(*make(0.3, friction=0.0, wall_friction=0.0)) < plain, "no tangential dashpots"
    assert least_steps(*make(0.3, tangential="no-history")) < plain, "its viscous limit is a part of each step"
    assert least_steps(*make(0.3, particles={"rotation": False})) < plain
    assert least_steps(*make(0.3, tangential_damping=0.0)) < plain < least_steps(*make(0.3, tangential_damping=1.0))
    assert least_steps(*make(0.9, wall_restitution=0.05)) > 1.5 * least_steps(*make(0.9))
    assert least_steps(*make(0.3, wall_restitution=0.9)) == plain, "walls take half of the contacts of a particle"


def test_one_pair_of_species_that_loses_much_sets_the_limit():
    mixture = {"mixture": ((0.8e-3, 1500.0, 0.3),)}
    lively = least_steps(*make(0.9, particles=mixture))
    dull = least_steps(*make(0.9, particles=mixture, pairs=((1, 2, 0.2, 0.5),)))
    assert dull > 2.0 * lively
    assert dull == pytest.approx(least_steps(*make(0.2)), rel=0.3)


@pytest.mark.parametrize("restitution", [5e-324, 1e-30, 1e-3, 1.0])
def test_the_limit_is_a_number_for_every_restitution(restitution):
    least = least_steps(*make(restitution))
    assert math.isfinite(least) and least > 3.0


BED = """
title = "dry"
end_time = 0.1
[domain]
size = [0.01, 0.01, 0.03]
cells = [5, 5, 15]
[particles]
diameter = 1e-3
density = 2500.0
count = 500
rotation = true
[contact]
restitution = 0.3
wall_restitution = 0.3
friction = 0.5
wall_friction = 0.5
[start]
"""


@pytest.fixture
def bed(tmp_path):
    (tmp_path / "case.toml").write_text(BED)
    return str(tmp_path)


def number_of(case, name="DEM steps per contact"):
    return {number.name: number for number in estimate(case)}.get(name)


@pytest.mark.parametrize(
    ("sets", "value", "verdict"),
    [
        ([], 9, "fit"),
        (["contact.steps_per_contact=8"], 8, "warn"),
        (["contact.steps_per_contact=6"], 6, "unfit"),
        (["contact.steps_per_contact=6", "gravity=0"], 6, "warn"),
        (["contact.steps_per_contact=6", "contact.restitution=0.9", "contact.wall_restitution=0.9"], 6, "fit"),
        (["contact.steps_per_contact=5", "contact.restitution=0.9", "contact.wall_restitution=0.9"], 5, "warn"),
    ],
)
def test_check_judges_the_steps(bed, sets, value, verdict):
    number = number_of(load_case(bed, sets))
    assert (number.value, number.verdict) == (value, verdict)
    assert number.limit == f"at least {9 if not any('0.9' in text for text in sets) else 6}"


def test_too_few_steps_are_refused_with_what_is_wanted(bed):
    with pytest.raises(CaseError) as caught:
        require_fit(load_case(bed, ["contact.steps_per_contact=6"]))
    (problem,) = caught.value.problems
    assert problem.startswith("DEM steps per contact: 6 is expected, at least 9 is fit")
    assert "contact.steps_per_contact" in problem and "--force" in problem


@pytest.mark.parametrize(("preset", "steps"), [("draft", 9), ("standard", 9), ("reference", 12), ("none", 9)])
def test_presets_ask_for_no_less_than_the_bed_needs(bed, preset, steps):
    case = load_case(bed, [f"accuracy={preset}"])
    assert steps_per_contact(case.contact, case.particles) == steps
    assert preset == "none" or f"contact.steps_per_contact = {steps}" in describe_preset(case)
    assert "of the case itself" not in describe_preset(case)


def test_a_preset_leaves_mistakes_to_the_checks(bed):
    for mistake in ("contact.restitution=2", "contact.model=hertz", "particles.diameter=-1"):
        with pytest.raises(CaseError):
            load_case(bed, ["accuracy=draft", mistake])


def test_friction_has_history_where_the_case_says_nothing(bed):
    assert number_of(load_case(bed), "sliding at rest") is None
    sliding = number_of(load_case(bed, ["contact.tangential=no-history"]), "sliding at rest")
    assert sliding.verdict == "warn" and 'contact.tangential = "history"' in sliding.limit
    assert number_of(load_case(bed, ["contact.friction=0", "contact.wall_friction=0"]), "sliding at rest") is None


@pytest.mark.parametrize(
    ("sets", "verdict"),
    [
        ([], None),
        (["gas.inlet_velocity=0.5"], "warn"),
        (["gas.inlet_velocity=0.0"], "warn"),
        (["gas.inlet_velocity=0.55"], None),
        (["end_time=0.5"], None),
    ],
)
def test_no_history_is_warned_of_where_the_bed_rests(sets, verdict):
    """U_mf of the case is 0.540 m/s."""
    case = load_case("patil/c2", ["averages.start=0.1", *sets])
    sliding = number_of(case, "sliding at rest")
    assert sliding.verdict == verdict
    assert sliding.value == pytest.approx(4.0 * 9.81 * dem_step(case.contact, case.particles))


@pytest.mark.parametrize(
    ("ramp", "verdict"),
    [
        ([(0.0, 0.0), (1.0, 1.2)], "warn"),
        ([(0.0, 0.6), (1.0, 1.2)], None),
        ([(0.0, 0.6), (20.0, 0.5)], "warn"),
        ([(0.0, 0.6), (90.0, 0.5)], None),
        ([(0.0, 0.6), (1.0, -0.6)], "warn"),
    ],
)
def test_a_ramp_counts_at_its_slowest_within_the_run(ramp, verdict):
    case = load_case("patil/c2")
    gas = case.gas.model_copy(update={"inlet_velocity": None, "inlet_ramp": tuple(ramp)})
    assert number_of(case.model_copy(update={"gas": gas}), "sliding at rest").verdict == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.9, None), (0.4, "warn")])
def test_a_bed_rests_beside_a_jet(monkeypatch, share, verdict):
    """Also where the jet has gas enough for the whole cross-section: 3 m/s, U_mf 0.54 m/s."""
    case = load_case("patil/c2", ["gas.inlet_velocity=3"])
    region = preflight.find_region(case)
    monkeypatch.setattr(preflight, "find_region", lambda case, folder: replace(region, inlet=share * region.inlet))
    assert number_of(case, "sliding at rest").verdict == verdict


def test_bed_height_in_cells(bed):
    number = number_of(load_case("patil/c1"), "bed height in cells")
    assert number.value == pytest.approx(0.0416667 / (0.25 / 55), rel=1e-3) and number.verdict is None
    assert "5-14 cells" in number.meaning
    assert number_of(load_case(bed), "bed height in cells") is None
