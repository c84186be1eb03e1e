"""What a child process is given: nothing of the current folder, nothing of an outer MPI job, always this package."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import fbcouple
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.environment import HUGE_PAGES, child_environment, find_package, hand_down, mpi_environment
from fbcouple.machine.launchers import mpi_command
from fbcouple.study.side_by_side import run_side_by_side

ROOT = Path(__file__).resolve().parents[2]
PLANTED = ("argparse", "json", "mpi4py", "multiprocessing", "numba", "numpy", "postproc", "pyvista", "fbcouple")
"""Modules of the standard library, of others and of our own that a folder may hold under the same name."""
SHOW = "import json, os, sys, fbcouple; print(json.dumps([fbcouple.__file__, sys.flags.safe_path, dict(os.environ)]))"


@pytest.fixture
def hostile(tmp_path, monkeypatch) -> Path:
    """The current folder, full of modules that leave a trace when they are imported."""
    for name in PLANTED:
        trace = f"open({str(tmp_path / name)!r} + '.ran', 'w').close()"
        (tmp_path / f"{name}.py").write_text(f"{trace}\nraise SystemExit(9)\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def find_traces(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*.ran"))


def ask_child(*words: str) -> list:
    done = subprocess.run([*words], env=mpi_environment(), capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("given", ["", ":/opt/lib", "/opt/lib:", "/opt/lib::/usr/lib", ".:/opt/lib", "lib:/opt/lib:~"])
@pytest.mark.parametrize("name", ["PATH", "LD_LIBRARY_PATH", "PYTHONPATH", "CPATH", "LIBRARY_PATH"])
def test_entries_that_mean_the_current_folder_are_dropped(name, given):
    found = child_environment({name: given}).get(name)
    kept = [entry for entry in given.split(":") if entry.startswith("/")]
    kept = find_package() * (name == "PYTHONPATH") + kept
    assert found == (":".join(kept) or None)


def test_the_loader_takes_semicolons_too():
    assert child_environment({"LD_LIBRARY_PATH": "/a;b;/c:;"})["LD_LIBRARY_PATH"] == "/a:/c"


def test_folders_of_compiled_code_do_not_move_with_the_child(monkeypatch, tmp_path):
    """A rank works in the run folder: a cache that is named from there would be the run folder's."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FBCOUPLE_CACHE", "cache")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "compiled")
    told = child_environment()
    assert told["FBCOUPLE_CACHE"] == str(tmp_path / "cache") and told["NUMBA_CACHE_DIR"] == str(tmp_path / "compiled")


