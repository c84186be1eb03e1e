"""Measured beds: folders with a case.toml and a validation.toml beside it, shipped or a user's own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from fbcouple.case.base import read_case
from fbcouple.case.problems import Problem, format_errors, show, write_hint
from fbcouple.case.source import FILE_NAME, VALIDATION_NAME, list_shipped, read_toml
from fbcouple.errors import CaseError
from fbcouple.input_files.companion_files import find_companion, is_bare
from fbcouple.input_files.measured_lines import Points, Reference, parse_reference, read_points
from fbcouple.validate.comparisons import COMPARISONS, LINE, Task, find_unit
from fbcouple.validate.points import find_within, read_series, take_span, take_value
from fbcouple.validate.schema import Measurement, Peer, Validation

_CHOSEN = ("file", "value", "error", "span", "origin")
"""Keys of a measurement of which a comparison takes some."""


@dataclass(frozen=True)
class Scored:
    """What a peer computed: its points, or its root mean square deviation alone."""

    peer: Peer
    points: Points | None


@dataclass(frozen=True)
class Bed:
    """A measured bed, read: `name` of its case, its folder, and the points of each measurement and peer."""

    name: str
    folder: Path
    title: str
    about: Validation
    tasks: tuple[Task, ...]
    peers: tuple[Scored, ...]


def list_beds() -> list[str]:
    """Names of the shipped cases that are measured beds."""
    cases = list_shipped().items()
    return [name for name, path in cases if path.name == FILE_NAME and path.with_name(VALIDATION_NAME).is_file()]


def read_bed(name: str) -> Bed:
    """Read the bed `name`: a shipped case that is one, or a folder with a case.toml and a validation.toml.

    Raises: CaseError with every mistake of validation.toml and of the files that it names.
    """
    folder = _find_folder(name)
    place = f"{name.rstrip('/')}/{VALIDATION_NAME}"
    raw = read_toml(folder / VALIDATION_NAME, place)
    try:
        about = Validation.model_validate(raw)
    except ValidationError as error:
        problems, _ = format_errors(error, raw, Validation)
        raise CaseError([f"{place}: {problem}" for problem in problems]) from None
    case, bases = read_case(folder / FILE_NAME, f"{name.rstrip('/')}/{FILE_NAME}")
    reader = _Reader(about, _list_references(case), [folder, *bases])
    if found := list(reader.check()):
        raise CaseError([f"{place}: {problem}" for problem in found])
    return Bed(name, folder, str(case.get("title", name)), about, tuple(reader.tasks.values()), tuple(reader.peers))


def _find_folder(name: str) -> Path:
    beds = list_beds()
    if name in beds:
        return list_shipped()[name].parent
    folder = Path(name)
    lacking = [file for file in (FILE_NAME, VALIDATION_NAME) if not (folder / file).is_file()]
    if not lacking:
        return folder
    hint = write_hint(name, beds)
    if name in list_shipped() or folder.is_dir():
        text = f"{show(name)}: is no measured bed, it has no {lacking[-1]}; measured are: {', '.join(beds)}{hint}."
        raise CaseError([text])
    text = f"neither a measured bed of those that are shipped ({', '.join(beds)}) nor a folder"
    raise CaseError([f"{show(name)}: {text} with {FILE_NAME} and {VALIDATION_NAME}{hint}."])


def _list_references(case: dict[str, object]) -> dict[str, Reference]:
    """The lines that the case names, by quantity@height; mistakes of the case itself are told by its check."""
    output = case.get("output", {})
    texts = output.get("references", []) if isinstance(output, dict) else []
    lines = [parse_reference(text) for text in texts if isinstance(text, str)]
    return {line.name: line for line in lines}


class _Reader:
    """Reads the points of what a validation.toml names, and tells what is wrong with it."""

    def __init__(self, about: Validation, lines: dict[str, Reference], folders: list[Path]) -> None:
        self._about, self._lines, self._folders = about, lines, folders
        self.tasks: dict[str, Task] = {}
        self.peers: list[Scored] = []

    def check(self) -> Iterator[Problem]:
        """Every mistake; what is right is in `tasks` and `peers`."""
        names: list[str] = []
        for measurement in self._about.measurements:
            where = f"measurements ({measurement.name})"
            if measurement.name in names:
                yield Problem(f"{where}.name", "two measurements have this name; give each its own.")
            names.append(measurement.name)
            if mistakes := list(check_keys(measurement, self._lines)):
                yield from (Problem(f"{where}.{one.key}", one.text) for one in mistakes)
                continue
            try:
                self.tasks[measurement.name] = self._read_task(measurement)
            except CaseError as error:
                yield from (Problem(where, problem) for problem in error.problems)
        for peer in self._about.peers:
            yield from self._check_peer(peer, names)

    def _read_task(self, measurement: Measurement) -> Task:
        unit = find_unit(measurement)
        if COMPARISONS[measurement.compare].of == LINE:
            line = self._lines[_name_line(measurement.of)]
            return Task(measurement, take_span(self._read_line(line, line.file), measurement.span), line)
        if measurement.file is None:
            assert measurement.value is not None
            return Task(measurement, take_value(measurement.value, measurement.error))
        axis = COMPARISONS[measurement.compare]
        return Task(measurement, read_series(self._find(measurement.file), axis.axis, axis.unit, unit))

    def _check_peer(self, peer: Peer, names: list[str]) -> Iterator[Problem]:
        where = f"peers ({peer.name}, {peer.of})"
        if peer.of not in names:
            hint = write_hint(peer.of, names)
            yield Problem(f"{where}.of", f"no measurement has this name, there are: {', '.join(names)}{hint}.")
        given = [key for key in ("file", "value", "rms") if getattr(peer, key) is not None]
        if len(given) != 1:
            yield Problem(where, f"{', '.join(given) or 'nothing'} is given; give file, value or rms, one of them.")
        elif task := self.tasks.get(peer.of):
            is_number = not COMPARISONS[task.measurement.compare].axis
            if given[0] == ("file" if is_number else "value"):
                mend = "give `value`" if is_number else "give `file`"
                kind = "one number" if is_number else "several points"
                yield Problem(f"{where}.{given[0]}", f"the measurement is {kind}; {mend}, or `rms`.")
                return
            try:
                self.peers.append(Scored(peer, self._read_peer(peer, task)))
            except CaseError as error:
                yield from (Problem(where, problem) for problem in error.problems)

    def _read_peer(self, peer: Peer, task: Task) -> Points | None:
        if peer.value is not None:
            return take_value(peer.value, None)
        if peer.file is None:
            return None
        if task.line is not None:
            points = self._read_line(task.line, peer.file)
            if len(points.x) < 2 or not len(find_within(task.points, points).x):
                text = f"{peer.file} has no two points with a measured one between them"
                where = f"measured is from {task.points.x[0]:g} to {task.points.x[-1]:g} m"
                raise CaseError([f"{text}; {where}: give the line there, or its `rms`."])
            return points
        axis = COMPARISONS[task.measurement.compare]
        points = read_series(self._find(peer.file), axis.axis, axis.unit, find_unit(task.measurement))
        (first, last), measured = points.x[[0, -1]], task.points.x
        if first > measured[0] or last < measured[-1]:
            text = f"{peer.file} is from {first:g} to {last:g} {axis.unit}"
            raise CaseError([f"{text}, what is measured from {measured[0]:g} to {measured[-1]:g}; give all of it."])
        return points

    def _read_line(self, line: Reference, file: str) -> Points:
        return read_points(self._find(file), line.quantity, line.axis)

    def _find(self, file: str) -> Path:
        holding = (folder for folder in self._folders if is_bare(file) and (folder / file).exists())
        return find_companion(next(holding, self._folders[0]), file, ".csv")


def _name_line(of: str) -> str:
    """quantity@height as the lines of the case are named: 0.0250 m is 0.025 m."""
    return parse_reference(f"{of}=x").name


def check_keys(measurement: Measurement, lines: dict[str, Reference]) -> Iterator[Problem]:
    """Whether `compare` is known, `of` is something that it takes, and it has the keys that it needs, and no others."""
    if measurement.compare not in COMPARISONS:
        hint = write_hint(measurement.compare, COMPARISONS)
        given = f"{show(measurement.compare)} is given"
        yield Problem("compare", f"{given}, allowed are: {', '.join(COMPARISONS)}{hint}.")
        return
    chosen = COMPARISONS[measurement.compare]
    if chosen.of == LINE:
        yield from _check_line(measurement.of, lines)
    elif isinstance(chosen.of, dict) and measurement.of not in chosen.of:
        hint = write_hint(measurement.of, chosen.of)
        yield Problem("of", f"{show(measurement.of)} is given, allowed are: {', '.join(chosen.of)}{hint}.")
    chosen_keys = [key for key in _CHOSEN if key in measurement.model_fields_set]
    for key in chosen.needs:
        if key not in chosen_keys:
            yield Problem(key, f'is missing; compare = "{chosen.name}" needs it.')
    for key in chosen_keys:
        if key not in (*chosen.needs, *chosen.takes):
            takes = ", ".join((*chosen.needs, *chosen.takes)) or "none of them"
            yield Problem(key, f'compare = "{chosen.name}" does not take it, but {takes}; remove it.')
    if measurement.span and measurement.span[0] >= measurement.span[1]:
        yield Problem(
            "span", f"{show(measurement.span)} is given; give the lower end first, and the upper one above it."
        )


def _check_line(of: str, lines: dict[str, Reference]) -> Iterator[Problem]:
    try:
        name = _name_line(of)
    except CaseError as error:
        yield Problem("of", error.problems[0].replace("=x`", "`"))
        return
    if name not in lines:
        known = ", ".join(lines) or "none"
        yield Problem("of", f"{show(of)} is no line of the case's output.references; it has: {known}. Name it there.")
