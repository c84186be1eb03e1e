"""Dumps and data files as LIGGGHTS writes them, and such as nobody should."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.bed.start_file import StartFile, read_start
from fbcouple.errors import CaseError

BOX = "ITEM: BOX BOUNDS pp ff ff\n0 0.02\n0 0.02\n0 0.06\n"
ROWS = ("2 1 0.009 0.006 0.011", "1 1 0.005 0.006 0.010")


def frame(step: int, rows: tuple[str, ...] = ROWS, columns: str = "id type x y z", box: str = BOX) -> str:
    body = "".join(f"{row} \n" for row in rows)
    return f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n{box}ITEM: ATOMS {columns} \n{body}"


ATOMS = "1 1 1e-3 2500 0.005 0.006 0.010\n2 1 1e-3 2500 0.009 0.006 0.011\n"
DATA = f"written by hand\n\n2 atoms\n2 atom types\n\n0 0.02 xlo xhi\n0 0.02 ylo yhi\n0 0.06 zlo zhi\n\nAtoms\n\n{ATOMS}"
MOVING = "\nVelocities\n\n2 0 0 -2 0 0 7\n1 0 0 -1 0 0 0\n"


@pytest.fixture
def read(tmp_path: Path):
    def give(text: str | bytes, step: int | None = None, name: str = "bed.dump") -> StartFile:
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_start(tmp_path / name, step)

    return give


def test_last_step_is_taken_in_the_order_of_the_ids(read):
    start = read(frame(0, ()) + frame(100, ("1 2 0 0 0",)) + frame(200))
    assert start.positions.tolist() == [[0.005, 0.006, 0.010], [0.009, 0.006, 0.011]]
    assert start.types.tolist() == [1, 1] and start.velocities is start.diameters is None


def test_step_that_is_asked_for_is_taken(read):
    assert read(frame(100, ("1 2 0.001 0.002 0.003",)) + frame(200), 100).positions.tolist() == [[0.001, 0.002, 0.003]]


def test_columns_and_line_ends_of_other_programs_are_read(read):
    columns = "id type type x y z ix iy iz vx vy vz fx omegax omegay omegaz radius density"
    text = frame(5, ("7 1 1 .005 .006 .01 0 0 0 1 2 3 9 4 5 6 5e-4 2500",), columns)
    start = read("ITEM: UNITS\nsi\nITEM: TIME\n0.5\n" + text.replace("\n", "\r\n"), name="bed.liggghts")
    assert start.velocities.tolist() == [[1, 2, 3]] and start.spins.tolist() == [[4, 5, 6]]
    assert start.diameters.tolist() == [1e-3] and start.densities.tolist() == [2500]
    assert start.unread == ("ix", "iy", "iz", "fx")


@pytest.mark.parametrize(
    ("columns", "row"),
    [("xs ys zs", "0.25 0.3 0.5"), ("xu yu zu", "-0.015 0.006 0.03"), ("xsu ysu zsu", "2.25 0.3 0.5")],
)
def test_scaled_and_unwrapped_positions_are_brought_back(read, columns, row):
    """x is periodic over 20 mm; y and z are not."""
    (place,) = read(frame(0, (row,), columns)).positions
    assert place == pytest.approx([0.005, 0.006, 0.03], abs=1e-15)


def test_plain_positions_over_a_periodic_side_are_brought_back_and_others_kept(read):
    """LIGGGHTS brings particles in only where it makes its neighbour lists anew."""
    rows = ("-1e-7 0.006 0.03", "0.0203 -1e-7 0.03", "0.013 0.006 0.06")
    places = read(frame(0, rows, "x y z")).positions
    expected = [[0.0199999, 0.006, 0.03], [0.0003, -1e-7, 0.03], [0.013, 0.006, 0.06]]
    assert places == pytest.approx(np.array(expected), abs=1e-15) and places[2].tolist() == expected[2]


def test_data_file_is_read(read):
    start = read(DATA + MOVING, name="bed.data")
    assert start.positions.tolist() == [[0.005, 0.006, 0.010], [0.009, 0.006, 0.011]]
    assert start.velocities[:, 2].tolist() == [-1, -2] and start.spins[:, 2].tolist() == [0, 7]
    assert start.diameters.tolist() == [1e-3] * 2 and start.densities.tolist() == [2500] * 2


def test_data_file_with_images_and_a_style_is_read(read):
    text = (
        DATA.replace("Atoms\n", "Atoms # sphere\n")
        .replace("0.010\n", "0.010 0 0 0\n")
        .replace("0.011\n", "0.011 0 0 1\n")
    )
    assert len(read(text, name="bed.data").positions) == 2


CUT = frame(3)[: frame(3).rindex("1 1 0.005")]
FAULTS = {
    "fewer particles": (CUT, "ends after 1 of the 2 particles that it announces"),
    "more particles": (frame(3).replace("\n2\nITEM: BOX", "\n1\nITEM: BOX"), "line 11 has `1 1 0.005"),
    "cut line": (frame(3)[:-14], "line 11, `1 1 0.005`, has 3 columns, 5 are wanted"),
    "nan": (frame(3).replace("0.006 0.011", "nan 0.011"), "line 10 has `nan` for y; give a finite number"),
    "no number": (frame(3).replace("0.006 0.011", "0_6 0.011"), "line 10 has `0_6` for y"),
    "letters": (frame(3).replace("0.006 0.011", "six 0.011"), "line 10 has `six` for y"),
    "minus count": (frame(3).replace("\n2\nITEM: BOX", "\n-2\nITEM: BOX"), "line 4 has `-2` for the number of atoms"),
    "huge count": (frame(3).replace("\n2\nITEM: BOX", f"\n{10**15}\nITEM: BOX"), "at most 1e.09 are allowed"),
    "long count": (frame(3).replace("\n2\nITEM: BOX", f"\n{'9' * 90}\nITEM: BOX"), "for the number of atoms; give"),
    "no count": ("ITEM: TIMESTEP\n3\nITEM: ATOMS id x y z\n1 0 0 0\n", "ATOMS and no number of them before it"),
    "one id twice": (frame(3, ("1 1 0 0 0", "1 1 .1 0 0")), "the particle of id 1 is there twice"),
    "no positions": (frame(3, ("1 5",), "id q"), "names the columns id q, and no positions"),
    "sheared box": (frame(3).replace("BOUNDS pp", "BOUNDS xy xz yz pp"), "line 5 has a box that is not upright"),
    "box upside down": (frame(3, ("1 .5 .5 .5",), "id xs ys zs", BOX.replace("0 0.06", "1 0")), "there is no box"),
    "other units": ("ITEM: UNITS\ncgs\n" + frame(3), "line 2 has the units `cgs`; values in SI units"),
    "contacts": ("ITEM: TIMESTEP\n3\nITEM: ENTRIES c_1\n1 2\n", "this is a dump of contacts"),
    "half a velocity": (frame(3, ("0 0 0 1 2",), "x y z vx vy"), "has not all of the columns vx, vy and vz"),
    "half a type": (frame(3, ("1 1.5 0 0 0",)), "the type of particle 1 is no whole number from 1"),
    "no particles": (frame(3, ()), "has no particles at its last time step; steps in it: 3"),
    "long line": ("ITEM: TIMESTEP\n" + "1" * 200_000, "line 2 is longer than 100000 letters"),
    "no text": (frame(3).encode() + b"\xff\xfe", "is not UTF-8 text"),
    "compressed": (b"\x1f\x8b" + bytes(50), "is compressed .gzip."),
    "restart": (bytes(4) + b"Z\0\0\0Version LIGGGHTS-PUBLIC 3.8.0" + bytes(9), "binary restart file, which only"),
}
DATA_FAULTS = {
    "fewer particles": (DATA.replace("2 atoms", "3 atoms"), "ends after 2 of the 3 rows of Atoms"),
    "no count": (DATA.replace("2 atoms", "# 2 atoms") + "\n2 atoms\n", "Atoms and no number of atoms before it"),
    "points": (DATA.replace("1e-3 2500 ", ""), "has 5 columns, 7 are wanted .*atom_style sphere or granular"),
    "other style": (DATA.replace("Atoms\n", "Atoms # bond\n"), "line 10 has atoms of the style bond"),
    "bonds": (DATA + "\nBonds\n\n1 1 1 2\n", "has the section Bonds"),
    "infinite": (DATA.replace("0.011", "inf"), "line 13 has `inf` for z"),
    "other ids": (DATA + MOVING.replace("\n2 0", "\n5 0"), "Velocities are not of the same ids as Atoms"),
    "no atoms": (DATA.partition("Atoms")[0], "has no section Atoms"),
    "no diameter": (DATA.replace("1 1 1e-3", "1 1 0"), "the diameter of particle 1 is 0, above 0 is allowed"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_dump_that_cannot_serve_is_told(read, name):
    text, told = FAULTS[name]
    with pytest.raises(CaseError, match=rf"^bed.dump.*{told}") as caught:
        read(text)
    assert len(str(caught.value)) < 400 and "\n" not in str(caught.value)


@pytest.mark.parametrize("name", DATA_FAULTS)
def test_data_file_that_cannot_serve_is_told(read, name):
    text, told = DATA_FAULTS[name]
    with pytest.raises(CaseError, match=rf"^bed.data.*{told}"):
        read(text, name="bed.data")


def test_step_that_is_not_there_is_told_with_those_that_are(read):
    with pytest.raises(CaseError, match=r"has no time step 7; steps in it: ..., 2, 3, 4, 5, 6\."):
        read("".join(map(frame, range(1, 7))), 7)
    with pytest.raises(CaseError, match="is no dump and has no time steps"):
        read(DATA, 7, name="bed.data")


DECK = """
units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
region box block 0 0.02 0 0.02 0 0.06 units box
create_box 1 box
create_atoms 1 single 0.005 0.006 0.01
create_atoms 1 single 0.009 0.006 0.011
set group all diameter 0.001 density 2500 vx 0.1 omegaz 3
fix a all property/global youngsModulus peratomtype 5e6
fix b all property/global poissonsRatio peratomtype 0.45
fix c all property/global coefficientRestitution peratomtypepair 1 0.9
pair_style gran model hertz
pair_coeff * *
fix d all nve/sphere
timestep 1e-5
dump d all custom 1 bed.dump id type x y z vx vy vz omegax omegay omegaz radius density
run 0
write_data bed.data
write_restart bed.restart
"""


def test_what_stock_liggghts_writes_is_read(tmp_path):
    program = shutil.which("liggghts")
    assert program, "LIGGGHTS is installed with its library"
    (tmp_path / "in.bed").write_text(DECK)
    subprocess.run([program, "-in", "in.bed"], cwd=tmp_path, check=True, capture_output=True)
    for name in ("bed.dump", "bed.data"):
        start = read_start(tmp_path / name)
        assert start.positions == pytest.approx(np.array([[0.005, 0.006, 0.01], [0.009, 0.006, 0.011]]))
        assert start.velocities[:, 0].tolist() == [0.1, 0.1] and start.spins[:, 2].tolist() == [3, 3]
        assert start.diameters == pytest.approx([1e-3] * 2) and start.densities == pytest.approx([2500] * 2)
    with pytest.raises(CaseError, match=r"bed.restart is a binary restart file"):
        read_start(tmp_path / "bed.restart")
