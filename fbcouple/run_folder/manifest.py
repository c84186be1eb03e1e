"""manifest.json: what set-up wrote into a run folder, with its hashes, and how the run was started, with what."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import write_whole
from fbcouple.run_folder.plain_files import format_path

NAME = "manifest.json"
LARGEST = 50_000_000
"""Bytes that a manifest may have."""
_PARTS = {"fbcouple": str, "files": dict, "case": dict}
"""What a manifest of fbcouple has at least."""


def read_manifest(run: Path) -> dict[str, Any]:
    """The manifest of the run folder `run`: `files` (name -> SHA-256), `case` (option -> value as set up),
    `replaced` (SHA-256 of files that a set-up under way writes over), and more.

    Raises: CaseError if there is none, or it is another program's.
    """
    path = run / NAME
    if not path.is_file():
        text = "is not a run folder; make one with: fbcouple setup CASE -o"
        raise CaseError([f"{format_path(run)}: {text} {format_path(run)}"])
    try:
        content = json.loads(path.read_bytes()) if path.stat().st_size <= LARGEST else None
    except (OSError, ValueError, RecursionError):
        content = None
    if not isinstance(content, dict) or not all(isinstance(content.get(part), kind) for part, kind in _PARTS.items()):
        text = "was not written by this version of fbcouple, or is damaged; set up another folder with -o"
        raise CaseError([f"{format_path(path)}: {text}, or read what is in this one and remove it."])
    if not all(isinstance(checksum, str) and _is_inside(name) for name, checksum in content["files"].items()):
        raise CaseError(
            [f"{format_path(path)}: `files` holds what is no file of the run folder; set up another folder."]
        )
    content.setdefault("replaced", [])
    if not _are_changes(content.get("inlet_changes", [])):
        raise CaseError([f"{format_path(path)}: `inlet_changes` is no list of times and texts; set up another folder."])
    if not isinstance(content["replaced"], list):
        raise CaseError([f"{format_path(path)}: `replaced` is no list; set up another folder."])
    return content


def _are_changes(value: Any) -> bool:
    """Tables of a `time` and what the `inlet` was changed to then."""
    return isinstance(value, list) and all(
        isinstance(change, dict)
        and isinstance(change.get("time"), int | float)
        and isinstance(change.get("inlet"), str)
        for change in value
    )


def _is_inside(name: str) -> bool:
    parts = name.split("/")
    return name.isprintable() and all(part not in ("", ".", "..") for part in parts)


def write_manifest(run: Path, content: dict[str, Any]) -> None:
    """Replace the manifest of `run`, all of it or nothing. Raises: OSError."""
    write_whole(run / NAME, json.dumps(content, indent=2) + "\n")


def hash_file(path: Path) -> str:
    """SHA-256 of the file `path`, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def hash_text(text: str) -> str:
    """SHA-256 of `text` as UTF-8, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()
