"""Parcels in the case: their number, size, contacts and drag against those of the grains, and what is refused."""

import math

import numpy as np
import pytest

from fbcouple.case.bed.contact_coefficients import find_pair, find_wall, scale_restitution
from fbcouple.case.bed.derived import dem_step, find_spring, pair_contact_time, steps_per_contact
from fbcouple.case.bed.drag_balance import find_balance, find_drag, minimum_fluidization, terminal_velocity
from fbcouple.case.bed.feeds import count_fed
from fbcouple.case.bed.particle_types import (
    count_kinds,
    grain_count,
    grains_per_parcel,
    list_kinds,
    mean_kind,
    particle_count,
    solids_volume,
)
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.rest_overlap import find_rest_overlap
from fbcouple.case.cost.work import count_work
from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import estimate
from fbcouple.case.source import find_case
from fbcouple.decks.conduction import find_radius_factor
from fbcouple.errors import CaseError

BED = "mueller/0.9"
HERTZ = ["contact.model=hertz", "contact.youngs_modulus=1e7", "contact.poisson_ratio=0.25", "contact.impact_speed=1.0"]
ELASTIC = ["contact.restitution=1.0", "contact.wall_restitution=1.0"]
MIXTURE = ["particles.mixture=[[0.8e-3, 2000.0, 0.3]]"]

HEAT = ["heat.particle_conductivity=1.0", "heat.particle_specific_heat=800.0", "heat.particle_temperature=300.0"]
HEAT += ["heat.gas_specific_heat=1000.0", "heat.gas_conductivity=0.026", "heat.gas_temperature=300.0"]
HEAT += ["heat.contact_conduction=batchelor-obrien", "heat.conduction_modulus=1e9"]


def load(*sets, ratio=None):
    return load_case(BED, [*sets, *([] if ratio is None else [f"particles.coarse_graining={ratio}"])])


def find_number(case, name):
    numbers = {number.name: number for number in estimate(case, None, find_case(BED).parent)}
    return numbers.get(name)


def problems_of(*sets):
    with pytest.raises(CaseError) as caught:
        load_case(BED, list(sets))
    return caught.value.problems


@pytest.mark.parametrize("sets", [[], MIXTURE], ids=["one kind", "mixture"])
def test_a_parcel_is_as_large_and_heavy_as_its_grains(sets):
    grains, parcels = load(*sets), load(*sets, ratio=2.0)
    assert grains_per_parcel(parcels.particles) == 8.0 and particle_count(grains.particles) == 9240
    for grain, parcel in zip(list_kinds(grains.particles), list_kinds(parcels.particles), strict=True):
        assert parcel.diameter == 2.0 * grain.diameter and parcel.grain_diameter == grain.diameter
        assert parcel.density == grain.density and parcel.share == grain.share
        assert parcel.mass == pytest.approx(8.0 * grain.mass, rel=1e-15) and parcel.grains == 8.0
    assert mean_kind(parcels.particles).diameter == pytest.approx(2.0 * mean_kind(grains.particles).diameter, rel=1e-14)
    assert particle_count(parcels.particles) == 1155 and grain_count(parcels.particles) == 9240
    assert sum(count_kinds(parcels.particles)) == 1155
    assert solids_volume(parcels.particles) == pytest.approx(solids_volume(grains.particles), rel=2e-3)


def test_a_bed_by_mass_has_as_many_parcels_as_weigh_it():
    case = load_case("patil/c2", ["particles.coarse_graining=1.5"])
    assert particle_count(case.particles) == round(57296 / 1.5**3)


@pytest.mark.parametrize("restitution", [0.986, 0.86, 0.7])
@pytest.mark.parametrize("ratio", [1.0, 1.26, 1.9])
def test_restitution_loses_as_much_in_a_volume_and_a_time(restitution, ratio):
    """Collisions of a volume take (1 - e^2)/d of the agitation in a time (Lu et al. 2017, as kinetic theory has it)."""
    scaled = scale_restitution(restitution, ratio)
    assert (1.0 - scaled**2) / ratio == pytest.approx(1.0 - restitution**2, rel=1e-12)
    case = load(
        f"contact.restitution={restitution}", "contact.wall_restitution=0.9", "contact.friction=0.3", ratio=ratio
    )
    (kind,) = list_kinds(case.particles)
    pair, wall = find_pair(case.contact, kind, kind), find_wall(case.contact, kind)
    assert pair.restitution == pytest.approx(scaled, rel=1e-14) and pair.friction == 0.3
    assert wall.restitution == pytest.approx(scale_restitution(0.9, ratio), rel=1e-14) and wall.friction == 0.1


