"""Plans: what is chosen reaches the error, costs least, and is a case that is predicted to cost what was told."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

import fbcouple
from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.means import MIRRORED, PERIODS, predict_means
from fbcouple.case.cost.prediction import predict
from fbcouple.case.cost.ranks import count_worked
from fbcouple.case.kinds.registry import Wanted
from fbcouple.case.load import load_case
from fbcouple.case.new_case import write_new_case
from fbcouple.case.plan.candidates import LIMIT, Pricing, list_averages, list_splits, make_member
from fbcouple.case.plan.case_file import write_case_file
from fbcouple.case.plan.choice import make_plan
from fbcouple.case.plan.knobs import KNOBS, Value, list_numerics, list_parcels
from fbcouple.case.plan.measured_errors import (
    MESH,
    NUMERICS,
    OVERLAP,
    PARCELS,
    interpolate,
    list_errors,
    list_overlaps,
    list_ratios,
)
from fbcouple.case.source import find_case
from fbcouple.errors import CaseError

BEDS = ("mueller/0.9", "patil/c1", "own")


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> Path:
    """A bed that is no shipped case."""
    folder = tmp_path_factory.mktemp("own") / "bed"
    write_new_case(folder, "bubbling", Wanted(1e-3, 2500.0, None, None, None))
    return folder / "case.toml"


def plan(name: str, own: Path, error: float, **wanted):
    return make_plan(str(own) if name == "own" else name, error, found=SHIPPED, **wanted)


@pytest.mark.parametrize("key", ["run", "restart"])
def test_what_another_run_has_stays_what_it_is(own, key):
    """A start of particles starts no parcels: a plan that chose them could not be set up."""
    case = load_case(str(own))
    assert len(list_parcels(case, own.parent, ())) > 1
    follows = case.model_copy(update={"start": case.start.model_copy(update={key: "other"})})
    (value,) = list_parcels(follows, own.parent, ())
    assert (value.words, value.settings) == ("particles", {})


def test_blocks_that_end_no_run_are_refused_before_anything_is_chosen(own):
    with pytest.raises(CaseError, match="blocks: 4 is given, at least 8 are allowed"):
        plan("own", own, 0.5, sets=["averages.start=1.0", "averages.blocks=4"])


@pytest.mark.parametrize("name", BEDS)
def test_what_is_chosen_reaches_the_error_by_its_own_case(name, own):
    """The case is made and predicted again by the same ways as any other."""
    made = plan(name, own, 0.06, ranks=4)
    one = made.chosen
    sets = [*made.sets, *(f"{key}={value}".replace("'", '"') for key, value in one.list_settings().items())]
    sets = [f'accuracy="{s.partition("=")[2]}"' if s.startswith("accuracy") else s for s in sets]
    case = load_case(made.name, sets)
    found = predict(case, one.ranks, SHIPPED, find_case(made.name).parent)
    assert case.averages.mirror == ("x",)
    statistical = MIRRORED * PERIODS * math.sqrt(found.means.period / found.means.window / one.replicas)
    assert math.hypot(statistical, one.numerics.error) == pytest.approx(0.06, rel=0.02)
    assert one.core_hours == pytest.approx(one.replicas * found.core_hours, rel=0.03)
    assert one.wall == pytest.approx(found.wall, rel=0.03) and one.replicas * one.ranks <= 4
    begin = one.means.end - one.means.window
    assert one.end_limit == pytest.approx(begin + LIMIT * one.means.window, rel=0.1)


def test_mirror_images_are_for_beds_that_are_their_own():
    box, column = load_case("mueller/0.9"), load_case("verma/1.02")
    assert list_averages(box, []) == ['averages.mirror=["x"]']
    assert list_averages(box, ["averages.mirror"]) == list_averages(column, []) == []
    assert list_averages(load_case("mueller/0.9", ['averages.mirror=["y"]']), []) == []


def test_of_all_combinations_none_that_reaches_it_is_cheaper():
    made = make_plan("mueller/0.9", 0.05, found=SHIPPED)
    case, folder = load_case("mueller/0.9"), find_case("mueller/0.9").parent
    pricing = Pricing(SHIPPED, folder)
    members = [make_member("mueller/0.9", made.sets, numerics, folder) for numerics in list_numerics(case, folder)]
    assert len(members) == 5 * 5 * 3 * 3
    found = [pricing.reach(member, 1, 1, 0.05) for member in members]
    costs = [one.core_hours for one in found if one is not None]
    assert 10 < len(costs) < len(members), "coarse meshes do not reach it"
    assert made.chosen.core_hours == min(costs)


def test_the_front_falls_and_holds_the_choice():
    made = make_plan("mueller/0.9", 0.1, found=SHIPPED)
    errors, costs = [one.error for one in made.front], [one.core_hours for one in made.front]
    assert errors == sorted(errors, reverse=True) and costs == sorted(costs)
    assert made.chosen in made.front and len(errors) >= 4
    for one in made.front:
        better = [c for curve in made.curves for c in curve if c.error <= one.error and c.core_hours < one.core_hours]
        assert better == [], "nothing beats it in both"


def test_a_tighter_time_takes_more_ranks_and_no_more_than_there_are():
    slow = make_plan("patil/c2", 0.1, 1e6, 64, found=SHIPPED).chosen
    fast = make_plan("patil/c2", 0.1, 600.0, 64, found=SHIPPED).chosen
    assert (slow.replicas, slow.ranks) == (1, 1)
    assert fast.wall <= 600.0 and slow.replicas * slow.ranks < fast.replicas * fast.ranks <= 64
    assert fast.core_hours > slow.core_hours


def test_what_cannot_be_reached_in_time_tells_the_best_that_can():
    made = make_plan("patil/c2", 0.06, 900.0, 4, found=SHIPPED)
    assert made.chosen is None and made.best.error > 0.06
    assert 0.95 * 900.0 < made.best.wall <= 900.0
    assert made.front == () or all(one.error > 0.06 for one in made.front)
    with pytest.raises(CaseError, match=r"0\.06 is not reached within 900 s on 4 ranks; the least error is 0\."):
        made.write("never.toml")


def test_less_than_the_numerics_err_is_not_reached_by_any_length():
    made = make_plan("patil/c2", 0.02, found=SHIPPED)
    assert made.chosen is None and 0.0225 < made.best.error < 0.03
    assert "by any numerics that were measured" in made.tell_miss()


def test_no_means_at_all_within_a_second():
    made = make_plan("patil/c2", 0.1, 1.0, found=SHIPPED)
    assert made.chosen is made.best is None and "no run that has means ends by then" in made.tell_miss()


def test_what_is_given_stays():
    held = make_plan("mueller/0.9", 0.1, sets=["accuracy=standard", "domain.cells=[22, 5, 60]"], found=SHIPPED).chosen
    assert held.numerics.words[NUMERICS].startswith("standard") and "domain.cells" not in held.list_settings()
    spring = make_plan("mueller/0.9", 0.1, sets=["contact.stiffness=200"], found=SHIPPED).chosen
    assert "contact.max_overlap" not in spring.list_settings()
    assert spring.numerics.words[OVERLAP] == "overlap 0.035 d"  # docs/results/studies/README.md
    courant = make_plan("mueller/0.9", 0.1, sets=["gas.max_courant=0.7"], found=SHIPPED).chosen
    known = {0.5: list_errors(NUMERICS)["standard, Courant 0.5"], 1.0: list_errors(NUMERICS)["standard, Courant 1"]}
    assert "gas.max_courant" not in courant.list_settings()
    assert courant.numerics.error == pytest.approx(
        math.hypot(interpolate("", known, 0.7), list_overlaps(False)[0.1]), rel=1e-6
    )


def test_parcels_are_for_rough_plans_and_own_ones_stay():
    rough, fine = (make_plan("mueller/0.9", error, found=SHIPPED).chosen for error in (0.6, 0.1))
    assert rough.list_settings()["particles.coarse_graining"] in (1.26, 1.5)
    assert rough.core_hours < fine.core_hours and "particles.coarse_graining" not in fine.list_settings()
    own = make_plan("mueller/0.9", 0.6, sets=["particles.coarse_graining=1.3"], found=SHIPPED).chosen
    assert own.numerics.words[PARCELS] == "parcels of 1.3 d" and own.numerics.error > list_ratios()[1.26] - 1e-12
    with pytest.raises(CaseError, match=r"^particles.coarse_graining: 2 is given, and errors were measured from 1 to"):
        make_plan("mueller/0.9", 0.6, sets=["particles.coarse_graining=2"], found=SHIPPED)


def test_a_knob_more_is_an_entry_more(monkeypatch):
    """Of two values that err alike the cheaper one is taken."""
    values = [Value("steps 6", {}, 0.0), Value("steps 12", {"contact.steps_per_contact": 12}, 0.0)]
    monkeypatch.setitem(KNOBS, "steps", lambda case, folder, held: values)
    made = make_plan("mueller/0.9", 0.1, found=SHIPPED)
    assert made.chosen.numerics.words["steps"] == "steps 6"


def test_a_slower_machine_costs_more_and_chooses_by_its_own_costs():
    slow = replace(SHIPPED, contact={law: 10.0 * cost for law, cost in SHIPPED.contact.items()}, neighbour=2e-7)
    one, other = (make_plan("mueller/0.9", 0.1, found=found).chosen for found in (SHIPPED, slow))
    assert other.core_hours > 2.0 * one.core_hours


@pytest.mark.parametrize(
    ("name", "sets", "text"),
    [
        ("single-impact", [], "case: no bed of particles under gas and gravity"),
        ("mueller/0.9", ['averages.error_of="bed_height"', "averages.until_error=0.1"], "averages.error_of: "),
        ("mueller/0.9", ["end_time=5"], "--set: end_time is given"),
        ("mueller/0.9", ["gas.inlet_velocity=0.1"], "gas: less comes in than fluidizes the bed"),
        ("mueller/0.9", ["contact.stiffness=3"], r"contact.max_overlap: .* measured from 0\.02 to 0\.1"),
        ("mueller/0.9", ["gas.max_courant=0.05"], r"gas.max_courant: 0\.05 is given"),
        ("mueller/0.9", ["accuracy=none"], 'accuracy: "none" is given, one of draft, standard, reference'),
    ],
)
def test_of_what_nothing_was_measured_nothing_is_planned(name, sets, text):
    with pytest.raises(CaseError, match=text):
        make_plan(name, 0.1, sets=sets, found=SHIPPED)


def test_gas_that_is_still_changed_has_no_mean(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(
        'base = "mueller/0.9"\nunset = ["gas.inlet_velocity"]\n[gas]\ninlet_ramp = [[0.0, 0.0], [4.0, 0.9]]\n'
        "[output]\nreferences = []\n"
    )
    with pytest.raises(CaseError, match="the gas is another up to 4 s, and the means begin at 1 s"):
        make_plan(str(file), 0.1, found=SHIPPED)
    assert make_plan(str(file), 0.1, sets=["averages.start=4"], found=SHIPPED).chosen is not None


@pytest.mark.parametrize("error", [0.0, -0.1, 0.91, math.nan])
def test_errors_out_of_range_are_refused(error):
    with pytest.raises(CaseError, match=r"--error: .* is given, above 0 and at most 0\.9 is allowed"):
        make_plan("mueller/0.9", error, found=SHIPPED)


def test_a_case_without_means_gets_some_from_where_its_start_up_ends(tmp_path, own):
    file = tmp_path / "case.toml"
    file.write_text(re.sub(r"\n\[averages\][^\[]*", "\n", own.read_text()))
    assert load_case(str(file)).averages is None
    made = make_plan(str(file), 0.1, found=SHIPPED)
    written = load_case(str(made.write(tmp_path / "planned.toml")))
    assert written.averages.start == "auto"
    assert predict_means(written).end == pytest.approx(made.chosen.means.end, rel=0.02)


def test_a_written_case_is_the_planned_one(tmp_path, own):
    made = make_plan(str(own), 0.05, 1e5, 16, sets=["gas.viscosity=1.9e-5"], found=SHIPPED)
    path = made.write(own.parent / "planned.toml")
    written, one = load_case(str(path)), made.chosen
    assert written.gas.viscosity == 1.9e-5 and written.end_time == one.end_limit
    assert written.averages.until_error == pytest.approx(one.until_error, rel=5e-3)
    found = predict(written, one.ranks, SHIPPED, path.parent)
    assert one.replicas * found.core_hours == pytest.approx(one.core_hours, rel=0.03)
    text = path.read_text()
    assert text.startswith("# Planned by fbcouple for an error of 0.05") and 'base = "case.toml"' in text
    with pytest.raises(CaseError, match="is there already"):
        made.write(path)
    with pytest.raises(CaseError, match=r"ends in \.toml"):
        made.write(tmp_path / "planned")
    with pytest.raises(CaseError, match="is no case; write it beside the case"):
        (tmp_path / "far/away").mkdir(parents=True)
        made.write(tmp_path / "far/away/planned.toml")
    assert not (tmp_path / "far/away/planned.toml").exists()


def test_a_spring_of_the_case_gives_way_to_the_planned_overlap(tmp_path):
    path = make_plan("mueller/0.9", 0.1, found=SHIPPED).write(tmp_path / "case.toml")
    assert 'unset = ["contact.stiffness"]' in path.read_text()
    assert load_case(str(path)).contact.stiffness < load_case("mueller/0.9").contact.stiffness


def test_what_is_set_in_another_way_is_unset_in_the_written_case(tmp_path):
    sets = ["particles.mass=0.01", "gas.inlet_ramp=[[0.0, 0.0], [0.1, 1.0]]"]
    path = write_case_file(tmp_path / "case.toml", "mueller/0.9", sets, {}, ["A note."])
    case = load_case(str(path))
    assert (case.particles.mass, case.particles.count, case.gas.inlet_velocity) == (0.01, None, None)


def test_from_python():
    case = fbcouple.load_case("mueller/0.9", {"gas.viscosity": 1.9e-5})
    made = fbcouple.plan_case(case, 0.1, ranks=2, values={"accuracy": "standard"})
    assert made.sets[:1] == ("gas.viscosity=1.9e-05",) and made.chosen.numerics.words[NUMERICS].startswith("standard")
    assert made.describe()["chosen"]["error"] <= 0.1
    assert MESH in made.describe()["chosen"]


def test_python_is_told_of_its_arguments():
    with pytest.raises(CaseError, match=r"^error: 2 is given, above 0"):
        fbcouple.plan_case("mueller/0.9", 2.0)


def test_no_rank_has_less_work_than_it_is_worth():
    case, folder = load_case("mueller/0.9"), find_case("mueller/0.9").parent
    splits = list(list_splits(case, 256, folder))
    assert max(each for _, each in splits) == count_worked(22 * 5 * 60, 9240) == 13
    assert (256, 1) in splits and all(replicas * each <= 256 for replicas, each in splits)
