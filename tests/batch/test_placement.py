"""Job scripts of a site: nodes, launcher, header, prelude, container, and the file that has them by name."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from fbcouple.batch.schedulers import SCHEDULERS
from fbcouple.case.cost.coefficients import SHIPPED, save_coefficients
from fbcouple.case.load import load_case, write_case
from fbcouple.cli.main import cli
from fbcouple.machine.environment import find_package

GOLDEN = Path(__file__).parent / "scripts"
EVERYTHING = (
    *("--nodes", "2", "--tasks-per-node", "4", "-n", "8", "--memory", "6000", "--launcher", "srun", "--bind", "core"),
    *("--module", "openmpi/4.1", "--queue", "long", "--account", "beds", "--mail", "me@example.org"),
    *("--notice", "600", "--chain", "3"),
)
HEADER = {"slurm": "--exclusive", "pbs": "-l filesystems=home", "lsf": "-x"}
PRELUDE = "source /opt/openfoam2512/etc/bashrc"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run folder, where the costs of a step are those that are shipped."""
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "cache"))
    (tmp_path / "bed").mkdir()
    write_case(load_case("patil/c2"), tmp_path / "bed/case.toml")
    (tmp_path / "bed/manifest.json").touch()
    return tmp_path / "bed"


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (tmp_path / "fbcouple").mkdir()
    return tmp_path / "fbcouple/site.toml"


def batch(run: Path, *words: str, scheduler: str = "slurm") -> Result:
    return CliRunner().invoke(cli, ["batch", str(run), "--scheduler", scheduler, "--time", "12:00:00", *words])


def read(run: Path, scheduler: str = "slurm") -> str:
    return (run / f"batch/{scheduler}.sh").read_text()