def test_children_and_grandchildren_import_this_package(hostile, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", f":.:{hostile.name}")
    grandchild = f"import subprocess, sys; print(subprocess.check_output([sys.executable, '-c', {SHOW!r}], text=True))"
    for program in (SHOW, grandchild):
        file, safe, told = ask_child(sys.executable, "-c", program)
        assert file == fbcouple.__file__ and safe is True
        assert all(entry.startswith("/") for entry in told["PYTHONPATH"].split(":"))
    assert find_traces(hostile) == []


def test_ranks_import_nothing_of_the_current_folder(hostile):
    command = mpi_command(1, [sys.executable, "-m", "fbcouple.simulation.worker", "--help"])
    done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0 and "--deadline" in done.stdout, done.stderr
    assert find_traces(hostile) == []


def test_processes_of_a_pool_import_nothing_of_the_current_folder(hostile):
    before = dict(os.environ)
    safe, _ = run_side_by_side(os.getenv, [("PYTHONSAFEPATH",), ("PYTHONPATH",)], 2, Requests())
    assert safe == "1" and dict(os.environ) == before
    assert find_traces(hostile) == []


@pytest.mark.parametrize("words", [["doctor"], ["verify", "filter"], ["cases"]])
def test_commands_import_nothing_of_the_current_folder(hostile, words):
    command = [sys.executable, "-P", "-m", "fbcouple.cli.main", *words]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and find_traces(hostile) == [], done.stdout + done.stderr


def test_own_environment_comes_back_after_it_was_handed_down(monkeypatch):
    monkeypatch.setenv("PATH", f".:{os.environ['PATH']}")
    before = dict(os.environ)
    with hand_down():
        assert os.environ["PYTHONSAFEPATH"] == "1" and not os.environ["PATH"].startswith(".")
    assert dict(os.environ) == before


def test_an_outer_mpi_job_does_not_reach_the_inner_one(monkeypatch):
    """Its launcher tells its ranks who they are; a launcher among them would refuse to start."""
    settings = {"OMPI_MCA_btl": "self,vader", "OMPI_ALLOW_RUN_AS_ROOT": "1", "PMIX_MCA_gds": "hash"}
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    show = "import json, os; print(json.dumps(dict(os.environ)))"
    outer = ask_child(*mpi_command(1, [sys.executable, "-c", show]))
    assert "OMPI_COMM_WORLD_RANK" in outer and "PMIX_RANK" in outer
    inner = child_environment(outer)
    left = {name for name in inner if name.startswith(("OMPI_", "PMI", "PRTE_"))}
    ours = {
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
        "OMPI_MCA_mpi_yield_when_idle",
        "OMPI_MCA_orte_tmpdir_base",
        "PMIX_MCA_mca_base_component_show_load_errors",
    }
    assert left - set(settings) <= ours
    assert {name: inner[name] for name in settings} == settings


def test_ranks_that_wait_let_others_have_their_core_unless_the_user_says_otherwise(monkeypatch):
    name = "OMPI_MCA_mpi_yield_when_idle"
    monkeypatch.delenv(name, raising=False)
    assert mpi_environment()[name] == "1"
    monkeypatch.setenv(name, "0")
    assert mpi_environment()[name] == "0"


def test_ranks_have_their_arrays_in_huge_pages_where_the_system_gives_them(monkeypatch):
    monkeypatch.delenv("GLIBC_TUNABLES", raising=False)
    read = "[line for line in open('/proc/self/smaps_rollup') if 'AnonHugePages' in line][0].split()[1]"
    program = f"arrays = [bytearray(b'x' * 700_000) for _ in range(100)]; print({read})"
    switch = Path("/sys/kernel/mm/transparent_hugepage/enabled")
    glibc = [int(part) for part in (os.confstr("CS_GNU_LIBC_VERSION") or "glibc 0").split()[1].split(".")]
    if switch.exists() and "[never]" not in switch.read_text() and glibc >= [2, 35]:
        assert ask_child(sys.executable, "-c", program) > 50_000
    else:
        assert mpi_environment()["GLIBC_TUNABLES"] == HUGE_PAGES


def test_what_the_user_tells_glibc_stands(monkeypatch):
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.malloc.check=0")
    assert mpi_environment()["GLIBC_TUNABLES"] == "glibc.malloc.check=0"


def test_settings_of_mpi_stay_where_there_is_no_outer_job():
    given = {"OMPI_MCA_pmix": "^s1", "OMPI_MCA_orte_launch_agent": "x", "PMIX_SECURITY_MODE": "native"}
    assert given.items() <= child_environment(given).items()


@pytest.mark.parametrize(
    ("cores", "ranks", "crowded"), [("4", 4, True), ("4", 5, False), ("1", 1, False), ("", 2, False)]
)
def test_ranks_share_the_cores_of_one_task(monkeypatch, cores, ranks, crowded):
    """`srun -n 1 -c 4 fbcouple run RUN -n 4`: mpirun sees one task; more ranks than cores are still refused."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: range(64))
    monkeypatch.setenv("SLURM_STEP_ID", "0")
    monkeypatch.setenv("SLURM_CPUS_ON_NODE", cores)
    assert ("--oversubscribe" in mpi_command(ranks, ["x"])) is crowded


def test_every_child_is_given_its_environment():
    """Whoever starts a process says with which environment."""
    silent = []
    for path in [*ROOT.glob("fbcouple/**/*.py"), *ROOT.glob("postproc/**/*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("subprocess.run", "subprocess.Popen"):
                told = {word.arg: ast.unparse(word.value) for word in node.keywords}.get("env", "")
                if "environment" not in told:
                    silent.append(f"{path.relative_to(ROOT)}:{node.lineno}")
    assert silent == []
