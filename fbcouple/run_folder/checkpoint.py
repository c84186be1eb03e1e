"""A checkpoint on disk: a folder that is whole or not there, with a checksum of everything in it.

checkpoints/step-000001200/   index.json       step, time, ranks, case, inputs, versions, size and SHA-256 of every file
                              state.json       clock, and numbers of the tasks; history.jsonl, snapshots.npz, exits.npz
                              cells-0000.npz   rows of rank 0's cells, one file a rank
                              liggghts.restart   LIGGGHTS' own
                              CFD/           OpenFOAM's own time directories
"""

from __future__ import annotations

import errno
import os
import re
import shutil
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.changes import list_changes, list_values
from fbcouple.case.companions import list_files
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import list_code
from fbcouple.errors import CaseError
from fbcouple.geometry.saved_fields import Words, list_words
from fbcouple.paths import WALLS
from fbcouple.run_folder.checkpoint_index import (
    Index,
    is_name,
    name_folder,
    read_index,
    require_task_names,
    require_whole,
    write_index,
)
from fbcouple.run_folder.manifest import hash_file
from fbcouple.run_folder.plain_files import format_path

FOLDER = "checkpoints"
REFUSED = ".refused"
_KEPT = 2
_NO_FOLDER_SYNC = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP)
_UNFINISHED = ".unfinished-"
_REST = re.compile(r"\.unfinished-(step-)?\d+")
_MOST_NAMED = 3
_ONE_VELOCITY = {b"interstitialInletVelocity", b"alpha", b"inletVelocity"}
"""Words of an inlet of one velocity, which the run may have had up to the checkpoint, and has another since."""

