"""A log of rows as lines of JSON, each with a checksum, so that a line that is not whole is seen."""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import Any, TextIO


def append_line(file: TextIO, row: dict[str, Any]) -> None:
    """Append `row` to the line log, with a checksum over the rest of the line."""
    text = json.dumps(row)
    file.write(f'{text[:-1]}, "crc32": {zlib.crc32(text.encode())}}}\n')
    file.flush()


def read_line(line: str) -> dict[str, Any] | None:
    """The row of a line of the log, or None if the line is not whole."""
    text, mark, checksum = line.rstrip("\n").rpartition(', "crc32": ')
    if not mark or not checksum.endswith("}") or checksum[:-1] != str(zlib.crc32(f"{text}}}".encode())):
        return None
    return json.loads(f"{text}}}")


def read_log(path: Path) -> list[dict[str, Any]]:
    """The rows of a line log up to the first line that is not whole."""
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines(keepends=True):
        row = read_line(line)
        if row is None:
            break
        rows.append(row)
    return rows
