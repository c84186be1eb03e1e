"""Put a run folder that was set up beside its place into its place, over an earlier set-up, and over nothing else."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from fbcouple.case.source import FILE_NAME
from fbcouple.errors import CaseError
from fbcouple.run_folder.checkpoint import list_checkpoints
from fbcouple.run_folder.lock import hold
from fbcouple.run_folder.manifest import NAME, hash_file, read_manifest, write_manifest
from fbcouple.run_folder.plain_files import format_path, require_plain

_RENDERED = ("CFD", "DEM")
"""Folders whose files follow from the case; those that lie elsewhere are the user's, copied."""


def refuse_foreign(run: Path) -> None:
    """Raise CaseError unless `run` is free or holds an earlier set-up without results."""
    if not run.exists() and not run.is_symlink():
        return
    if not run.is_dir():
        raise CaseError([f"{format_path(run)}: is not a run folder of fbcouple; give another folder with -o"])
    require_plain(run)
    traces = [name for name in ("results.nc", "logs/run.jsonl") if (run / name).exists()]
    traces += [str(folder.relative_to(run)) for folder in list_checkpoints(run)]
    if traces:
        raise CaseError(
            [f"{format_path(run)}: holds a run ({traces[0]}); give another folder with -o, or remove it first"]
        )
    _read_files(run)


def _read_files(run: Path) -> tuple[dict[str, str], list[str]]:
    """What an earlier set-up wrote into `run`: file -> SHA-256; and, where it was cut short, the SHA-256 of what one
    before it had written."""
    if (run / NAME).exists():
        manifest = read_manifest(run)
        return manifest["files"], manifest["replaced"]
    if any(path.name != "lock" for path in run.iterdir()):
        raise CaseError([f"{format_path(run)}: is not a run folder of fbcouple; give another folder with -o"])
    return {}, []


def put_in_place(fresh: Path, run: Path, manifest: dict[str, Any], source: Path | None) -> None:
    """Move the files of `manifest` and the manifest from `fresh` to `run`, and remove those that an earlier set-up
    wrote and this one does not. Cut short, it can be done again. `source`: folder that the case came from.

    Raises: CaseError, before anything is changed, if a run is under way in it, or a file would be lost that no set-up
    wrote, or that was changed since.
    """
    if not run.exists():
        fresh.rename(run)
        return
    with hold(run):
        refuse_foreign(run)
        (old, replaced), new = _read_files(run), manifest["files"]
        known = [*replaced, *old.values()]
        _refuse_losses(run, (old, known), new, source is not None and source.resolve() == run)
        write_manifest(run, manifest | {"files": old | new, "replaced": sorted(set(known))})
        for name in new:
            (run / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(fresh / name, run / name)
        for name in old.keys() - new.keys():
            _remove_own(run, name, old[name])
        (run / "logs").mkdir(exist_ok=True)
        write_manifest(run, manifest)


def _refuse_losses(run: Path, written: tuple[dict[str, str], list[str]], new: dict[str, str], in_place: bool) -> None:
    """Raise CaseError if a file of the user would be overwritten by another; `written`: files and checksums that
    set-ups wrote; `in_place`: the case lies in `run`."""
    old, known = written
    problems = []
    for name, checksum in new.items():
        path = run / name
        if path.is_dir():
            problems.append(f"{format_path(path)}: is a folder, and a file of that name is to be written")
        if not path.is_file() or (name == FILE_NAME and in_place) or (name in old and _is_rendered(name)):
            continue
        if hash_file(path) not in (checksum, *(known if name in old else ())):
            what = "was changed since set-up" if name in old else "is no file that fbcouple wrote"
            problems.append(f"{format_path(path)}: {what} and would be replaced")
    if problems:
        raise CaseError([f"{problem}; move it elsewhere, or give another folder with -o." for problem in problems])


def _is_rendered(name: str) -> bool:
    return name.partition("/")[0] in _RENDERED


def _remove_own(run: Path, name: str, checksum: str) -> None:
    """Remove what an earlier set-up wrote, unless it is the user's own and was changed since, and folders that are
    empty then."""
    path = run / name
    if path.is_file() and (_is_rendered(name) or hash_file(path) == checksum):
        path.unlink()
    for folder in path.relative_to(run).parents[:-1]:
        with suppress(OSError):
            (run / folder).rmdir()
