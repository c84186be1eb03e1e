"""Another case from a checkpoint on: `--resume --set`. Only what `case.changes` calls free may change, and how fast gas
comes in: up to the checkpoint the inlet's ramp stays what it was, so that the case still tells all of the run."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.derived import inlet_rows
from fbcouple.case.bed.gas_heat import is_inlet_hot_wall
from fbcouple.case.bed.streams import has_openings, list_streams
from fbcouple.case.changes import FREE, FREE_SECTIONS, Values, is_free, is_same_ramp, list_inflows, list_values
from fbcouple.case.checks.registry import list_problems
from fbcouple.case.load import write_case
from fbcouple.case.problems import Problem, format_errors, write_hint
from fbcouple.case.schema.reference import list_options
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import apply_settings, read_value
from fbcouple.decks.needs import tell_parts
from fbcouple.decks.render import render_decks
from fbcouple.decks.unchanged import INLET_DECK
from fbcouple.errors import CaseError
from fbcouple.machine.whole_files import write_whole
from fbcouple.results.inlet_speed import Row, find_after, find_before
from fbcouple.run_folder.checkpoint import Checkpoint
from fbcouple.run_folder.manifest import hash_file, read_manifest, write_manifest

_OF_INLET = re.compile(r"gas\.inlets\.(\d{1,6})\.(velocity|ramp|ramp_file)")
_LATER = 1e-9
_ALMOST = 1.0 - 1e-9
_OF_FLOOR = ("gas.inlet_velocity", "gas.inlet_ramp")


def ask(case: Case, sets: Sequence[str], run: Path) -> Case:
    """The case of the run folder `run` with `sets` (key=value) on top, as if it were so from the start.

    Raises: CaseError with every mistake, if one of them may not be changed in a run, or the case is wrong then.
    """
    raw = case.model_dump(exclude_none=True)
    of_inlet = [one for one in sets if _OF_INLET.fullmatch(_find_key(one))]
    known = [one for one in sets if _find_key(one) in _OF_FLOOR or is_free(_find_key(one))]
    problems = [_refuse(_find_key(one)) for one in sets if one not in known and one not in of_inlet]
    if any(_find_key(one) in _OF_FLOOR for one in known):
        raw["gas"] = {key: value for key, value in raw.get("gas", {}).items() if f"gas.{key}" not in _OF_FLOOR}
    problems += apply_settings(raw, known)[1]
    problems += [problem for one in of_inlet for problem in _set_inlet(raw, one)]
    if not problems:
        try:
            asked = adopt_inlets(Case.model_validate(raw), run)
            problems = list_problems(asked, run, set())
        except ValidationError as error:
            problems = format_errors(error, raw)[0]
    if problems:
        raise CaseError([f"--set: {problem}" for problem in problems])
    return asked


def changes_inlet(sets: Sequence[str]) -> bool:
    """Is how fast gas comes in among what is set?"""
    return any(key in _OF_FLOOR or _OF_INLET.fullmatch(key) for key in map(_find_key, sets))


def _find_key(setting: str) -> str:
    return setting.partition("=")[0].strip()


def _refuse(key: str) -> Problem:
    if key not in list_options() and not any(map(str.isdigit, key.split("."))):
        hint = write_hint(key, list_options(), "`fbcouple options` lists them")
        return Problem(key, f"is no key of a case{hint}.")
    free = ", ".join([*_OF_FLOOR, "gas.inlets.N.velocity (or ramp, ramp_file)", *FREE])
    sections = " and ".join(f"[{section}]" for section in FREE_SECTIONS)
    return Problem(
        key, f"is fixed once a run has begun; {free}, {sections} may be changed: set up another run with it."
    )


def _set_inlet(raw: dict[str, Any], setting: str) -> Iterator[Problem]:
    """Put the velocity, ramp or ramp_file of one inlet into `raw`, in place of the one that it has."""
    found = _OF_INLET.fullmatch(_find_key(setting))
    assert found is not None
    inlets = list(raw.get("gas", {}).get("inlets", ()))
    number, text = int(found[1]), setting.partition("=")[2]
    if not 1 <= number <= len(inlets):
        yield Problem(found[0], f"the case has {len(inlets)} inlets, counted from 1 as in its file; give one of these.")
    elif not text.strip():
        yield Problem(found[0], "no value is given; write a value after the equals sign.")
    else:
        kept = {key: value for key, value in inlets[number - 1].items() if key not in ("velocity", "ramp", "ramp_file")}
        inlets[number - 1] = kept | {found[2]: read_value(text)}
        raw["gas"]["inlets"] = inlets


def change_case(run: Path, case: Case, asked: Case, checkpoint: Checkpoint | None) -> Case:
    """Write the case `asked` into the run folder `run` of `case`, its inlet from `checkpoint` on; cut short, it can be
    done again. Returns: the case as it is then.

    Raises: CaseError, before anything is written, if the inlet cannot be so in this run.
    """
    changes: list[dict[str, Any]] = []
    manifest = read_manifest(run)
    if asked.gas != case.gas:
        if checkpoint is None:
            mend = "set it up with the other inlet"
            raise CaseError([f"--set: {run} has no checkpoint, from which its inlet could be another; {mend}."])
        if checkpoint.time >= asked.end_time * _ALMOST:
            text = f"its checkpoint, at t = {checkpoint.time:.6g} s, is not before the end, {asked.end_time:g} s"
            raise CaseError([f"--set: {run}: {text}; give a later end_time, too."])
        told = list(_tell(checkpoint.index.case, asked, checkpoint.time))
        joined = _join(checkpoint.index.case, asked, checkpoint.time).gas if told else case.gas
        asked = asked.model_copy(update={"gas": joined})
        _require_same_faces(case, asked)
        _require_same_heat(case, asked)
        earlier = [change for change in manifest.get("inlet_changes", []) if change["time"] < checkpoint.time]
        changes = [*earlier, *({"time": checkpoint.time, "inlet": text} for text in told)]
        manifest["inlet_changes"] = changes
    decks = {name: text for name, text in render_decks(asked, run).items() if _is_to_write(run, name, text, manifest)}
    write_case(asked, run / "case.toml")
    for name, text in decks.items():
        write_whole(run / name, text)
    manifest |= tell_parts(asked)
    manifest["files"] |= {name: hash_file(run / name) for name in ["case.toml", *decks]}
    write_manifest(run, manifest | {"case": list_values(asked)})
    return asked


def _is_to_write(run: Path, name: str, text: str, manifest: dict[str, Any]) -> bool:
    """Is the deck `name` another than `text`, and none that somebody else has changed? The inlet's is ours always: it
    may be of an earlier attempt that was cut short."""
    path = run / name
    if not path.is_file():
        return True
    is_ours = name == INLET_DECK or hash_file(path) == manifest["files"].get(name)
    return is_ours and path.read_bytes() != text.encode()


def _tell(before: Values, asked: Case, time: float) -> Iterator[str]:
    """Of each inlet that is another from `time` [s] on, what it was and what it is."""
    for number, ((_, old), (_, new)) in enumerate(
        zip(list_inflows(before), list_inflows(list_values(asked)), strict=True), start=1
    ):
        if not is_same_ramp(old, new, start=time):
            name = f"inlet {number}" if asked.gas and asked.gas.inlets else "inlet"
            later = [row for row in new if row[0] > time]
            ramp = f", and {len(later)} rows of a ramp after it" if later else ""
            yield f"{name}: {find_before(old, time):g} m/s up to then, {find_after(new, time):g} m/s from then on{ramp}"


def _join(before: Values, asked: Case, time: float) -> Case:
    """`asked` with the velocities of `before` up to `time` [s]."""
    gas = asked.gas
    assert gas is not None
    past = [rows for _, rows in list_inflows(before)]
    update: dict[str, Any]
    if gas.inlets:
        pairs = [(inlet, old, list(inlet_rows(inlet))) for inlet, old in zip(gas.inlets, past, strict=True)]
        update = {
            "inlets": tuple(
                inlet
                if old == new
                else inlet.model_copy(update={"velocity": None, "ramp_file": None, "ramp": tuple(old)})
                if is_same_ramp(old, new, start=time)
                else inlet.model_copy(update={"velocity": None, "ramp_file": None, "ramp": _join_rows(old, new, time)})
                for inlet, old, new in pairs
            )
        }
    else:
        ((_, new),) = list_inflows(list_values(asked))
        update = {} if past[0] == new else {"inlet_velocity": None, "inlet_ramp": _join_rows(past[0], new, time)}
    return asked.model_copy(update={"gas": gas.model_copy(update=update)})


def _join_rows(old: list[Row], new: list[Row], time: float) -> tuple[Row, ...]:
    """Rows that are `old` up to `time` [s] and `new` from then on, with a jump where they differ there.

    It is a little later than the step that ends at `time`, which is of the old velocity also where the run is repeated
    and its clock differs by rounding.
    """
    start = time * (1.0 + _LATER)
    rows = [row for row in old if row[0] < time] + [(start, find_before(old, time)), (start, find_after(new, start))]
    return tuple(rows + [row for row in new if row[0] > start])


def _require_same_faces(case: Case, asked: Case) -> None:
    """Raise CaseError if an inlet that is wall would be open, or the other way round: its faces are made at set-up."""
    if not has_openings(case):
        return
    pairs = enumerate(zip(list_streams(case), list_streams(asked), strict=True), start=1)
    texts = [
        f"--set: inlet {number} lets no gas in at any time and is wall; set up another run with it open."
        if old.is_closed
        else f"--set: inlet {number} would let no gas in at any time; set up another run with it closed."
        for number, (old, new) in pairs
        if old.is_closed != new.is_closed
    ]
    if texts:
        raise CaseError(texts)


def _require_same_heat(case: Case, asked: Case) -> None:
    """Raise CaseError if an inlet that is a hot wall would be open, or the other way round: the case could not tell of
    both."""
    was_wall, would_be_wall = is_inlet_hot_wall(case), is_inlet_hot_wall(asked)
    if was_wall == would_be_wall:
        return
    hot = "a wall with a temperature (heat.wall_temperature or [[heat.walls]])"
    text = f"lets no gas in at any time and is {hot}, which it would not be once it is open"
    if would_be_wall:
        text = f"would let no gas in at any time and be {hot}, which it was not so far"
    mend = f"set up another run with it {'closed' if would_be_wall else 'open'}"
    raise CaseError([f"--set: gas.inlet_velocity: the inlet {text}; {mend}, or with an adiabatic floor."])
