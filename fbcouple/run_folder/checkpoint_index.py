"""What a checkpoint may hold, and whether it holds it: its index, the names of its files, and their sums.

A checkpoint may come from anybody, and what its index lists is then no less foreign than what it does not. A solver
reads of it only files of the names below; fields of the gas hold numbers and known words only. LIGGGHTS' restart file
cannot be looked at like that: the index is signed with a key of this user, and what has not his signature is another's.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fbcouple.case.problems import show
from fbcouple.errors import CaseError
from fbcouple.geometry.saved_fields import Words, require_known_words
from fbcouple.machine.own_key import is_own, sign
from fbcouple.run_folder.manifest import hash_file, hash_text

FORMAT = 4
NAME = "index.json"
LARGEST = 200_000_000
"""Bytes that an index may have."""
_FOLDER = re.compile(r"step-(\d{12})")
_OWN_FILES = re.compile(r"state\.json|history\.jsonl|snapshots\.npz|exits\.npz|liggghts\.restart")
_TASK_FILES = re.compile(r"task-[A-Za-z0-9][\w-]*(\.\w+)?", re.ASCII)
"""What files of tasks that a case brings are called."""
_CELLS = re.compile(r"cells-(\d{4,6})\.npz")
_TIME = r"\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_FIELD = re.compile(
    rf"CFD/(?:processor(\d{{1,6}})/)?({_TIME})/([A-Za-z]\w*|uniform/time|expressions/exprResultGlobals)"
)
_CHECKSUM = re.compile(r"[0-9a-f]{64}")
_KINDS = {"step": int, "time": float, "ranks": int, "case": dict, "inputs": dict, "made_by": dict, "updates": list}
_MOST_NAMED = 3


@dataclass(frozen=True)
class Index:
    """What the index of a checkpoint says."""

    step: int
    time: float
    """Simulated time [s]."""
    ranks: int
    case: dict[str, Any]
    """Option -> value, all that matter to what the run computes."""
    inputs: dict[str, str]
    """File that the run reads beside decks and checkpoint -> its SHA-256."""
    made_by: dict[str, str]
    """Program or library -> version."""
    updates: list[str] = field(default_factory=list)
    """With what else the run went on before, a line each."""
    files: dict[str, tuple[int, str]] = field(default_factory=dict)
    """File, named from the checkpoint's folder -> size and SHA-256."""
    moment_steps: int | None = None
    """Coupling steps between two moments for a checkpoint; None: it does not say."""
    own: bool = False
    """Did this user write it, by its signature?"""


def is_name(name: str) -> bool:
    """Is this how the folder of a checkpoint is called?"""
    return _FOLDER.fullmatch(name) is not None


def name_folder(step: int) -> str:
    """How the folder of the checkpoint of `step` is called."""
    return f"step-{step:012d}"


def require_task_names(folder: Path, files: Collection[str]) -> None:
    """Raise CaseError (one text) unless the checkpoint in `folder` can be read again with its `files`: tasks that a
    case brings name those of theirs, and list all that they wrote."""
    for name in files:
        if not any(kind.fullmatch(name) for kind in (_CELLS, _FIELD, _OWN_FILES, _TASK_FILES)):
            words = "call it task-NAME with letters, digits, - and _, as task-probe.npz"
            raise CaseError([f"a task writes {show(name)}, which is no name for a file of a task; {words}"])
    for name in sorted(_list_files(folder) - set(files)):
        raise CaseError([f"a task wrote {show(name)} and does not list it; return Saved(files=[{show(name)}])"])


def write_index(folder: Path, about: dict[str, Any], files: dict[str, tuple[int, str]]) -> Path:
    """Write the index of the checkpoint in `folder`, with a checksum of its own and this user's signature, and return
    its place."""
    text = json.dumps({"format": FORMAT, **about, "files": files}, indent=1)
    (folder / NAME).write_text(
        json.dumps({"sha256": hash_text(text), "signature": sign(text), "index": text}), encoding="utf-8"
    )
    return folder / NAME


