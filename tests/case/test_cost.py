"""What a run costs, told before: DEM steps exactly, times as the model says, errors that fall with the window."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import get_args

import pytest
from click.testing import CliRunner

from fbcouple.case.bed.derived import dem_step
from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.region import find_region, read_mesh
from fbcouple.case.bed.thin_cells import find_thinnest
from fbcouple.case.cost.coefficients import (
    FORMAT,
    SHIPPED,
    SUBGRID,
    find_file,
    load_coefficients,
    read_coefficients,
    save_coefficients,
    scale,
)
from fbcouple.case.cost.means import predict_means
from fbcouple.case.cost.memory import CYLINDER_CELL, LAUNCHER, LAUNCHER_CELL, find_job_memory, find_memory
from fbcouple.case.cost.prediction import predict, predict_run, time_stages
from fbcouple.case.cost.work import (
    BUBBLING,
    RESTING,
    SPOUTED,
    Work,
    count_dem_steps,
    count_fluid_steps,
    count_work,
    name_law,
    share_ghosts,
)
from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import gas_step
from fbcouple.case.schema.gas import Gas
from fbcouple.case.source import find_case
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.geometry.quality import measure_widths

ROUND = replace(
    SHIPPED,
    particle=4e-9,
    neighbour=5e-9,
    rebuild=1e-7,
    dem_step=1e-6,
    cell=1e-6,
    corrector=5e-7,
    fluid_step=1e-3,
    exchange_particle=1e-8,
    exchange_cell=1e-7,
    exchange_step=1e-4,
    start_up=2.0,
    start_cell=0.0,
    contact={"hooke": 2e-8, "hooke history": 4e-8, "hertz history": 5e-8},
    subgrid=dict.fromkeys(SUBGRID, 5e-7),
    shared={"dem": 1.1, "cfd": 1.2, "exchange": 1.0},
    spread=1.0,
)
BED = Work(
    seconds=1.0,
    particles=1e5,
    contacts=2.0,
    is_bed=True,
    law="hooke",
    dem_steps=50_000,
    rebuilds=500.0,
    turnovers=0.0,
    cells=20_000,
    fluid_steps=1000.0,
    correctors=2,
    digits=4.5,
    subgrid="none",
    is_box=True,
)


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """A cache without the costs of this machine."""
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "cache"))


def test_stages_are_steps_times_what_a_step_costs():
    """DEM: 50 000 x (1 us + 1e5 x (4 + 5 + 1 + 2 x 20) ns) = 250.05 s, the 1 ns a list of 100 ns each 100 steps.

    Gas: 1000 x (1 ms + 2e4 x 2 us) = 41 s.
    """
    assert time_stages(BED, ROUND) == pytest.approx({"dem": 250.05, "cfd": 41.0, "exchange": 3.1})


def test_ranks_share_the_work_but_not_what_a_step_costs_at_least():
    """On two ranks, each with 5 % of the other's particles: 50 000 x (1 us + 5 ms x 1.05 x 1.1 / 2)."""
    found = time_stages(BED, ROUND, ranks=2, ghosts=0.05)
    assert found == pytest.approx({"dem": 144.425, "cfd": 25.0, "exchange": 1.6})


@pytest.mark.parametrize(("law", "seconds"), [("hooke", 250.05), ("hooke history", 450.05), ("hertz history", 550.05)])
def test_friction_that_remembers_costs_more(law, seconds):
    assert time_stages(replace(BED, law=law), ROUND)["dem"] == pytest.approx(seconds)


@pytest.mark.parametrize("model", SUBGRID)
def test_a_sub_grid_model_costs_each_cell_more(model):
    """1000 x 20 000 x 0.5 us, on two ranks with what they cost each other."""
    for ranks, seconds in ((1, 10.0), (2, 6.0)):
        with_model = time_stages(replace(BED, subgrid=model), ROUND, ranks=ranks)["cfd"]
        assert with_model - time_stages(BED, ROUND, ranks=ranks)["cfd"] == pytest.approx(seconds)


def test_particles_that_fly_alone_have_no_neighbours_to_look_through():
    """50 000 x (1 us + 1e5 x 4 ns)."""
    assert time_stages(replace(BED, contacts=0.0, is_bed=False), ROUND)["dem"] == pytest.approx(20.05)


def test_a_phase_that_is_not_there_costs_nothing():
    assert set(time_stages(replace(BED, cells=0, fluid_steps=0.0), ROUND)) == {"dem"}
    assert set(time_stages(replace(BED, particles=0.0, dem_steps=0), ROUND)) == {"cfd"}