Sums = dict[str, tuple[int, str]]
"""File, named from the checkpoint's folder -> size and SHA-256."""


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint that was found to be whole and of this case."""

    folder: Path
    index: Index

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.index.time

    @property
    def ranks(self) -> int:
        """MPI ranks that wrote it."""
        return self.index.ranks


def describe(case: Case, run: Path, makers: dict[str, str], updates: list[str]) -> dict[str, Any]:
    """What a checkpoint of a run of `case` in `run` says beside step, time and ranks: all that must not change between
    it and the run that goes on from it, and how often LIGGGHTS is set up anew, which is noted if it changes. `makers`:
    versions that numbers depend on; `updates`: how they changed before.
    """
    about = {"case": list_values(case), "inputs": hash_inputs(case, run), "made_by": makers, "updates": updates}
    return about | {"moment_steps": case.checkpoint.moment_steps}


def hash_inputs(case: Case, run: Path) -> dict[str, str]:
    """SHA-256 of the files in `run` that a run of `case` reads after its start, other than decks: law, mesh, walls."""
    mesh = list_files(run, case.domain.mesh) if case.domain.mesh else []
    return {name: hash_file(run / name) for name in (*list_code(case).values(), *mesh, WALLS) if (run / name).is_file()}


def begin(run: Path, step: int) -> Path:
    """An empty folder for the checkpoint of `step`; what an earlier attempt left is removed."""
    for rest in _list_rests(run):
        shutil.rmtree(rest)
    folder = run / FOLDER / f"{_UNFINISHED}{step}"
    folder.mkdir(parents=True)
    return folder


def add_up(folder: Path, names: list[Path]) -> Sums:
    """Bring the files `names` in `folder` (all in it, where a name is a folder) to the disk, and take their sums."""
    sums: Sums = {}
    for name in names:
        top = folder / name
        for path in sorted(top.rglob("*")) if top.is_dir() else [top]:
            _flush(path)
            if path.is_file():
                sums[str(path.relative_to(folder))] = path.stat().st_size, hash_file(path)
        _flush(top)
    return sums


def finish(folder: Path, about: dict[str, Any], sums: Sums) -> Path:
    """Make the checkpoint in `folder` valid: index, then its name; only the newest two stay. Returns its place."""
    require_task_names(folder, sums)
    _flush(write_index(folder, about, sums))
    _flush(folder)
    path = folder.parent / name_folder(about["step"])
    if path.exists():
        shutil.rmtree(path)
    folder.rename(path)
    _flush(path.parent)
    for old in list_checkpoints(path.parents[1])[_KEPT:]:
        # Renamed first: a removal that is cut short leaves nothing that looks like a checkpoint.
        shutil.rmtree(old.rename(old.with_name(f"{_UNFINISHED}{old.name}")))
    return path


def find_checkpoint(name: str) -> Path:
    """Where in a run folder the checkpoint `name` is. Raises: ValueError if no checkpoint is called so."""
    if not is_name(name):
        raise ValueError(f"no checkpoint is called {name!r}")
    return Path(FOLDER) / name


def list_checkpoints(run: Path) -> list[Path]:
    """Folders of the checkpoints of `run`, the newest first; nothing is said of what is in them."""
    return sorted((p for p in (run / FOLDER).glob("step-*") if is_name(p.name) and p.is_dir()), reverse=True)


def list_strays(run: Path) -> list[Path]:
    """What lies among the checkpoints of `run` and is none, nor what was refused or not finished."""
    known = set(_list_rests(run))
    strays = [path for path in (run / FOLDER).glob("*") if path not in known]
    return sorted(p for p in strays if not (is_name(p.name.removesuffix(REFUSED)) and p.is_dir()))


def _list_rests(run: Path) -> list[Path]:
    """What attempts that were cut short left of checkpoints."""
    return [path for path in (run / FOLDER).glob(f"{_UNFINISHED}*") if _REST.fullmatch(path.name) and path.is_dir()]


def format_newest(run: Path) -> str:
    """Say what a run that failed goes on from."""
    found = list_checkpoints(run)
    return f"{found[0]} stands, --resume goes on from it" if found else "there is no checkpoint before it"


def abandon(run: Path) -> None:
    """Remove what is there of a checkpoint that could not be finished, so that it takes no room."""
    for rest in _list_rests(run):
        shutil.rmtree(rest, ignore_errors=True)


def choose(run: Path, case: Case) -> tuple[Checkpoint | None, list[str]]:
    """The newest checkpoint that is whole and of `case`, and a line on each newer one that is not.

    A refused one is renamed, so that it is not among the newest two any more. None if there never was any; raises
    CaseError if there are some and all are refused.
    """
    found = list_checkpoints(run)
    refusals = []
    for folder in found:
        try:
            good = read(folder, case)
        except CaseError as error:
            refusals.append(str(error))
            continue
        for bad in found[: found.index(folder)]:
            shutil.rmtree(bad.with_name(bad.name + REFUSED), ignore_errors=True)
            bad.rename(bad.with_name(bad.name + REFUSED))
        return good, refusals
    if refusals:
        raise CaseError([*refusals, f"{run}: no checkpoint is left to resume from; --fresh starts again"])
    return None, []


def read(folder: Path, case: Case) -> Checkpoint:
    """Check every file of the checkpoint in `folder`; raises CaseError with its name and what is wrong with it.

    The decks of its run must have been looked at: fields of the gas may have the words that they have.
    """
    run = folder.parents[1]
    try:
        index = read_index(folder)
        _require_same(index, case, run)
        require_whole(folder, index, _read_words(run))
    except CaseError as error:
        raise CaseError([f"{format_path(folder)}: refused: {error}"]) from None
    return Checkpoint(folder, index)


def _require_same(index: Index, case: Case, run: Path) -> None:
    """Raise CaseError if the case or a file that the run reads is not the one that the checkpoint is of."""
    if changes := list_changes(index.case, case, index.time):
        more = f" and {len(changes) - _MOST_NAMED} more" if len(changes) > _MOST_NAMED else ""
        told = ", ".join(map(str, changes[:_MOST_NAMED]))
        raise CaseError([f"it is of another case than the case.toml of the run: {told}{more}"])
    inputs = hash_inputs(case, run)
    changed = [name for name in sorted({*index.inputs, *inputs}) if index.inputs.get(name) != inputs.get(name)]
    if changed:
        words = "has changed" if len(changed) == 1 else "have changed"
        raise CaseError([f"{', '.join(changed[:_MOST_NAMED])} {words} since; put back what the run had then"])


def _read_words(run: Path) -> Words:
    """Words of the fields as they start, and of the mesh's patches."""
    decks = [run / "CFD/system/blockMeshDict", *(run / "CFD/0").glob("*")]
    words = list_words([path.read_text(encoding="utf-8", errors="replace") for path in decks if path.is_file()])
    return words | _ONE_VELOCITY


def _flush(path: Path) -> None:
    """Bring a file or folder to the disk; a write that failed unseen is told here.

    A file system that cannot do that with a folder (CIFS, some of FUSE) brings its names to the disk in its own time.
    """
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno not in _NO_FOLDER_SYNC or not stat.S_ISDIR(os.fstat(number).st_mode):
            raise
    finally:
        os.close(number)