def test_numbers_of_the_restitution_by_hand():
    assert scale_restitution(0.86, 3.0) == pytest.approx(math.sqrt(0.2188), rel=1e-12)
    assert scale_restitution(1.0, 50.0) == 1.0
    with pytest.raises(ValueError, match="no restitution"):
        scale_restitution(0.86, 3.9)


def test_rows_of_species_are_scaled_too_and_left_alone_where_asked():
    rows = ["contact.pairs=[[1, 2, 0.9, 0.2]]", "contact.walls=[[2, 0.8, 0.2]]"]
    for scale, pair_wanted, wall_wanted in ((True, math.sqrt(0.62), math.sqrt(0.28)), (False, 0.9, 0.8)):
        case = load(*MIXTURE, *rows, f"contact.scale_restitution={str(scale).lower()}", ratio=2.0)
        one, other = list_kinds(case.particles)
        assert find_pair(case.contact, one, other).restitution == pytest.approx(pair_wanted, rel=1e-14)
        assert find_wall(case.contact, other).restitution == pytest.approx(wall_wanted, rel=1e-14)


@pytest.mark.parametrize("model", [[], HERTZ], ids=["hooke", "hertz"])
@pytest.mark.parametrize("ratio", [1.26, 2.0])
def test_contacts_keep_overlap_over_diameter_and_take_as_much_longer(model, ratio):
    sets = [*model, *ELASTIC, "contact.friction=0.0", "contact.wall_friction=0.0"]
    grains, parcels = load(*sets), load(*sets, ratio=ratio)
    assert find_number(parcels, "overlap").value == pytest.approx(find_number(grains, "overlap").value, rel=1e-12)
    resting = [find_number(case, "overlap at rest").value for case in (grains, parcels)]
    assert resting[1] == pytest.approx(resting[0], rel=1e-4)  # of so many parcels as come nearest to the bed's weight
    times = [pair_contact_time(case.contact, case.particles) for case in (grains, parcels)]
    assert times[1] / times[0] == pytest.approx(ratio, rel=1e-12)
    steps = [dem_step(case.contact, case.particles) for case in (grains, parcels)]
    assert steps[1] / steps[0] == pytest.approx(ratio, rel=1e-12)
    assert find_spring(parcels.contact, list_kinds(parcels.particles)[0]) == ratio * parcels.contact.stiffness


def test_low_restitution_of_parcels_wants_more_steps():
    hard = ["contact.tangential=history", "contact.restitution=0.86", "contact.wall_restitution=0.86"]
    grains, parcels = load(*hard), load(*hard, ratio=3.5)
    assert steps_per_contact(grains.contact, grains.particles) == 6
    assert steps_per_contact(parcels.contact, parcels.particles) == 9
    assert find_number(parcels, "parcel restitution").value == pytest.approx(math.sqrt(1 - 3.5 * (1 - 0.86**2)))


def test_presets_give_parcels_the_steps_that_they_need():
    hard = ["contact.tangential=history", "contact.restitution=0.86", "contact.wall_restitution=0.86"]
    fine = ["accuracy=draft", *hard]
    ratio = (9240 / 216) ** (1 / 3)
    for sets in ([f"particles.coarse_graining={ratio}"], ["particles.parcels=216"]):
        assert load(*fine, *sets).contact.steps_per_contact == 9
    assert load(*fine).contact.steps_per_contact == 6
    (problem,) = problems_of(*fine, "particles.coarse_graining=3.9")
    assert "1/(1 - e^2)" in problem


def test_a_number_of_parcels_of_a_bed_that_is_wrong_is_no_further_problem():
    problems = problems_of("particles.parcels=100", "particles.mixture=[[1e-3,1e3,0.6],[2e-3,1e3,0.6]]")
    assert problems and not any("parcels" in problem for problem in problems)


def test_max_overlap_gives_parcels_the_overlap_that_was_asked_for():
    case = load("contact.max_overlap=0.02", ratio=2.0)
    assert 0.0198 < find_number(case, "overlap").value <= 0.02


def test_drag_balances_are_those_of_the_grains():
    grains, parcels = load(), load(ratio=2.0)
    assert terminal_velocity(parcels) == pytest.approx(terminal_velocity(grains), rel=1e-12)
    assert minimum_fluidization(parcels) == pytest.approx(minimum_fluidization(grains), rel=1e-12)
    (grain,), (parcel,) = list_kinds(grains.particles), list_kinds(parcels.particles)
    drags = [find_drag(case, 0.6, 0.7, None, kind) for case, kind in ((grains, grain), (parcels, parcel))]
    assert drags[1] == pytest.approx(8.0 * drags[0], rel=1e-14)
    slips = [find_balance(case, 0.5, None, kind) for case, kind in ((grains, grain), (parcels, parcel))]
    assert slips[1] == pytest.approx(slips[0], rel=1e-12)


