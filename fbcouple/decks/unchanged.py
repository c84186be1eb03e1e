"""Whether what lies in a run folder is what follows from its case, before a solver reads any of it.

Decks are programs: OpenFOAM compiles `#codeStream`, loads `libs` and calls what `systemCall` says, LIGGGHTS has
`shell`. A run folder may come from anybody, so decks are held against what the case gives here and now. Hashes in the
manifest, which whoever made the folder can write as well, find what was changed by accident: start, mesh, law.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fbcouple.case.bed.particle_types import particle_count
from fbcouple.case.bed.positions import start_kinds, start_motion, start_positions
from fbcouple.case.changes import FREE, FREE_SECTIONS, INLET, list_changes
from fbcouple.case.companions import list_files
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import list_code
from fbcouple.decks.context import find_box
from fbcouple.decks.render import format_particles, render_decks
from fbcouple.errors import CaseError
from fbcouple.paths import START, TEMPERATURES, WALLS
from fbcouple.run_folder.manifest import hash_file, read_manifest
from fbcouple.run_folder.plain_files import format_path, require_plain

# Where solvers look for decks, and what a run itself puts there.
_DECK_FOLDERS = ("CFD/system", "CFD/constant", "CFD/0", "DEM")
_WRITTEN_LATER = ("CFD/system/decomposeParDict", "CFD/constant/polyMesh", START, TEMPERATURES, WALLS)
_GAS_FOLDER = re.compile(r"system|constant|0|processor\d+|(?=.*[1-9])\d+(\.\d+)?(e[+-]?\d+)?")
"""What OpenFOAM may find in CFD/: times later than 0 are removed before a run. It takes more for a time, as 0x10."""
INLET_DECK = "CFD/0/U"
_MOST_COMPARED = 100_000
"""Particles up to which start positions are made again to be compared."""
_LAST_DIGITS = 1e-9
"""Relative difference that another machine's mathematical functions may make."""
_AGAIN = "set the run up again, or read the file and say --trust."


def require_unchanged(case: Case, run: Path, trusted: bool, is_inlet_free: bool = False) -> list[str]:
    """Look at the whole run folder `run` of `case`; with `trusted` its decks, data and the case's own files may differ.

    is_inlet_free: how fast gas comes in may be another than at set-up, and its deck another's: both are written anew,
    and may be of an earlier attempt that was cut short.

    Returns: names of the files that differ.
    Raises: CaseError with all that is not what the case gives, a text each.
    """
    require_plain(run)
    manifest = read_manifest(run)
    _require_same_case(manifest["case"], case, run, 0.0 if is_inlet_free else None)
    problems = {**_find_changed_files(manifest["files"], case, run), **_find_changed_decks(case, run)}
    if is_inlet_free:
        problems.pop(INLET_DECK, None)
    if problems and not trusted:
        raise CaseError([f"{format_path(run / name)}: {text}" for name, text in problems.items()])
    return sorted(problems)


def require_own_decks(case: Case, run: Path) -> None:
    """Look at the decks once more, after something has been put into `run`. Raises: CaseError."""
    if problems := _find_changed_decks(case, run):
        raise CaseError([f"{format_path(run / name)}: {text}" for name, text in problems.items()])


def _require_same_case(before: dict[str, Any], case: Case, run: Path, until: float | None) -> None:
    """Raise CaseError if an option has been changed that decks and start positions were made from; velocities of the
    inlet count up to `until` [s] only."""
    if changes := list_changes(before, case, until):
        free = ", ".join([*FREE, *(f"[{section}]" for section in FREE_SECTIONS)])
        shown = format_path(run)
        mend = f"put it back, or set it up: fbcouple setup {shown} -o {shown} (another folder if this one has results)"
        text = f"since set-up; in a run folder only {free} may be changed: {mend}."
        go_on = (
            f"since set-up; a run that has begun gets another inlet by `fbcouple run {shown} --resume --set`: {mend}."
        )
        raise CaseError(
            [
                f"{format_path(run / 'case.toml')}: {change}, {go_on if change.key in INLET else text}"
                for change in changes
            ]
        )


def _find_changed_files(sums: dict[str, str], case: Case, run: Path) -> dict[str, str]:
    """Files beside the decks that a run reads, and what is wrong with each that is not the one that was set up."""
    problems = {}
    written = (TEMPERATURES,) if TEMPERATURES in sums or (run / TEMPERATURES).exists() else ()
    for name in (*_list_read(case, run), *written):
        if not (run / name).is_file():
            problems[name] = "is missing; set the run up again."
        elif sums.get(name) != hash_file(run / name):
            problems[name] = f"has been changed since set-up; {_AGAIN}"
    if case.particles and START not in problems and not _follows_from_case(case, run):
        problems[START] = f"is not what the case gives; {_AGAIN}"
    return problems


def _list_read(case: Case, run: Path) -> Iterator[str]:
    """Names of the files beside the decks that a run of `case` reads."""
    if case.particles:
        yield START
        if case.particles.positions:
            yield case.particles.positions
    yield from list_code(case).values()
    if case.domain.mesh:
        yield from list_files(run, case.domain.mesh)
    if (run / WALLS).exists():
        yield WALLS


def _follows_from_case(case: Case, run: Path) -> bool:
    """Are the start positions those of the case, to the last digits? Only looked at where they are soon made again."""
    assert case.particles is not None
    if not case.domain.is_plain_box or particle_count(case.particles) > _MOST_COMPARED:
        return True
    start = (start_positions(case, run), start_kinds(case, run), find_box(case, None), start_motion(case, run))
    wanted, given = "".join(format_particles(case, *start)), (run / START).read_text(encoding="utf-8", errors="replace")
    return given == wanted or _is_close(given.split(), wanted.split())


def _is_close(given: list[str], wanted: list[str]) -> bool:
    return len(given) == len(wanted) and all(
        one == other or _is_same_number(one, other) for one, other in zip(given, wanted, strict=True)
    )


def _is_same_number(one: str, other: str) -> bool:
    try:
        return math.isclose(float(one), float(other), rel_tol=_LAST_DIGITS, abs_tol=_LAST_DIGITS**2)
    except ValueError:
        return False


def _find_changed_decks(case: Case, run: Path) -> dict[str, str]:
    """Decks that are not what the case gives, and what else solvers would find beside them."""
    decks = render_decks(case, run)
    problems = {name: _format_change(run / name) for name, text in decks.items() if _differs(run / name, text)}
    expected = {*decks, *_WRITTEN_LATER}
    found = [path for folder in _DECK_FOLDERS for path in sorted((run / folder).glob("*"))]
    strange = [path for path in found if path.relative_to(run).as_posix() not in expected]
    strange += [
        path
        for path in sorted((run / "CFD").glob("*"))
        if not _GAS_FOLDER.fullmatch(path.name) and path.relative_to(run).as_posix() not in expected
    ]
    for path in strange:
        text = "is none of this case's decks; remove it, or read it and say --trust."
        problems[path.relative_to(run).as_posix()] = text
    return problems


def _differs(path: Path, text: str) -> bool:
    wanted = text.encode()
    return not path.is_file() or path.stat().st_size != len(wanted) or path.read_bytes() != wanted


def _format_change(path: Path) -> str:
    if not path.is_file():
        return "is missing or is not a plain file; set the run up again."
    return f"is not what the case gives; {_AGAIN}"
