"""The page of the paper on the disk: one HTML file that stands alone, its numbers, and the same as Markdown with
pictures and data in files of their own."""

from __future__ import annotations

import base64
import csv
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import require_writable
from fbcouple.postproc.files import ELSEWHERE, name_numbers, write_whole
from fbcouple.postproc.papers.hamidouche2019.figure_data import Data
from fbcouple.postproc.papers.hamidouche2019.page import SCALING, Member, Page, make_page
from fbcouple.postproc.report.tables import make_plain
from fbcouple.postproc.report.wording import open_templates, show

OWN = "figure-"
"""How the names of the page's pictures and data begin."""


def write_page(folder: Path, members: Sequence[Member], output: Path) -> list[Path]:
    """Write the page of the set in `folder` to `output` (HTML), its numbers beside it (JSON), and README.md, pictures
    and data into the folder of the same name; where that holds runs, into the one of that name and "-page".

    Returns: the files. Raises: CaseError if one cannot be written, or is where the page or its data are read from.
    """
    numbers = name_numbers(output)
    beside = _choose_folder(folder, output)
    for path in (numbers, beside / "README.md"):
        if path.resolve() == (folder / SCALING).resolve():
            raise CaseError([f"{path}: holds what figure 7 is made of; {ELSEWHERE}."])
        require_writable(path, ELSEWHERE)
    page = make_page(folder, members)
    files = [*_write_data(page, beside), *_write_pictures(page, beside)]
    names = {stem: file.name for stem, file in ((file.stem, file) for file in files) if file.suffix != ".png"}
    context = page.content | {"files": names, "json_name": numbers.name}
    plain = make_plain({key: value for key, value in page.content.items() if key != "figures"})
    plain["figures"] = [
        make_plain({k: v for k, v in each.items() if k != "pictures"}) for each in page.content["figures"]
    ]
    text = json.dumps(plain, indent=1, allow_nan=False) + "\n"
    written = [
        (output, _render("paper.html", context | {"beside": beside.name})),
        (numbers, text),
        (beside / "README.md", _render("paper.md", context)),
    ]
    return [*(_write_text(path, words) for path, words in written), *files]


def _choose_folder(folder: Path, output: Path) -> Path:
    """Where pictures and data go: into no folder of runs, which would take them for members of a set.

    Raises: CaseError if there is no such folder.
    """
    plain = output.with_suffix("")
    for beside in (plain, plain.with_name(f"{plain.name}-page")):
        if beside.resolve() != folder.resolve() and not _holds_runs(beside):
            return beside
    raise CaseError([f"{output}: the folders {plain.name} and {plain.name}-page beside it hold runs; {ELSEWHERE}."])


def _holds_runs(folder: Path) -> bool:
    """Is it a run folder, or one with runs, or with files of reduced means, in it?"""
    is_of_runs = (folder / "case.toml").is_file() or any(folder.glob("*/case.toml"))
    return is_of_runs or any(not file.name.startswith(OWN) for file in folder.glob("*.nc"))


def _write_text(path: Path, text: str) -> Path:
    return write_whole(path, lambda place: place.write_text(text, encoding="utf-8"))


def _write_pictures(page: Page, folder: Path) -> list[Path]:
    written = []
    for figure in page.content["figures"]:
        for picture in figure["pictures"]:
            data = base64.b64decode(picture["source"].partition(",")[2])
            path = folder / f"{picture['name']}.png"
            written.append(write_whole(path, lambda place, data=data: place.write_bytes(data)))  # type: ignore[misc]
    return written


def _write_data(page: Page, folder: Path) -> list[Path]:
    return [_write_one(folder, name, data) for name, data in page.data.items()]


def _write_one(folder: Path, name: str, data: Data) -> Path:
    """A CSV file of rows, a netCDF file of maps."""
    if isinstance(data, xr.Dataset):
        encoding = {each: {"zlib": True, "complevel": 9, "shuffle": True} for each in data.data_vars}
        return write_whole(folder / f"{name}.nc", lambda place: data.to_netcdf(place, encoding=encoding))
    return write_whole(folder / f"{name}.csv", lambda place: _write_rows(place, data))


def _write_rows(path: Path, rows: list[dict[str, Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(rows[0] if rows else [])
        writer.writerows(
            [f"{value:.5g}" if isinstance(value, float) else value for value in row.values()] for row in rows
        )


def _render(name: str, context: dict[str, Any]) -> str:
    environment = open_templates(escapes=name.endswith(".html"))
    environment.filters |= {"plain": _escape, "lines": _format_table}
    return environment.get_template(name).render(context).lstrip()


def _escape(text: str) -> str:
    """A text of Markdown that means what it says."""
    return re.sub(r"([|_*<`])", r"\\\1", text)


def _format_table(rows: list[dict[str, Any]], without: Sequence[str] = ()) -> str:
    """A table of Markdown."""
    heads = [head for head in rows[0] if head not in without]
    lines = [[_escape(head) for head in heads], ["---"] * len(heads)]
    lines += [[_escape(show(row[head], head)) or "–" for head in heads] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