def read_index(folder: Path) -> Index:
    """The index of the checkpoint in `folder`; nothing is said of the files.

    Raises: CaseError (one text, without the folder) if there is none, or it is damaged or nothing that is written here.
    """
    path = folder / NAME
    if not path.is_file():
        raise CaseError([f"{NAME} is missing"])
    told, own = _parse(path)
    if told.get("format") != FORMAT:
        raise CaseError([f"format {show(told.get('format'))}, this fbcouple reads {FORMAT}"])
    if not all(isinstance(told.get(key), kind) and not isinstance(told[key], bool) for key, kind in _KINDS.items()):
        raise CaseError([f"{NAME} does not say what an index says"])
    texts = [*told["updates"], *told["inputs"].values(), *told["made_by"].values()]
    files = told.get("files")
    if (
        not all(isinstance(text, str) for text in texts)
        or not isinstance(files, dict)
        or not all(_is_sum(entry) for entry in files.values())
    ):
        raise CaseError([f"{NAME} does not say what it was made of, by its files"])
    steps = told.get("moment_steps")
    index = Index(
        **{key: told[key] for key in _KINDS},
        files={n: tuple(entry) for n, entry in files.items()},
        moment_steps=steps if type(steps) is int else None,
        own=own,
    )
    if name_folder(index.step) != folder.name or not 0.0 < index.time < math.inf:
        raise CaseError([f"{NAME} is of step {index.step} at t = {index.time!r} s"])
    _require_own_names(index)
    return index


def _parse(path: Path) -> tuple[dict[str, Any], bool]:
    """What the index in `path` says, and whether this user wrote it."""
    try:
        outer = json.loads(path.read_bytes()) if path.stat().st_size <= LARGEST else {}
        text = outer["index"]
        inner = json.loads(text) if outer["sha256"] == hash_text(text) else None
        own = is_own(text, outer.get("signature"))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        inner = None
    if not isinstance(inner, dict):
        raise CaseError([f"{NAME} is damaged"])
    return inner, own


def _is_sum(entry: Any) -> bool:
    kinds = isinstance(entry, list) and [type(part) for part in entry] == [int, str]
    return kinds and entry[0] >= 0 and _CHECKSUM.fullmatch(entry[1]) is not None


def _require_own_names(index: Index) -> None:
    """Raise CaseError unless the files are of the names that are written here, and as many as there were ranks."""
    cells, parts, times = set(), set(), set()
    for name in index.files:
        if numbered := _CELLS.fullmatch(name):
            cells.add(int(numbered[1]))
        elif saved := _FIELD.fullmatch(name):
            parts.add(saved[1] and int(saved[1]))
            times.add(saved[2])
        elif not (_OWN_FILES.fullmatch(name) or _TASK_FILES.fullmatch(name)):
            raise CaseError([f"{show(name)} is in it, which no checkpoint has"])
    every = set(range(index.ranks)) if index.ranks <= len(index.files) else {-1}
    if cells != every or parts not in (set(), every if index.ranks > 1 else {None}):
        raise CaseError([f"{NAME} says {index.ranks} ranks, and there are files of {len(cells)}"])
    if len(times) > 1 or not all(0.0 < float(time) < math.inf for time in times):
        raise CaseError([f"its fields are of the times {', '.join(sorted(times)[:_MOST_NAMED])}"])


def _list_files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()}


def require_whole(folder: Path, index: Index, words: Words) -> None:
    """Raise CaseError (one text, without the folder) unless all files that `index` lists, and no others, are in
    `folder` as they were written; `words` are those that fields of the gas may have."""
    there = _list_files(folder)
    for name in sorted(there - {NAME, *index.files}):
        raise CaseError([f"{show(name)} is in it, which it was not written with; remove it"])
    for name, (size, checksum) in index.files.items():
        path = folder / name
        if name not in there or not path.is_file():
            raise CaseError([f"{name} is missing"])
        if path.stat().st_size != size:
            raise CaseError([f"{name} has {path.stat().st_size} bytes, {size} were written"])
        if hash_file(path) != checksum:
            raise CaseError([f"{name} is damaged (checksum)"])
        if _FIELD.fullmatch(name):
            _require_field(path, name, words)


def _require_field(path: Path, name: str, words: Words) -> None:
    try:
        require_known_words(path, words)
    except CaseError as error:
        raise CaseError([f"{name} {error}"]) from None
