"""Files of start positions: the sizes in them, what other programs write, particles that overlap."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fbcouple.case.bed.derived import dem_step
from fbcouple.case.bed.particle_types import list_kinds, particle_count, solids_volume
from fbcouple.case.bed.positions import LARGEST_SHIFT, start_kinds, start_motion, start_positions
from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import estimate
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError

CASE = """
title = "a few particles"
end_time = 0.01
[domain]
size = [0.02, 0.02, 0.06]
cells = [5, 5, 15]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.3
[particles]
diameter = 1e-3
density = 1000.0
count = 3
positions = "start.csv"
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[exchange]
filter_passes = 1
"""
ROWS = ("0.005,0.006,0.010", "0.008,0.006,0.010", "0.011,0.006,0.010")


@pytest.fixture
def bed(tmp_path):
    """Write the case with `lines` as its positions file, and load it with settings."""

    def load(lines, *sets, text=CASE):
        (tmp_path / "case.toml").write_text(text)
        (tmp_path / "start.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        return load_case(str(tmp_path), sets)

    return load


def give(rows, *values):
    return [f"{row},{value}" for row, value in zip(rows, values, strict=True)]


@pytest.mark.parametrize("column", ["diameter", "radius"])
def test_each_particle_has_the_size_that_its_row_gives(bed, tmp_path, column):
    sizes = np.array([2.06e-3, 0.5e-3, 0.5e-3])
    given = sizes if column == "diameter" else sizes / 2
    case = bed([f"x,y,z,{column}", *give(ROWS, *given.tolist())])
    lay_out(str(tmp_path), tmp_path / "run", (), False, forced=True)
    text = (tmp_path / "run/DEM/particles.data").read_text()
    rows = [line.split() for line in text.partition("Atoms\n\n")[2].splitlines()]
    assert [float(row[2]) for row in rows] == sizes.tolist() and {row[3] for row in rows} == {"1000.0"}
    assert rows[0][1] != rows[1][1] == rows[2][1] and "3 atom types" in text
    assert solids_volume(case.particles) == pytest.approx(math.pi / 6 * (sizes**3).sum(), rel=1e-12)
    assert load_case(str(tmp_path / "run")) == case


def test_what_follows_from_the_sizes_knows_them(bed, tmp_path):
    """The smallest sets the DEM step: T_C goes as sqrt(m), so d^1.5 of it; all densities are in the weight."""
    case = bed(["x,y,z,diameter,density", *give(ROWS, "1e-3,1000", "0.25e-3,1000", "1e-3,3000")])
    alone = bed(["x,y,z", *ROWS])
    assert dem_step(case.contact, case.particles) == pytest.approx(dem_step(alone.contact, alone.particles) / 8)
    numbers = {number.name: number for number in estimate(case, folder=tmp_path)}
    weight = math.pi / 6 * (1e-9 * (1000 + 3000 - 2 * 1.2) + 0.25e-3**3 * (1000 - 1.2)) * 9.81
    assert numbers["pressure drop"].value == pytest.approx(weight / 0.0004)
    assert numbers["smallest diameter"].value == 0.25e-3 and numbers["largest diameter"].verdict == "fit"
    assert [kind.species for kind in list_kinds(case.particles)] == [1, 1, 1]


def test_sizes_that_the_diameter_of_the_case_lies_beside_are_warned_of(bed, tmp_path):
    case = bed(["x,y,z,radius", *give(ROWS, *[1e-3] * 3)])
    numbers = {number.name: number for number in estimate(case, folder=tmp_path)}
    assert numbers["smallest diameter"].value == 2e-3 and numbers["smallest diameter"].verdict == "warn"


def test_sizes_that_are_the_case_s_own_change_nothing(bed):
    assert bed(["x,y,z,radius,density", *give(ROWS, *["5e-4,1000"] * 3)]) == bed(["x,y,z", *ROWS])


def test_mass_is_held_against_the_sizes(bed):
    text = CASE.replace("count = 3", "mass = MASS")
    lines = ["x,y,z,diameter", *give(ROWS, 1e-3, 2e-3, 1e-3)]
    mass = 1000 * math.pi / 6 * 10e-9
    assert particle_count(bed(lines, text=text.replace("MASS", str(mass))).particles) == 3
    with pytest.raises(CaseError, match=r"start.csv holds 3 particles of 5.23599e-06 kg and the case 9e-06 kg"):
        bed(lines, text=text.replace("MASS", "9e-6"))


MIXTURE = "particles.mixture=[[2e-3, 500.0, 0.34]]"


def test_sizes_say_the_kinds_of_a_mixture(bed, tmp_path):
    case = bed(["x,y,z,diameter", *give(ROWS, 1e-3, "2.00001e-3", 1e-3)], MIXTURE, 'particles.fractions="number"')
    assert start_kinds(case, tmp_path).tolist() == [0, 1, 0] and not case.particles.sizes


@pytest.mark.parametrize(
    ("head", "values", "told"),
    [
        (
            "diameter",
            (1e-3, 1.5e-3, 1e-3),
            "particle 2 has 0.0015 m, which no kind of the case has .1: 0.001 m and 1000",
        ),
        ("diameter,kind", ("1e-3,1", "2e-3,1", "1e-3,1"), "particle 2 has 0.002 m, which kind 1 of the case is not"),
        ("diameter,kind", ("1e-3,1", "2e-3,2", "1e-3,3"), "particle 3 has 0.001 m, which kind 3 of the case is not"),
        ("diameter", (1e-3, 2e-3, 2e-3), r"start.csv holds \[1, 2\] particles of each kind and the case \[2, 1\]"),
    ],
)
def test_sizes_that_are_not_those_of_the_mixture_are_told(bed, head, values, told):
    with pytest.raises(CaseError, match=told):
        bed([f"x,y,z,{head}", *give(ROWS, *values)], MIXTURE, 'particles.fractions="number"')


def test_a_density_alone_that_several_kinds_have_is_told(bed):
    mixture = "particles.mixture=[[2e-3, 1000.0, 0.34]]"
    with pytest.raises(CaseError, match="particle 1 has 1000 kg m-3, which several kinds of the case have"):
        bed(["x,y,z,density", *give(ROWS, *[1000] * 3)], mixture, 'particles.fractions="number"')


def test_more_sizes_than_there_can_be_types_are_told(bed):
    rows = [f"{0.002 * (n % 9 + 1)},{0.002 * (n // 9 + 1)},0.02,{1e-3 + 1e-6 * n}" for n in range(51)]
    with pytest.raises(CaseError, match="gives 51 different sizes or densities, at most 50 are allowed"):
        bed(["x,y,z,diameter", *rows], "particles.count=51")


def place(count):
    return [f"{0.002 * (n % 9 + 1):g},{0.002 * (n // 9 % 9 + 1):g},{0.01 + 0.002 * (n // 81):g}" for n in range(count)]


@pytest.mark.parametrize(("column", "noise"), [("density", 1e-13), ("radius", 1e-15), ("diameter", 1e-7)])
def test_sizes_that_rounding_alone_parts_are_one(bed, tmp_path, column, noise):
    """As programs write them that calculate them: 200 particles of two sizes, of 60 numbers each."""
    middle = {"density": 2500.0, "radius": 5e-4, "diameter": 1e-3}[column]
    values = [middle * (1 + n % 60 * noise) * (1 if n % 4 else 0.8) for n in range(200)]
    case = bed([f"x,y,z,{column}", *give(place(200), *map(repr, values))], "particles.count=200")
    rows = [(density if column == "density" else diameter, count) for diameter, density, count in case.particles.sizes]
    scale = 2.0 if column == "radius" else 1.0
    assert [count for _, count in rows] == [50, 150]
    assert [value for value, _ in rows] == pytest.approx([0.8 * scale * middle, scale * middle], rel=1e-5)
    assert start_kinds(case, tmp_path).tolist() == [1 if n % 4 else 0 for n in range(200)]
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case


def test_a_size_that_is_the_case_s_own_but_for_rounding_changes_nothing(bed, tmp_path):
    values = [5e-4 * (1 + n * 1e-15) for n in range(3)]
    case = bed(["x,y,z,radius", *give(ROWS, *map(repr, values))])
    assert not case.particles.sizes and start_kinds(case, tmp_path).tolist() == [0, 0, 0]


def test_sizes_that_differ_little_by_little_are_not_one(bed):
    """Neighbours lie within rounding of each other, the ends do not."""
    values = [1e-3 * (1 + 0.6e-5 * n) for n in range(40)]
    case = bed(["x,y,z,diameter", *give(place(40), *map(repr, values))], "particles.count=40")
    assert [row[0] for row in case.particles.sizes] == values


def test_a_run_folder_with_every_number_as_a_size_still_loads(bed, tmp_path):
    values = [6e-4 * (1 + n * 1e-14) for n in range(3)]
    sizes = [[value, 1000.0, 1] for value in values]
    text = CASE.replace('positions = "start.csv"', f'positions = "start.csv"\nsizes = {sizes}')
    case = bed(["x,y,z,diameter", *give(ROWS, *map(repr, values))], text=text)
    assert [row[0] for row in case.particles.sizes] == values and start_kinds(case, tmp_path).tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (["x,y,z,radius,diameter", *give(ROWS, *["1e-3,1e-3"] * 3)], "diameter 0.001 and the radius 0.001 m"),
        (["x,y,z,radius", *give(ROWS, 1e-3, 0, 1e-3)], "the radius of particle 2 is 0, above 0 is allowed"),
        (["X,Y,Z,phase_id,diameter,density,U,V,W", *give(ROWS, *["1,1e-3,1e3,0,0,0"] * 3)], "`phase_id`; MFIX writes"),
        (["x,y,z,u", *give(ROWS, 1, 2, 3)], "`u`; if it is the velocity along x call it `vx`"),
        (["x,y,z,dp", *give(ROWS, 1, 2, 3)], "`dp`; if it is the diameter call it `diameter`"),
        (["x,y,z", "5,6,10", "8,6,10", "11,6,10"], "coordinates are in m .they look like mm."),
    ],
)
def test_columns_that_could_be_taken_for_others_are_told(bed, lines, told):
    with pytest.raises(CaseError, match=told):
        bed(lines)


def test_units_and_velocities_of_the_head_count(bed, tmp_path):
    lines = ["x [mm];y [mm];z [cm];diameter [um];v:0;v:1;v:2;note", "5,5;6;1;1000;0,5;0;-1;a"]
    case = bed(lines, "particles.count=1")
    assert start_positions(case, tmp_path).tolist() == [[0.0055, 0.006, 0.01]] and not case.particles.sizes
    velocities = start_motion(case, tmp_path)
    assert velocities is not None and velocities.tolist() == [[0.5, 0.0, -1.0, 0.0, 0.0, 0.0]]
    numbers = {number.name: number for number in estimate(case, folder=tmp_path)}
    assert numbers["unread columns"].verdict == "warn" and "note" in numbers["unread columns"].meaning


def test_given_sizes_must_be_those_of_the_file(bed, tmp_path):
    case = bed(["x,y,z,diameter", *give(ROWS, 1e-3, 2e-3, 1e-3)])
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case
    (tmp_path / "start.csv").write_text("\n".join(["x,y,z", *ROWS]) + "\n")
    with pytest.raises(CaseError, match=r"particles.sizes: \[\[0.001, 1000.0, 2\], .* and start.csv says nothing"):
        load_case(str(tmp_path))


def test_sizes_need_positions(bed):
    text = CASE.replace('positions = "start.csv"', "sizes = [[1e-3, 1e3, 3]]").replace(
        "[exchange]", "[start]\n[exchange]"
    )
    with pytest.raises(CaseError, match=r"particles\.sizes: .* is given and no positions"):
        bed(["x,y,z", *ROWS], text=text)


CYLINDER = CASE.replace("[domain]", '[domain]\nshape = "cylinder"').replace("cells = [5, 5, 15]", "cells = [6, 6, 12]")
PERIODIC = CASE.replace("[domain]", '[domain]\nperiodic = ["x", "y"]')
PRISMS = CASE.replace("[domain]", '[domain]\nelements = "prisms"')


@pytest.mark.parametrize("text", [CASE, CYLINDER, PERIODIC, PRISMS], ids=["box", "cylinder", "periodic", "prisms"])
def test_two_particles_at_one_place_are_told_in_every_shape(bed, text):
    lines = ["x,y,z", "0.01,0.01,0.02", "0.01,0.01,0.01", "0.01,0.01,0.02"]
    told = r"start.csv: particle 1 at \(0.01, 0.01, 0.02\) m and particle 3 at \(0.01, 0.01, 0.02\) m are at one place;"
    with pytest.raises(CaseError, match=told):
        bed(lines, text=text)


@pytest.mark.parametrize(
    ("one", "other", "overlap"),
    [
        ("0.0001,0.01,0.02", "0.0196,0.01,0.02", "by 0.5 of"),
        ("0.01,0.0199,0.02", "0.01,0.0002,0.02", "by 0.7 of"),
        ("0.0,0.0,0.02", "0.02,0.02,0.02", "are at one place"),
        ("0.0001,0.0199,0.02", "0.0199,0.0001,0.02", "by 0.717 of"),
    ],
)
def test_particles_overlap_across_periodic_sides(bed, one, other, overlap):
    with pytest.raises(CaseError, match=r"particle 2 at .* and particle 3 at .* across a periodic side") as caught:
        bed(["x,y,z", "0.01,0.01,0.05", one, other], text=PERIODIC)
    assert overlap in str(caught.value)


def test_what_does_not_overlap_across_a_periodic_side_passes(bed):
    bed(["x,y,z", "0.01,0.01,0.05", "0.0003,0.01,0.02", "0.0193,0.01,0.02"], text=PERIODIC)


@pytest.mark.parametrize(("x", "taken"), [("-1e-7", 0.0199999), ("0.0204", 0.0004), ("-1e-3", 0.019), ("0.02", 0.02)])
def test_what_lies_a_little_over_a_periodic_side_comes_in_on_the_other(bed, tmp_path, x, taken):
    """As LIGGGHTS writes particles that it has not brought in yet."""
    lines = ["x,y,z", "0.01,0.01,0.05", f"{x},0.01,0.02", "0.01,-2e-5,0.02"]
    case = bed(lines, text=PERIODIC)
    assert start_positions(case, tmp_path) == pytest.approx(
        np.array([[0.01, 0.01, 0.05], [taken, 0.01, 0.02], [0.01, 0.01998, 0.02]]), rel=1e-12
    )
    lay_out(str(tmp_path), tmp_path / "run", (), False, forced=True)
    rows = [line.split() for line in (tmp_path / "run/DEM/particles.data").read_text().split("Atoms")[1].splitlines()]
    assert [float(row[4]) for row in rows if row] == start_positions(case, tmp_path)[:, 0].tolist()
    with pytest.raises(CaseError, match=r"2 particles are not inside the box"):
        bed(lines if x != "0.02" else [*lines[:2], "-1e-7,0.01,0.02", lines[3]])


@pytest.mark.parametrize("x", [-1.1e-3, 0.0211, 0.03])
def test_what_lies_far_over_a_periodic_side_is_told(bed, x):
    told = r"1 particles are not inside the box, first is particle 2 .* up to 0.001 m over a periodic side"
    with pytest.raises(CaseError, match=told):
        bed(["x,y,z", "0.01,0.01,0.05", f"{x},0.01,0.02", "0.01,0.01,0.02"], text=PERIODIC)


def test_particles_over_a_periodic_side_overlap_with_those_at_the_other(bed):
    with pytest.raises(CaseError, match=r"particle 2 at .* and particle 3 at .* overlap by 0.5 of"):
        bed(["x,y,z", "0.01,0.01,0.05", "-1e-4,0.01,0.02", "0.0194,0.01,0.02"], text=PERIODIC)


def test_a_small_particle_may_lie_nearer_to_a_wall_than_a_large_one(bed):
    lines = ["x,y,z,diameter", "0.0002,0.01,0.02,4e-4", "0.01,0.01,0.02,4e-3", "0.01,0.01,0.03,4e-3"]
    assert bed(lines).particles.sizes == ((4e-4, 1000.0, 1), (4e-3, 1000.0, 2))
    with pytest.raises(CaseError, match=r"1 particles are not inside the cylinder, first is particle 2"):
        bed([lines[0], "0.0005,0.01,0.02,4e-4", "0.0015,0.01,0.02,4e-3", lines[3]], text=CYLINDER)


def dump(*rows, columns="id type x y z"):
    box = "ITEM: BOX BOUNDS ff ff ff\n0 0.02\n0 0.02\n0 0.06"
    return [f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(rows)}\n{box}\nITEM: ATOMS {columns}", *rows]


DUMPED = CASE.replace("start.csv", "start.dump")
PLACES = [row.replace(",", " ") for row in ROWS]


@pytest.fixture
def dumped(tmp_path):
    """The same with a dump."""

    def load(lines, *sets):
        (tmp_path / "case.toml").write_text(DUMPED)
        (tmp_path / "start.dump").write_text("\n".join(lines) + "\n")
        return load_case(str(tmp_path), sets)

    return load


SPECIES = ("particles.mixture=[[1e-3, 500.0, 0.34]]", 'particles.fractions="number"')


def test_types_of_a_dump_are_the_species(dumped, tmp_path):
    """By themselves, and where several kinds are of the size that the dump gives."""
    case = dumped(dump(f"3 1 {PLACES[2]}", f"1 1 {PLACES[0]}", f"2 2 {PLACES[1]}"), *SPECIES)
    assert start_kinds(case, tmp_path).tolist() == [0, 1, 0]
    rows = [f"{n} {kind} {place} 5e-4" for n, kind, place in zip((1, 2, 3), (2, 1, 1), PLACES, strict=True)]
    case = dumped(dump(*rows, columns="id type x y z radius"), *SPECIES)
    assert start_kinds(case, tmp_path).tolist() == [1, 0, 0]


def test_types_that_the_case_has_not_are_told(dumped):
    rows = [f"{n} {kind} {place}" for n, kind, place in zip((1, 2, 3), (2, 3, 1), PLACES, strict=True)]
    with pytest.raises(CaseError, match=r"holds \[1, 1, 1\] particles of each kind and the case \[2, 1\]"):
        dumped(dump(*rows), *SPECIES)
    with pytest.raises(CaseError, match=r"particle 1 has 0.001 m, which several kinds of the case have"):
        dumped(dump(*(f"{row} 5e-4" for row in rows), columns="id type x y z radius"), *SPECIES)


def test_one_kind_may_have_any_type(dumped, tmp_path):
    rows = [f"{n} 2 {place}" for n, place in zip((1, 2, 3), PLACES, strict=True)]
    assert start_kinds(dumped(dump(*rows)), tmp_path).tolist() == [0, 0, 0]


def test_a_dump_in_other_units_is_noticed(dumped):
    rows = [f"{n} 1 0.5 0.{n} 1.1" for n in (2, 4, 6)]
    with pytest.raises(CaseError, match=r"coordinates are in m .they look like cm"):
        dumped(dump(*rows))


@pytest.mark.parametrize("rotation", [True, False])
def test_spin_of_a_dump_counts_where_the_case_has_rotation(dumped, tmp_path, rotation):
    rows = [f"{n} {place} 1 0 0 0 0 {n}" for n, place in zip((1, 2, 3), PLACES, strict=True)]
    case = dumped(
        dump(*rows, columns="id x y z vx vy vz omegax omegay omegaz"), f"particles.rotation={str(rotation).lower()}"
    )
    lay_out(str(tmp_path), tmp_path / "run", (), False, forced=True)
    motion = start_motion(case, tmp_path)
    assert motion[:, 0].tolist() == [1, 1, 1] and motion[:, 5].tolist() == ([1, 2, 3] if rotation else [0, 0, 0])
    assert (tmp_path / "run/start.dump").read_bytes() == (tmp_path / "start.dump").read_bytes()


def test_time_step_of_a_dump_is_an_option(dumped, tmp_path):
    one, other = dump("1 1 0.01 0.01 0.01"), dump("1 1 0.01 0.01 0.02")
    text = [line.replace("TIMESTEP\n0", "TIMESTEP\n7") for line in one] + other
    case = dumped(text, "particles.count=1", "particles.positions_step=7")
    assert start_positions(case, tmp_path)[0, 2] == 0.01
    assert start_positions(dumped(text, "particles.count=1"), tmp_path)[0, 2] == 0.02
    with pytest.raises(CaseError, match=r"particles.positions: start.dump has no time step 8; steps in it: 7, 0"):
        dumped(text, "particles.count=1", "particles.positions_step=8")


def test_a_seed_shifts_every_particle_a_little(bed, tmp_path):
    """By a thousandth of its own diameter at most, each seed otherwise, and the same one always alike."""
    rows = ["x,y,z,diameter", *give(ROWS, 2e-3, 1e-3, 1e-3)]
    plain = start_positions(bed(rows), tmp_path)
    one, again, other = (start_positions(bed(rows, f"particles.positions_seed={n}"), tmp_path) for n in (0, 0, 1))
    reach = np.abs(one - plain) / np.array([[2e-3], [1e-3], [1e-3]])
    assert (one == again).all() and (one != other).all()
    assert (reach <= LARGEST_SHIFT).all() and reach.max() > 0.5 * LARGEST_SHIFT


def test_a_shift_over_a_periodic_side_comes_in_on_the_other(bed, tmp_path):
    rows = ["x,y,z", "0.0,0.006,0.010", "0.02,0.009,0.010", "0.011,0.006,0.010"]
    sets = ("particles.positions_seed=3", 'domain.periodic=["x"]')
    shifted = start_positions(bed(rows, *sets), tmp_path)
    assert (shifted[:, 0] >= 0.0).all() and (shifted[:, 0] <= 0.02).all()
    across = np.minimum(shifted[:2, 0], 0.02 - shifted[:2, 0])
    assert (across <= 1e-3 * LARGEST_SHIFT).all() and (across > 0.0).all()


def test_a_lattice_has_a_seed_of_its_own(bed):
    text = CASE.replace('positions = "start.csv"\n', "positions_seed = 2\n") + "[start]\n"
    with pytest.raises(CaseError, match=r"particles.positions_seed: a seed is given and no positions; .*start.seed"):
        bed(["x,y,z", *ROWS], text=text)
    assert bed(["x,y,z", *ROWS], 'start.method="pour"', text=text).particles.positions_seed == 2
