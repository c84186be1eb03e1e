"""One archive for a bug report: what is installed, and of a run its case, decks, manifest and logs; no results.

Passwords and keys stay at home: of the environment only what the solvers and MPI read is taken, and what looks like a
secret, or is the value of a variable that is called one, is masked in every text. The size is bounded.
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
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path

from fbcouple import __version__
from fbcouple.doctor import Row
from fbcouple.errors import CaseError, SolverError
from fbcouple.places import cache_folder
from fbcouple.unexpected import LAST_ERROR

LARGEST_FILE = 1_000_000
"""Bytes of a file that are taken; of a longer one its beginning and its end."""
LARGEST = 20_000_000
"""Bytes of all of them together, before they are compressed."""
MOST_LISTED = 10_000
_BEGINNING = 100_000
_MASK = "***"
_SHORTEST_SECRET = 6
_ENVIRONMENT = re.compile(
    r"(OMPI|PMIX|PRTE|FOAM|WM|SLURM|PBS|LSB|OMP|NUMBA|FBCOUPLE|LC)_\w+|PATH|LD_LIBRARY_PATH|PYTHONPATH|LANG|SHELL"
)
_SECRET_NAME = re.compile(r"(?i)key|token|secret|passw|passphrase|credential|cookie|auth")
_SECRET_TEXT = re.compile(
    rb"(?i)((?:password|passwd|passphrase|secret|token|api[_-]?key)[\"']?\s*[=:]\s*[\"']?)[^\s\"',;]+"
    rb"|(://[^/\s:@]+:)[^/\s@]+(?=@)"
)
# Of a run folder, what matters most first.
_PARTS = (
    "case.toml",
    "manifest.json",
    "logs/failure.json",
    "logs/*",
    "grains/in.grains",
    "fluid/system/*",
    "fluid/constant/*",
    "fluid/0/*",
    "checkpoints/*/index.json",
    "batch/*",
    "*.py",
    "*.csv",
)


def write_bundle(rows: list[Row], run: Path | None, folder: Path) -> Path:
    """Write the archive into `folder`, with the doctor's `rows` and what describes `run`; returns its place.

    Raises: CaseError if `run` is no run folder, SolverError if the disk does not take the archive.
    """
    if run and not (run / "case.toml").is_file():
        raise CaseError([f"{run}: is not a run folder (no case.toml)."])
    moment = time.strftime("%Y%m%d-%H%M%S", time.gmtime())
    name = f"fbcouple-bundle-{run.resolve().name + '-' if run else ''}{moment}"
    place, unfinished = folder / f"{name}.tar.gz", folder / f".{name}.part"
    texts = {"about.json": _describe(rows), "environment.txt": list_environment(os.environ)}
    try:
        texts |= _read_last_error() | (_read_run(run) if run else {})
        with tarfile.open(unfinished, "w:gz") as archive:
            for file, content in texts.items():
                masked = mask(content, os.environ)
                about = tarfile.TarInfo(f"{name}/{file}")
                about.size, about.mtime = len(masked), int(time.time())
                archive.addfile(about, io.BytesIO(masked))
        unfinished.replace(place)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise SolverError(f"{place}: cannot be written: {error}") from error
    return place


def list_environment(variables: Mapping[str, str]) -> bytes:
    """The variables that solvers, MPI and batch systems read, a line each, but none that is called a secret."""
    told = {
        name: value
        for name, value in variables.items()
        if _ENVIRONMENT.fullmatch(name) and not _SECRET_NAME.search(name)
    }
    return "".join(f"{name}={value}\n" for name, value in sorted(told.items())).encode(errors="surrogateescape")


def mask(content: bytes, variables: Mapping[str, str]) -> bytes:
    """`content` without what looks like a secret, or is the value of a variable that is called one."""
    for name, value in variables.items():
        if _SECRET_NAME.search(name) and len(value) >= _SHORTEST_SECRET:
            content = content.replace(os.fsencode(value), _MASK.encode())
    return _SECRET_TEXT.sub(lambda found: (found[1] or found[2]) + _MASK.encode(), content)


def _describe(rows: list[Row]) -> bytes:
    wanted = importlib.metadata.requires("fbcouple") or []
    names = [found[0] for line in wanted if "extra ==" not in line and (found := re.match(r"[\w.-]+", line))]
    about = {
        "fbcouple": __version__,
        "python": platform.python_version(),
        "system": platform.platform(),
        "cores": os.cpu_count(),
        "packages": {name: importlib.metadata.version(name) for name in names},
        "doctor": [asdict(row) for row in rows],
    }
    return (json.dumps(about, indent=1) + "\n").encode()


def _read_last_error() -> dict[str, bytes]:
    """The traceback of the last unexpected error, if one was kept."""
    place = cache_folder() / LAST_ERROR
    return {LAST_ERROR: _read(place)} if place.is_file() else {}


def _read_run(run: Path) -> dict[str, bytes]:
    """Name in the archive -> content; a file that found no room any more is named in left-out.txt."""
    texts = {"files.txt": "".join(_list_files(run)).encode(errors="surrogateescape")}
    room = LARGEST
    left_out = []
    for path in _find_files(run):
        name = f"run/{path.relative_to(run)}"
        if min(path.stat().st_size, LARGEST_FILE) > room:
            left_out.append(f"{name}\n")
        elif name not in texts:
            texts[name] = _read(path)
            room -= len(texts[name])
    if left_out:
        texts["left-out.txt"] = "".join(left_out).encode(errors="surrogateescape")
    return texts


def _find_files(run: Path) -> Iterator[Path]:
    """Plain files inside the run folder: it may come from anybody, and no link leads out of it."""
    here = run.resolve()
    for part in _PARTS:
        for path in sorted(run.glob(part)):
            if path.is_file() and path.resolve() == here / path.relative_to(run):
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


def _list_files(run: Path) -> Iterator[str]:
    """Size, time and name of every file in the run folder."""
    for number, path in enumerate(sorted(run.rglob("*"))):
        if number == MOST_LISTED:
            yield "[... and more]\n"
            return
        about = path.lstat()
        moment = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(about.st_mtime))
        yield f"{about.st_size:>14} {moment} {path.relative_to(run)}{'/' if path.is_dir() else ''}\n"