def start(job: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the job script with the programs of `folder` first on the PATH."""
    environment = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"}
    return subprocess.run([job], env=environment, capture_output=True, text=True, check=False, timeout=60)


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_scripts_are_as_they_were_read(run: Path, scheduler: str) -> None:
    """The whole text with every option; where runs, interpreter and package lie has a word in its place."""
    own = ["--qos", "low", "--constraint", "milan|rome"] if scheduler == "slurm" else []
    words = [*EVERYTHING, *own, "--header", HEADER[scheduler], "--prelude", PRELUDE]
    done = batch(run, *words, scheduler=scheduler)
    assert done.exit_code == 0, done.stderr
    text = read(run, scheduler).replace(str(run), "/data/bed").replace(sys.executable, "/opt/venv/bin/python")
    package = "".join(f"export PYTHONPATH={folder}" + '"${PYTHONPATH:+:$PYTHONPATH}"\n' for folder in find_package())
    assert text.replace(package, "") == (GOLDEN / f"{scheduler}.sh").read_text()
    assert subprocess.run(["bash", "-n", run / f"batch/{scheduler}.sh"], check=False).returncode == 0


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_what_is_not_asked_for_leaves_no_trace(run: Path, scheduler: str) -> None:
    assert batch(run, "-n", "8", "--chain", "3", scheduler=scheduler).exit_code == 0
    text = read(run, scheduler)
    for absent in ("FBCOUPLE_LAUNCHER", "stop(", "eval", "apptainer", "scatter", "ptile", "per-node", "qos", "mail"):
        assert absent not in text


def test_a_prelude_that_fails_starts_no_run(run: Path, tmp_path: Path) -> None:
    """With the exit code of a machine that lacks something; the first that fails is named."""
    assert batch(run, "--prelude", "export SITE=here", "--prelude", '[ "$SITE" = there ]').exit_code == 0
    done = start(run / "batch/slurm.sh", tmp_path)
    assert done.returncode == 3 and '[ "$SITE" = there ]\' failed with exit code 1' in done.stderr
    assert not (run / "batch/state").exists()


def test_a_prelude_reaches_the_run_and_names_the_launcher(run: Path, tmp_path: Path) -> None:
    program = tmp_path / "python"
    program.write_text('#!/bin/bash\necho "$SITE $FBCOUPLE_LAUNCHER $FBCOUPLE_BIND $*"\n')
    program.chmod(0o755)
    assert batch(run, "--prelude", "export SITE='my site'", "--launcher", "srun", "-n", "4").exit_code == 0
    job = run / "batch/slurm.sh"
    job.write_text(job.read_text().replace(sys.executable, str(program)))
    assert start(job, tmp_path).stdout == f"my site srun none -m fbcouple.cli.main run {run} -n 4 --resume\n"


def test_a_container_runs_its_own_fbcouple(run: Path, tmp_path: Path) -> None:
    (tmp_path / "apptainer").write_text('#!/bin/bash\necho "$*"\n')
    (tmp_path / "apptainer").chmod(0o755)
    assert batch(run, "--container", "/images/fbcouple.sif", "-n", "4").exit_code == 0
    wanted = f"exec --bind {run} /images/fbcouple.sif fbcouple run {run} -n 4 --resume\n"
    assert start(run / "batch/slurm.sh", tmp_path).stdout == wanted


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--nodes", "3", "-n", "8"], "--nodes: 3 on each of 3 nodes are 9 places for 8 ranks"),
        (["--tasks-per-node", "4", "-n", "8"], "--nodes: 4 on each of 1 nodes are 4 places for 8 ranks"),
        (["--launcher", "aprun", "--bind", "socket"], "--bind: aprun has no socket, allowed: none, core, numa"),
        (["--qos", "a b"], '--qos: "a b" is given'),
        (["--constraint", "x$(touch y)"], "--constraint: "),
        (["--mail", "a@b\n#SBATCH --x"], "--mail: "),
        (["--header", "--x\nrm -rf y"], "--header: "),
        (["--prelude", "a\nb"], "--prelude: "),
        (["--container", "fbcouple.sif"], "--container: "),
        (["--container", "/a.sif", "--nodes", "2", "-n", "2"], "--container: the mpirun of the image"),
        (["--container", "/a.sif", "--launcher", "srun"], "--container: the mpirun of the image"),
    ],
)
def test_what_cannot_be_met_is_refused(run: Path, words: list[str], text: str) -> None:
    done = batch(run, *words)
    assert done.exit_code == 1 and text in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (run / "batch").exists()


@pytest.mark.parametrize(("scheduler", "option"), [("pbs", "--qos"), ("pbs", "--constraint"), ("lsf", "--qos")])
def test_a_line_that_a_batch_system_has_not_is_no_silent_loss(run: Path, scheduler: str, option: str) -> None:
    done = batch(run, option, "low", "--chain", "2", scheduler=scheduler)
    assert done.exit_code == 1 and f"{option}: {scheduler} has no line for it" in done.stderr


SITE = """
[box]
scheduler = "slurm"
time = "06:00:00"
ranks = 4
queue = "short"
prelude = ["true", "export A=1"]
[other]
scheduler = "pbs"
"""


def call(*words: object) -> Result:
    return CliRunner().invoke(cli, ["batch", *map(str, words)])


def test_a_site_is_taken_by_name_and_the_command_line_wins(run: Path, site: Path) -> None:
    site.write_text(SITE)
    assert call(run, "--site", "box", "--queue", "long").exit_code == 0
    text = read(run)
    assert "--time=06:00:00" in text and "--ntasks=4" in text and "--partition=long" in text
    assert "eval true" in text and "eval 'export A=1'" in text


def test_of_a_site_file_that_is_not_named_nothing_is_taken(run: Path, site: Path) -> None:
    site.write_text(SITE)
    assert call(run).exit_code == 2
    assert batch(run).exit_code == 0 and "partition" not in read(run) and "--ntasks=4\n" not in read(run)


@pytest.mark.parametrize(
    ("words", "ranks", "is_told"),
    [
        ((), 32, True),
        (("--nodes", "3"), 33, True),
        (("--nodes", "2", "--tasks-per-node", "12"), 24, False),
        (("-n", "5"), 5, False),
    ],
)
def test_ranks_that_nobody_names_are_proposed(run: Path, words: tuple[str, ...], ranks: int, is_told: bool) -> None:
    """23 100 cells, 500 a rank at least: 46 have work, 32 by doubling, 33 where each of three nodes has as many."""
    done = batch(run, *words)
    assert done.exit_code == 0, done.stderr
    assert f"--ntasks={ranks}\n" in read(run) and f'run "$run" -n {ranks} ' in read(run)
    told = f"{run}: 32 ranks are proposed (16 to 64 within what is unsure), "
    assert (told in done.output and "64 would have too little work each" in done.output) is is_told


def test_ranks_of_a_set_are_those_of_its_dearest_run(run: Path) -> None:
    (run.parent / "small").mkdir()
    write_case(load_case("patil/demo"), run.parent / "small/case.toml")
    (run.parent / "small/manifest.json").touch()
    done = batch(run.parent)
    assert done.exit_code == 0, done.stderr
    assert f"{run}: 32 ranks are proposed" in done.output and "--ntasks=32\n" in read(run.parent)


def test_without_a_prediction_the_ranks_have_to_be_named(run: Path) -> None:
    save_coefficients(SHIPPED, {}).write_text("{}")
    done = batch(run)
    assert done.exit_code == 1 and "bench calibrate" in done.stderr
    assert batch(run, "-n", "4").exit_code == 0


@pytest.mark.parametrize(
    ("content", "name", "text"),
    [
        (None, "box", "there is no "),
        ("[box]\n", "bix", "has no [bix], only box"),
        ("time = 1\n", "box", '"time" stands outside of a table'),
        ("[box]\ntrust = true\n", "box", '"trust" is no option'),
        ("[box]\nqueu = 'x'\n", "box", "did you mean `queue`"),
        ("[box]\nprelude = 'x'\n", "box", "a list of texts is allowed"),
        ("[box]\nqueue = ['x']\n", "box", "a text or a whole number is allowed"),
        ("[box\n", "box", "cannot be read"),
    ],
)
def test_a_site_file_that_is_wrong_is_told(run: Path, site: Path, content: str | None, name: str, text: str) -> None:
    if content is not None:
        site.write_text(content)
    done = call(run, "--scheduler", "slurm", "--time", "01:00:00", "--site", name)
    assert done.exit_code == 1 and text in done.stderr and not (run / "batch").exists(), done.output


def test_values_of_a_site_are_judged_as_those_of_the_command_line(run: Path, site: Path) -> None:
    site.write_text('[box]\nscheduler = "slurm"\ntime = "soon"\n')
    assert call(run, "--site", "box").exit_code == 2
    site.write_text('[box]\nscheduler = "slurm"\ntime = "01:00:00"\nqueue = "a b"\n')
    assert call(run, "--site", "box").exit_code == 1


def test_site_file_of_an_editor_that_marks_utf_8(run, site):
    site.write_bytes(b'\xef\xbb\xbf[big]\nscheduler = "slurm"\nqueue = "long"\n')
    done = CliRunner().invoke(cli, ["batch", str(run), "--site", "big", "--time", "12:00:00"])
    assert done.exit_code == 0, done.output
    assert "long" in read(run)
