"""Files that are no table of numbers in a text, told by their first bytes, and how the text of a table is written."""

from __future__ import annotations

import codecs
from pathlib import Path

from fbcouple.errors import CaseError

_SIGNATURES = {
    b"PK\x03\x04": "a zip archive or a workbook",
    b"\xd0\xcf\x11\xe0": "a workbook",
    b"\x1f\x8b": "compressed (gzip)",
    b"\x89HDF": "an HDF5 file",
}
_FOREIGN = {
    "ITEM:": "a LIGGGHTS or LAMMPS dump",
    "# vtk DataFile": "a VTK file",
    "<?xml": "an XML file, as VTK's are",
    "<VTKFile": "a VTK file",
    "{": "JSON",
}
"""First bytes, and first words, of files that are no such tables."""


def find_encoding(path: Path, rows: str, first_line: str) -> str:
    """How the text of a table of `rows`, which `first_line` could start, is written, by the first bytes of the file.

    Raises: CaseError (one text that begins with the file's name) if they are of no table; OSError.
    """
    with path.open("rb") as file:
        start = file.read(4096)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"  # "Unicode text" of a spreadsheet, what PowerShell writes
    for signature, kind in _SIGNATURES.items():
        if start.startswith(signature):
            raise CaseError([f"{path.name} is {kind}; save it as CSV in UTF-8, starting `{first_line}`."])
    if b"\0" in start:
        text = f"{path.name} holds NUL bytes, so it is UTF-16 or no text at all"
        raise CaseError([f"{text}; save it as CSV in UTF-8, starting `{first_line}`."])
    for words, kind in _FOREIGN.items():
        if start.lstrip().startswith(words.encode()):
            text = f"{path.name} is {kind} (it begins with `{words}`)"
            raise CaseError([f"{text}; write its {rows} as CSV, starting `{first_line}`."])
    return "utf-8-sig"