def test_dem_steps_are_those_of_the_constant_step():
    """20 s of patil/c2 with k_n = 1000 N/m: T_C = pi sqrt(M/k_n) = 8.037e-5 s, a sixth of it a step."""
    case = load_case("patil/c2", ["contact.stiffness=1000"])
    step = dem_step(case.contact, case.particles)
    assert step == pytest.approx(8.0373e-5 / 6, rel=1e-4)
    assert count_dem_steps(case, 20.0) == math.ceil(20.0 / step) == pytest.approx(1.4925e6, rel=1e-3)


def test_fluid_steps_follow_a_ramp():
    """At half the speed a Courant step is twice as long; a bed under half a second of each takes 3/4 of the steps."""
    fast = load_case("patil/c2", ["gas.max_fourier=50"])
    ramp = {"inlet_velocity": None, "inlet_ramp": ((0.0, 0.6), (0.5, 0.6), (0.5, 1.2), (1.0, 1.2))}
    slow = fast.model_copy(update={"gas": fast.gas.model_copy(update=ramp)})
    held = dem_step(fast.contact, fast.particles)
    assert gas_step(slow, 0.5) == pytest.approx(2.0 * gas_step(fast)) and gas_step(fast) > 20 * held
    ratio = count_fluid_steps(slow, 1.0) / count_fluid_steps(fast, 1.0)
    assert ratio == pytest.approx(0.75, rel=0.02)


def test_a_fluid_step_is_no_shorter_than_a_dem_step():
    case = load_case("patil/c2", ["gas.max_step=1e-6"])
    assert count_fluid_steps(case, 1.0) == pytest.approx(count_dem_steps(case, 1.0), rel=1e-4)


@pytest.mark.parametrize(
    ("name", "law", "contacts"),
    [
        ("patil/c2", "hooke", "bubbling"),
        ("netl/biseg", "hooke history", "bubbling"),
        ("yue/spout", "hertz history", "spouted"),
        ("anand/hopper", "hertz history", "resting"),
    ],
)
def test_contacts_are_of_the_law_and_the_state_of_the_bed(name, law, contacts):
    case = load_case(name)
    work = count_work(case, find_case(name).parent)
    states = {"resting": RESTING, "spouted": SPOUTED, "bubbling": BUBBLING}
    assert name_law(case) == work.law == law and work.contacts == states[contacts]


def test_a_bed_that_less_gas_than_lifts_it_flows_through_rests():
    """patil/c2 is fluidized by 0.54 m/s."""
    found = [count_work(load_case("patil/c2", [f"gas.inlet_velocity={u}"])).contacts for u in (0.5, 0.6)]
    assert found == [RESTING, BUBBLING]


def test_particles_that_are_fed_count_from_when_they_come():
    """5000 a second up to 1.358 s, of 4.25 s: 6790 particles for all but the 0.679 s that they wait on the mean."""
    work = count_work(load_case("anand/hopper"))
    assert work.particles == pytest.approx(6790 * (1.0 - 0.679 / 4.25))


def test_ranks_look_at_the_particles_beside_them():
    """patil/c2 is cut across its width of 80 mm: 1.3 mm of a neighbour beside 40 mm, on both sides of 20 mm."""
    case = load_case("patil/c2")
    assert [share_ghosts(case, ranks) for ranks in (1, 2, 4)] == pytest.approx([0.0, 0.0325, 0.13])


def test_the_factor_grows_with_what_is_not_known():
    case, exact = load_case("patil/c2"), replace(SHIPPED, spread=1.0)
    one, many = predict(case, 1, exact), predict(case, 64, exact)
    shipped = predict(case, 1, SHIPPED)
    assert 1.15 < one.factor < many.factor < 2.0 < shipped.factor
    assert shipped.factor == pytest.approx(math.exp(math.hypot(math.log(one.factor), math.log(2.0))))


def test_a_machine_twice_as_slow_takes_twice_as_long():
    case = load_case("mueller/0.9")
    one, slow = predict(case, 2, SHIPPED), predict(case, 2, scale(SHIPPED, 2.0))
    assert slow.wall == pytest.approx(2.0 * one.wall) and slow.memory == one.memory
    assert one.core_hours == pytest.approx(one.wall * 2 / 3600)


NEVER = "averages.until_error=0.01"
"""An error that ends no run of a length that anybody has."""


