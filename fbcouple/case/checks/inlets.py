"""Whether the tables [[gas.inlets]] and [[gas.outlets]] say where gas comes in and leaves, and fit the region."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.adopt_inlets import find_areas, find_inlet_section, read_ramp
from fbcouple.case.bed.inlet_profile import read_profile
from fbcouple.case.bed.region import find_openings
from fbcouple.case.bed.streams import find_opening, find_outline, has_openings, list_above, list_streams
from fbcouple.case.checks.registry import check, examine_times
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.gas import Domain, Gas
from fbcouple.case.schema.inlets import Inlet, Outlet
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.plane_cover import Circle, Shape, cross_each_other, measure_cover
from fbcouple.geometry.sides import SIDES, find_axes

_ROUNDING = 1e-9
_AGREES = 1e-6


@check("gas.inlets", "gas.outlets", "domain")
def check_openings(case: Case, folder: Path) -> Iterator[Problem]:
    """Each opening is on a face of the region or of a patch, and lets gas through; inlets and outlets are apart."""
    if case.gas is None or not has_openings(case):
        return
    problems = [*_check_other_words(case, case.gas)]
    for number, inlet in enumerate(case.gas.inlets, start=1):
        texts = [*_check_place(case.domain, inlet), *_check_velocity(case, inlet, folder)]
        problems += [Problem("gas.inlets", f"inlet {number}: {text}") for text in texts]
    for number, outlet in enumerate(case.gas.outlets, start=1):
        problems += [Problem("gas.outlets", f"outlet {number}: {text}") for text in _check_place(case.domain, outlet)]
    yield from problems
    if not problems:
        yield from _check_together(case, case.gas, folder)


def _check_other_words(case: Case, gas: Gas) -> Iterator[Problem]:
    """What says the same in another way is not given, too."""
    domain = case.domain
    others: dict[str, dict[str, Any]] = {
        "gas.inlets": {
            "domain.inlet": domain.inlet,
            "gas.closed_nozzle": gas.closed_nozzle,
            "gas.closed_nozzle_size": gas.closed_nozzle_size,
        },
        "gas.outlets": {"domain.outlet": domain.outlet, "gas.top": gas.top if gas.top == "closed" else None},
    }
    for key, words in others.items():
        given = gas.inlets if key == "gas.inlets" else gas.outlets
        for word in (word for word, value in words.items() if given and value is not None):
            mend = "a table with velocity = 0 closes what it covers" if "nozzle" in word else "the tables say it all"
            yield Problem(word, f"it and {key} are both given; remove it ({mend}).")
    if gas.closed_nozzle and (gas.closed_nozzle_size or gas.outlets):
        other = "closed_nozzle_size" if gas.closed_nozzle_size else "outlets"
        mend = "remove it, and give closed_nozzle_size in m"
        yield Problem("gas.closed_nozzle", f"it and {other} are both given; {mend}.")
    if gas.closed_nozzle_size:
        width, depth = domain.size[:2]
        along, across = gas.closed_nozzle_size
        if domain.shape != "box":
            text = f"{show(gas.closed_nozzle_size)} is given and domain.shape is {show(domain.shape)}"
            mend = "only a box has it: give [[gas.inlets]], the last of them in its place with velocity = 0."
            yield Problem("gas.closed_nozzle_size", f"{text}; {mend}")
        elif along > width * (1 + _ROUNDING) or across > depth * (1 + _ROUNDING) or along * across >= width * depth:
            text = f"{show(gas.closed_nozzle_size)} is given on a floor of {width:g} x {depth:g} m"
            yield Problem("gas.closed_nozzle_size", f"{text} and leaves nothing open or sticks out; give less.")


def _check_place(domain: Domain, table: Inlet | Outlet) -> Iterator[str]:
    given = [key for key in ("rectangle", "circle", "patches") if getattr(table, key)]
    wanted = ["patches"] if domain.shape == "file" else ["rectangle", "circle"]
    if len(given) != 1 or given[0] not in wanted:
        found = " and ".join(given) or "none of rectangle, circle and patches"
        yield f"{found} is given and domain.shape is {show(domain.shape)}; give {' or '.join(wanted)}, one of them."
        return
    if table.patches:
        return
    if domain.shape == "cylinder" and table.face not in ("floor", "top"):
        yield f'face = "{table.face}" is given, a cylinder has them on its floor and its top; give one of these.'
        return
    if table.face in SIDES and "xyz"[SIDES[table.face][0]] in domain.periodic:
        yield f'face = "{table.face}" is given and the bed repeats itself there; give another face.'
        return
    shape = find_opening(table).shape
    assert shape is not None
    if shape.area <= 0.0:
        yield f"{show(table.rectangle or table.circle)} has no area; give two opposite corners."
    elif not _is_on_face(domain, table.face, shape):
        names = ["xyz"[axis] for axis in find_axes(table.face)]
        low, high = find_outline(domain, table.face).min(axis=0), find_outline(domain, table.face).max(axis=0)
        ends = zip(names, low.tolist(), high.tolist(), strict=True)
        allowed = " and ".join(f"{name} from {start:g} to {end:g} m" for name, start, end in ends)
        circle = ", within the circle" if domain.shape == "cylinder" else ""
        text = f"{show(table.rectangle or table.circle)} sticks out of the face {table.face}"
        yield f"{text}, which has {allowed}{circle}; move it, or make it smaller."


def _is_on_face(domain: Domain, face: str, shape: Shape) -> bool:
    outline = find_outline(domain, face)
    if domain.shape == "cylinder":
        return measure_cover(outline, shape) >= shape.area * (1.0 - _ROUNDING)
    room = _ROUNDING * outline.max()
    low, high = shape.bounds
    return bool(np.all(low >= outline.min(axis=0) - room) and np.all(high <= outline.max(axis=0) + room))


def _check_velocity(case: Case, inlet: Inlet, folder: Path) -> Iterator[str]:
    yield from _check_profile(case, inlet, folder)
    ways = [inlet.velocity, inlet.ramp_file if inlet.ramp_file is not None else inlet.ramp]
    given = sum(way is not None for way in ways)
    if given > 1 or (given == 0 and inlet.profile_file is None):
        found = "velocity and a ramp are both" if given else "no velocity is"
        yield f"{found} given; give velocity, ramp or ramp_file, one of them (in m/s)."
    if inlet.ramp_file is not None:
        try:
            if read_ramp(case, inlet, folder) != inlet.ramp:
                yield "ramp and ramp_file are both given and differ; remove ramp, which follows from the file."
        except CaseError as error:
            yield from error.problems
    times = [time for time, _ in inlet.ramp or ()]
    if text := examine_times("row {} of its ramp", times):
        yield text
        return
    if times and times[0] < 0.0:
        yield f"its ramp starts at {times[0]:g} s; start at 0 s or later."


def _check_profile(case: Case, inlet: Inlet, folder: Path) -> Iterator[str]:
    given = f'profile = "{inlet.profile}"' if inlet.profile != "flat" else "profile_file" if inlet.profile_file else ""
    if given and inlet.patches:
        yield f"{given} is given with patches; only a rectangle or a circle has one: remove it."
        return
    if inlet.profile_file is None:
        if inlet.peak is not None:
            yield "peak is given without profile_file, of which it follows; remove it."
        return
    if inlet.profile != "flat":
        yield f"{given} and profile_file are both given; give one of them."
    if find_opening(inlet).shape is None:
        return
    try:
        peak = read_profile(case, inlet, folder).peak
    except CaseError as error:
        yield from error.problems
        return
    if inlet.peak is not None and abs(inlet.peak - peak) > _AGREES * peak:
        yield f"peak = {inlet.peak:g} is given and it is {peak:.7g}; remove it, it follows from profile_file."


def _check_together(case: Case, gas: Gas, folder: Path) -> Iterator[Problem]:
    streams = list_streams(case)
    shapes = [(n, s.opening.face, s.opening.shape) for n, s in enumerate(streams, start=1)]
    discs = [(n, face, shape) for n, face, shape in shapes if isinstance(shape, Circle)]
    for (one, face, first), (other, side, second) in combinations(discs, 2):
        if face == side and cross_each_other(first, second):
            text = f"the circles of inlets {one} and {other} cross each other"
            yield Problem("gas.inlets", f"{text}; move them apart, or one into the other.")
            return
    for number, stream in enumerate(streams):
        shape = stream.opening.shape
        is_flat = stream.is_flat and gas.inlets[number].profile_file is None if gas.inlets else True
        if not is_flat and shape and any(_overlap(shape, other) for other in list_above(streams, number)):
            text = f"inlet {number + 1}: it has a profile and another inlet lies on it"
            yield Problem("gas.inlets", f"{text}; give it after that one, or a flat profile.")
            return
    try:
        find_openings(case, folder)
        areas = find_areas(case, folder)
    except CaseError as error:
        yield from (Problem(_find_key(gas, problem), problem) for problem in error.problems)
        return
    if gas.inlets:
        yield from _check_areas(case, gas, areas)


def _find_key(gas: Gas, problem: str) -> str:
    """The option that a text about openings is of."""
    if problem.startswith("outlet "):
        return "gas.outlets" if gas.outlets else "domain.outlet"
    return "gas.inlets" if gas.inlets else "gas.outlets"


def _overlap(one: Shape, other: Shape) -> bool:
    (low, high), (other_low, other_high) = one.bounds, other.bounds
    return bool(np.all(low < other_high) and np.all(other_low < high))


def _check_areas(case: Case, gas: Gas, areas: np.ndarray) -> Iterator[Problem]:
    """Each inlet has an area left, and what the case says of areas is what follows."""
    streams = list_streams(case)
    for number, (inlet, area) in enumerate(zip(gas.inlets, areas.tolist(), strict=True), start=1):
        if area <= 0.0 and not streams[number - 1].is_closed:
            text = f"inlet {number}: later ones cover all of it"
            yield Problem("gas.inlets", f"{text}; put it behind them in the file, or remove it.")
        elif inlet.area is not None and abs(inlet.area - area) > _AGREES * area:
            text = f"inlet {number}: area = {inlet.area:g} m2 is given and it has {area:.7g} m2"
            yield Problem("gas.inlets", f"{text}; remove area, which follows from the rest.")
    section = find_inlet_section(case, areas)
    if gas.inlet_section is not None and abs(gas.inlet_section - section) > _AGREES * section:
        text = f"{gas.inlet_section:g} m2 is given and it is {section:.7g} m2"
        yield Problem("gas.inlet_section", f"{text}; remove it, it follows from the rest.")
