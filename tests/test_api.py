"""The Python face: a small bed set up, run, looked at, compared, and stepped in a process of its own."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import fbcouple
from fbcouple.errors import CaseError, DivergedError, SolverError
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command

sys.path.append(str(Path(__file__).parent / "faults"))
from small_bed import BED

TASK = """
import json
from pathlib import Path
import fbcouple

class Probe(fbcouple.Task):
    '''Largest pressure of rank 0 in every step.'''

    def __init__(self):
        self.values = []

    def after_step(self, sim):
        self.values.append([sim.time, float(sim.gas.pressure.max())])

    def finish(self, sim):
        if sim.comm.rank == 0:
            Path("probe.json").write_text(json.dumps(self.values))

    def save(self, sim, folder):
        return fbcouple.Saved({"values": self.values})

    def load(self, sim, saved, folder):
        self.values = saved.numbers["values"]
"""
STEP = """
import os, sys, fbcouple
here, variable = os.getcwd(), os.environ.get("PWD")
with fbcouple.Simulation.open(sys.argv[1]) as sim:
    before = sim.particles.positions.copy()
    for _ in range(3):
        sim.step()
    count = sim.comm.allreduce(len(sim.particles.positions))
    sys.stdout.write(f"{sim.comm.size} {count} {sim.clock.steps} {sim.gas.pressure.max() > 0}\\n")
    sim.run()
    assert os.environ["PWD"] == os.getcwd() and os.path.samefile(os.getcwd(), sys.argv[1])
assert os.getcwd() == here and os.environ.get("PWD") == variable
try:
    fbcouple.Simulation.open(sys.argv[1], fresh=True)
except fbcouple.errors.CaseError as error:
    sys.stdout.write("once\\n" if "one simulation" in str(error) else str(error))
"""

LEAVE = """
import sys, fbcouple
class Count(fbcouple.Task):
    seen = 0
    def after_step(self, sim):
        self.seen += 1
    def finish(self, sim):
        sys.stdout.write(f"{self.seen} done\\n")
with fbcouple.Simulation.open(sys.argv[1], tasks=[Count()]) as sim:
    for _ in range(4):
        sim.step()
"""
HINDERED = """
import os, sys, fbcouple
here = os.getcwd()
try:
    fbcouple.Simulation.open(sys.argv[1])
except fbcouple.errors.FbcoupleError as error:
    assert os.getcwd() == here and len(str(error)) > 40, str(error)
    sys.stdout.write("told, and back\\n")
"""


@pytest.fixture
def case_file(tmp_path: Path) -> Path:
    (tmp_path / "case").mkdir()
    path = tmp_path / "case/case.toml"
    path.write_text(BED)
    return path


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[fbcouple.Run, list[dict]]:
    """A run that is complete, started from another thread, and the rows that were shown."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "case.toml").write_text(BED)
    run = fbcouple.setup(folder / "case.toml", folder / "run", {"end_time": 3e-3})
    rows: list[dict] = []
    thread = threading.Thread(target=lambda: run.start(progress=rows.append))
    thread.start()
    thread.join()
    return run, rows


def test_a_case_has_values_on_top_and_goes_into_a_run_folder(case_file, tmp_path):
    case = fbcouple.load_case(case_file, {"gas.inlet_velocity": 0.5})
    assert case.gas.inlet_velocity == 0.5
    run = fbcouple.setup(case, tmp_path / "run", {"gravity": 9.8})
    assert (run.case.gas.inlet_velocity, run.case.gravity) == (0.5, 9.8)
    assert run.status() == fbcouple.Status("set up", 0.0, case.end_time, None, "") and run.history() == []


def test_mistakes_are_those_of_the_command_line(case_file, tmp_path):
    with pytest.raises(CaseError, match=r"gas\.inlet_velocty.*did you mean `inlet_velocity`"):
        fbcouple.load_case(case_file, {"gas.inlet_velocty": 0.5})
    with pytest.raises(CaseError, match="is not a run folder"):
        fbcouple.Run(tmp_path)
    with pytest.raises(CaseError, match=r"is a case, and no run folder \(no manifest\.json\)"):
        fbcouple.Run(case_file.parent)
    with pytest.raises(CaseError, match=r"runs: a run is given, a list of runs is allowed; give \['a run'\]"):
        fbcouple.report("a run", tmp_path / "page.html")
    with pytest.raises(CaseError, match="is a set of cases"):
        fbcouple.setup("patil/all", tmp_path / "run")
    with pytest.raises(AttributeError, match="no attribute 'lod_case'"):
        _ = fbcouple.lod_case


