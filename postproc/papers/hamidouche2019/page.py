"""The paper on one page, figure by figure: ours, what it says of it, whether that agrees, and how sure."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from shlex import quote
from typing import Any

from matplotlib.figure import Figure

from fbcouple.errors import CaseError
from fbcouple.input_files.toml_text import parse_toml
from fbcouple.postproc.averaging import list_warnings
from fbcouple.postproc.papers.hamidouche2019 import page_tables
from fbcouple.postproc.papers.hamidouche2019.claims import NO, STATED, YES, Row, judge_claims
from fbcouple.postproc.papers.hamidouche2019.figure_data import Data
from fbcouple.postproc.papers.hamidouche2019.impact import draw_contact, find_contact
from fbcouple.postproc.papers.hamidouche2019.paper_beds import AS_PRINTED, BEDS, identify_case
from fbcouple.postproc.papers.hamidouche2019.paper_figures import FIGURES, PaperFigure, Picture
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import tell_numerics
from fbcouple.postproc.papers.hamidouche2019.paper_runs import identify, sort_runs
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.postproc.papers.hamidouche2019.run_uses import list_uses, name_chosen, tell_choices
from fbcouple.postproc.report.pictures import make_picture
from fbcouple.results.reader import NotDrawableError, Results, open_results
from fbcouple.results.tables import TETRAHEDRA
from fbcouple.version import __version__

Content = dict[str, Any]
SCALING = "scaling.json"
"""In the folder of the runs: what `fbcouple bench scaling --tetrahedra --json FILE` wrote, for figures 7a and 7b."""
PRINTED_BEDS = [name for name in BEDS if name not in ("c2-slip", "c6-smagorinsky")]
"""Those that the paper tells of."""
BESIDE = {"c3-slip": "; it is none of patil/all: `fbcouple setup patil/c3-slip`"}
"""Of beds that the set of the paper leaves out: what makes them."""
FEW_CLAIMS = ("statement", "beds", "numerics", "measured", "wanted", "verdict", "why")


@dataclass(frozen=True)
class Member:
    """What lies in the folder of the runs: its results, or why there are none, and which beds it is of."""

    path: Path
    beds: tuple[str, ...]
    results: Results | None
    lack: str = ""


def open_members(paths: Sequence[Path]) -> list[Member]:
    """Read the members of a set; those that have no results yet are known by their cases."""
    return [_open(path) for path in paths]


def _open(path: Path) -> Member:
    try:
        results = open_results(path)
    except CaseError as error:
        file = path / "case.toml"
        try:
            case = parse_toml(file.read_text(encoding="utf-8")) if file.is_file() else {}
            beds = identify_case(case)[1]
        except (
            OSError,
            ValueError,
            KeyError,
            TypeError,
            CaseError,
        ):  # what cannot be read is of no bed, and said to be
            beds = []
        is_waiting = file.is_file() and not (path / "results.nc").exists()
        return Member(path, tuple(beds), None, "no results yet" if is_waiting else str(error).splitlines()[0])
    return Member(path, tuple(identify(results)[1]), replace(results, label=path.stem if path.is_file() else path.name))


def is_of_the_paper(members: Sequence[Member]) -> bool:
    """Is one of them a bed of the paper?"""
    return any(member.beds for member in members)


@dataclass(frozen=True)
class Page:
    """The page: its `content`, with the pictures as data of it, and the `data` behind them by name of their file."""

    content: Content
    data: dict[str, Data]


def make_page(folder: Path, members: Sequence[Member]) -> Page:
    """Everything that the page shows of the `members` of the set in `folder`."""
    runs = [member.results for member in members if member.results is not None]
    by_contacts, left_out = sort_runs(runs)
    chosen = by_contacts[AS_PRINTED]
    uses = list_uses(runs)
    names = name_chosen(uses)
    claims = judge_claims(runs)
    data: dict[str, Data] = {}
    figures = [_describe_contact(runs), _describe_scaling(folder)]
    for figure in FIGURES:
        described, own = _describe_figure(figure, chosen, claims, names)
        figures.append(described)
        data |= own
    return Page(
        {
            "title": "Hamidouche et al. 2019, figure by figure",
            "version": __version__,
            "made": time.strftime("%Y-%m-%d"),
            "numerics": tell_numerics(runs),
            "missing": _list_missing(members, chosen, left_out),
            "choices": tell_choices(uses),
            "warnings": list_warnings(runs),
            "figures": figures,
            "runs": page_tables.tabulate_runs(uses),
            "twins": page_tables.tabulate_twins(runs),
            "makers": page_tables.tabulate_makers(runs),
            "claims": [asdict(row) for row in claims],
            "counts": _count_verdicts(claims),
        },
        data,
    )


def _list_missing(members: Sequence[Member], chosen: dict[str, Results], left_out: dict[str, str]) -> list[str]:
    """Why beds of the paper are not shown, a sentence a reason, and for each member that is none or has none;
    `left_out` tells why a run of a bed is not `chosen`."""
    lacking = {bed: member.lack for member in members if member.results is None for bed in member.beds}
    beds: dict[str, list[str]] = {}
    for bed in PRINTED_BEDS:
        if bed not in chosen:
            reason = lacking.get(bed) or left_out.get(bed) or f"no run in this folder{BESIDE.get(bed, '')}"
            beds.setdefault(reason, []).append(bed)
    told = [f"{', '.join(names)}: {reason}" for reason, names in beds.items()]
    others = [f"{member.path.name}: {member.lack}" for member in members if member.results is None and not member.beds]
    return [*told, *others]


def _describe_figure(
    figure: PaperFigure, chosen: dict[str, Results], claims: Sequence[Row], names: dict[str, str]
) -> tuple[Content, dict[str, Data]]:
    remarks: list[str] = []
    data: dict[str, Data] = {}
    made = []
    for picture in figure.pictures:
        shown = [replace(chosen[bed], label=bed) for bed in picture.beds if bed in chosen]
        if not shown:
            continue
        others = [chosen[bed] for bed in figure.beds if bed in chosen and bed not in picture.beds]
        words = f"Ours, of {', '.join(names[run.label] for run in shown)}."
        described = _draw(figure.number, picture, words, remarks, (shown, others))
        if described:
            made.append(described)
            data[described["name"]] = picture.collect(shown)
    lacking = [bed for bed in figure.beds if bed not in chosen]
    if lacking:
        remarks.append(f"No run of {', '.join(lacking)}.")
    own = [row for name in figure.claims for row in claims if row.name == name and (row.runs or row.beds == STATED)]
    return {
        "number": figure.number,
        "shows": figure.shows,
        "said": figure.said,
        "pictures": made,
        "remarks": remarks,
        "agreement": _tell_agreement(own),
        "claims": [{key: getattr(row, key) for key in FEW_CLAIMS} for row in own],
        "numbers": _tell_numbers(figure, chosen, remarks),
    }, data


def _draw(number: str, picture: Picture, words: str, remarks: list[str], runs: Sequence[list[Results]]) -> Content:
    """A picture of the first of `runs`; the second are the others of its figure."""
    name = f"figure-{number.lower()}-{picture.name}"
    return make_picture(lambda: picture.draw(*runs), name, words, f"Figure {number}", remarks)


def _tell_numbers(figure: PaperFigure, chosen: dict[str, Results], remarks: list[str]) -> list[dict[str, Any]]:
    shown = [replace(chosen[bed], label=bed) for bed in figure.beds if bed in chosen]
    if figure.tell is None or not shown:
        return []
    try:
        return figure.tell(shown)
    except NotDrawableError as lack:
        if not any(text.endswith(str(lack)) for text in remarks):
            remarks.append(str(lack))
        return []


def _list_papers(rows: Sequence[Row]) -> list[Row]:
    """What the paper claims of its own beds, without what it did not try."""
    return [row for row in rows if row.beds == STATED and row.contacts == AS_PRINTED and not CLAIMS[row.name].is_ours]


def _count_verdicts(rows: Sequence[Row]) -> dict[str, Any]:
    """How many claims the paper has, how many hold and how many do not; and what is judged beside them."""
    counted = _list_papers(rows)
    verdicts = [row.verdict for row in counted]
    ours = [f"{row.statement} {row.verdict.capitalize()}." for row in rows if CLAIMS[row.name].is_ours]
    return {"of": len(counted), "yes": verdicts.count(YES), "no": verdicts.count(NO), "beside": " ".join(ours)}


def _tell_agreement(rows: Sequence[Row]) -> str:
    """How many of a figure's claims hold, on the beds that they speak of."""
    counted = _list_papers(rows)
    if not counted:
        return "The paper has no claim here that a number decides."
    verdicts = [row.verdict for row in counted]
    told = f"{verdicts.count(YES)} of {len(counted)} claims hold"
    no, open_ = verdicts.count(NO), len(counted) - verdicts.count(YES) - verdicts.count(NO)
    told += f", {no} {'does' if no == 1 else 'do'} not" if no else ""
    return f"{told}{f', {open_} open' if open_ else ''}."


