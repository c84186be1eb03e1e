"""Where what a command prints goes away: a run goes on to its end, other commands end as Unix tools do."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from small_bed import PATIENCE, await_true, prepare, start_program

from fbcouple.machine.output import SteadyStream

SHORT = ["end_time=1e-3", "averages.start=0.0"]


def call(*words: str, **streams) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "fbcouple.cli.main", *words]
    return subprocess.run(command, env={**os.environ}, text=True, check=False, timeout=PATIENCE, **streams)


def open_pipe_without_reader() -> int:
    reader, writer = os.pipe()
    os.close(reader)
    return writer


SLOW_LOSSES = [pytest.param(loss, marks=pytest.mark.slow) for loss in ("pipe", "closed")]


@pytest.mark.parametrize("loss", ["full disk", *SLOW_LOSSES])
def test_run_goes_on_without_its_output(tmp_path, loss):
    run = prepare(tmp_path, SHORT)
    places = {"pipe": open_pipe_without_reader, "full disk": lambda: os.open("/dev/full", os.O_WRONLY)}
    if loss == "closed":
        words = [sys.executable, "-m", "fbcouple.cli.main", "run", str(run)]
        shell = ["sh", "-c", 'exec "$@" >&- <&-', "sh", *words]
        done = subprocess.run(shell, env={**os.environ}, stderr=subprocess.PIPE, text=True, check=False)
    else:
        stream = places[loss]()
        done = call("run", str(run), stdout=stream, stderr=subprocess.PIPE)
        os.close(stream)
    assert done.returncode == 0 and (run / "results.nc").exists(), done.stderr
    told = "the output could not be written from some line on: [Errno 28] No space left on device\n"
    assert done.stderr == (told if loss == "full disk" else "")


def test_run_goes_on_without_its_terminal(tmp_path):
    """The terminal is closed while the bar is drawn, stderr with it, and no signal comes (a disowned job)."""
    run = prepare(tmp_path, SHORT)
    master, terminal = pty.openpty()
    command = [sys.executable, "-m", "fbcouple.cli.main", "run", str(run)]
    job = subprocess.Popen(command, env={**os.environ}, stdout=terminal, stderr=terminal)
    await_true((run / "logs").exists, job)
    os.close(terminal)
    assert os.read(master, 1)
    os.close(master)
    assert job.wait(PATIENCE) == 0 and (run / "results.nc").exists()


@pytest.mark.slow
def test_stopped_run_keeps_its_code_without_stderr(tmp_path):
    run = prepare(tmp_path, ["end_time=10.0"])
    lost = open_pipe_without_reader()
    done = call("run", str(run), "--wall-limit", "0.01", stdout=lost, stderr=lost)
    os.close(lost)
    assert done.returncode == 75


def test_reader_that_goes_away_ends_a_listing_quietly():
    lost = open_pipe_without_reader()
    done = call("cases", stdout=lost, stderr=subprocess.PIPE)
    os.close(lost)
    assert done.returncode == 141 and done.stderr == ""


def test_listing_on_a_full_disk_is_no_success(monkeypatch, tmp_path):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    with open("/dev/full", "w") as full:
        done = call("cases", stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 3 and len(done.stderr.splitlines()) == 1
    assert "No space left on device" in done.stderr and "doctor --bundle" in done.stderr


def test_stream_tells_why_it_is_lost():
    with open("/dev/full", "w") as full:
        stream = SteadyStream(full)
        assert stream.write("text") == 4 and stream.lost is None
        stream.flush()
        assert stream.lost is not None and "No space left" in str(stream.lost)
        stream.write("more")
        stream.flush()


def test_inner_job_starts_below_an_outer_launcher(tmp_path):
    """`mpirun -n 1 fbcouple run RUN`: what the outer launcher told its rank is not for the launcher of the run."""
    from fbcouple.machine.environment import mpi_environment  # noqa: PLC0415
    from fbcouple.machine.launchers import mpi_command  # noqa: PLC0415

    run = prepare(tmp_path, SHORT)
    command = mpi_command(1, [sys.executable, "-m", "fbcouple.cli.main", "run", str(run), "-n", "2"])
    done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, check=False, timeout=PATIENCE)
    assert done.returncode == 0 and (run / "results.nc").exists(), done.stdout + done.stderr


def test_current_folder_is_the_run_and_full_of_modules(tmp_path):
    """`cd RUN && fbcouple run .`, and its pictures: nothing of the folder is imported, on any rank, in any child."""
    run = prepare(tmp_path, [*SHORT, "output.particles_every=1e-3"])
    for name in ("mpi4py", "numpy", "pyvista", "argparse", "postproc", "fbcouple"):
        (run / f"{name}.py").write_text(f"open({str(tmp_path / name)!r} + '.ran', 'w').close()\nraise SystemExit(9)\n")
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    for words in (["run", ".", "-n", "2"], ["post", "."]):
        command = [sys.executable, "-P", "-m", "fbcouple.cli.main", *words]
        done = subprocess.run(command, cwd=run, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert (run / "figures/bed_views.png").exists() and list(tmp_path.glob("*.ran")) == []


def test_job_of_the_parent_hears_a_signal_that_comes_at_once(tmp_path):
    """From the command's first line on it is a request, not the end of the process."""
    run = prepare(tmp_path, ["end_time=10.0"])
    program = "import os, signal, fbcouple.case.load as l; load = l.load_case\n"
    program += "def f(*a): os.kill(os.getpid(), signal.SIGTERM); return load(*a)\n"
    program += "l.load_case = f\nfrom fbcouple.cli.main import main; main()"
    job = start_program(["-c", program, "run"], run)
    _, words = job.communicate(timeout=PATIENCE)
    assert job.returncode == 75 and "stopped by SIGTERM before the first step" in words, words
