"""The file polyMesh/boundary: of each patch its name, its type, and where its faces are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.geometry.foam_text import LARGEST_BOUNDARY, read_body, strip_comments
from fbcouple.geometry.polymesh import Patches

_REPEATED = ("cyclic", "cyclicAMI", "cyclicACMI", "empty", "wedge", "processor", "symmetry", "symmetryPlane")
# A quoted text, one of `{};`, or a word: whatever else stands together, as OpenFOAM's words do (inlet(1), Zulauf_ö).
_TOKEN = re.compile(r'"[^"]*"?|[{};]|[^\s"{};]+')
_SHOWN = 60


def read_patches(path: Path) -> Patches:
    """The patches of a boundary file in their order.

    Raises: CaseError (one text) if it is not text, or has anything but plain patches.
    """
    try:
        text = strip_comments(read_body(path, LARGEST_BOUNDARY).decode())
    except UnicodeDecodeError:
        raise CaseError([f"{path.name} is not UTF-8 text; rename its patches, or write the file in UTF-8."]) from None
    start, end = text.find("("), text.rfind(")")
    if not 0 <= start < end:
        raise CaseError([f"{path.name} has no list of patches in brackets; write the mesh again."])
    tokens = iter(_TOKEN.findall(text, start + 1, end))
    patches: Patches = {}
    for word in tokens:
        entries, name = _read_entries(path, word, tokens), word.strip('"')
        if name in patches:
            raise CaseError([f"{path.name} has two patches of the name {_shorten(name)}; rename one."])
        patches[name] = _find_range(path, name, entries)
        kind = entries.get("type", "")
        if kind in _REPEATED and patches[name][1]:
            text = f"patch {_shorten(name)} is of the type {kind}, `patch` and `wall` are allowed"
            raise CaseError([f"{path.name}: {text}; change it in the mesher."])
    return patches


def _read_entries(path: Path, name: str, tokens: Iterator[str]) -> dict[str, str]:
    """The entries up to the `}` that ends the patch `name`; dictionaries inside it are passed over."""
    if name.startswith(("#", "$")):
        text = f"{path.name} has `{_shorten(name)}`: directives and macros are not run"
        raise CaseError([f"{text}; write the patches out."])
    if name in ("{", "}", ";") or (name.startswith('"') and not name[1:].endswith('"')) or next(tokens, "") != "{":
        raise CaseError([f"{path.name}: `{_shorten(name)}` is where a patch `name {{ ... }}` is expected; fix it."])
    entries: dict[str, str] = {}
    words: list[str] = []
    depth = 1
    for token in tokens:
        depth += {"{": 1, "}": -1}.get(token, 0)
        if depth == 0:
            return entries
        if token.startswith(("#", "$")):
            text = f"{path.name}: patch {_shorten(name)} has `{_shorten(token)}`: directives and macros are not run"
            raise CaseError([f"{text}; write its entries out."])
        if token in ("{", "}", ";"):
            if depth == 1 and token == ";" and words:
                entries[words[0]] = " ".join(words[1:])
            words = []
        else:
            words.append(token)
    raise CaseError([f"{path.name}: patch {_shorten(name)} has no closing brace; fix it."])


def _find_range(path: Path, name: str, entries: dict[str, str]) -> tuple[int, int]:
    try:
        first, count = (int(entries[key]) for key in ("startFace", "nFaces"))
    except (KeyError, ValueError):
        raise CaseError([f"{path.name}: patch {_shorten(name)} has no startFace and nFaces; fix it."]) from None
    return first, count


def _shorten(word: str) -> str:
    return word if len(word) <= _SHOWN else f"{word[:_SHOWN]}..."
