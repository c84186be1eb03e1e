"""What the schema cannot see: whether the parts of a case fit together, and fit on this machine.

Each check names the keys that it needs, so that the others still run when one of them is wrong.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from fbcouple.case.alternatives import word_removal
from fbcouple.case.bed.derived import dem_step, inlet_rows
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.checks.coarse_graining import find_beyond
from fbcouple.case.checks.mixture import find_unsound
from fbcouple.case.companions import find_companion
from fbcouple.case.problems import Problem, show, write_hint
from fbcouple.case.schema.output import AUTO, find_first_sample
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import DRAG_FILE, OWN, examine_law_file
from fbcouple.errors import CaseError

MOST = 2_000_000_000
"""Cells, or particles, that 32-bit labels can number."""

COEFFICIENTS = tuple(
    f"contact.{key}" for key in ("restitution", "wall_restitution", "friction", "wall_friction", "pairs", "walls")
)
BED = ("particles.diameter", "particles.density", "particles.mass", "particles.count", "domain.size")

Check = Callable[[Case, Path], Iterator[Problem]]
CHECKS: list[tuple[Check, tuple[str, ...]]] = []


def check(*needs: str) -> Callable[[Check], Check]:
    """Register a check that needs the keys or sections `needs` to be right."""

    def register(function: Check) -> Check:
        CHECKS.append((function, needs))
        return function

    return register


def find_problems(case: Case, folder: Path = Path()) -> list[str]:
    """Return every mistake between the fields of a case that passed the schema, one text each.

    folder: where the case file lies, for `particles.positions`.
    """
    return [str(problem) for problem in list_problems(case, folder, ())]


def list_problems(case: Case, folder: Path, spoiled: Collection[str]) -> list[Problem]:
    """Run the checks whose keys are not among `spoiled` (option keys or section names)."""
    problems: list[Problem] = []
    if "particles" not in spoiled and case.particles:
        problems, sound = find_unsound(case.particles, spoiled)
        spoiled = spoiled if sound else {*spoiled, "particles.diameter"}
        if beyond := find_beyond(case, spoiled):
            problems, spoiled = problems + beyond, {*spoiled, "contact.restitution"}
    incalculable: list[Problem] = []  # one value spoils several checks: told once
    for function, needs in CHECKS:
        if any(need in spoiled or need.split(".")[0] in spoiled for need in needs):
            continue
        try:
            problems += function(case, folder)
        except (OverflowError, ZeroDivisionError):
            text = "the values are too large or too small to calculate with; give every one in SI units."
            incalculable.append(Problem(needs[0].split(".")[0], text))
    return problems or incalculable[:1]  # a mistake that is told may be why


def machine_memory() -> int:
    """Return the memory of this machine [bytes]."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


@check("title")
def check_title(case: Case, folder: Path) -> Iterator[Problem]:
    """The title is one line: it goes into the head of decks and figures."""
    if not case.title.isprintable():
        yield Problem("title", f"{show(case.title)} is given, one line without control characters is allowed; fix it.")


@check("gas", "particles", "exchange")
def check_phases(case: Case, folder: Path) -> Iterator[Problem]:
    """Gas, particles or both; [exchange] if and only if both."""
    if case.gas is None and case.particles is None:
        yield Problem("gas", "neither [gas] nor [particles] is given; add one of them or both.")
    elif case.exchange is None and case.gas and case.particles:
        yield Problem("exchange", "gas and particles need [exchange]; add the section (it may be empty).")
    elif case.exchange is not None and not (case.gas and case.particles):
        missing = "particles" if case.gas else "gas"
        yield Problem("exchange", f"there is nothing to couple; remove [exchange] or add [{missing}].")


@check("particles", "contact", "start", "particles.positions")
def check_particle_sections(case: Case, folder: Path) -> Iterator[Problem]:
    """[contact] and [start] if and only if there are particles, [start] only without a positions file."""
    if case.particles is None:
        for name in ("contact", "start"):
            if getattr(case, name) is not None:
                yield Problem(name, f"there are no particles; remove [{name}] or add [particles].")
        return
    if case.contact is None:
        yield Problem("contact", "particles need [contact]; add the section with restitution and friction.")
    if case.start is None and case.particles.positions is None:
        text = "particles need a start; add [start] (it may be empty) or give particles.positions."
        yield Problem("start", text)
    if case.start is not None and case.particles.positions is not None:
        yield Problem("start", "particles.positions says where the particles start; remove [start] or the positions.")


