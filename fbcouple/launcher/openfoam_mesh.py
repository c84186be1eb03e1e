"""The OpenFOAM mesh of a run and its parts for the ranks, by OpenFOAM's own tools; fields of a checkpoint on it."""

from __future__ import annotations

import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fbcouple.case.bed.region import has_own_mesh, read_mesh
from fbcouple.case.schema.sections import Case
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import make_environment
from fbcouple.errors import SolverError, StoppedError
from fbcouple.geometry.block import list_cyclic
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.geometry.partition import find_rank_grid
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.environment import missing_program, mpi_environment
from fbcouple.machine.stop_signals import follow_parent
from fbcouple.run_folder.checkpoint import Checkpoint
from fbcouple.run_folder.lock import Lock

_TAIL = 12
_PAUSE = 0.1


@dataclass(frozen=True)
class Guard:
    """What OpenFOAM's tools are started with: the lock of the run folder, which they hold on, and the requests that
    end them early."""

    lock: Lock
    requests: Requests


def prepare_mesh(case: Case, run: Path, ranks: int, guard: Guard | None = None) -> None:
    """Make the OpenFOAM mesh and cut it into `ranks` parts with OpenFOAM's own tools, from the decks.

    Raises SolverError with the tool's words, StoppedError if a request came while it was at work.
    """
    cfd = run / "CFD"
    for old in (*_list_parts(cfd), *_time_folders(cfd), cfd / "constant/polyMesh"):
        _remove(old)
    (run / "logs/mesh.log").write_text("", encoding="utf-8")
    if has_own_mesh(case):
        write_polymesh(read_mesh(case, run), cfd / "constant/polyMesh", list_cyclic(case.domain.periodic))
    else:
        _run_tool(run, guard, "blockMesh")
    if find_needs(case)["closed_nozzle"]:
        _run_tool(run, guard, "topoSet")
        _run_tool(run, guard, "createPatch", "-overwrite")
    _cut(case, run, ranks, guard)


def resume_mesh(case: Case, run: Path, ranks: int, checkpoint: Checkpoint, guard: Guard | None = None) -> None:
    """Make the mesh for `ranks` ranks with the fields of `checkpoint` on it, whatever ranks wrote them."""
    cfd = run / "CFD"
    prepare_mesh(case, run, checkpoint.ranks, guard)
    for name in checkpoint.index.files:
        if name.startswith("CFD/"):
            (run / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(checkpoint.folder / name, run / name)
    if ranks == checkpoint.ranks:
        return
    if checkpoint.ranks > 1:
        _run_tool(run, guard, "reconstructPar", "-latestTime")
    for old in _list_parts(cfd):
        _remove(old)
    _cut(case, run, ranks, guard)


def _cut(case: Case, run: Path, ranks: int, guard: Guard | None) -> None:
    if ranks > 1:
        template = make_environment().get_template("openfoam/system/decomposeParDict")
        text = template.render(ranks=ranks, grid=find_rank_grid(case.domain.size, ranks))
        (run / "CFD/system/decomposeParDict").write_text(text, encoding="utf-8")
        _run_tool(run, guard, "decomposePar", "-copyUniform")


def _run_tool(run: Path, guard: Guard | None, *tool: str) -> None:
    command = [*tool, "-case", "CFD"]  # OpenFOAM takes blanks and quotes out of a path on the command line
    path = run / "logs/mesh.log"
    start = path.stat().st_size
    with path.open("ab") as log:
        try:
            # A session of its own: Ctrl-C at the terminal is for this process, which ends the tool.
            process = subprocess.Popen(
                command,
                cwd=run,
                env=mpi_environment() | {"PWD": str(run.resolve())},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                pass_fds=(guard.lock.number,) if guard else (),
                preexec_fn=follow_parent(signal.SIGKILL),  # noqa: PLW1509  (no threads here)
            )
        except FileNotFoundError as error:
            raise missing_program(tool[0], "openfoam") from error
        _await(process, tool[0], guard)
    if process.returncode:
        with path.open("rb") as log:
            log.seek(start)
            words = log.read().decode(errors="replace").strip()
        fatal = words.find("--> FOAM FATAL")
        told = words[fatal:] if fatal >= 0 else "\n".join(words.splitlines()[-_TAIL:])
        raise SolverError(f"{tool[0]} failed with code {process.returncode} (logs/mesh.log): {told[:800]}")


def _await(process: subprocess.Popen, name: str, guard: Guard | None) -> None:
    """Wait for a tool's end; a request to stop ends it, and so does whatever ends this function."""
    try:
        while process.poll() is None:
            if guard and guard.requests.first:
                raise StoppedError(f"stopped by {guard.requests.first} before the first step, while {name} was at work")
            with suppress(subprocess.TimeoutExpired):
                process.wait(_PAUSE)
    finally:
        if process.returncode is None:
            process.kill()
            process.wait()


def _list_parts(cfd: Path) -> list[Path]:
    """What the ranks' parts of an earlier run are in."""
    return [path for path in cfd.glob("processor*") if path.name.removeprefix("processor").isdecimal()]


def _time_folders(cfd: Path) -> Iterator[Path]:
    for folder in cfd.iterdir():
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
