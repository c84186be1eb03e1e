"""Claims are decided by the runs they speak of, told by their parameters, and only beyond their errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.case.load import load_case
from fbcouple.case.schema.reference import list_options
from fbcouple.cli.main import cli
from fbcouple.paths import CASES
from fbcouple.postproc.averaging import find_start_up_in_means
from fbcouple.postproc.measures import Measured
from fbcouple.postproc.papers.hamidouche2019.claims import NO, STATED, UNDECIDED, YES, judge_claims
from fbcouple.postproc.papers.hamidouche2019.judging import above, below, fall, rise, settle, within
from fbcouple.postproc.papers.hamidouche2019.paper_beds import AS_COMPUTED, AS_PRINTED, BEDS, identify_case
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import tell_numerics
from fbcouple.postproc.papers.hamidouche2019.paper_runs import identify, list_twins, sort_runs
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.postproc.papers.hamidouche2019.run_uses import list_uses, tell_choices
from fbcouple.results.reader import Results, open_results
from tests.postproc.paper_bed import write_bed

Make = Callable[..., Results]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """A run of a shipped case with analytic means: `make("c4-0.1", height=0.0625, unrest=0.06)`."""

    def make_run(name: str, sets: tuple[str, ...] = (), folder: str = "", **shape: float) -> Results:
        return open_results(write_bed(tmp_path / (folder or name.replace("/", "-")), name, sets, **shape))

    return make_run


def verdicts(*runs: Results) -> dict[str, str]:
    return {row.name: row.verdict for row in judge_claims(runs) if row.contacts == AS_PRINTED and row.beds == STATED}


@pytest.mark.parametrize("name", BEDS)
def test_shipped_case_is_known_by_its_parameters(make, name):
    numerics, names = identify(make(name, folder="any"))
    assert numerics == AS_PRINTED and name in names
    assert all(replace(BEDS[other], models=BEDS[name].models) == BEDS[name] for other in names)


def test_variant_with_other_numerics_is_told_apart(make):
    assert identify(make("paper-numerics/c5-0.0"))[0] == AS_COMPUTED


@pytest.mark.parametrize(
    "setting",
    [
        "particles.rotation=true",
        "exchange.drag=beetstra",
        "exchange.filter_passes=2",
        "contact.restitution=0.9",
        "contact.friction=0.15",
        "gas.closed_nozzle=[3, 4]",
        "gas.walls=slip",
        "particles.mass=0.08",
        "contact.tangential=history",
        "exchange.voidage=divided",
        "domain.periodic=['y']",
        "gas.inlet_velocity=1.3",
        "domain.cells=[35, 6, 100]",
        "particles.coarse_graining=2",
        "gravity=3.7",
        "exchange.lift_force=true",
        "exchange.virtual_mass=true",
        "exchange.viscous_force=true",
        "exchange.accelerated=true",
        "start.spacing=1.2",
    ],
)
def test_changed_case_is_no_longer_the_papers(make, setting):
    _, names = identify(make("c4-0.1", sets=(setting,)))
    assert names == []


ANY = [
    *("title", "end_time", "accuracy", "gas.max_step", "contact.skin"),
    *("start.seed", "start.settle_limit", "start.rest_speed", "particles.positions_seed"),
    *("gas.max_courant", "gas.max_fourier", "gas.correctors", "gas.pressure_tolerance"),
    *("contact.steps_per_contact", "contact.stiffness"),
]
"""Options in which runs of one bed may differ, with whole sections for what is kept of them."""


def test_an_option_counts_unless_it_is_named_as_one_that_does_not():
    """An option that the schema gets tomorrow makes another bed of a case that sets it."""
    for key in [key for key in list_options() if key.count(".") < 2]:
        case = load_case("patil/c2").model_dump(mode="json", exclude_none=True)
        section, _, name = key.rpartition(".")
        (case.setdefault(section, {}) if section else case)[name] = 7
        is_free = key in ANY or section in ("averages", "output", "checkpoint", "monitors")
        assert identify_case(case)[1] == (["c2"] if is_free or key == "particles.count" else []), key


def test_heat_and_vessels_of_others_are_none_of_the_papers():
    for name in ("patil/heat-1.20", "patil/demo", "mueller/0.9", "beaulieu/heated"):
        assert identify_case(load_case(name).model_dump(mode="json", exclude_none=True))[1] == []


@pytest.mark.parametrize("file", sorted((CASES.parent / "docs/results/paper").glob("*.nc")), ids=lambda file: file.stem)
def test_the_runs_that_are_kept_are_beds_of_the_paper(file):
    numerics, names = identify(open_results(file))
    assert numerics == AS_PRINTED and file.stem in names


def test_a_longer_run_in_parcels_does_not_stand_for_the_bed(make):
    parcels = make("c2", ("particles.coarse_graining=2",), folder="parcels", end=20.0)
    real = make("c2", folder="c2", end=8.0)
    assert sort_runs([parcels, real])[0][AS_PRINTED]["c2"] is real
    chosen, left_out = sort_runs([parcels])
    assert chosen[AS_PRINTED] == {}
    assert left_out["c2"] == "parcels is not the paper's bed: particles.coarse_graining = 2.0"


def test_means_of_two_inlets_are_of_no_bed(make):
    run = make("c2")
    changed = replace(run, data=run.data.assign_attrs(inlet_changed_at=[5.0]))
    assert identify(changed)[1] == [] and "inlet changed at 5 s" in sort_runs([changed])[1]["c2"]
    assert identify(replace(run, data=run.data.assign_attrs(inlet_changed_at=[0.5])))[1] == ["c2"]


def test_draft_numerics_and_code_of_its_own_are_named(make):
    run = make("c4-0.0", ("accuracy=draft",))
    run = replace(run, case=run.case | {"output": run.case["output"] | {"task_file": "mine.py"}})
    (row,) = [row for row in judge_claims([run]) if row.name == "not-homogeneous"]
    for words in ("gas.correctors = 1", "gas.pressure_tolerance = 0.0001", "output.task_file = mine.py"):
        assert words in row.runs


def test_bed_by_count_is_the_bed_by_mass(make, tmp_path):
    run = make("c2")
    particles = {key: value for key, value in run.case["particles"].items() if key != "mass"} | {"count": 57296}
    assert identify(Results(run.path, run.data, run.case | {"particles": particles}))[1] == ["c2"]


def test_without_runs_nothing_is_told(make):
    rows = judge_claims([])
    assert [row.name for row in rows] == list(CLAIMS)
    assert {row.verdict for row in rows} == {UNDECIDED} and not any(row.measured for row in rows)


def test_foreign_run_decides_nothing(make):
    rows = judge_claims([make("c4-0.1", sets=("particles.rotation=true",))])
    assert {row.verdict for row in rows} == {UNDECIDED}


def test_short_run_decides_nothing_and_is_named(make):
    row = next(row for row in judge_claims([make("c4-0.1", end=5.5)]) if row.name == "bed-height")
    assert row.verdict == UNDECIDED and "c4-0.1 averaged 4.5 s" in row.why


def test_longer_of_two_runs_counts(make):
    short, full = make("c4-0.0", folder="a", end=8.0, unrest=0.0), make("c4-0.0", folder="b", end=20.0)
    assert verdicts(short, full)["not-homogeneous"] == verdicts(full, short)["not-homogeneous"] == YES


def test_a_run_without_its_start_up_counts_before_a_longer_one_with_it(make):
    """By the test that warns: its history falls for 4 s, and its means begin at 1 s."""
    long, late = make("c4-0.0", folder="long", unrest=0.0), make("c4-0.0", folder="late", end=12.0)
    falling = long.data["solids_centre_z"] * (1.0 + 0.3 * np.exp(-long.data["time"]))
    falling.values[400:] = (0.03125 * (1.0 + 0.06 * np.sin(40.0 * long.data["time"]))).values[400:]
    long = replace(long, data=long.data.assign(solids_centre_z=falling))
    assert find_start_up_in_means(long) and not find_start_up_in_means(late)
    for runs in ([long, late], [late, long]):
        assert sort_runs(runs)[0][AS_PRINTED]["c4-0.0"] is late
        assert tell_choices(list_uses(runs)) == [
            "long (c4-0.0) is not used: start-up included in its means; late counts."
        ]
    short = make("c4-0.0", folder="short", end=3.0)
    uses = list_uses([late, short, make("c4-0.0", folder="less", end=10.0)])
    assert [use.words for use in uses] == [
        "c4-0.0",
        "none: averaged 2 s, needed 5 s",
        "none: averaged 9 s; late, which averaged 11 s, counts",
    ]
    assert len(tell_choices(uses)) == 2


def test_the_same_seed_is_no_twin(make):
    """Later means of one run of C4-0.1 count for both of its names, and not the run itself for the second."""
    one = make("c4-0.1", folder="one")
    later = replace(make("c4-0.1", folder="later", end=15.0), label="later")
    chosen = sort_runs([one, later])[0][AS_PRINTED]
    assert chosen["c4-0.1"] is chosen["c5-0.1"] is one


def test_run_with_the_papers_sub_grid_model_counts_before_a_longer_one(make):
    other = make("c4-0.0", ("gas.turbulence=smagorinsky",), folder="a", end=20.0, unrest=0.0)
    assert verdicts(make("c4-0.0", folder="b", end=8.0), other)["not-homogeneous"] == YES
    (row,) = [row for row in judge_claims([other]) if row.name == "not-homogeneous"]
    assert row.verdict == NO and row.runs.endswith("gas.turbulence = smagorinsky)")


@pytest.mark.parametrize(("height", "verdict"), [(0.0625, YES), (0.0650, YES), (0.072, NO), (0.050, NO)])
def test_bed_height(make, height, verdict):
    runs = [make(f"c4-{mu}", height=height, unrest=0.01) for mu in ("0.0", "0.1", "0.2", "0.4")]
    assert verdicts(*runs)["bed-height"] == verdict
    assert verdicts(*runs[1:])["bed-height"] == UNDECIDED


@pytest.mark.parametrize(("unrest", "homogeneous", "bubbles"), [(0.001, YES, NO), (0.06, NO, YES)])
def test_bubbles_move_the_centre_of_mass(make, unrest, homogeneous, bubbles):
    found = verdicts(make("c5-0.0", unrest=unrest), make("c4-0.0", unrest=unrest))
    assert found["homogeneous"] == homogeneous and found["not-homogeneous"] == bubbles


@pytest.mark.parametrize(("flux", "noise", "verdict"), [(-20.0, 1e-3, YES), (20.0, 1e-3, NO), (-20.0, 30.0, UNDECIDED)])
def test_double_loop(make, flux, noise, verdict):
    assert verdicts(make("c2", wall_flux=flux, noise=noise))["double-loop"] == verdict


@pytest.mark.parametrize(
    ("solids", "noise", "verdict"),
    [(0.55, 1e-3, YES), (0.45, 1e-3, NO), (0.501, 1e-3, UNDECIDED), (0.55, 0.1, UNDECIDED)],
)
def test_denser_walls(make, solids, noise, verdict):
    runs = make("c2", noise=noise), make("c3", wall_solids=solids, noise=noise)
    assert verdicts(*runs)["denser-walls"] == verdict


@pytest.mark.parametrize(
    ("heights", "verdict"),
    [
        ((0.070, 0.065, 0.060, 0.055), YES),
        ((0.070, 0.060, 0.065, 0.055), NO),
        ((0.055, 0.060, 0.065, 0.070), NO),
        ((0.0600, 0.0600, 0.0600, 0.0600), UNDECIDED),
    ],
)
@pytest.mark.parametrize(("family", "claim"), [("c4", "height-wall-friction"), ("c5", "height-friction")])
def test_height_against_friction(make, heights, verdict, family, claim):
    values = ("0.0", "0.1", "0.2", "0.4")
    runs = [make(f"{family}-{mu}", height=h, unrest=0.01) for mu, h in zip(values, heights, strict=True)]
    found = verdicts(*runs)
    assert found[claim] == verdict
    assert verdicts(*runs[:3])[claim] == UNDECIDED


@pytest.mark.parametrize(("best", "verdict"), [("0.2", YES), ("0.4", NO)])
@pytest.mark.parametrize(
    ("family", "claims"), [("c4", ("wall-flux-c4", "flux-c4")), ("c5", ("wall-flux-c5", "flux-c5"))]
)
def test_largest_flux(make, best, verdict, family, claims):
    runs = [make(f"{family}-{mu}", wall_flux=-40.0 if mu == best else -20.0) for mu in ("0.0", "0.1", "0.2", "0.4")]
    found = verdicts(*runs)
    assert [found[name] for name in claims] == [verdict, verdict]


@pytest.mark.parametrize(("last", "verdict"), [(0.05, YES), (0.3, NO)])
def test_agitation_against_friction(make, last, verdict):
    values = {"0.0": 0.2, "0.1": 0.15, "0.2": 0.1, "0.4": last}
    found = verdicts(*(make(f"c5-{mu}", agitation=value) for mu, value in values.items()))
    assert found["agitation-friction"] == verdict


def test_peak_of_agitation_and_freeboard(make):
    runs = [make(f"{family}-{mu}") for family in ("c4", "c5") for mu in ("0.0", "0.2", "0.4")] + [make("c4-0.1")]
    found = verdicts(*runs)
    assert found["agitation-peak"] == YES and found["freeboard"] == YES
    found = verdicts(*runs[1:], make("c4-0.0", folder="other", freeboard=0.05, end=30.0))
    assert found["freeboard"] == NO


def test_the_bed_that_lies_on_its_margin_is_named(make):
    runs = [make(f"{family}-{mu}") for family in ("c4", "c5") for mu in ("0.0", "0.2", "0.4")]
    rows = judge_claims([*runs, make("c4-0.1", freeboard=0.02)])
    (row,) = [row for row in rows if row.name == "freeboard"]
    assert row.measured.endswith("(c4-0.1)")
    assert row.why == "within two standard errors (c4-0.1, c5-0.1): a number lies on its margin"


def test_a_flux_at_the_walls_has_its_unit_and_place(make):
    rows = {row.name: row for row in judge_claims([make(f"c4-{mu}") for mu in ("0.0", "0.1", "0.2", "0.4")])}
    assert rows["wall-flux-c4"].measured.endswith("over rho U_f") and "z/H = 0.092" in rows["wall-flux-c4"].wanted
    assert rows["wall-flux-c4"].why.startswith("within two standard errors (c4-0.2 against c4-0.0, c4-0.2 against c4")
    assert rows["agitation-peak"].measured.startswith("z/H = 0.2")


@pytest.mark.parametrize(
    ("peak", "noise", "verdict"),
    [(0.055, 1e-3, YES), (0.03, 1e-3, NO), (0.0625, 0.3, UNDECIDED), (0.03, 3.0, UNDECIDED)],
)
def test_peak_of_agitation_is_told_beyond_its_errors_only(make, peak, noise, verdict):
    runs = [make(f"c4-{mu}", height=0.09, peak=peak, noise=noise) for mu in ("0.0", "0.1", "0.2", "0.4")]
    assert verdicts(*runs)["agitation-peak"] == verdict


def test_numerics_that_are_not_the_papers_are_named(make):
    sets = ("accuracy=none", "gas.max_courant=0.8", "contact.stiffness=400.0", "contact.steps_per_contact=3")
    row = next(row for row in judge_claims([make("c5-0.0", sets)]) if row.name == "homogeneous")
    assert row.runs == "c5-0.0 (gas.max_courant = 0.8, contact.steps_per_contact = 3)" and row.verdict != UNDECIDED
    assert row.numerics == "e = 0.97; CFL 0.8, steps a contact 3"
    own = make("c5-0.0", ("accuracy=none",), folder="plain")
    plain = next(row for row in judge_claims([own]) if row.name == "homogeneous")
    assert plain.runs == "c5-0.0" and plain.numerics == "e = 0.97" and tell_numerics([own]) == ""


def test_of_several_runs_it_is_said_which_have_other_numerics(make):
    """The sentence at the top names the paper's values beside; a run that is no bed of it has none to be named."""
    paper = make("c4-0.0", ("accuracy=none",))
    ours = [make(f"c4-{mu}", ("accuracy=standard",)) for mu in ("0.1", "0.2", "0.4")]
    (row,) = [row for row in judge_claims([paper, *ours]) if row.name == "bed-height"]
    assert row.numerics == "e = 0.97; CFL 1.5 (3 of 4), Fourier 1.5 (3 of 4)"
    foreign = make("c2", ("gravity=3.7", "accuracy=standard"), folder="foreign")
    assert tell_numerics([paper, ours[0], foreign]) == (
        "Not the paper's numerics: gas.max_courant = 1.5 (0.2 in the paper) in c4-0.1; "
        "gas.max_fourier = 1.5 (0.15 in the paper) in c4-0.1."
    )
    assert tell_numerics(ours).endswith("gas.max_fourier = 1.5 (0.15 in the paper) in all 3 runs.")