@check("particles", "particles.mass", "particles.count")
def check_mass_or_count(case: Case, folder: Path) -> Iterator[Problem]:
    """The bed is given by its mass or by its count."""
    if case.particles is not None and (case.particles.mass is None) == (case.particles.count is None):
        text = "neither mass nor count is given; give one of them (mass in kg, or count)"
        if case.particles.mass is not None:
            text = f"mass and count are both given; {word_removal(case, ('particles.mass', 'particles.count'))}"
        yield Problem("particles.mass", f"{text}.")


def has_bed(case: Case) -> bool:
    """Tell whether there are particles, their number is given, and one of them fits into the box."""
    particles = case.particles
    if particles is None or (particles.mass is None) == (particles.count is None):
        return False
    return largest_diameter(particles) < min(case.domain.size) * (1 + 1e-9)


@check("contact.stiffness", "contact.steps_per_contact", "end_time", *COEFFICIENTS, *BED[:2])
def check_contact(case: Case, folder: Path) -> Iterator[Problem]:
    """The DEM step is a number that time can advance by."""
    if case.contact is not None and case.particles is not None and case.contact.model == "hooke":
        step = dem_step(case.contact, case.particles)
        if not (math.isfinite(step) and case.end_time + step > case.end_time):
            text = f"{case.contact.stiffness:g} N/m gives a DEM step of {step:g} s, which time cannot advance by"
            yield Problem("contact.stiffness", f"{text}; give the stiffness in N/m and the particle in SI units.")


@check("gas.inlet_velocity", "gas.inlet_ramp", "gas.inlets")
def check_inlet(case: Case, folder: Path) -> Iterator[Problem]:
    """The inlet has one velocity, a ramp or tables, and the times of the ramp go up; a time may stand twice, not
    more."""
    if case.gas is None:
        return
    gas = case.gas
    ways = {"inlet_velocity": gas.inlet_velocity, "inlets": gas.inlets or None, "inlet_ramp": gas.inlet_ramp}
    given = [name for name, value in ways.items() if value is not None]
    if len(given) != 1:
        text = "neither it nor inlet_ramp is given; give one of them (in m/s), or inlets"
        if given:
            both = " and ".join(given).replace("inlet_velocity", "it")
            text = f"{both} are both given; {word_removal(case, [f'gas.{name}' for name in given])}"
        yield Problem("gas.inlet_velocity", f"{text}.")
    if wrong := examine_times("row {}", [time for time, _ in case.gas.inlet_ramp or ()]):
        yield Problem("gas.inlet_ramp", wrong)


def examine_times(row: str, times: Sequence[float]) -> str | None:
    """What is wrong with the times [s] of a ramp: they go up, and one may stand twice (a jump). row: what a row is
    called, with a place for its number."""
    counts = Counter(times)
    for number, (before, after) in enumerate(pairwise(times), start=2):
        if after < before or counts[after] > 2:
            text = f"{row.format(number)} is at {after:g} s, {'before' if after < before else 'as are two more than'}"
            return f"{text} the last; order the rows by time, two at most at one time (a jump)."
    return None


@check("gas.closed_nozzle", "domain.cells")
def check_nozzle(case: Case, folder: Path) -> Iterator[Problem]:
    """The closed nozzle lies in the middle of the floor and leaves some of it open."""
    if case.gas is None or case.gas.closed_nozzle is None:
        return
    floor, given = case.domain.cells[:2], case.gas.closed_nozzle
    allowed = [
        ", ".join(map(str, range(2 - n % 2, n + 1, 2))) if n < 12 else f"{2 - n % 2}, {4 - n % 2}, ... {n}"
        for n in floor
    ]
    mend = f"give {allowed[0]} along x and {allowed[1]} along y, not the whole floor in both, or closed_nozzle_size."
    floor_text = f"{show(given)} is given on a floor of {floor[0]} x {floor[1]} faces"
    if any(n > most for n, most in zip(given, floor, strict=True)) or given == floor:
        yield Problem("gas.closed_nozzle", f"{floor_text} and leaves no face open or sticks out; {mend}")
    elif any((most - n) % 2 for n, most in zip(given, floor, strict=True)):
        yield Problem("gas.closed_nozzle", f"{floor_text} and cannot lie in its middle; {mend}")


