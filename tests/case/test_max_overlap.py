"""`contact.max_overlap`: the spring by what it does, in the effective case, against what stands there already."""

import math

import pytest

from fbcouple.case.bed.adopt_spring import round_up
from fbcouple.case.bed.derived import dem_step
from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import estimate
from fbcouple.case.source import find_case
from fbcouple.errors import CaseError

HERTZ = ["contact.model=hertz", "contact.poisson_ratio=0.25", "contact.tangential=history"]
BEDS = {"patil/c2": [], "mueller/0.9": [], "netl/biseg": [], "patil/demo": HERTZ, "yue/spout": []}
"""Beds with linear springs, of two species, and with Hertz contacts."""


def find_overlap(case, name):
    (overlap,) = [number.value for number in estimate(case, None, find_case(name).parent) if number.name == "overlap"]
    return overlap


@pytest.mark.parametrize("name", BEDS)
@pytest.mark.parametrize("wanted", [0.01, 0.05])
def test_the_spring_makes_the_overlap_that_is_asked_for_and_hardly_less(name, wanted):
    case = load_case(name, [*BEDS[name], f"contact.max_overlap={wanted}"])
    assert case.contact.max_overlap is None
    assert 0.99 * wanted < find_overlap(case, name) <= wanted


@pytest.mark.parametrize(("name", "sets"), [("patil/c2", []), ("patil/demo", HERTZ)])
def test_the_step_is_proportional_to_the_overlap(name, sets):
    fine, coarse = (load_case(name, [*sets, f"contact.max_overlap={wanted}"]) for wanted in (0.01, 0.05))
    steps = [dem_step(case.contact, case.particles) for case in (fine, coarse)]
    assert steps[1] / steps[0] == pytest.approx(5.0, rel=0.005)


def test_hertz_takes_the_speed_that_the_overlap_is_of_unless_the_case_has_its_own():
    sets = [*HERTZ, "contact.max_overlap=0.05"]
    assert load_case("patil/demo", sets).contact.impact_speed == 1.2
    assert load_case("patil/demo", [*sets, "contact.impact_speed=0.5"]).contact.impact_speed == 0.5


def test_the_effective_case_has_the_spring_and_is_read_as_it_is(tmp_path):
    case = load_case("patil/c2", ["contact.max_overlap=0.05"])
    write_case(case, tmp_path / "case.toml")
    text = (tmp_path / "case.toml").read_text(encoding="utf-8")
    assert "max_overlap" not in text and f"stiffness = {case.contact.stiffness}" in text
    assert load_case(str(tmp_path / "case.toml")) == case
    faster = load_case(str(tmp_path / "case.toml"), ["gas.inlet_velocity=1.5"])
    assert faster.contact.stiffness == case.contact.stiffness


def test_what_is_set_goes_on_top_of_what_the_file_has(tmp_path):
    assert load_case("mueller/0.9").contact.stiffness == 200.0
    assert load_case("mueller/0.9", ["contact.max_overlap=0.05"]).contact.stiffness < 200.0
    text = find_case("mueller/0.9").read_text(encoding="utf-8").replace("stiffness = 200.0", "max_overlap = 0.05")
    (tmp_path / "case.toml").write_text(text.partition("references")[0], encoding="utf-8")
    assert load_case(str(tmp_path / "case.toml"), ["contact.stiffness=200"]).contact.stiffness == 200.0


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        (
            ["contact.max_overlap=0.05", "contact.stiffness=100"],
            "--set: contact.max_overlap: 0.05 is given, and stiffness = 100 too, which says it already; remove one",
        ),
        (
            [*HERTZ, "contact.max_overlap=0.05", "contact.youngs_modulus=1e7", "contact.impact_speed=1"],
            "--set: contact.max_overlap: 0.05 is given, and youngs_modulus = 1e+07 too, which says it already; remove",
        ),
        (["contact.max_overlap=0.3"], "contact.max_overlap: 0.3 is given, "),
    ],
)
def test_two_springs_and_a_hole_for_one_are_refused(sets, words):
    with pytest.raises(CaseError) as refused:
        load_case("patil/c2", sets)
    assert words in str(refused.value)


def test_particles_that_never_move_have_no_overlap_to_choose_by(tmp_path):
    (tmp_path / "case.toml").write_text(
        """
title = "no gas, no weight"
end_time = 1.0
gravity = 0.0
[domain]
size = [0.02, 0.02, 0.04]
cells = [5, 5, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 100
[contact]
max_overlap = 0.05
restitution = 0.9
wall_restitution = 0.9
friction = 0.0
wall_friction = 0.0
[start]
""",
        encoding="utf-8",
    )
    with pytest.raises(CaseError, match="nothing in the case makes a particle move, so that no stiffness follows"):
        load_case(str(tmp_path / "case.toml"))


DRY = """
title = "a bed without gas"
end_time = 1.0
[domain]
size = [0.008, 0.008, 0.4]
cells = [4, 4, 200]
[particles]
diameter = 1e-3
density = 2500.0
count = 400
[contact]
max_overlap = 0.05
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
"""
FEED = "[[particles.feeds]]\nlow = [0.0, 0.0, 0.02]\nhigh = [0.008, 0.008, 0.03]\nrate = 100.0\n"


@pytest.mark.parametrize(
    ("change", "times"),
    [
        (("[start]", "[start]\nspacing = 3.0"), 25.0),
        (("[contact]", f"{FEED}velocity = [0.0, 0.0, -20.0]\n[contact]"), 1000.0),
        (("count = 400", f"count = 0\n{FEED}"), 1.0),
    ],
    ids=["loose lattice", "fast feed", "empty start"],
)
def test_the_spring_is_that_of_what_falls_and_is_fed(tmp_path, change, times):
    """At least so many times as stiff as that of the bed that rests; none of it was known from an empty start."""
    (tmp_path / "case.toml").write_text(DRY)
    plain = load_case(str(tmp_path))
    (tmp_path / "case.toml").write_text(DRY.replace(*change))
    case = load_case(str(tmp_path))
    assert case.contact.stiffness > times * plain.contact.stiffness
    (overlap,) = [number.value for number in estimate(case, None, tmp_path) if number.name == "overlap"]
    assert 0.049 < overlap <= 0.05


@pytest.mark.parametrize(
    ("value", "rounded"), [(364.2001, 365.0), (364.0, 364.0), (1.001e7, 1.01e7), (0.00999, 0.00999)]
)
def test_springs_are_rounded_to_the_stiffer_side(value, rounded):
    assert round_up(value) == rounded
    assert math.isclose(round_up(value), value, rel_tol=1e-2)


@pytest.mark.parametrize("sets", [[], [*HERTZ, "contact.impact_speed=1"]])
def test_a_deep_bed_of_fine_particles_is_as_stiff_as_its_weight_asks(sets):
    """3 m of 0.1 mm: the weight presses the lowest deeper into each other than any impact."""
    deep = ["particles.diameter=1e-4", "particles.count=860000", "domain.size=[5e-4,5e-4,6.0]"]
    deep += ["domain.cells=[2,2,24000]", "output.references=[]"]
    case = load_case("mueller/0.9", [*sets, *deep, "contact.max_overlap=0.02"])
    numbers = {number.name: number.value for number in estimate(case)}
    assert 0.0198 < numbers["overlap at rest"] <= 0.02 and numbers["overlap"] < 0.02
