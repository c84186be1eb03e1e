"""Tables on disk: CSV, JSON with one object a row, and one page of HTML that holds its pictures."""

from __future__ import annotations

import base64
import csv
import io
import json
import math
import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import write_whole
from fbcouple.paths import TEMPLATES

Row = dict[str, Any]
Tables = dict[str, list[Row]]
ELSEWHERE = "give another folder with -o"
TETRAHEDRA = "tetrahedra"
"""What `bench scaling` says of its cells, where they were cut into these."""


def describe_machine() -> str:
    """System and cores of this machine, in words."""
    return f"{platform.system()} {platform.machine()}, {len(os.sched_getaffinity(0))} cores"


def show_cell(value: Any) -> str:
    """A value as a table for people has it: four digits, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def write_tables(folder: Path, name: str, tables: Tables, about: Row) -> list[Path]:
    """Write NAME.json with `about` and every table, and a CSV file for each table; each under a temporary name first.

    Returns: the files. Raises: CaseError if one cannot be written.
    """
    files = [write_json(folder / f"{name}.json", tables, about)]
    for table, rows in tables.items():
        if rows:
            text = io.StringIO()
            writer = csv.DictWriter(text, list(dict.fromkeys(key for row in rows for key in row)), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
            files.append(folder / f"{table}.csv")
            _write(files[-1], text.getvalue())
    return files


def write_json(path: Path, tables: Tables, about: Row, mend: str = ELSEWHERE) -> Path:
    """Write `about` and every table as JSON, one object a row; a number that is not finite is null there.

    Raises: CaseError, which ends in `mend`, if it cannot be written.
    """
    content = about | {name: [_spare(row) for row in rows] for name, rows in tables.items()}
    _write(path, json.dumps(content, indent=1) + "\n", mend)
    return path


def _spare(row: Row) -> Row:
    return {key: None if isinstance(v, float) and not math.isfinite(v) else v for key, v in row.items()}


def write_page(
    path: Path,
    title: str,
    note: str,
    pictures: Sequence[Path],
    tables: Tables,
    is_marked: Callable[[Row], bool] = lambda row: False,
) -> Path:
    """Write a page with the pictures inside it; rows of which `is_marked` holds are marked.

    Raises: CaseError if it cannot be written.
    """
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES / "tables"), undefined=StrictUndefined, autoescape=True, trim_blocks=True
    )
    shown = []
    for name, rows in tables.items():
        columns = [
            c for c in dict.fromkeys(k for r in rows for k in r) if any(r.get(c) not in (None, "") for r in rows)
        ]
        cells = [{"marked": is_marked(r), "cells": [show_cell(r.get(c)) for c in columns]} for r in rows]
        shown.append({"title": name, "columns": columns, "rows": cells})
    coded = [base64.b64encode(picture.read_bytes()).decode() for picture in pictures]
    page = environment.get_template("page.html").render(title=title, note=note, pictures=coded, tables=shown)
    _write(path, page)
    return path


def _write(path: Path, text: str, mend: str = ELSEWHERE) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    except OSError as error:
        raise CaseError([f"{path}: cannot be written ({error.strerror or error}); {mend}."]) from error