@pytest.mark.parametrize(("one", "other", "claim"), [("c6", "a1", "turbulence"), ("c3", "c3-slip", "walls-fine")])
def test_pair_without_visible_difference(make, one, other, claim):
    first = make(one)
    assert verdicts(first, make(other, folder="same"))[claim] == YES
    assert verdicts(first, make(other, folder="taller", height=0.085))[claim] == NO
    unsure = verdicts(make(one, folder="n1", noise=0.3), make(other, folder="n2", height=0.085, noise=0.3))
    assert unsure[claim] == UNDECIDED


@pytest.mark.parametrize(
    ("value", "holds"),
    [(0.0, True), (1.79, True), (-1.79, True), (1.9, None), (2.0, None), (2.19, None), (2.21, False), (-2.21, False)],
)
def test_an_interval_decides_that_lies_wholly_inside_or_outside_of_the_margin(value, holds):
    assert within(Measured(10.0 + value, 0.1), 10.0, 2.0).holds is holds


@pytest.mark.parametrize(("value", "wanted"), [(1.5, 4.0), (0.5, 4.0), (1.9, 1.2345679)])
def test_it_is_told_how_much_longer_the_windows_have_to_be(value, wanted):
    """Errors fall as one over the root of the window: 0.5 to 0.25 takes four times as long."""
    answer = above(Measured(value, 0.5), 1.0)
    assert answer.holds is None and answer.longer == pytest.approx(wanted)
    longer = Measured(value, 0.999 * 0.5 / answer.longer**0.5)
    assert above(longer, 1.0).holds is not None and below(longer, 1.0).holds is not None
    assert above(Measured(value, 1.001 * 0.5 / answer.longer**0.5), 1.0).holds is None


