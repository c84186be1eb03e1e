"""`fbcouple run RUN --replicas N`: real runs of a few beads without gas."""

from __future__ import annotations

import json
import tomllib

import pytest
from click.testing import CliRunner

import fbcouple
from fbcouple.batch.state import look_at
from fbcouple.case.load import load_case
from fbcouple.case.seeds import change_seeds
from fbcouple.cli.main import cli
from fbcouple.decks import replicas as making
from fbcouple.decks.replicas import make_replicas
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.paths import list_replicas

BED = """
title = "beads that fall"
end_time = 0.01
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 60
[contact]
stiffness = 100.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[output]
record_every = 1e-3
"""


@pytest.fixture
def bed(tmp_path):
    """Set up the case with settings as a run folder."""

    def lay(*sets, text=BED):
        (tmp_path / "case.toml").write_text(text, encoding="utf-8")
        lay_out(str(tmp_path), tmp_path / "run", sets, False, forced=True)
        return tmp_path / "run"

    return lay


def call(*arguments):
    return CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False)


def read_particles(run):
    return (run / "DEM/particles.data").read_text(encoding="utf-8")


def test_the_run_becomes_the_first_of_its_replicas(bed):
    run = bed("start.seed=7")
    first = read_particles(run)
    (run / "notes.txt").write_text("mine", encoding="utf-8")
    done = call("run", run, "--replicas", 3, "-j", 2)
    assert done.exit_code == 0 and "is a folder of 3 replicas now, replica-1 to replica-3" in done.output
    found = list_replicas(run)
    assert [path.name for path in found] == ["replica-1", "replica-2", "replica-3"]
    assert [load_case(str(path)).start.seed for path in found] == [7, 8, 9]
    assert [look_at(path).state for path in found] == ["complete"] * 3
    assert read_particles(found[0]) == first and len({read_particles(path) for path in found}) == 3
    assert sorted(path.name for path in run.iterdir()) == [path.name for path in found]
    assert (found[0] / "notes.txt").read_text(encoding="utf-8") == "mine"
    rows = json.loads(call("status", run, "--json").output)
    assert [row["state"] for row in rows] == ["complete"] * 3


def test_the_same_command_goes_on_and_another_number_is_refused(bed):
    run = bed()
    assert call("run", run, "--replicas", 2, "--wall-limit", 1).exit_code == 75
    again = call("run", run, "--replicas", 2, "-j", 2)
    assert again.exit_code == 0 and "all 2 runs are complete" in again.output
    other = call("run", run, "--replicas", 4)
    assert other.exit_code == 1 and "holds 2 replicas and 4 are asked for; their number stays" in other.output
    assert call("run", run, "-j", 2).exit_code == 0


def test_a_run_that_was_made_is_kept(bed):
    run = bed()
    assert call("run", run).exit_code == 0
    results = (run / "results.nc").read_bytes()
    done = call("run", run, "--replicas", 2)
    assert done.exit_code == 0 and (run / "replica-1/results.nc").read_bytes() == results


@pytest.mark.parametrize("moved", [0, 1, 3])
def test_making_that_is_cut_short_is_done_again(bed, monkeypatch, moved):
    """Between any two of its renames: the run is there, whole, after the same call."""
    run = bed()
    before = {path.relative_to(run) for path in run.rglob("*") if path.name != "lock"}
    replace, calls = making.os.replace, []

    def cut(source, target):
        calls.append(source)
        if len(calls) > moved:
            raise KeyboardInterrupt
        replace(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(making, "os", type("os", (), {"replace": staticmethod(cut)}))
        with pytest.raises(KeyboardInterrupt):
            make_replicas(run, 2)
    first, _ = make_replicas(run, 2)
    assert {path.relative_to(first) for path in first.rglob("*")} == before
    assert list_replicas(run) == [run / "replica-1", run / "replica-2"]


def test_what_no_seed_changes_is_refused(bed):
    run = bed("start.jitter=0")
    done = call("run", run, "--replicas", 2)
    assert done.exit_code == 1 and "no seed changes it: its particles start on a lattice without jitter" in done.output
    assert (run / "case.toml").is_file() and not list(run.glob("replica-*"))
    gas = BED[: BED.index("[particles]")] + "[gas]\ndensity = 1.2\nviscosity = 1.8e-5\ninlet_velocity = 0.1\n"
    with pytest.raises(CaseError, match="it has no particles"):
        change_seeds(load_case(str(bed(text=gas).parent)), 1)


def test_every_seed_of_a_case_is_another(bed, tmp_path):
    rows = "x,y,z\n" + "".join(f"0.00{n},0.003,0.005\n" for n in range(1, 8))
    (tmp_path / "start.csv").write_text(rows, encoding="utf-8")
    text = BED.replace("[start]", "").replace("count = 60", 'count = 7\npositions = "start.csv"')
    text += "[[particles.feeds]]\nlow = [0.0, 0.0, 0.015]\nhigh = [0.01, 0.006, 0.02]\nrate = 100.0\nseed = 5\n"
    run = bed(text=text)
    one, two, three = make_replicas(run, 3)
    cases = [load_case(str(path)) for path in (one, two, three)]
    assert [case.particles.positions_seed for case in cases] == [None, 1, 2]
    assert [case.particles.feeds[0].seed for case in cases] == [5, 6, 7]
    assert (two / "start.csv").read_text(encoding="utf-8") == rows
    assert read_particles(two) != read_particles(three) != read_particles(one)
    assert "positions_seed" not in tomllib.loads((one / "case.toml").read_text(encoding="utf-8"))["particles"]


def test_options_of_one_run_are_refused_before_anything_is_made(bed):
    run = bed()
    assert call("run", run, "--replicas", 2, "--until", 0.1).exit_code == 2
    assert call("run", run, "--replicas", 1).exit_code == 2
    assert (run / "case.toml").is_file()


def test_a_batch_script_of_replicas_is_an_array(bed):
    run = bed()
    done = call("batch", run, "--replicas", 3, "--scheduler", "slurm", "--time", "01:00:00")
    assert done.exit_code == 0
    text = (run / "batch/slurm.sh").read_text(encoding="utf-8")
    assert "#SBATCH --array=0-2" in text
    assert [f"    {path}" in text for path in list_replicas(run)] == [True] * 3
    again = call("batch", run, "--replicas", 3, "--scheduler", "pbs", "--time", "01:00:00", "--chain", 2)
    assert again.exit_code == 0 and "#PBS -J 0-2" in (run / "batch/pbs.sh").read_text(encoding="utf-8")


def test_replicas_from_python(bed):
    found = fbcouple.start_replicas(fbcouple.Run(bed()), 2, jobs=2)
    assert [run.path.name for run in found] == ["replica-1", "replica-2"]
    assert [run.status().state for run in found] == ["complete"] * 2
    states = fbcouple.run_set(found[0].path.parent, fresh=True, wall_limit=1.0)
    assert [status.state for status in states] == ["complete"] * 2
    with pytest.raises(CaseError, match="holds 2 replicas and 3 are asked for"):
        fbcouple.start_replicas(found[0].path.parent, 3)
