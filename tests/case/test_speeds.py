"""How fast particles can be when they meet, and the pre-flight numbers of a bed over an inlet that is no floor."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.bed.drag_balance import find_drag, terminal_velocity
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.case.bed.positions import start_positions
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import list_speeds
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate, require_fit
from fbcouple.geometry.block import make_block
from fbcouple.geometry.foam_files import write_polymesh

CASE = """
title = "speeds"
end_time = 0.01
[domain]
size = [0.012, 0.012, 0.036]
cells = [6, 6, 18]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.5
[particles]
diameter = 1e-3
density = 1000.0
count = 1500
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
filter_passes = 1
"""
MESH = 'shape = "file"\nmesh = "mesh"\nsize = [0.012, 0.012, 0.036]'
SOLIDS = 1500 * np.pi / 6 * 1e-9


def write(folder, *changes):
    text = CASE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "case.toml").write_text(text)
    return load_case(str(folder / "case.toml"))


def write_dry(folder, *changes):
    """The same without gas."""
    gas = CASE[CASE.index("[gas]") : CASE.index("[particles]")]
    return write(folder, (gas, ""), ("[exchange]\nfilter_passes = 1\n", ""), *changes)


def write_jet(folder, turn=None):
    """A column whose inlet is the middle ninth of its floor; `turn` takes its points elsewhere."""
    mesh = make_block((0.012, 0.012, 0.036), (6, 6, 9), "prisms")
    first, count = mesh.patches["inlet"]
    rows = mesh.faces.take(np.arange(first, first + count))
    middles = np.add.reduceat(mesh.points[rows.values], rows.starts[:-1]) / rows.lengths[:, None]
    middle = np.all(np.abs(middles[:, :2] - 0.006) < 0.002, axis=1)
    order = np.arange(len(mesh.owner))
    order[first : first + count] = first + np.argsort(~middle, kind="stable")
    jet = int(middle.sum())
    patches = {"inlet": (first, jet), "floor": (first + jet, count - jet)} | {
        name: where for name, where in mesh.patches.items() if name != "inlet"
    }
    points = mesh.points if turn is None else turn(mesh.points)
    faces, owner = mesh.faces.take(order), mesh.owner[order]
    write_polymesh(type(mesh)(points, faces, owner, mesh.neighbour, patches), folder / "mesh")


def read_numbers(case, folder):
    return {number.name: number for number in estimate(case, folder=folder)}


def speed_of(case, folder=None):
    folder = folder or Path()
    ((_, speed, why),) = list_speeds(case, find_region(case, folder), None, folder)
    return speed, why


def test_a_jet_in_the_floor_weighs_no_bed(tmp_path):
    """Height, pressure drop and fluidization are of the column, not of the ninth of its floor that is the inlet."""
    write_jet(tmp_path)
    changes = ("size = [0.012, 0.012, 0.036]", MESH), ("inlet_velocity = 0.5", "inlet_velocity = 8.0")
    case = write(tmp_path, *changes)
    numbers = read_numbers(case, tmp_path)
    assert find_region(case, tmp_path).inlet == pytest.approx(0.012**2 / 9, rel=1e-12)
    assert numbers["settled height"].value == pytest.approx(SOLIDS / 0.6 / 0.012**2, rel=1e-6)
    weight = SOLIDS * (1000.0 - 1.2) * 9.81
    assert numbers["pressure drop"].value == pytest.approx(weight / 0.012**2, rel=1e-6)
    assert numbers["minimum fluidization"].limit == "below U_f = 0.888889"
    assert numbers["inlet direction"].verdict == "fit" and numbers["inlet direction"].value == pytest.approx(0.0)
    require_fit(case, folder=tmp_path)


def test_a_bead_in_a_jet_is_as_fast_as_its_way_allows(tmp_path):
    """Over a bed of 9 mm a jet of 8 m/s makes a bead of 1 mm no faster than its drag at the start would."""
    write_jet(tmp_path)
    changes = ("size = [0.012, 0.012, 0.036]", MESH), ("inlet_velocity = 0.5", "inlet_velocity = 8.0")
    case = write(tmp_path, *changes)
    (kind,) = list_kinds(case.particles)
    pull = find_drag(case, 1.0, 8.0, None, kind) * 8.0 / kind.mass - 9.81 * (1.0 - 1.2 / 1000.0)
    jet = math.sqrt(2.0 * pull * SOLIDS / 0.6 / 0.012**2)
    speed, _ = speed_of(case, tmp_path)
    assert 0.5 < jet <= speed < 1.5


@pytest.mark.parametrize(
    ("turn", "angle", "words", "verdict"),
    [
        (lambda p: p[:, [0, 2, 1]] * [1, 1, -1] + [0, 0, 0.012], 90.0, "from the side, along (0, 1, 0)", "warn"),
        (lambda p: p * [1, -1, -1] + [0, 0.012, 0.036], 180.0, "from the top, along (0, 0, -1)", "warn"),
        (lambda p: p, 0.0, "from the bottom, along (0, 0, 1)", "fit"),
    ],
)
def test_where_the_gas_comes_in_is_told(tmp_path, turn, angle, words, verdict):
    write_jet(tmp_path, turn)
    size = np.ptp(turn(np.array([[0.0, 0.0, 0.0], [0.012, 0.012, 0.036]])), axis=0).tolist()
    case = write(tmp_path, ("size = [0.012, 0.012, 0.036]", MESH.replace("[0.012, 0.012, 0.036]", str(size))))
    number = read_numbers(case, tmp_path)["inlet direction"]
    assert number.value == pytest.approx(angle, abs=1e-5) and number.verdict == verdict
    assert words in number.meaning and "gravity acts along (0, 0, -1)" in number.meaning


def test_a_single_sphere_meets_walls_only(tmp_path):
    """At sqrt(2 g h) from its start, with its whole mass: x = v sqrt(m/k) where it loses nothing."""
    (tmp_path / "one.csv").write_text("x,y,z\n0.006,0.006,0.0345\n")
    changes = (
        ("count = 1500", 'count = 1\npositions = "one.csv"'),
        ("[start]\n", ""),
        ("wall_restitution = 0.9", "wall_restitution = 1.0"),
        ("inlet_velocity = 0.5", "inlet_velocity = 0.05"),
    )
    case = write(tmp_path, *changes)
    number = read_numbers(case, tmp_path)["overlap"]
    speed = math.sqrt(2 * 9.81 * (1 - 1.2 / 1000.0) * 0.0345)
    mass = np.pi / 6 * 1e-9 * 1000.0
    assert number.value == pytest.approx(speed * math.sqrt(mass / 1000.0) / 1e-3, rel=1e-6)
    assert "contact with a wall" in number.meaning and "a fall over 0.0345 m" in number.meaning


def test_a_sphere_that_starts_fast_is_as_fast_as_it_starts(tmp_path):
    (tmp_path / "two.csv").write_text("x,y,z,vx,vy,vz\n0.006,0.006,0.02,0,3,4\n0.006,0.006,0.01,0,0,0\n")
    case = write(tmp_path, ("count = 1500", 'count = 2\npositions = "two.csv"'), ("[start]\n", ""))
    assert speed_of(case, tmp_path) == (pytest.approx(5.0), "the start")


def test_a_start_speed_and_a_fall_add_up(tmp_path):
    """The one that is slower is the faster at the floor."""
    (tmp_path / "two.csv").write_text("x,y,z,vx,vy,vz\n0.006,0.006,0.03,0,0.3,0.4\n0.006,0.006,0.001,0,0,0.6\n")
    case = write_dry(tmp_path, ("count = 1500", 'count = 2\npositions = "two.csv"'), ("[start]\n", ""))
    speed, why = speed_of(case, tmp_path)
    assert speed == pytest.approx(math.sqrt(0.25 + 2 * 9.81 * 0.03)) and why == "the start and a fall over 0.03 m"


def test_a_loose_start_lattice_falls_onto_the_bed_that_it_makes(tmp_path):
    """At three diameters 16 sites a layer: 100 particles are seven high, and make a bed of less than one."""
    count, loose = ("count = 1500", "count = 100"), ("[start]", "[start]\nspacing = 3.0")
    speed, why = speed_of(write_dry(tmp_path, count, loose))
    height = 6.5 * 3e-3 + 0.5 * 0.5 * 2e-3 - 0.5e-3  # shaken, down to a centre on the floor
    assert speed == pytest.approx(math.sqrt(2 * 9.81 * height), rel=1e-3)
    assert why == "a fall over 0.0195 m from the start lattice"
    close, _ = speed_of(write_dry(tmp_path, count))
    assert close < 0.3 * speed


def test_a_loose_start_lattice_of_a_cylinder_falls_too(tmp_path):
    """About as far as its highest sites are."""
    round_ = ("cells = [6, 6, 18]", 'cells = [6, 6, 18]\nshape = "cylinder"'), ("count = 1500", "count = 60")
    case = write(tmp_path, *round_, ("[start]", "[start]\nspacing = 2.5"))
    case = case.model_copy(update={"gas": None, "exchange": None})
    speed, why = speed_of(case, tmp_path)
    highest = start_positions(case, tmp_path)[:, 2].max()
    assert speed == pytest.approx(math.sqrt(2 * 9.81 * highest), rel=0.1) and why.endswith("from the start lattice")


FEED = "[[particles.feeds]]\nlow = [0.0, 0.0, 0.02]\nhigh = [0.012, 0.012, 0.03]\nrate = 100.0\n"


def feed(*changes):
    """Changes of the case that make it one with a feed, itself changed."""
    text = FEED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return ("[contact]", f"{text}[contact]")


@pytest.mark.parametrize("part", ["", "\nregion = [[0.0, 0.012], [0.0, 0.012], [0.0, 0.02]]"])
@pytest.mark.parametrize("count", [0, 1, 100])
def test_what_is_fed_falls_from_its_box(tmp_path, count, part):
    case = write_dry(tmp_path, ("count = 1500", f"count = {count}"), ("[start]", f"[start]{part}"), feed())
    speed, why = speed_of(case)
    assert speed == pytest.approx(math.sqrt(2 * 9.81 * 0.0295)) and why == "a fall over 0.0295 m from feed 1"
    assert "head-on contact" in read_numbers(case, tmp_path)["overlap"].meaning


def test_what_is_fed_has_the_velocity_of_its_feed(tmp_path):
    fast = feed(("rate", "velocity = [0.0, 0.0, -20.0]\nrate"))
    speed, why = speed_of(write_dry(tmp_path, fast))
    assert speed == pytest.approx(math.sqrt(400.0 + 2 * 9.81 * 0.0295))
    assert why == "feed 1 and a fall over 0.0295 m"
    assert speed_of(write(tmp_path, fast)) == (pytest.approx(20.0), "feed 1")


def test_drag_holds_what_is_fed_at_its_terminal_velocity(tmp_path):
    small = ("diameter = 1e-3", "diameter = 1e-4"), ("count = 1500", "count = 15000")
    case = write(tmp_path, *small, ("inlet_velocity = 0.5", "inlet_velocity = 0.001"), feed())
    assert speed_of(case)[0] == pytest.approx(terminal_velocity(case), rel=1e-9)


def test_a_feed_is_of_its_species(tmp_path):
    two = ("count = 1500", 'count = 1500\nmixture = [[1e-3, 2000.0, 0.5]]\nfractions = "number"')
    fast = feed(("rate", "velocity = [0.0, 0.0, -20.0]\nspecies = 2\nrate"))
    case = write_dry(tmp_path, two, fast)
    (_, one, _), (_, other, _) = list_speeds(case, find_region(case), None, tmp_path)
    assert one < 1.0 and other > 20.0


def test_nothing_falls_faster_than_its_terminal_velocity(tmp_path):
    small = ("diameter = 1e-3", "diameter = 1e-4"), ("count = 1500", "count = 1500000")
    case = write(tmp_path, *small, ("inlet_velocity = 0.5", "inlet_velocity = 0.001"))
    assert speed_of(case)[0] == pytest.approx(terminal_velocity(case), rel=1e-9)


def test_a_bed_is_no_faster_than_the_gas_that_lifts_it(tmp_path):
    speed, why = speed_of(write(tmp_path))
    assert math.sqrt(2 * 9.81 * SOLIDS / 0.6 / 0.012**2) < speed < 0.5 and why == "the gas that lifts the bed"


def test_particles_that_fall_without_gas_are_judged_too(tmp_path):
    case = write_dry(tmp_path)
    height = SOLIDS / 0.6 / 0.012**2
    assert speed_of(case)[0] == pytest.approx(math.sqrt(2 * 9.81 * height), rel=1e-9)
    assert read_numbers(case, tmp_path)["overlap"].verdict == "fit"


@pytest.mark.parametrize("words", ['inlet_velocity = 0.0\ntop = "closed"', "inlet_ramp = [[0.0, 0.0], [1.0, -0.2]]"])
def test_nothing_is_said_of_fluidization_where_no_gas_rises(tmp_path, words):
    numbers = read_numbers(write(tmp_path, ("inlet_velocity = 0.5", words)), tmp_path)
    assert "minimum fluidization" not in numbers
    assert numbers["terminal velocity"].verdict is None and numbers["terminal velocity"].value > 1.0


def test_more_gas_than_a_particle_falls_by_carries_it_to_the_outlet_where_it_stays(tmp_path):
    number = read_numbers(write(tmp_path, ("inlet_velocity = 0.5", "inlet_velocity = 8.0")), tmp_path)
    assert (
        number["terminal velocity"].verdict == "warn" and "a wall for particles" in number["terminal velocity"].meaning
    )


@pytest.mark.parametrize(("edge", "diameter", "told"), [(0.012, 1e-3, False), (12.0, 1.0, True)])
def test_lengths_that_were_given_in_mm_are_told(tmp_path, edge, diameter, told):
    size = f"[{edge}, {edge}, {3 * edge}]"
    case = write(tmp_path, ("[0.012, 0.012, 0.036]", size), ("diameter = 1e-3", f"diameter = {diameter}"))
    meaning = read_numbers(case, tmp_path)["overlap"].meaning
    assert ("lengths are in m, 1 mm is 1e-3" in meaning) == told