def test_why_nothing_is_decided_names_the_longest_of_the_windows():
    answers = [above(Measured(1.0, 0.1)), above(Measured(1.0, 1.0)), above(Measured(0.5, 1.0))]
    assert settle("", answers[:1]).holds is True
    assert settle("", answers).why == "within two standard errors: windows 16 times as long decide, if it stays"
    assert settle("", [*answers, above(Measured(-1.0, 0.1))]).holds is False
    assert "on its margin" in settle("", [above(Measured(0.0, 1.0))]).why


@pytest.mark.parametrize(
    ("values", "holds"),
    [((3.0, 2.0, 1.0), True), ((3.0, 3.1, 1.0), True), ((3.0, 4.0, 1.0), False), ((3.0, 2.9, 2.8), None)],
)
def test_falling_and_rising(values, holds):
    falling = [Measured(value, 0.2) for value in values]
    assert settle("", fall(falling)).holds is holds
    assert settle("", rise(falling[::-1])).holds is holds


def test_claims_on_the_mesh_are_judged_on_the_finest_and_the_coarsest_too(make):
    runs = [make("c1", wall_flux=20.0), make("c2"), make("c3")]
    rows = [row for row in judge_claims(runs) if row.name in ("double-loop", "denser-walls")]
    found = [(row.name, row.beds, row.verdict) for row in rows]
    assert found == [
        ("double-loop", STATED, YES),
        ("double-loop", "c3", YES),
        ("double-loop", "c1", NO),
        ("denser-walls", STATED, NO),
        ("denser-walls", "c1, c2", NO),
    ] or found[3:] == [("denser-walls", STATED, UNDECIDED), ("denser-walls", "c1, c2", UNDECIDED)]
    assert rows[2].runs.startswith("c1 (") and "(C2; C1 and C3 in rows of their own" in rows[0].statement


