"""The OpenFOAM mesh of a run and its parts for the ranks, by OpenFOAM's own tools; fields of a checkpoint on it."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.region import read_mesh
from fbcouple.case.schema import Case
from fbcouple.checkpoint import Checkpoint
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import make_environment
from fbcouple.environment import mpi_environment
from fbcouple.errors import SolverError
from fbcouple.meshes.foam_files import write_polymesh
from fbcouple.partition import find_rank_grid

_TAIL = 12


def prepare_mesh(case: Case, run: Path, ranks: int) -> None:
    """Make the OpenFOAM mesh and cut it into `ranks` parts with OpenFOAM's own tools, from the decks.

    Raises SolverError with the tool's words.
    """
    fluid = run / "fluid"
    for old in (*fluid.glob("processor*"), *_time_folders(fluid), fluid / "constant/polyMesh"):
        _remove(old)
    (run / "logs/mesh.log").write_text("", encoding="utf-8")
    if case.domain.is_plain_box:
        _run_tool(run, "blockMesh")
    else:
        write_polymesh(read_mesh(case, run), fluid / "constant/polyMesh")
    if find_needs(case)["closed_nozzle"]:
        _run_tool(run, "topoSet")
        _run_tool(run, "createPatch", "-overwrite")
    _cut(case, run, ranks)


def resume_mesh(case: Case, run: Path, ranks: int, checkpoint: Checkpoint) -> None:
    """Make the mesh for `ranks` ranks with the fields of `checkpoint` on it, whatever ranks wrote them."""
    fluid = run / "fluid"
    prepare_mesh(case, run, checkpoint.ranks)
    shutil.copytree(checkpoint.folder / "fluid", fluid, dirs_exist_ok=True)
    if ranks == checkpoint.ranks:
        return
    if checkpoint.ranks > 1:
        _run_tool(run, "reconstructPar", "-latestTime")
    for old in fluid.glob("processor*"):
        _remove(old)
    _cut(case, run, ranks)


def _cut(case: Case, run: Path, ranks: int) -> None:
    if ranks > 1:
        template = make_environment().get_template("openfoam/system/decomposeParDict")
        text = template.render(ranks=ranks, grid=find_rank_grid(case.domain.size, ranks))
        (run / "fluid/system/decomposeParDict").write_text(text, encoding="utf-8")
        _run_tool(run, "decomposePar")


def _run_tool(run: Path, *tool: str) -> None:
    command = [*tool, "-case", "fluid"]  # OpenFOAM takes blanks and quotes out of a path on the command line
    try:
        done = subprocess.run(
            command,
            cwd=run,
            env=mpi_environment() | {"PWD": str(run.resolve())},
            capture_output=True,
            text=True,
            check=False,
            encoding="utf-8",
            errors="replace",
        )
    except FileNotFoundError as error:
        raise SolverError(f"{tool[0]} is not on the PATH; mend: sudo apt-get install openfoam") from error
    with (run / "logs/mesh.log").open("a", encoding="utf-8") as log:
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