def test_cost_counts_parcels_and_their_longer_steps():
    grains, parcels = (count_work(case) for case in (load(*ELASTIC), load(*ELASTIC, ratio=2.0)))
    assert parcels.particles == grains.particles / 8.0
    assert parcels.dem_steps == pytest.approx(grains.dem_steps / 2.0, rel=1e-5)


def test_feeds_are_rates_of_grains():
    feed = "particles.feeds=[{low=[0.0,0.0,0.08],high=[0.044,0.01,0.1],rate=800.0}]"
    grains, parcels = load(feed), load(feed, ratio=2.0)
    assert count_fed(grains) == 8800.0 and count_fed(parcels) == 1100.0
    assert find_number(parcels, "particles fed").value == 8800
    mass = feed.replace("rate=800.0", "mass_flow=1e-3")
    assert count_fed(load(mass, ratio=2.0)) == pytest.approx(count_fed(load(mass)) / 8.0, rel=1e-12)


@pytest.mark.parametrize("number", [9240, 4620, 1155, 777])
def test_a_number_of_parcels_gives_the_ratio_that_makes_it(tmp_path, number):
    case = load(f"particles.parcels={number}")
    assert case.particles.parcels is None and particle_count(case.particles) == number
    assert case.particles.coarse_graining == pytest.approx((9240 / number) ** (1 / 3), rel=1e-15)
    assert grain_count(case.particles) == pytest.approx(9240, rel=1e-12)
    write_case(
        case.model_copy(update={"output": case.output.model_copy(update={"references": ()})}), tmp_path / "a.toml"
    )
    text = (tmp_path / "a.toml").read_text(encoding="utf-8")
    assert "parcels = " not in text and f"coarse_graining = {case.particles.coarse_graining!r}" in text
    assert load_case(str(tmp_path / "a.toml")).particles == case.particles


def test_a_number_of_parcels_of_a_bed_by_mass():
    assert particle_count(load_case("patil/c2", ["particles.parcels=10000"]).particles) == 10000