def test_chance_is_taken_off_the_difference_of_two_maps(make):
    """Maps of one bed that differ by noise of the size of their errors are alike, as long as that is well below 5 %."""
    one, other = make("c6"), make("a1")
    rng = np.random.default_rng(3)

    def disturb(run, size):
        data = run.data.copy()
        depth = rng.standard_normal((data.sizes["z"], 1, data.sizes["x"])) * size
        data["solids_fraction"] = data["solids_fraction"] + depth
        data["solids_fraction_stderr"] = xr.full_like(data["solids_fraction_stderr"], size)
        return Results(run.path, data, run.case)

    seen = {size: verdicts(disturb(one, size), disturb(other, size))["turbulence"] for size in (0.005, 0.02)}
    assert seen == {0.005: YES, 0.02: UNDECIDED}


def test_sub_grid_models_are_compared_with_each_other_too(make):
    rows = judge_claims([make("c6"), make("a1"), make("c6", ("gas.turbulence=smagorinsky",), folder="s")])
    assert [(row.beds, row.verdict) for row in rows if row.name == "turbulence"] == [
        (STATED, YES),
        ("c6-smagorinsky, a1", YES),
        ("c6, c6-smagorinsky", YES),
    ]


def test_every_margin_has_a_reason():
    assert all(claim.wanted and claim.reason for claim in CLAIMS.values()) and len(CLAIMS) == 21


