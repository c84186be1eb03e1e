"""One archive for a bug report: what is installed, and of a run its case, decks, manifest and logs; no results.

Only known files are taken, and of them and of the environment only what is known to be harmless (`disclosure`): a file
of the user's own, such as a drag law or start positions, stays at home. The size is bounded.
"""

from __future__ import annotations

import importlib.metadata
import io
import json
import os
import platform
import re
import tarfile
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from fbcouple.decks.render import DECKS
from fbcouple.doctor.checks import Row
from fbcouple.doctor.disclosure import Vocabulary, list_environment, mask_values
from fbcouple.errors import CaseError, SolverError
from fbcouple.machine.unexpected import LAST_ERROR
from fbcouple.machine.whole_files import replacing
from fbcouple.paths import cache_folder
from fbcouple.solvers.versions import find_commit
from fbcouple.version import __version__

LARGEST_FILE = 1_000_000
"""Bytes of a file that are taken; of a longer one its beginning and its end."""
LARGEST = 20_000_000
"""Bytes of all of them together, before they are compressed."""
MOST_LISTED = 10_000
_BEGINNING = 100_000
# Of a run folder, what matters most first.
_PARTS = (
    "case.toml",
    "manifest.json",
    "logs/failure.json",
    "logs/launcher.log",
    "logs/openfoam.log",
    "logs/liggghts.log",
    "logs/mesh.log",
    "logs/run.jsonl",
    *DECKS,
    "checkpoints/step-*/index.json",
    "batch/state",
)
_CHECKPOINT = re.compile(r"step-\d{1,12}")
_MPI_MESSAGES = Path("/usr/share/openmpi")


def write_bundle(rows: list[Row], run: Path | None, folder: Path) -> Path:
    """Write the archive into `folder`, with the doctor's `rows` and what describes `run`; returns its place.

    Raises: CaseError if `run` is no run folder, SolverError if the disk does not take the archive.
    """
    if run and not (run / "case.toml").is_file():
        raise CaseError([f"{run}: is not a run folder (no case.toml)."])
    moment = time.strftime("%Y%m%d-%H%M%S", time.gmtime())
    name = f"fbcouple-bundle-{run.resolve().name + '-' if run else ''}{moment}"
    path = folder / f"{name}.tar.gz"
    vocabulary = Vocabulary([*_find_messages(rows), *sorted(_MPI_MESSAGES.glob("help-*.txt"))])
    try:
        texts = {"about.json": _describe(rows, vocabulary), "environment.txt": list_environment(os.environ)}
        texts |= _read_last_error(vocabulary) | (_read_run(run, vocabulary) if run else {})
        with replacing(path) as fresh, tarfile.open(fresh, "w:gz") as archive:
            for file, text in texts.items():
                content = mask_values(text, os.environ).encode("utf-8", "backslashreplace")
                about = tarfile.TarInfo(f"{name}/{file}")
                about.size, about.mtime = len(content), int(time.time())
                archive.addfile(about, io.BytesIO(content))
    except OSError as error:
        raise SolverError(f"{path}: cannot be written: {error}") from error
    return path


def _find_messages(rows: list[Row]) -> Iterator[Path]:
    """The libraries and programs that the doctor has found."""
    for row in rows:
        if row.found.startswith("/") and (path := Path(row.found.split(",")[0])).is_file():
            yield path


def _describe(rows: list[Row], vocabulary: Vocabulary) -> str:
    wanted = importlib.metadata.requires("fbcouple") or []
    names = [found[0] for line in wanted if "extra ==" not in line and (found := re.match(r"[\w.-]+", line))]
    about = {
        "fbcouple": __version__,
        "commit": find_commit(),
        "python": platform.python_version(),
        "system": platform.platform(),
        "cores": os.cpu_count(),
        "packages": {name: importlib.metadata.version(name) for name in names},
        "doctor": [asdict(row) | {"found": vocabulary.filter(row.found).rstrip("\n")} for row in rows],
    }
    return json.dumps(about, indent=1) + "\n"


def _read_last_error(vocabulary: Vocabulary) -> dict[str, str]:
    """The traceback of the last unexpected error, if one was kept."""
    path = cache_folder() / LAST_ERROR
    return {LAST_ERROR: vocabulary.filter(_read(path).decode("utf-8", "replace"))} if path.is_file() else {}


def _read_run(run: Path, vocabulary: Vocabulary) -> dict[str, str]:
    """Name in the archive -> text; a file that found no room any more is named in left-out.txt."""
    texts = {"files.txt": "".join(_list_files(run, vocabulary))}
    room = LARGEST
    left_out = []
    for path in _find_files(run):
        name = f"run/{path.relative_to(run)}"
        if min(path.stat().st_size, LARGEST_FILE) > room:
            left_out.append(f"{name}\n")
        elif name not in texts:
            texts[name] = vocabulary.filter(_read(path).decode("utf-8", "replace"))
            room -= len(texts[name])
    if left_out:
        texts["left-out.txt"] = "".join(left_out)
    return texts


def _find_files(run: Path) -> Iterator[Path]:
    """Plain files inside the run folder: it may come from anybody, and no link leads out of it."""
    here = run.resolve()
    for part in _PARTS:
        for path in sorted(run.glob(part)):
            inside = path.relative_to(run)
            is_known = inside.parts[0] != "checkpoints" or _CHECKPOINT.fullmatch(inside.parts[1])
            if is_known and path.is_file() and path.resolve() == here / inside:
                yield path


def _read(path: Path) -> bytes:
    size = path.stat().st_size
    with path.open("rb") as file:
        if size <= LARGEST_FILE:
            return file.read(LARGEST_FILE)
        beginning = file.read(_BEGINNING)
        end = LARGEST_FILE - _BEGINNING - 100
        file.seek(size - end)
        return beginning + f"\n[... {size - _BEGINNING - end} bytes are left out ...]\n".encode() + file.read(end)


def _list_files(run: Path, vocabulary: Vocabulary) -> Iterator[str]:
    """Size, time and name of every file in the run folder; of a name that is not known, its ending at most."""
    for number, path in enumerate(sorted(run.rglob("*"))):
        if number == MOST_LISTED:
            yield "[... and more]\n"
            return
        about = path.lstat()
        moment = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(about.st_mtime))
        name = "/".join(map(vocabulary.filter_name, path.relative_to(run).parts))
        yield f"{about.st_size:>14} {moment} {name}{'/' if path.is_dir() else ''}\n"
