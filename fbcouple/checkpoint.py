"""A checkpoint on disk: a folder that is whole or not there, with a checksum of everything in it.

checkpoints/step-000001200/   index.json       step, time, ranks, case, size and SHA-256 of every other file
                              state.json       clock, cadences, counts; history.jsonl, snapshots.npz
                              cells-0000.npz   sums of rank 0's cells, one file a rank
                              grains.restart   LIGGGHTS' own
                              fluid/           OpenFOAM's own time directories
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fbcouple.case.options import list_options
from fbcouple.case.schema import Case
from fbcouple.case.section import as_tuple
from fbcouple.errors import CaseError

FOLDER = "checkpoints"
REFUSED = ".refused"
_FORMAT = 2
_KEPT = 2
_CHUNK = 1 << 20
_UNFINISHED = ".unfinished-"
# Options that came after checkpoints did: where they stand at their default, older checkpoints stand.
_YOUNGER = (
    "accuracy",
    "gas.top",
    "contact.skin",
    "exchange.accelerated",
    "output.particles_every",
    "output.tracked",
    *(f"domain.{key}" for key in ("shape", "elements", "mesh", "scale", "inlet", "outlet")),
)

Sums = dict[str, tuple[int, str]]
"""File, named from the checkpoint's folder -> size and SHA-256."""


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint that was found to be whole and of this case."""

    folder: Path
    step: int
    time: float
    """Simulated time [s]."""
    ranks: int


def fingerprint(case: Case, with_end: bool = False) -> str:
    """What must not change between a checkpoint and the run that goes on from it: all but how often files are saved
    and what ends a run. Checkpoints once told its end too (`with_end`)."""
    told = case.model_dump(mode="json", exclude={"checkpoint": True, "monitors": True, "output": {"save_every"}})
    if not with_end:
        del told["end_time"]
    for dotted in _YOUNGER:
        *section, key = dotted.split(".")
        table = told[section[0]] if section else told
        if table and as_tuple(table[key]) == list_options()[dotted].default:
            del table[key]
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def begin(run: Path, step: int) -> Path:
    """An empty folder for the checkpoint of `step`; what an earlier attempt left is removed."""
    for rest in (run / FOLDER).glob(f"{_UNFINISHED}*"):
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
                sums[str(path.relative_to(folder))] = path.stat().st_size, _hash(path)
        _flush(top)
    return sums


def finish(folder: Path, about: dict[str, Any], sums: Sums) -> Path:
    """Make the checkpoint in `folder` valid: index, then its name; only the newest two stay. Returns its place."""
    text = json.dumps({"format": _FORMAT, **about, "files": sums}, indent=1)
    (folder / "index.json").write_text(json.dumps({"sha256": _hash_text(text), "index": text}), encoding="utf-8")
    _flush(folder / "index.json")
    _flush(folder)
    place = folder.parent / f"step-{about['step']:012d}"
    if place.exists():
        shutil.rmtree(place)
    folder.rename(place)
    _flush(place.parent)
    for old in list_checkpoints(place.parents[1])[_KEPT:]:
        # Renamed first: a removal that is cut short leaves nothing that looks like a checkpoint.
        shutil.rmtree(old.rename(old.with_name(f"{_UNFINISHED}{old.name}")))
    return place


def list_checkpoints(run: Path) -> list[Path]:
    """Folders of the checkpoints of `run`, the newest first; nothing is said of what is in them."""
    return sorted((p for p in (run / FOLDER).glob("step-*") if p.suffix != REFUSED), reverse=True)


def word_newest(run: Path) -> str:
    """Say what a run that failed goes on from."""
    found = list_checkpoints(run)
    return f"{found[0]} stands, --resume goes on from it" if found else "there is no checkpoint before it"


def abandon(run: Path) -> None:
    """Remove what is there of a checkpoint that could not be finished, so that it takes no room."""
    for rest in (run / FOLDER).glob(f"{_UNFINISHED}*"):
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
    """Check every file of the checkpoint in `folder`; raises CaseError with its name and what is wrong with it."""
    index = _read_index(folder)
    if index["format"] != _FORMAT:
        raise CaseError([f"{folder}: refused: format {index['format']}, this fbcouple reads {_FORMAT}"])
    if index["case"] not in (fingerprint(case), fingerprint(case, with_end=True)):
        raise CaseError([f"{folder}: refused: it is of another case than the case.toml of the run"])
    for name, (size, checksum) in index["files"].items():
        path = folder / name
        if not path.is_file():
            raise CaseError([f"{folder}: refused: {name} is missing"])
        if path.stat().st_size != size:
            raise CaseError([f"{folder}: refused: {name} has {path.stat().st_size} bytes, {size} were written"])
        if _hash(path) != checksum:
            raise CaseError([f"{folder}: refused: {name} is damaged (checksum)"])
    return Checkpoint(folder, index["step"], index["time"], index["ranks"])


def _read_index(folder: Path) -> dict[str, Any]:
    try:
        outer = json.loads((folder / "index.json").read_bytes())
        text = outer["index"]
        if outer["sha256"] == _hash_text(text):
            return json.loads(text)
    except FileNotFoundError:
        raise CaseError([f"{folder}: refused: index.json is missing"]) from None
    except (ValueError, KeyError, TypeError):
        pass
    raise CaseError([f"{folder}: refused: index.json is damaged"])


def _flush(path: Path) -> None:
    """Bring a file or folder to the disk; a write that failed unseen is told here."""
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _hash(path: Path) -> str:
    digest = hashlib.sha256()
    for chunk in _read_chunks(path):
        digest.update(chunk)
    return digest.hexdigest()


def _hash_text(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _read_chunks(path: Path) -> Iterator[bytes]:
    with path.open("rb") as file:
        while chunk := file.read(_CHUNK):
            yield chunk