def test_a_run_outside_the_main_thread_has_status_rows_and_results(done):
    run, rows = done
    status = run.status()
    assert status.state == "complete" and status.time == pytest.approx(3e-3, rel=0.1) and status.checkpoint.is_dir()
    assert [row["time"] for row in rows] == [row["time"] for row in run.history()] and len(rows) > 1
    assert run.results()["time"].values.tolist() == [row["time"] for row in rows]


def test_a_complete_run_is_not_run_again_but_goes_on_where_it_is_asked_to(done):
    run, _ = done
    with pytest.raises(CaseError, match="holds results"):
        run.start(progress=False)
    assert run.resume(progress=False).state == "complete"


def test_a_report_of_runs(done, tmp_path):
    page, numbers = fbcouple.report([done[0]], tmp_path / "page.html")
    assert page.is_file() and numbers.is_file()


def test_a_run_that_stops_early_says_so_and_one_that_fails_raises(case_file, tmp_path):
    run = fbcouple.setup(case_file, tmp_path / "run", {"checkpoint.moment_steps": 5})
    assert run.start(until=1e-3, progress=False).state == "stopped"
    wrong = fbcouple.setup(
        case_file, tmp_path / "wrong", {"monitors.courant": 1.0001, "gas.max_courant": 1e-9}, force=True
    )
    with pytest.raises(DivergedError, match="Courant number"):
        wrong.start(progress=False)
    status = wrong.status()
    assert status.state == "failed" and "monitors.courant" in status.message


def test_why_a_run_stopped_before_its_first_step_is_told(case_file, tmp_path):
    requests = Requests()
    requests.stop("SIGTERM")
    status = fbcouple.setup(case_file, tmp_path / "run").start(progress=False, requests=requests)
    assert status.state == "set up" and status.message.startswith("stopped by SIGTERM before the first step")


def test_a_task_of_ones_own_looks_at_every_step_and_goes_on_after_a_restart(case_file, tmp_path):
    (case_file.parent / "probe.py").write_text(TASK)
    values = {"output.task_file": "probe.py", "end_time": 3e-3, "checkpoint.moment_steps": 5}
    with pytest.raises(CaseError, match=r"output\.task_file: probe\.py is Python code.*trust=True"):
        fbcouple.setup(case_file, tmp_path / "run", values)
    whole, parts = (fbcouple.setup(case_file, tmp_path / name, values, trust=True) for name in ("whole", "parts"))
    whole.start(trust=True, progress=False)
    parts.start(trust=True, until=1e-3, progress=False)
    parts.resume(trust=True, progress=False)
    probes = [(run.path / "probe.json").read_text() for run in (whole, parts)]
    assert probes[0] == probes[1] and len(probes[0]) > 100


FILES = """
import numpy as np
import fbcouple

class Keeper(fbcouple.Task):
    def __init__(self):
        self.times = []

    def after_step(self, sim):
        self.times.append(sim.time)

    def finish(self, sim):
        if sim.comm.rank == 0:
            np.save("times.npy", self.times)

    def save(self, sim, folder):
        if sim.comm.rank == 0:
            np.savez(folder / "NAME.npz", times=self.times)
        return fbcouple.Saved(files=LISTED)

    def load(self, sim, saved, folder):
        self.times = np.load(folder / "task-times.npz")["times"].tolist()
"""


def test_a_task_goes_on_from_a_file_of_its_own(case_file, tmp_path):
    text = FILES.replace("NAME", "task-times").replace("LISTED", "['task-times.npz']")
    (case_file.parent / "keeper.py").write_text(text)
    values = {"output.task_file": "keeper.py", "end_time": 3e-3, "checkpoint.moment_steps": 5}
    run = fbcouple.setup(case_file, tmp_path / "run", values, trust=True)
    run.start(trust=True, until=1e-3, progress=False)
    run.resume(trust=True, progress=False)
    times = np.load(run.path / "times.npy")
    assert (np.diff(times) > 0.0).all() and times[0] < 1e-4 and times[-1] == pytest.approx(3e-3, rel=1e-2)