def test_what_is_set_goes_on_top_of_what_the_file_has(tmp_path):
    text = find_case(BED).read_text(encoding="utf-8").partition("[output]")[0]
    text = text.replace("count = 9240", "count = 9240\ncoarse_graining = 2.0")
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    assert load_case(str(tmp_path)).particles.coarse_graining == 2.0
    assert particle_count(load_case(str(tmp_path), ["particles.parcels=1000"]).particles) == 1000
    both = text.replace("coarse_graining = 2.0", "coarse_graining = 2.0\nparcels = 9")
    (tmp_path / "case.toml").write_text(both, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(str(tmp_path))
    assert "particles.parcels: 9 is given and coarse_graining = 2 too; give one" in str(caught.value)
    assert load_case(str(tmp_path), ["particles.coarse_graining=1.5"]).particles.coarse_graining == 1.5


def test_more_parcels_than_grains_are_refused():
    (problem,) = problems_of("particles.parcels=9241")
    assert "particles.parcels: 9241 is given and the bed has 9240 particles" in problem
    feed = "particles.feeds=[{low=[0.0,0.0,0.08],high=[0.044,0.01,0.1],rate=800.0}]"
    (problem,) = problems_of("particles.parcels=5", "particles.count=0", feed)
    assert "the bed starts with no particles; give coarse_graining" in problem
    (problem,) = problems_of("particles.coarse_graining=0.5")
    assert "particles.coarse_graining" in problem and "1" in problem


@pytest.mark.parametrize("key", ["restitution", "wall_restitution"])
def test_ratios_that_restitution_does_not_allow_are_refused_with_the_reason(key):
    (problem,) = problems_of(f"contact.{key}=0.86", "particles.coarse_graining=3.9")
    assert problem.startswith("--set: particles.coarse_graining: 3.9 is given; grains of restitution 0.86 lose more")
    assert "1/(1 - e^2)" in problem and "3.84" in problem and "contact.scale_restitution = false" in problem
    load(f"contact.{key}=0.86", "contact.scale_restitution=false", ratio=3.9)
    load(f"contact.{key}=0.86", ratio=3.8)
    rows = ["contact.pairs=[[1, 2, 0.5, 0.1]]", *MIXTURE]
    assert any("restitution 0.5" in problem for problem in problems_of(*rows, "particles.coarse_graining=1.5"))


@pytest.mark.parametrize(
    "sets",
    [
        HEAT,
        [*HEAT[:-1], *HERTZ],
        [*HEAT, *MIXTURE],
        ["contact.max_overlap=0.01"],
        [*HERTZ, "contact.tangential=history", "particles.rotation=true"],
        ["accuracy=draft", *HEAT],
        ["particles.parcels=90", *HEAT],
    ],
)
def test_no_check_calculates_with_a_restitution_that_parcels_cannot_have(sets):
    beyond = [] if "particles.parcels=90" in sets else ["particles.coarse_graining=4.5"]
    problems = problems_of("contact.restitution=0.87", *sets, *beyond)
    assert [problem for problem in problems if "restitution 0.87 lose more" in problem], problems


def test_check_tells_parcels_and_what_is_too_coarse():
    assert find_number(load(), "parcels") is None
    case = load(ratio=2.0)
    assert find_number(case, "particles").value == 9240 and find_number(case, "parcels").value == 1155
    assert find_number(case, "coarse graining").limit == "below 35.96"
    across, deep = find_number(case, "parcels across"), find_number(case, "parcels deep")
    assert across.value == pytest.approx(0.01 / 2.4e-3) and across.verdict == "warn"
    assert deep.value == pytest.approx(find_number(case, "settled height").value / 2.4e-3) and deep.verdict == "fit"
    cell = find_number(case, "cell size x")
    assert cell.value == pytest.approx(2.0 / 2.4) and "parcels" in cell.meaning
    bubble = 0.54 * (0.9 - find_number(case, "minimum fluidization").value) ** 0.4 / 9.81**0.2
    bubble *= find_number(case, "settled height").value ** 0.8
    assert find_number(case, "parcels in a bubble").value == pytest.approx(bubble / 2.4e-3)
    assert find_number(load(ratio=2.5), "parcels in a bubble").verdict == "warn"
    assert find_number(load("gas.inlet_velocity=0.3", ratio=2.0), "parcels in a bubble") is None
    assert find_number(load(ratio=3.5), "parcels deep").verdict == "warn"
    kept = load("contact.scale_restitution=false", ratio=2.0)
    assert find_number(kept, "coarse graining").verdict is None and find_number(kept, "parcel restitution") is None


def test_the_width_of_a_kernel_is_in_parcels():
    wide = ["exchange.voidage=gaussian", "exchange.kernel_width=4.0"]
    grains, parcels = load(*wide), load(*wide, ratio=2.0)
    assert find_number(parcels, "width x").value == pytest.approx(2.0 * find_number(grains, "width x").value)
    (problem,) = problems_of(wide[0], "exchange.kernel_width=60.0", "particles.coarse_graining=2.0")
    assert "60 diameters are 0.144 m" in problem


def test_rest_overlap_of_a_mixture():
    cases = load(*MIXTURE), load(*MIXTURE, ratio=2.0)
    found = [find_rest_overlap(case, find_region(case, find_case(BED).parent)) for case in cases]
    assert found[1] == pytest.approx(found[0], rel=1e-2)  # the count is rounded
    assert np.isfinite(found).all()


def test_positions_are_of_parcels_and_sizes_theirs(tmp_path):
    text = find_case(BED).read_text(encoding="utf-8").partition("[start]")[0]
    lines = [f"{0.004 + 0.006 * n},0.005,0.01,{{}}" for n in range(5)]
    case = text.replace("count = 9240", 'count = 40\ncoarse_graining = 2.0\npositions = "p.csv"') + "[exchange]\n"
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    for diameter, sizes in ((2.4e-3, ()), (2.2e-3, ((2.2e-3, 1000.0, 5),))):
        rows = "\n".join(line.format(diameter) for line in lines)
        (tmp_path / "p.csv").write_text(f"x,y,z,diameter\n{rows}\n", encoding="utf-8")
        found = load_case(str(tmp_path)).particles
        assert found.sizes == sizes and particle_count(found) == 5
        (kind,) = list_kinds(found)
        assert kind.diameter == pytest.approx(diameter) and kind.grain_diameter == pytest.approx(diameter / 2.0)


@pytest.mark.parametrize(
    ("given", "column", "told"),
    [
        ("count = 40", [1.2e-3] * 40, "it holds particles (l = 1) and the case has parcels of l = 2 "),
        (f"mass = {40 * 1000 * math.pi / 6 * 1.2e-3**3!r}", [1.2e-3] * 40, "it holds particles (l = 1) and the case"),
        ("count = 40", [3.6e-3] * 4, "it holds parcels of l = 3 and the case has parcels of l = 2 "),
        ("count = 40\nmixture = [[0.6e-3, 1000.0, 0.5]]", [1.2e-3, 0.6e-3], "it holds particles (l = 1) and the case"),
    ],
)
def test_a_file_of_another_ratio_is_told_as_such(tmp_path, given, column, told):
    text = find_case(BED).read_text(encoding="utf-8").partition("[start]")[0]
    case = text.replace("count = 9240", f'{given}\ncoarse_graining = 2.0\npositions = "p.csv"') + "[exchange]\n"
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    rows = [f"{0.003 + 0.004 * (n % 10)},0.005,{0.003 + 0.004 * (n // 10)},{d}" for n, d in enumerate(column)]
    (tmp_path / "p.csv").write_text("\n".join(["x,y,z,diameter", *rows]), encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(str(tmp_path))
    (problem,) = caught.value.problems
    assert f"particles.positions: p.csv: {told}" in problem and "start from a run or file of the same" in problem
    assert "particles.count" not in problem


def test_what_does_not_fit_is_told_in_particles_and_parcels(tmp_path):
    (problem,) = problems_of("particles.count=900000", "particles.coarse_graining=2.0")
    assert "particles.count: 900000 particles (112500 parcels) do not fit into the box: 0.64 of its volume" in problem
    assert " parcels, " in problem and "kg); give less, in kg or particles" in problem
    (problem,) = problems_of("output.tracked=[1156]", "particles.coarse_graining=2.0")
    assert "parcel 1156 is given and there are 1155 parcels" in problem


def test_contacts_conduct_through_a_bed_of_parcels_as_through_one_of_grains():
    """The true radius of a contact over that of its soft spring is what it was."""
    grains, parcels = load(*HEAT), load(*HEAT, ratio=2.0)
    folder = find_case(BED).parent
    found = find_radius_factor(grains, folder)
    assert found < 1.0 and find_radius_factor(parcels, folder) == pytest.approx(found, rel=1e-12)


def test_sizes_of_a_file_and_a_mass_give_no_ratio(tmp_path):
    """The diameter of the case does not count then: no number of grains follows from the mass."""
    text = find_case(BED).read_text(encoding="utf-8").partition("[start]")[0]
    sizes = [2.2e-3, 2.2e-3, 2.0e-3, 2.0e-3, 2.0e-3]
    rows = [f"{0.004 + 0.006 * n},0.005,0.01,{size}" for n, size in enumerate(sizes)]
    (tmp_path / "p.csv").write_text("\n".join(["x,y,z,diameter", *rows]), encoding="utf-8")
    mass = sum(1000.0 * math.pi / 6.0 * size**3 for size in sizes)
    given = f'mass = {mass!r}\nparcels = 5\npositions = "p.csv"'
    (tmp_path / "case.toml").write_text(text.replace("count = 9240", given) + "[exchange]\n", encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(str(tmp_path))
    (problem,) = caught.value.problems
    assert "particles.parcels: 5 is given and the file of positions says how large each parcel is" in problem
    assert "give coarse_graining, or count" in problem
    by_count = load_case(str(tmp_path), ["particles.count=40"]).particles
    assert by_count.coarse_graining == pytest.approx(2.0) and len(by_count.sizes) == 2


def test_the_least_restitution_is_of_contacts_that_there_are():
    """That of two species counts, and one that rows of all species have taken the place of does not."""
    across = find_number(load(*MIXTURE, "contact.pairs=[[1, 2, 0.6, 0.3]]", ratio=1.5), "parcel restitution")
    assert across.value == pytest.approx(math.sqrt(1.0 - 1.5 * (1.0 - 0.36)))
    rows = ["contact.pairs=[[1, 1, 0.9, 0.3], [1, 2, 0.9, 0.3], [2, 2, 0.9, 0.3]]", "contact.wall_restitution=0.9"]
    replaced = load(*MIXTURE, "contact.restitution=0.5", *rows, ratio=2.0)
    assert find_number(replaced, "parcel restitution").value == pytest.approx(math.sqrt(1.0 - 2.0 * 0.19))
    (problem,) = problems_of(*MIXTURE, "contact.restitution=0.5", *rows[1:], "particles.coarse_graining=2.0")
    assert "grains of restitution 0.5 lose more" in problem


def test_a_ratio_of_1_loses_what_its_grains_do():
    assert find_number(load(ratio=1.0), "coarse graining").meaning == "Length ratio l, with the restitution of grains."
    assert "l times less" in find_number(load("contact.scale_restitution=false", ratio=2.0), "coarse graining").meaning
