"""A restart file of stock LIGGGHTS as the start of a case: read only where somebody trusts it, and then whole."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from fbcouple.case.bed.positions import start_kinds, start_motion, start_positions
from fbcouple.cli.main import cli
from fbcouple.decks import restart_file
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.run_folder.manifest import hash_file

DECK = """
atom_style granular
atom_modify map array
boundary p f f
newton off
communicate single vel yes
units si
region reg block 0 0.01 0 0.006 0 0.02 units box
create_box 2 reg
neighbor 0.0005 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 5e6 5e6
fix m2 all property/global poissonsRatio peratomtype 0.45 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 0.9
fix m4 all property/global coefficientFriction peratomtypepair 2 0.05 0.05 0.05 0.05
pair_style gran model hertz tangential history
pair_coeff * *
timestep 1e-5
fix w1 all wall/gran model hertz tangential history primitive type 1 zplane 0.0
fix g all gravity 9.81 vector 0 0 -1
fix i all nve/sphere
create_atoms 1 single .005 .003 .010 units box
create_atoms 2 single .0078 .003 .011 units box
create_atoms 1 single .0052 .003 .0109 units box
set type 1 diameter 1e-3 density 2500
set type 2 diameter 0.8e-3 density 1500
set group all vx 1.0
set atom 2 omegaz 4
run 100
write_restart bed.restart
write_data bed.data
"""
CASE = """
title = "from a restart file"
end_time = 0.004
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 3
mixture = [[0.8e-3, 1500.0, 0.3]]
fractions = "number"
rotation = true
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.3
wall_friction = 0.3
stiffness = 100.0
[start]
restart = "bed.restart"
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 2.0
[exchange]
filter_passes = 1
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> Path:
    """Folder of a restart file, and of the data file of the same moment, that the stock program wrote."""
    folder = tmp_path_factory.mktemp("stock")
    (folder / "in.bed").write_text(DECK)
    program = shutil.which("liggghts")
    assert program, "LIGGGHTS is installed with its library"
    subprocess.run([program, "-in", "in.bed"], cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture
def bed(written, tmp_path):
    """Set the case up beside that file, trusted or not, with settings; returns the run folder and its case."""
    (tmp_path / "case.toml").write_text(CASE)
    for name in ("bed.restart", "bed.data"):
        shutil.copyfile(written / name, tmp_path / name)

    def set_up(*sets: str, trusted: bool = True, name: str = "run"):
        ((run, case),) = lay_out(str(tmp_path), tmp_path / name, sets, trusted, True).items()
        return run, case

    return set_up


def test_trusted_file_gives_what_the_data_file_gives(bed, tmp_path):
    """To the last digit, and as the case numbers its kinds."""
    run, case = bed()
    (tmp_path / "case.toml").write_text(CASE.replace('[start]\nrestart = "bed.restart"\n', ""))
    other = bed("particles.positions=bed.data", name="other")
    for read in (start_positions, start_motion, start_kinds):
        assert np.array_equal(read(case, run), read(*reversed(other)))
    assert start_kinds(case, run).tolist() == [0, 1, 0] and start_motion(case, run)[1, 5] == 4.0
    origin = json.loads((run / "manifest.json").read_text())["start"]
    assert hash_file(tmp_path / "bed.restart") in origin and "which was trusted" in origin
    assert case.start is None and not (run / "bed.restart").exists(), "the run folder holds what was read, in words"


@pytest.mark.parametrize("command", ["setup", "check"])
def test_file_that_nobody_trusts_is_not_read(bed, tmp_path, monkeypatch, command):
    monkeypatch.setattr(restart_file, "read_foreign_restart", lambda path: pytest.fail("it is not trusted"))
    output = ["-o", str(tmp_path / "run"), "--force"] if command == "setup" else []
    result = CliRunner().invoke(cli, [command, str(tmp_path), *output])
    if command == "setup":
        assert result.exit_code == 1 and not (tmp_path / "run").exists()
        assert (
            "start.restart: bed.restart is a restart file, which LIGGGHTS reads and nothing can check" in result.stderr
        )
        assert "--trust" in result.stderr and "particles.positions" in result.stderr
    else:
        assert "start: the restart file is read by `setup --trust`, which checks what comes out" in result.stdout


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        (("particles.count=4",), r"start.restart: \w+.restart holds 3 particles and the case 4"),
        (
            ("particles.mixture=[]",),
            r"start.restart: particle 2 has 0.0008 m and 1500 kg m-3, which no kind of the case",
        ),
        (("start.restart=none.restart",), r"start.restart: none.restart cannot be read: No such file"),
        (
            ("start.restart=bed.data",),
            r'start.restart: "bed.data" is given, the bare name of a .restart file is allowed',
        ),
        (("start.method=pour",), r'start.method: "pour" is given and start.restart too'),
        (("domain.size=[0.005, 0.006, 0.02]",), r"start.restart: bed.restart: \d particles are not inside the box"),
    ],
)
def test_what_does_not_fit_is_told_and_nothing_is_written(bed, tmp_path, sets, told):
    with pytest.raises(CaseError, match=told):
        bed(*sets)
    assert not (tmp_path / "run").exists()


def test_one_file_gives_a_restart_file_or_a_run_and_a_setting_takes_the_place_of_the_other(bed, tmp_path):
    (tmp_path / "case.toml").write_text(CASE.replace("[start]\n", '[start]\nrun = "elsewhere"\n'))
    with pytest.raises(CaseError, match=r'start.restart: "bed.restart" is given and start.run too'):
        bed()
    (tmp_path / "case.toml").write_text(CASE)
    with pytest.raises(CaseError, match=r"start.run: .*elsewhere"):
        bed("start.run=elsewhere")


def test_file_that_is_cut_short_is_told_with_the_words_of_liggghts(bed, tmp_path):
    path = tmp_path / "bed.restart"
    path.write_bytes(path.read_bytes()[:600])
    with pytest.raises(CaseError, match=r"start.restart: bed.restart cannot be read: .*ERROR.*; give one that this"):
        bed()


def test_option_names_itself_where_a_restart_file_is_given_as_positions(bed, tmp_path):
    (tmp_path / "case.toml").write_text(CASE.replace('[start]\nrestart = "bed.restart"\n', ""))
    with pytest.raises(CaseError, match=re.escape("give it as start.restart and say --trust")):
        bed("particles.positions=bed.restart")