def _describe_contact(runs: Sequence[Results]) -> Content:
    """Figure 4: worked out, with a run of one contact if there is one."""
    found = None
    for run in runs:
        if "exchange" in run.case:
            continue
        try:
            found = find_contact(run)
        except NotDrawableError:
            continue
    remarks: list[str] = [] if found else ["No run of single-impact in this folder: LIGGGHTS is not in the picture."]
    note = f"e = {page_tables.RESTITUTION:g}; the contact starts at t = 0"

    def draw() -> Figure:
        return draw_contact("One sphere against a wall", note, page_tables.RESTITUTION, found)

    picture = make_picture(draw, "figure-4", "Ours.", "Figure 4", remarks)
    rows = page_tables.tell_contact()
    if found is not None:
        rows.append(page_tables.tell_run(found.restitution))
    return {
        "number": "4",
        "shows": "overlap and velocity in a contact with a wall",
        "said": "RK2 with steps of T_C/6 is stable and near the exact contact; restitution is off by less than 5 %.",
        "pictures": [picture] if picture else [],
        "remarks": remarks,
        "agreement": "",
        "claims": [],
        "numbers": rows,
    }


def _describe_scaling(folder: Path) -> Content:
    """Figures 7a and 7b: what `bench scaling` measured, if its tables lie in the folder."""
    path, remarks, rows = folder / SCALING, [], []
    command = f"`fbcouple bench scaling -n 1 -n 2 --tetrahedra --json {quote(str(path))}`"
    if path.is_file():
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
            cells = found.get("cells", "cells that it does not name")
            table = next(value for value in found.values() if isinstance(value, list) and "of_ideal" in value[0])
            columns = ("scaling", "ranks", "seconds", "gain", "value", "of_ideal")
            if cells == TETRAHEDRA:
                rows = [{name: row.get(name, "") for name in columns} for row in table]
            else:
                remarks.append(f"{path} is of {cells}, the figure of {TETRAHEDRA}: write it again by {command}.")
        except (ValueError, StopIteration, AttributeError, TypeError, IndexError, KeyError) as error:
            remarks.append(f"{path} is not what bench scaling writes ({error}); write it again by {command}.")
    else:
        remarks.append(f"Not measured here; {command} does.")
    return {
        "number": "7",
        "shows": "speed-up (a) and scale-up (b) of a box of particles and tetrahedra",
        "said": "From 532 to 4144 cores the speed-up reaches 80 % of the ideal one (38 million tetrahedra, 410 million "
        "particles); at a constant load a core the scale-up from 252 to 4144 cores is excellent.",
        "pictures": [],
        "remarks": remarks,
        "agreement": "",
        "claims": [],
        "numbers": rows,
    }