def test_a_mean_without_a_standard_error_decides_nothing(make):
    """Of a window that is too short to tell an error there is none; it is not an error of 0."""
    names = (
        *(f"{family}-{mu}" for family in ("c4", "c5") for mu in ("0.0", "0.2", "0.4")),
        "c4-0.1",
        "c2",
        "c3",
        "c6",
        "a1",
    )
    runs = []
    for name in names:
        run = make(name, agitation=0.1 if name.endswith("0.4") else 0.2)
        bare = {each: xr.full_like(field, np.nan) for each, field in run.data.items() if str(each).endswith("_stderr")}
        runs.append(Results(run.path, run.data.assign(bare).drop_dims("block"), run.case))
    rows = {row.name: row for row in judge_claims(runs) if row.beds == STATED}
    by_maps = ("freeboard", "agitation-peak", "double-loop", "denser-walls", "flux-mesh", "flux-c4", "turbulence")
    for name in (*by_maps, "agitation-friction", "agitation-wall-friction", "wall-flux-c5"):
        assert rows[name].verdict == UNDECIDED and "no standard error" in rows[name].why, name
    assert above(Measured(1.0, float("nan"))).holds is None


def test_a_clear_no_needs_no_error_of_the_others():
    """Neighbours whose errors are not known may rise: that is not decided, unless the ends decide it."""
    nan = float("nan")
    unsure, far = Measured(2.0, nan), Measured(9.0, 0.1)
    assert settle("", fall([Measured(1.0, 0.1), unsure, far])).holds is False
    open_end = settle("", fall([far, unsure, Measured(1.0, 0.1)]))
    assert open_end.holds is None and "no standard error" in open_end.why
    assert settle("", fall([far, Measured(5.0, 0.1), Measured(1.0, 0.1)])).holds is True