@check("gas.top", "gas.inlet_velocity", "gas.inlet_ramp", "gas.inlets")
def check_lid(case: Case, folder: Path) -> Iterator[Problem]:
    """Under a lid no gas comes in: it is incompressible and could not leave."""
    if case.gas is None or case.gas.top == "open":
        return
    key = "gas.inlet_velocity" if case.gas.inlet_ramp is None else "gas.inlet_ramp"
    key = "gas.inlets" if case.gas.inlets else key
    ramps = [case.gas.inlet_ramp or (), *map(inlet_rows, case.gas.inlets)]
    if any([case.gas.inlet_velocity, *(velocity for ramp in ramps for _, velocity in ramp)]):
        yield Problem(key, "gas comes in and gas.top is closed; give 0 or open the top.")


@check("averages.start", "averages.every", "averages.blocks", "end_time")
def check_averages(case: Case, folder: Path) -> Iterator[Problem]:
    """The averaging window lies within the run, and each of its blocks has a sample."""
    if case.averages is None:
        return
    begin, is_found = find_first_sample(case.averages), case.averages.start == AUTO
    window, blocks = case.end_time - begin, case.averages.blocks * (2 if is_found else 1)
    if window <= 0.0:
        text = f"{begin:g} s is given and the run ends at {case.end_time:g} s"
        yield Problem("averages.start", f"{text}; start before end_time.")
    elif case.averages.every > window / blocks * (1 + 1e-9):
        given = "given" if "every" in case.averages.model_fields_set else "the default"
        text = f"{case.averages.every:g} s is {given}, at most {window / blocks:g} s is allowed"
        when = "the start of the run" if is_found else "averages.start"
        words = f"({blocks} blocks from {when} to end_time, a sample in each)"
        yield Problem("averages.every", f"{text} {words}; give less, or fewer averages.blocks, or a later end_time.")


@check("exchange.scheme", "exchange.accelerated")
def check_acceleration(case: Case, folder: Path) -> Iterator[Problem]:
    """Only the exact mean of the drag can know of other forces."""
    if case.exchange and case.exchange.accelerated and case.exchange.scheme != "exponential":
        text = f"true is given and exchange.scheme is {show(case.exchange.scheme)}"
        yield Problem("exchange.accelerated", f'{text}; give exchange.scheme = "exponential" or remove this option.')


@check("exchange.drag", "exchange.drag_file")
def check_drag(case: Case, folder: Path) -> Iterator[Problem]:
    """The drag law is in the registry, or the case brings a file with its own."""
    if case.exchange is None:
        return
    if case.exchange.drag == OWN or case.exchange.drag_file is not None:
        own = case.exchange.drag_file
        yield from check_law_file(DRAG_FILE, case.exchange.drag, own, case.find_folder(folder, own))
        return
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415  (loads numba)

    if case.exchange.drag not in DRAG_LAWS:
        hint = write_hint(case.exchange.drag, DRAG_LAWS)
        text = f"{show(case.exchange.drag)} is given, allowed are: {', '.join(DRAG_LAWS)}, {OWN} (with drag_file)"
        yield Problem("exchange.drag", f"{text}{hint}; give the name of one of these drag laws.")


def check_law_file(key: str, law: str, name: str | None, folder: Path) -> Iterator[Problem]:
    """A case's own law is named as such, and its file, of the option `key`, is a Python file beside the case with the
    function."""
    option = key.removesuffix("_file")
    if name is None:
        yield Problem(key, f"{option} is {show(OWN)} and no file is given; give the .py file that holds the law.")
    elif law != OWN:
        text = f"{show(name)} is given and {option} is {show(law)}"
        yield Problem(key, f"{text}; give {option} = {show(OWN)} or remove the file.")
    else:
        try:
            examine_law_file(key, find_companion(folder, name, ".py"))
        except CaseError as error:
            yield from (Problem(key, problem) for problem in error.problems)