@pytest.mark.parametrize(
    ("name", "end", "found"), [("patil/c2", 10.21, 0.10), ("patil/c5-0.0", 6.05, 0.10)], ids=["c2", "c5-0.0"]
)
def test_errors_of_beds_that_were_run(name, end, found):
    """docs/results: standard error of the flux map over the map, of means from 1 s on."""
    sure = predict_means(load_case(name, [f"end_time={end}", NEVER]))
    assert sure.error / sure.factor < found < sure.error * sure.factor


def test_four_windows_are_twice_as_sure():
    short, long = (predict_means(load_case("patil/c2", [f"end_time={end}", NEVER])) for end in (3.0, 9.0))
    assert short.error == pytest.approx(2.0 * long.error)
    assert long.period == pytest.approx(2.0 * math.pi * math.sqrt(0.0417 / 9.81), rel=2e-3)


def test_a_run_until_it_is_sure_ends_when_it_is():
    case = load_case("patil/c2", ["end_time=100", "averages.until_error=0.1", "averages.earliest_end=1"])
    sure, work = predict_means(case), predict(case, 1, SHIPPED).work
    assert sure.error == pytest.approx(0.1) and work.seconds == sure.end < 30.0
    late = predict_means(load_case("patil/c2", ["averages.until_error=0.5", "averages.earliest_end=8", "end_time=9"]))
    assert late is not None and late.end == 8.0
    whole = predict_means(load_case("patil/c2", ["averages.until_error=0.5", "averages.earliest_end=8", "end_time=7"]))
    assert whole is not None and whole.end == 7.0
    hasty = predict_means(load_case("patil/c2", ["end_time=2", "averages.until_error=0.01"]))
    assert hasty.end == 2.0 and hasty.error > 0.01


def test_a_start_up_that_the_run_finds_is_taken_for_four_periods_and_a_third_of_the_run_at_most():
    long, short = (
        predict_means(load_case("patil/c2", ["averages.start=auto", f"end_time={end}", NEVER])) for end in (20, 3)
    )
    assert long.window == pytest.approx(20.0 - 4.0 * long.period) and short.window == pytest.approx(2.0)
    sets = ["averages.start=auto", "averages.until_error=0.1", "averages.earliest_end=1", "end_time=100"]
    sure = predict_means(load_case("patil/c2", sets))
    assert sure.error == pytest.approx(0.1) and sure.end == pytest.approx(sure.window + 4.0 * sure.period)
    hasty = predict_means(load_case("patil/c2", [*sets, "averages.until_error=0.5"]))
    assert hasty.end == pytest.approx(12.0 * hasty.period) and hasty.error < 0.5


@pytest.mark.parametrize("name", ["anand/hopper", "single-impact"])
def test_no_error_is_told_of_what_does_not_bubble(name):
    assert predict_means(load_case(name)) is None


def test_costs_are_kept_by_host():
    assert load_coefficients() == SHIPPED and SHIPPED.is_shipped
    found = replace(scale(SHIPPED, 0.5), measured="here", spread=1.2)
    path = save_coefficients(found, {"scenes": []})
    assert path == find_file() and load_coefficients() == found and not found.is_shipped
    assert find_file("another/../host").name == "cost-another_.._host.json"


@pytest.mark.parametrize(
    ("edit", "text"),
    [
        (lambda content: content["coefficients"].pop("cell"), "its names are others"),
        (lambda content: content["coefficients"].update(cell=-1.0), "cell is no number"),
        (lambda content: content["coefficients"]["contact"].update(hooke="x"), "contact.hooke is no number"),
        (lambda content: content.update(format=0), f"format 0 is not {FORMAT}"),
        (lambda content: content.update(coefficients=3), "no table"),
    ],
)
def test_damaged_costs_are_refused(tmp_path, edit, text):
    content = json.loads(json.dumps({"format": FORMAT, "coefficients": asdict(SHIPPED)}))
    assert read_coefficients(json.dumps(content), tmp_path) == SHIPPED
    edit(content)
    with pytest.raises(CaseError, match=f"{text}.*bench calibrate"):
        read_coefficients(json.dumps(content), tmp_path)


def test_a_run_goes_on_without_a_prediction(tmp_path):
    """Costs that cannot be read are told of, and are no reason not to run."""
    case, said = load_case("patil/demo"), []
    write_case(case, tmp_path / "case.toml")
    told = predict_run(tmp_path, 2, said.append)
    assert told["ranks"] == 2 and told["dem_steps"] == count_dem_steps(case, 2.0) and said == []
    save_coefficients(SHIPPED, {}).write_text("{}")
    assert predict_run(tmp_path, 2, said.append) is None
    assert len(said) == 1 and "is not predicted" in said[0] and "bench calibrate" in said[0]