def test_the_twin_of_a_bed_counts_under_its_second_name(make):
    """Two runs of C4-0.1, which is C5-0.1, are one for each; one alone is both; another sub-grid model is no twin."""
    calm, wild = make("c4-0.1", unrest=0.01), make("c5-0.1", unrest=0.09, end=12.0)
    chosen = sort_runs([wild, calm])[0][AS_PRINTED]
    assert [chosen[name].path.parent.name for name in ("c4-0.1", "c5-0.1")] == ["c4-0.1", "c5-0.1"]
    assert sort_runs([wild])[0][AS_PRINTED]["c4-0.1"].path == wild.path
    other = make("c4-0.1", ("gas.turbulence=smagorinsky", "start.seed=7"), folder="other")
    assert sort_runs([calm, other])[0][AS_PRINTED]["c5-0.1"].path == calm.path
    assert [(name, one.path, two.path) for name, one, two in list_twins([calm, wild, other])] == [
        ("c4-0.1", calm.path, wild.path)
    ]


def test_best_match_is_never_decided(make):
    assert verdicts(*(make(name) for name in ("c4-0.1", "c4-0.2", "c5-0.2")))["best-match"] == UNDECIDED


def test_runs_with_other_numerics_have_rows_of_their_own(make):
    rows = judge_claims([make("c5-0.0", unrest=0.06), make("paper-numerics/c5-0.0", unrest=0.001)])
    found = {(row.contacts, row.verdict) for row in rows if row.name == "homogeneous"}
    assert found == {(AS_PRINTED, NO), (AS_COMPUTED, YES)}
    assert [row.name for row in rows if row.contacts == AS_COMPUTED] == ["homogeneous"]


def test_lacking_quantity_is_told(make, tmp_path):
    run = make("c5-0.0")
    row = judge_claims([Results(run.path, run.data.drop_vars("solids_centre_z"), run.case)])
    (homogeneous,) = [line for line in row if line.name == "homogeneous"]
    assert homogeneous.verdict == UNDECIDED and "solids_centre_z" in homogeneous.why


