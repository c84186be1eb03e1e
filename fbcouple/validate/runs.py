"""The run of a measured bed: made, gone on with, or found; and what it was made with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from shlex import quote
from typing import Any

from pydantic import ValidationError

from fbcouple.api import Run
from fbcouple.case.changes import list_changes, list_values
from fbcouple.case.load import load_case
from fbcouple.case.problems import show
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import FILE_NAME
from fbcouple.decks.set_up import lay_out, name_run
from fbcouple.decks.starts import expect_start
from fbcouple.errors import CaseError, StoppedError
from fbcouple.postproc.averaging import format_window
from fbcouple.results.reader import Results
from fbcouple.validate.ahead import find_lacks
from fbcouple.validate.source import Bed

Say = Callable[[str], None]
Fact = dict[str, Any]


def choose_folder(bed: Bed, output: Path | None) -> Path:
    """The run folder: as given, or runs/validate/<name of the bed>."""
    return output or Path("runs/validate") / name_run(bed.name, bed.folder / FILE_NAME)


def run_bed(bed: Bed, folder: Path, ranks: int, resume: bool, sets: Sequence[str], trusted: bool, say: Say) -> None:
    """Set the bed's case up in `folder` and run it to its end; resume: go on with the run that is there.

    trusted: also with code that the case brings; say: told what the run cannot be compared with.

    Raises: CaseError, before anything is written, if the bed's own case cannot give a measurement, or with `sets` none;
    as `fbcouple.setup` and `Run.start`; StoppedError if it stopped early with a checkpoint.
    """
    if resume and sets:
        raise CaseError([f"--set: {sets[0]}: a run that goes on has its case already; leave --set or --resume out."])
    if not resume:
        require_gives(bed, sets, say)
        lay_out(str(bed.name), folder, sets, trusted, say=say)
    run = Run(folder)
    begin = run.resume if resume else run.start
    status = begin(ranks, trust=trusted, say=say)
    if status.state != "complete":
        command = f"fbcouple validate {quote(bed.name)} -o {quote(str(folder))} -n {ranks} --resume"
        raise StoppedError(f"{folder}: {status.message}; go on with `{command}{' --trust' if trusted else ''}`")


def require_gives(bed: Bed, sets: Sequence[str], say: Say) -> None:
    """Look whether a run of the bed's case, with `sets`, gives what it is compared with; `say` is told what not.

    Raises: CaseError if the case itself does not, or with `sets` nothing is left to compare with.
    """
    if lacks := find_lacks(bed, load_case(bed.name)):
        mend = "or remove the measurement"
        raise CaseError([f"{bed.name}: measurements ({name}): {lack}, {mend}." for name, lack in lacks.items()])
    if not sets:
        return
    lacks = find_lacks(bed, load_case(bed.name, sets))
    if len(lacks) == len(bed.tasks):
        raise CaseError([f"--set: {name}: {lack}: nothing is left to compare with." for name, lack in lacks.items()])
    for name, lack in lacks.items():
        say(f"not compared: {name}: {lack}")


def list_facts(bed: Bed, results: Results) -> list[Fact]:
    """What the run is, and what it took: rows of name and value."""
    data = results.data.attrs
    time = results.simulated
    ranks = int(data.get("ranks", 1))
    facts = {
        "bed": bed.name,
        "measured by": bed.about.source,
        "simulated [s]": time,
        "complete": "yes" if results.complete else f"no, it ends at {results.case['end_time']:g} s",
        "time means over": _tell_window(results),
        "ranks": ranks,
        "core-seconds": float(data["core_seconds"]) if "core_seconds" in data else None,
        "processor time [s]": float(data["cpu_seconds"]) if "cpu_seconds" in data else None,
        "core-seconds a simulated second": float(data.get("core_seconds", 0.0)) / time if time else None,
        "machine": str(data.get("machine", "not known")),
        "made with": str(data.get("source", "not known")),
        "differs from the bed's case in": "; ".join(list_differences(bed, results)) or "nothing",
    }
    return [{"what": name, "value": value} for name, value in facts.items()]


def _tell_window(results: Results) -> str:
    window = results.window
    if window is None:
        return "none"
    return format_window(results) if window[1] > window[0] else f"not begun, they start at {window[0]:g} s"


def list_differences(bed: Bed, results: Results) -> list[str]:
    """Options in which the run's case is not the bed's: key, value, and that of the bed in brackets.

    Raises: CaseError if the run's case is none that this version of fbcouple reads.
    """
    own = expect_start(load_case(bed.name), bed.folder)
    try:
        made = Case.model_validate(results.case)
    except ValidationError as error:
        first = ".".join(map(str, error.errors(include_url=False)[0]["loc"]))
        text = f"{results.path}: its case ({first}) is not as this version of fbcouple has it; run the bed again."
        raise CaseError([text]) from None
    changes = [(change.key, change.before, change.now) for change in list_changes(list_values(own), made)]
    if made.end_time != own.end_time:
        changes.insert(0, ("end_time", own.end_time, made.end_time))
    return [f"{key} = {_word(now)} ({_word(before)})" for key, before, now in changes]


def _word(value: Any) -> str:
    return "none" if value is None else show(value)
