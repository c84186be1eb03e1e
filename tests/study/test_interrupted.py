"""A signal to a study: what runs stops with a checkpoint, nothing else begins, the same command goes on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from fbcouple.run_folder.checkpoint import list_checkpoints
from fbcouple.study.runs import ENDING

LONGEST = 300.0
STEPS = """
title = "steps"
base = "case.toml"
measures = ["path"]
design = "grid"
[set]
end_time = 0.4
gas.inlet_velocity = 0.52
gas.max_courant = 10.0
output.record_every = 2e-3
[knobs]
gas.max_step = [2e-3, 2e-4, 1e-4]
"""
SCENES = """
title = "beads"
base = "case.toml"
span = "particles"
times = 200
restart = true
[set]
gas.max_courant = 10.0
gas.inlet_velocity = 0.52
[scenes.steps]
gas.max_step = [1e-4, 2e-4]
forms = ["exponential"]
"""


def start(kind: str, study: Path, out: Path, *options: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-P", "-m", "fbcouple", "study", kind, str(study), "-o", str(out), *options]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    return subprocess.Popen(command, text=True, start_new_session=True, **pipes)


def wait_for(come: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + LONGEST
    while not come():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def has_rows(run: Path) -> bool:
    log = run / "logs/run.jsonl"
    return log.is_file() and log.read_text().count("\n") > 2


def read_ending(run: Path) -> dict:
    return json.loads((run / ENDING).read_text())


def read_command(run: Path) -> list[str]:
    return json.loads((run / "manifest.json").read_text())["run"]["command"]


@pytest.mark.parametrize(("number", "jobs"), [(signal.SIGINT, 1), (signal.SIGTERM, 2)])
def test_members_are_interrupted_and_go_on(write, tmp_path, number, jobs):
    """The signal reaches all processes of the study, as that of a terminal does, and is heard once."""
    study, out = write(text=STEPS), tmp_path / "out"
    first, second, third = (out / "members" / name for name in ("max_step-0.002", "max_step-0.0002", "max_step-0.0001"))
    process = start("error-vs-time", study, out, "-j", str(jobs))
    wait_for(lambda: (first / ENDING).exists() and has_rows(second), process)
    os.killpg(process.pid, number)
    said, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 75, said
    assert "interrupted (" in said and "1 of 3 runs have ended; call it again to go on" in said, said
    assert "out of time" not in said and "failed" not in said and not (out / "study.json").exists()
    ending = read_ending(second)
    assert ending["how"] == "interrupted" and ending["text"].startswith("stopped by ")
    assert list_checkpoints(second) and read_ending(first)["how"] == "complete"
    assert not list(third.glob("results.nc")) and (jobs == 2 or not third.exists())

    if jobs == 2:
        return
    kept, stopped = (first / "results.nc").stat().st_mtime_ns, list_checkpoints(second)[0].name
    again = start("error-vs-time", study, out, "--only", second.name)
    said, _ = again.communicate(timeout=LONGEST)
    assert again.returncode == 0 and said.count(": complete (") == 2, said
    assert (first / "results.nc").stat().st_mtime_ns == kept and read_ending(second)["seconds"] > ending["seconds"]
    assert f"--resume {stopped}" in " ".join(read_command(second)), "it went on from where it was stopped"


def list_processes(folder: Path) -> list[str]:
    """Commands of the processes that have to do with a folder."""
    found = []
    for file in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            found += [text] if str(folder) in (text := file.read_bytes().replace(b"\0", b" ").decode()) else []
    return found


def test_nothing_goes_on_after_a_study_that_was_killed(write, tmp_path):
    study, out = write(text=STEPS), tmp_path / "out"
    runs = [out / "members" / name for name in ("max_step-0.0002", "max_step-0.0001")]
    process = start("error-vs-time", study, out, "-j", "2")
    wait_for(lambda: any(map(has_rows, runs)), process)
    others = [int(file.parent.name) for file in Path("/proc").glob("[0-9]*/stat") if is_child(file, process.pid)]
    process.kill()
    process.communicate(timeout=LONGEST)
    end = time.monotonic() + LONGEST
    while (left := list_processes(out)) or any(Path(f"/proc/{number}").exists() for number in others):
        assert time.monotonic() < end, left
        time.sleep(0.1)
    assert len(others) >= 2 and any(map(list_checkpoints, runs))


def is_child(file: Path, parent: int) -> bool:
    with suppress(OSError):
        return int(file.read_text().rpartition(")")[2].split()[1]) == parent
    return False


def test_scenes_are_interrupted(write, tmp_path):
    out = tmp_path / "out"
    process = start("stability", write(text=SCENES), out)
    wait_for((out / "scenes/steps-0.0001-exponential/logs/heartbeat").exists, process)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 75 and "0 of 2 runs have ended; call it again to go on" in said, said
    assert "1/2 steps-0.0001-exponential: interrupted (" in said
    assert [run.name for run in (out / "scenes").iterdir()] == ["steps-0.0001-exponential"]
    assert not (out / "restarts").exists() and not (out / "stability.json").exists()