def test_table_on_the_command_line(make, tmp_path):
    make("c4-0.0")
    done = CliRunner().invoke(cli, ["claims", str(tmp_path / "c4-0.0"), "--json", str(tmp_path / "claims.json")])
    assert done.exit_code == 0, done.output
    assert "%" in done.stdout and UNDECIDED.split()[0] in done.stdout
    assert done.stdout.startswith("Not the paper's numerics: gas.max_courant = 1.5 (0.2 in the paper) in c4-0.0;")
    assert "CFL 1.5" in done.stdout
    rows = json.loads((tmp_path / "claims.json").read_text())["claims"]
    assert {row["name"]: row["verdict"] for row in rows}["not-homogeneous"] == YES


def test_a_run_that_is_a_bed_but_for_an_option_is_told_with_it(make, tmp_path):
    make("c4-0.0", sets=("particles.rotation=true",))
    done = CliRunner().invoke(cli, ["claims", str(tmp_path / "c4-0.0"), "--json", str(tmp_path / "claims.json")])
    assert done.exit_code == 0, done.output
    rows = {row["name"]: row for row in json.loads((tmp_path / "claims.json").read_text())["claims"]}
    row = rows["not-homogeneous"]
    assert row["verdict"] == UNDECIDED and "not the paper's bed: particles.rotation = true" in row["why"]


def test_of_other_beds_one_line_is_told(make, tmp_path):
    make("c4-0.1", sets=("gas.inlet_velocity=1.3",))
    done = CliRunner().invoke(cli, ["claims", str(tmp_path / "c4-0.1")])
    assert done.exit_code == 0, done.output
    run, line, match = done.stdout.splitlines()
    assert run == "c4-0.1 is not used: none of the paper's beds."
    count = len(CLAIMS) - 1
    assert line.startswith(f"{count} of {len(CLAIMS)} statements cannot be told") and "no run here is one" in line
    assert match.startswith("mu_p = mu_w = 0.1 matches the experiment best.") and "only as pictures" in match


@pytest.mark.parametrize(
    ("name", "end", "told"),
    [
        ("c1", 3.0, "c1 (c1) is not used: averaged 2 s, needed 5 s."),
        ("c7", 20.0, "c7 is c7, a bed that no statement speaks of."),
    ],
)
def test_a_bed_of_the_paper_that_decides_nothing_is_not_said_to_be_none(make, tmp_path, name, end, told):
    make(name, end=end)
    done = CliRunner().invoke(cli, ["claims", str(tmp_path / name)])
    assert done.exit_code == 0, done.output
    assert told in done.stdout.splitlines() and "no run here is one" not in done.stdout
    assert "they speak of beds that are not among these runs" in done.stdout


def test_means_that_begin_in_the_start_up_are_warned_of(tmp_path):
    """c2 is steady from 1.8 s on, and its means begin at 1 s; later blocks of it count before it."""
    whole = CASES.parent / "docs/results/paper/c2.nc"
    done = CliRunner().invoke(cli, ["pool", str(whole), "--from", "1.8", "-o", str(tmp_path / "c2-later.nc")])
    assert done.exit_code == 0, done.output
    done = CliRunner().invoke(cli, ["claims", str(whole), str(tmp_path / "c2-later.nc")])
    assert done.exit_code == 0, done.output
    (warning,) = done.stderr.splitlines()
    assert warning.startswith("warning: c2: the time means over 1–8.17 s") and "steady from 1.8 s on" in warning
    line = "c2.nc (c2) is not used: start-up included in its means; c2-later.nc counts."
    assert line in done.stdout.splitlines()


def test_a_folder_of_runs_is_answered_with_the_runs_in_it(make, tmp_path):
    make("c4-0.0")
    done = CliRunner().invoke(cli, ["claims", str(tmp_path)])
    assert done.exit_code == 1 and f"give those that are meant: `fbcouple claims {tmp_path / 'c4-0.0'}`" in done.output


def test_a_bed_of_the_paper_shows_the_statements_that_speak_of_it_alone(make, tmp_path):
    make("c6")
    done = CliRunner().invoke(cli, ["claims", str(tmp_path / "c6")])
    assert done.exit_code == 0, done.output
    assert done.stdout.splitlines()[-1].startswith(f"{len(CLAIMS) - 2} of {len(CLAIMS)} statements cannot be told")
    assert "matches the" in done.stdout and "only as pictures" in " ".join(done.stdout.split())
