"""The parent process: makes the mesh, starts the MPI job, watches it, and says why it died if it did."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from fbcouple.case.load import load_case
from fbcouple.case.schema import Case
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import make_environment
from fbcouple.errors import CaseError, DivergedError, FbcoupleError, SolverError
from fbcouple.failure import SOLVER_LOGS, forget_failure, read_failure
from fbcouple.results import read_line

_ERRORS: dict[int, type[FbcoupleError]] = {1: CaseError, 4: DivergedError}
_PAUSE = 0.25
_TAIL = 12
_PRODUCTS = ("results.nc", "figures", "report.html", "report.json")

Watch = Callable[[dict[str, Any]], None]


def launch(run: Path, ranks: int, until: float | None, fresh: bool, watch: Watch) -> None:
    """Run the case in `run` on `ranks` MPI ranks to its end, or to `until` [s]; `watch` sees each history row.

    Raises CaseError if `run` is no run folder or holds results and `fresh` is not said; SolverError with the solver's
    own last words; DivergedError if a check of the run failed.
    """
    case = _read_run(run, fresh)
    end = case.end_time if until is None else min(until, case.end_time)
    for name in _PRODUCTS:
        _remove(run / name)
    forget_failure(run)
    log = run / "logs/run.jsonl"
    for old in (log, *(run / "logs" / name for name in SOLVER_LOGS)):
        old.unlink(missing_ok=True)
    if case.gas:
        prepare_mesh(case, run, ranks)
    command = mpi_command(ranks, [sys.executable, "-m", "fbcouple.worker", str(run.resolve()), repr(end)])
    _note_run(run, ranks, command)
    _watch_job(command, run, log, watch)


def _read_run(run: Path, fresh: bool) -> Case:
    if not (run / "manifest.json").exists():
        raise CaseError([f"{run}: is not a run folder; make one with: fbcouple setup CASE -o {run}"])
    if (run / "results.nc").exists() and not fresh:
        raise CaseError([f"{run}: holds results (results.nc); --fresh starts again and removes them"])
    return load_case(str(run / "case.toml"))


def prepare_mesh(case: Case, run: Path, ranks: int) -> None:
    """Make the OpenFOAM mesh and cut it into `ranks` parts with OpenFOAM's own tools, from the decks.

    Raises SolverError with the tool's words.
    """
    fluid = run / "fluid"
    for old in (*fluid.glob("processor*"), *_time_folders(fluid), fluid / "constant/polyMesh"):
        _remove(old)
    tools = [["blockMesh"]]
    if find_needs(case)["closed_nozzle"]:
        tools += [["topoSet"], ["createPatch", "-overwrite"]]
    if ranks > 1:
        text = make_environment().get_template("openfoam/system/decomposeParDict").render(ranks=ranks)
        (fluid / "system/decomposeParDict").write_text(text)
        tools.append(["decomposePar"])
    with (run / "logs/mesh.log").open("w") as log:
        for tool in tools:
            _run_tool(tool, fluid, log)


def _run_tool(tool: list[str], fluid: Path, log: Any) -> None:
    command = [*tool, "-case", str(fluid)]
    try:
        done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise SolverError(f"{tool[0]} is not on the PATH; mend: sudo apt-get install openfoam") from error
    log.write(done.stdout + done.stderr)
    if done.returncode:
        words = (done.stdout + done.stderr).strip()
        start = words.find("--> FOAM FATAL")
        told = words[start:] if start >= 0 else "\n".join(words.splitlines()[-_TAIL:])
        raise SolverError(f"{tool[0]} failed with code {done.returncode} (logs/mesh.log): {told[:800]}")


def _time_folders(fluid: Path) -> Iterator[Path]:
    for folder in fluid.iterdir():
        try:
            if float(folder.name) > 0.0:
                yield folder
        except ValueError:
            continue


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def mpi_environment() -> dict[str, str]:
    """One thread a rank; Open MPI may run as root where the caller is root (containers, CI)."""
    own = {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    if os.geteuid() == 0:
        own |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    project = os.environ.get("WM_PROJECT_DIR", "/usr/share/openfoam")
    return {"WM_PROJECT_DIR": project} | os.environ | own | {"FOAM_CONTROLDICT": forbid_case_code(Path(project))}


def forbid_case_code(project: Path) -> str:
    """OpenFOAM's global controlDict with compiling and system calls from a case switched off.

    FOAM_CONTROLDICT takes the place of every etc/controlDict; of an entry that is given twice the last one counts.
    Empty, which OpenFOAM takes for not set, where `project` has none.
    """
    file = project / "etc/controlDict"
    text = file.read_text(errors="replace") if file.is_file() else ""
    return f"{text}\nInfoSwitches {{ allowSystemOperations 0; }}\n" if text else ""


def mpi_command(ranks: int, program: list[str]) -> list[str]:
    """The command line that starts `program` on `ranks` ranks; more ranks than cores share them."""
    crowded = ["--oversubscribe"] if ranks > len(os.sched_getaffinity(0)) else []
    return ["mpirun", "-n", str(ranks), "--bind-to", "none", *crowded, *program]


def _note_run(run: Path, ranks: int, command: list[str]) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["run"] = {
        "ranks": ranks,
        "host": platform.node(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "command": command,
        "started": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
    }
    fresh = run / "manifest.tmp"
    fresh.write_text(json.dumps(manifest, indent=2) + "\n")
    fresh.replace(run / "manifest.json")


def _watch_job(command: list[str], run: Path, log: Path, watch: Watch) -> None:
    launcher_log = run / "logs/launcher.log"
    with launcher_log.open("w") as words:
        try:
            job = subprocess.Popen(command, env=mpi_environment(), stdout=words, stderr=subprocess.STDOUT)
        except FileNotFoundError as error:
            raise SolverError("mpirun is not on the PATH; mend: sudo apt-get install openmpi-bin") from error
        try:
            for row in _follow(log, job):
                watch(row)
        except BaseException:
            job.terminate()
            job.wait()
            raise
    if job.returncode or not (run / "results.nc").exists():
        text, code = read_failure(run, launcher_log.read_text(errors="replace"))
        raise CaseError([text]) if code == 1 else _ERRORS.get(code, SolverError)(text)


def _follow(log: Path, job: subprocess.Popen) -> Iterator[dict[str, Any]]:
    """History rows as the job writes them, until it ends."""
    place = 0
    over = False
    while not over:
        over = job.poll() is not None
        if log.exists():
            with log.open() as file:
                file.seek(place)
                while (line := file.readline()).endswith("\n"):
                    place = file.tell()
                    row = read_line(line)
                    if row is not None:
                        yield row
        if not over:
            time.sleep(_PAUSE)
