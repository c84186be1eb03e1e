"""Fields that OpenFOAM saved, looked at before OpenFOAM reads them again: numbers, and words that are known.

OpenFOAM runs what `#codeStream`, `#calc` or a coded boundary condition in a field says, loads `libs`, and includes
other files. A saved field repeats the boundary conditions of the decks, so besides numbers it has their words and a
few of OpenFOAM's own.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.geometry.block import CYCLIC

_TOKEN = re.compile(rb'\s+|[{}()\[\];]|"[^"\n]*"|[^\s{}()\[\];"]+')
_COMMENT = re.compile(rb"//[^\n]*|/\*.*?\*/", re.DOTALL)
_RULE = re.compile(rb"// (\* )+//|// \*+ //")
_COUNT = re.compile(rb"\s*(\d{1,18})\s*")
_BYTES = {b"List<scalar>": 8, b"List<vector>": 24, b"List<symmTensor>": 48, b"List<tensor>": 72}
"""Bytes of an entry of a list in binary."""
_NUMBER = re.compile(rb"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_QUOTED = re.compile(rb'"(LSB;label=(32|64);scalar=64|[\d.e+-]+(/(uniform|expressions))?)"')
_PATCH = re.compile(rb"procBoundary\d+to\d+(through\w+)?|outlet\d+")
_WORDS = frozenset(
    b"FoamFile version format ascii binary class arch location object dictionary time value name index deltaT deltaT0 "
    b"dimensions oriented internalField boundaryField uniform nonuniform List<scalar> List<vector> List<symmTensor> "
    b"List<tensor> volScalarField volVectorField surfaceScalarField surfaceVectorField type calculated processor "
    b"processorCyclic cyclic variables".split()
) | {name.encode() for pair in CYCLIC.values() for name in pair}
Words = Collection[bytes]


def require_known_words(path: Path, known: Words) -> None:
    """Raise CaseError (one text, without the path) if the field in the file `path` holds another word than those of
    `known` and what OpenFOAM writes into every field."""
    for token in _list_tokens(path.read_bytes()):
        if token in _WORDS or token in known or token == path.name.encode():
            continue
        if not (_NUMBER.fullmatch(token) or _QUOTED.fullmatch(token) or _PATCH.fullmatch(token)):
            raise CaseError(
                [f"holds {token[:60].decode(errors='replace')!r}, which is in no field that fbcouple saves"]
            )


def list_words(texts: Collection[str]) -> set[bytes]:
    """The words of decks, quoted ones whole, without those of comments."""
    return {token for text in texts for token in _TOKEN.findall(_COMMENT.sub(b" ", text.encode()))}


def _list_tokens(content: bytes) -> Iterator[bytes]:
    """Words of a field file in their order, without brackets, the banner at the top, rules of stars, and the numbers of
    binary lists.

    Raises: CaseError where a list is not as long as it says, or binary though the file does not say so.
    """
    offset = content.find(b"*/", 2) + 2 if content.startswith(b"/*") else 0
    words: list[bytes] = []
    while offset < len(content):
        found = _RULE.match(content, offset) or _TOKEN.match(content, offset)
        if found is None:
            raise CaseError(["has a quotation mark without an end"])
        offset, token = found.end(), found[0]
        if token.isspace() or token in b"{}()[];" or token.startswith(b"// "):
            continue
        yield token
        words.append(token)
        if token in _BYTES:
            offset = _skip_list(content, offset, _BYTES[token], words)
    if words.count(b"FoamFile") != 1 or words.count(b"format") != 1:
        raise CaseError(["has not one header"])


def _skip_list(content: bytes, offset: int, size: int, words: list[bytes]) -> int:
    """Where the list is over whose count stands at `offset`."""
    count = _COUNT.match(content, offset)
    if count is None or words[words.index(b"format") + 1 :][:1] != [b"binary"]:
        raise CaseError(["holds a list that is not binary"])
    if content[count.end() : count.end() + 1] != b"(":
        return count.end()
    end = count.end() + 1 + int(count[1]) * size
    if content[end : end + 1] != b")":
        raise CaseError([f"has no list of {int(count[1])} entries where it says so"])
    return end + 1