@pytest.mark.parametrize(
    ("name", "listed", "words"),
    [
        ("mine", "['mine.npz']", "mine.npz.*is no name for a file of a task; call it task-NAME"),
        ("task-mine", "[]", "task-mine.npz.*does not list it; return Saved"),
    ],
)
def test_a_file_that_a_checkpoint_could_not_be_read_with_is_refused_when_it_is_written(
    case_file, tmp_path, name, listed, words
):
    (case_file.parent / "keeper.py").write_text(FILES.replace("NAME", name).replace("LISTED", listed))
    values = {"output.task_file": "keeper.py", "end_time": 3e-3, "checkpoint.moment_steps": 5}
    run = fbcouple.setup(case_file, tmp_path / "run", values, trust=True)
    with pytest.raises(SolverError, match=words):
        run.start(trust=True, until=1e-3, progress=False)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1", "has no class of fbcouple.Task"),
        ("def (", "is not Python, line 1"),
        ("class Mine:\n    pass", "has no class of fbcouple.Task"),
    ],
)
def test_a_file_without_a_task_is_refused(case_file, text, message):
    (case_file.parent / "probe.py").write_text(text)
    with pytest.raises(CaseError, match=message):
        fbcouple.load_case(case_file, {"output.task_file": "probe.py"})


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_simulation_is_stepped_in_every_rank_and_run_to_its_end(case_file, tmp_path, ranks):
    run = fbcouple.setup(case_file, tmp_path / "run", {"end_time": 3e-3})
    command = [sys.executable, "-c", STEP, str(run.path)]
    environment = mpi_environment()
    done = subprocess.run(
        mpi_command(ranks, command) if ranks > 1 else command,
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    count = run.case.particles.count
    assert done.stdout.count(f"{ranks} {count} 3 True") == ranks and done.stdout.count("once") == ranks
    assert run.status().state == "complete"


def test_a_simulation_that_is_left_early_has_its_results_and_tasks_of_its_own(case_file, tmp_path):
    run = fbcouple.setup(case_file, tmp_path / "run", {"end_time": 3e-3})
    done = subprocess.run([sys.executable, "-c", LEAVE, str(run.path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["4", "done"]
    assert run.results().attrs["complete"] == 0 and len(run.history()) > 1
    assert run.start(fresh=True, progress=False).state == "complete"


@pytest.mark.parametrize("ranks", [1, 2])
def test_what_hinders_a_simulation_is_told_on_every_rank(case_file, tmp_path, ranks):
    run = fbcouple.setup(case_file, tmp_path / "run")
    (run.path / "DEM" / "particles.data").unlink()
    (run.path / "DEM" / "particles.data").mkdir()  # reading it is an error of the system
    command = mpi_command(ranks, [sys.executable, "-c", HINDERED, str(run.path)])
    done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, check=False)
    assert done.stdout.count("told, and back") == ranks, done.stdout + done.stderr


def test_the_import_is_quick_and_loads_no_mpi_numba_or_vtk():
    program = "import sys, time; t = time.perf_counter(); import fbcouple; print(time.perf_counter() - t, *sys.modules)"
    times = []
    for _ in range(3):
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        seconds, *loaded = done.stdout.split()
        times.append(float(seconds))
        assert not {"mpi4py", "numba", "vtkmodules", "xarray", "matplotlib"} & set(loaded)
    assert np.min(times) < 0.3


def test_a_script_runs_again_where_it_says_so(case_file, tmp_path):
    values = {"end_time": np.float64(2e-3), "domain.cells": np.array([3, 3, 8])}
    path = tmp_path / "again"
    with pytest.warns(UserWarning, match="averages.start = 0.001: end_time = 0.002"):
        first = fbcouple.setup(case_file, path, values)
    values |= {"averages.start": 1e-3}
    assert first.case.end_time == 2e-3 and first.start(progress=False).state == "complete"
    (path / "notes.txt").write_text("of the user")
    with pytest.raises(CaseError, match="holds a run"):
        fbcouple.setup(case_file, path, values)
    with pytest.raises(CaseError, match=r"gas\.density"):
        fbcouple.setup(case_file, path, values | {"gas.density": -1.0}, overwrite=True)
    assert first.status().state == "complete", "a wrong case removes nothing"
    again = fbcouple.setup(case_file, path, values, overwrite=True)
    assert not (path / "results.nc").exists() and (path / "notes.txt").read_text() == "of the user"
    assert again.status().state == "set up"