def test_check_tells_what_a_run_will_cost():
    lines = CliRunner().invoke(cli, ["check", "patil/c2", "-n", "2"]).output.splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("predicted on 2 ranks"))
    names = [line.split("  ")[0] for line in lines[start:] if line[:1].strip()]
    assert names[1:5] == ["wall time", "core-hours", "memory", "error of the means"]
    assert "of another machine" in lines[-2] and "bench calibrate" in lines[-2]
    case = load_case("patil/c2")
    assert f"{count_dem_steps(case, predict_means(case).end)} DEM steps" in "\n".join(lines)


def test_what_leaves_a_bed_at_rest_falls_fast():
    """The hopper's grains fall by its box, 0.162 m high: 1.2 sqrt(g H) over half a skin of 0.4 x 2.24 mm."""
    case, folder = load_case("anand/hopper"), find_case("anand/hopper").parent
    height, half = case.domain.size[2], 0.5 * 0.4 * 2.24e-3
    found = count_work(case, folder)
    assert found.rebuilds / found.seconds == pytest.approx(1.2 * math.sqrt(9.81 * height) / half, rel=1e-3)


def test_every_sub_grid_model_has_a_cost():
    allowed = get_args(Gas.model_fields["turbulence"].annotation)
    assert set(allowed) == {"none", *SUBGRID}


@pytest.mark.parametrize("shape", ["cylinder", "box"])
@pytest.mark.parametrize("elements", ["prisms", "tetrahedra"])
def test_cells_that_are_made_here_are_as_thin_as_their_mesh_has_them(shape, elements):
    sets = [f"domain.shape={shape}", f"domain.elements={elements}", "domain.size=[0.05, 0.05, 0.1]"]
    case = load_case("mueller/0.9", [*sets, "domain.cells=[6, 6, 12]"])
    assert find_thinnest(case, Path()) == pytest.approx(measure_widths(read_mesh(case))[:, 2].min(), rel=1e-9)


def feed(mass_flow, *sets):
    tables = f"particles.feeds=[{{low=[0.0, 0.0, 0.1], high=[0.08, 0.015, 0.12], mass_flow={mass_flow}}}]"
    return count_work(load_case("patil/c1", [tables, *sets]), end=2.0)


def test_a_feed_costs_a_turnover_in_each_step_in_which_it_brings_something():
    """A particle has 1.31e-6 kg: 1 kg/s are hundreds in a fluid step, 1.31e-5 kg/s ten a second."""
    fast, slow = feed(1.0), feed(1.309e-5)
    assert fast.turnovers == fast.fluid_steps and slow.turnovers == pytest.approx(20.0, rel=1e-3)
    dear, cheap = (time_stages(work, SHIPPED)["dem"] for work in (slow, replace(slow, turnovers=0.0)))
    assert dear - cheap == pytest.approx(20.0 * SHIPPED.turnover, rel=1e-3)


def test_gas_that_carries_particles_is_as_fast_as_it_comes_in():
    """No bed makes it 1/0.40 times as fast: 0.4/0.65 of the steps."""
    bed = load_case("patil/c1")
    assert count_fluid_steps(bed, 1.0, carried=True) / count_fluid_steps(bed, 1.0) == pytest.approx(0.26, rel=0.1)


def test_cells_of_a_mesh_take_more_memory_and_a_job_holds_its_launcher():
    """119 404 tetrahedra took 6.4 kB each, 675 000 hexahedra of a cylinder 4.3, those of a box 1.9."""
    case = load_case("verma/1.02")
    cells, particles = find_region(case).cells, particle_count(case.particles)
    ranks = find_memory(case, ranks=2) - SHIPPED.particle_memory * particles - CYLINDER_CELL * cells
    assert ranks == pytest.approx(2 * SHIPPED.rank_memory) and 2 * SHIPPED.cell_memory < CYLINDER_CELL
    beside = find_job_memory(case, Path(), 2) - find_memory(case, ranks=2)
    assert beside == pytest.approx(LAUNCHER + LAUNCHER_CELL * cells)
    box = load_case("patil/c2")
    assert find_job_memory(box, Path(), 1) - find_memory(box) == LAUNCHER
