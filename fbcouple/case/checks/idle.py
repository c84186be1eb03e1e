"""Options that are given and that nothing looks at, for another option of the case leaves them without effect."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fbcouple.case.checks.registry import check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.inlets import Inlet, Outlet
from fbcouple.case.schema.option import Section
from fbcouple.case.schema.reference import list_sections
from fbcouple.case.schema.sections import Case

_WRITTEN = 0.8
"""Part of the options with a value that a case of a run folder gives at least; one that somebody wrote gives a half at
most."""


@dataclass(frozen=True)
class Idle:
    """An option, `key`, that may be without effect: `find_reason` says why it is in a case, "" where it is not; `mend`
    is what to do in place of removing it, `by` are the options, or sections, that decide it."""

    key: str
    by: tuple[str, ...]
    find_reason: Callable[[Case], str]
    mend: str


def _of_contact_model(case: Case) -> str:
    return 'model = "hertz" does not look at it' if case.contact and case.contact.model == "hertz" else ""


def _of_ratio(case: Case) -> str:
    particles = case.particles
    if particles is None or particles.coarse_graining is not None or particles.parcels is not None:
        return ""
    return "the particles are no parcels"


def _of_made_start(case: Case) -> str:
    """Nothing is put on a lattice."""
    start = case.start
    if start is None or not start.is_made:
        return ""
    given = next((key for key in ("run", "restart") if getattr(start, key) is not None), 'method = "pour"')
    return f"{given} does not look at it"


def _of_no_pouring(case: Case) -> str:
    start = case.start
    if start is None or start.method == "pour":
        return ""
    return f"{_of_made_start(case).split(' ')[0] if start.is_made else 'a lattice'} does not look at it"


def _of_chance(case: Case) -> str:
    """Nothing of the start is by chance."""
    start, particles = case.start, case.particles
    if start is None or particles is None or start.method == "pour":
        return ""
    if start.is_made:
        return _of_made_start(case)
    is_even = start.jitter == 0.0 and not particles.mixture and particles.spread is None
    return "jitter = 0 leaves nothing to chance" if is_even else ""


def _of_spread(case: Case) -> str:
    return "no spread" if case.particles and case.particles.spread is None else ""


def _of_one_kind(case: Case) -> str:
    particles = case.particles
    return "no mixture and no spread" if particles and not particles.mixture and particles.spread is None else ""


def _of_no_inlets(case: Case) -> str:
    return "no inlets" if case.gas and not case.gas.inlets else ""


def _of_one_phase(case: Case) -> str:
    missing = "gas" if case.gas is None else "particles" if case.particles is None else ""
    return f"the case has no [{missing}]" if missing else ""


def _of_no_heat(case: Case) -> str:
    return "the case has no [heat]" if case.heat is None else ""


_MADE = ("start.method", "start.run", "start.restart")
_TO_LATTICE = 'take method = "lattice"'
_OF_SEED = "give jitter above 0 (of a run or a restart file particles.positions_seed)"
_MIXED = ("particles.mixture", "particles.spread")
ROWS = (
    Idle("contact.stiffness", ("contact.model",), _of_contact_model, 'take model = "hooke"'),
    Idle(
        "contact.scale_restitution",
        ("particles.coarse_graining", "particles.parcels"),
        _of_ratio,
        "give particles.coarse_graining",
    ),
    Idle("start.spacing", _MADE, _of_made_start, _TO_LATTICE),
    Idle("start.jitter", _MADE, _of_made_start, _TO_LATTICE),
    Idle("start.rest_speed", _MADE, _of_no_pouring, 'take method = "pour"'),
    Idle("start.settle_limit", _MADE, _of_no_pouring, 'take method = "pour"'),
    Idle("start.seed", (*_MADE, "start.jitter", *_MIXED), _of_chance, _OF_SEED),
    Idle("particles.classes", ("particles.spread",), _of_spread, "give the spread"),
    Idle("particles.fractions", _MIXED, _of_one_kind, "give one of them"),
    Idle("gas.inlet_section", ("gas.inlets",), _of_no_inlets, "give inlets"),
    Idle("heat.nusselt", ("gas", "particles"), _of_one_phase, "add it"),
    Idle("monitors.heat", ("heat",), _of_no_heat, "add [heat]"),
)
"""Others that go with one option are looked at by the checks of that option's section."""


def _check_row(row: Idle, case: Case, folder: Path) -> Iterator[Problem]:
    if (given := _find_given(case, row.key)) is not None and (reason := row.find_reason(case)):
        value = f"{given:g}" if isinstance(given, float) else show(given)
        yield Problem(row.key, f"{value} is given and {reason}; remove it, or {row.mend}.")


for _row in ROWS:
    check(_row.key, *_row.by)(partial(_check_row, _row))


@check("gas.inlets", "gas.outlets")
def check_faces(case: Case, folder: Path) -> Iterator[Problem]:
    """A face is where a rectangle or a circle is; patches have theirs of the mesh."""
    if case.gas is None or is_written(case):
        return
    tables: list[tuple[str, int, Inlet | Outlet]] = [
        *(("inlet", number, inlet) for number, inlet in enumerate(case.gas.inlets, start=1)),
        *(("outlet", number, outlet) for number, outlet in enumerate(case.gas.outlets, start=1)),
    ]
    for key, number, table in tables:
        if table.patches and is_own(table, "face"):
            text = f'{key} {number}: face = "{table.face}" is given with patches, which say where it is'
            yield Problem(f"gas.{key}s", f"{text}; remove it, or give rectangle or circle.")


def _find_given(case: Case, dotted: str) -> Any:
    """The value of an option that the case itself gives; None where it does not, or gives what it would have anyway."""
    section, _, key = dotted.partition(".")
    table = getattr(case, section)
    return getattr(table, key) if table is not None and is_own(table, key) and not is_written(case) else None


def is_own(table: Section, key: str) -> bool:
    """Is an option of `table` given, with another value than its default?"""
    return key in table.model_fields_set and getattr(table, key) != type(table).model_fields[key].default


def is_written(case: Case) -> bool:
    """Does the case give almost every option that has a value, as one does that was written, defaults and all, into a
    run folder, by this or an earlier version? What is without effect there says nothing of what somebody wants."""
    tables = [table for name in list_sections() if name and (table := getattr(case, name, None)) is not None]
    given = [
        key in table.model_fields_set
        for table in [case, *tables]
        for key in type(table).model_fields
        if getattr(table, key, None) is not None
    ]
    return sum(given) > _WRITTEN * len(given)


def list_idle(case: Case) -> list[str]:
    """Options, by dotted key, that would be without effect in a case."""
    return [row.key for row in ROWS if row.find_reason(case)]


def drop_idle(case: Case, set_keys: Collection[str]) -> Case:
    """The case without the options of its file that `--set` (`set_keys`) leaves without effect: they have their
    defaults."""
    for row in ROWS:
        section, _, key = row.key.partition(".")
        is_by_setting = row.key not in set_keys and any(name in set_keys for name in row.by)
        if is_by_setting and _find_given(case, row.key) is not None and row.find_reason(case):
            table = getattr(case, section)
            kept = table.model_copy(update={key: type(table).model_fields[key].default})
            case = case.model_copy(update={section: kept})
    return case
