"""The velocity over an inlet that the file of its `profile_file` says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.streams import Opening, Stream, find_opening
from fbcouple.case.schema.inlets import Inlet
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.plane_cover import Circle
from fbcouple.geometry.sides import find_axes
from fbcouple.geometry.velocity_profile import Profile, make_radial, make_strips, make_triangles
from fbcouple.input_files.companion_files import find_companion
from fbcouple.input_files.number_table import Form, read_table
from fbcouple.input_files.units import LENGTHS, SPEEDS

MOST_ROWS = {"rectangle": 5000, "circle": 1000}
_ROWS, _LARGEST = "rows of a velocity over an inlet", 2_000_000
_WORDS = {"r": "radius", "u": "velocity", "v": "velocity"}


def read_profile(case: Case, inlet: Inlet, folder: Path) -> Profile:
    """The profile that the file of `inlet` says. Raises: CaseError (one text, without the key)."""
    assert inlet.profile_file is not None
    path = find_companion(case.find_folder(folder, inlet.profile_file), inlet.profile_file, ".csv")
    about = path.stat()
    return _read(path, (about.st_mtime_ns, about.st_size), find_opening(inlet))


def read_profiles(case: Case, streams: tuple[Stream, ...], folder: Path) -> tuple[Stream, ...]:
    """The streams of `case` with what files say of their profiles. Raises: CaseError (one text, without the key)."""
    if case.gas is None or not any(inlet.profile_file for inlet in case.gas.inlets):
        return streams
    return tuple(
        replace(stream, profile=read_profile(case, inlet, folder)) if inlet.profile_file else stream
        for stream, inlet in zip(streams, case.gas.inlets, strict=True)
    )


@lru_cache(maxsize=8)
def _read(path: Path, stamp: tuple[int, int], opening: Opening) -> Profile:
    """`stamp`: when the file was written, and its size."""
    shape = opening.shape
    assert shape is not None
    if isinstance(shape, Circle):
        columns = _read_columns(path, {"radius": LENGTHS, "velocity": SPEEDS}, ("radius", "velocity"))
        _require_few(path, "circle", columns["velocity"])
        profile: Profile = _name(path, make_radial, shape, columns["radius"], columns["velocity"])
    else:
        names = ["xyz"[axis] for axis in find_axes(opening.face)]
        columns = _read_columns(path, {**dict.fromkeys(names, LENGTHS), "velocity": SPEEDS}, ("velocity",))
        _require_few(path, "rectangle", columns["velocity"])
        given = [name for name in names if name in columns]
        if len(given) == 2:
            positions = np.stack([columns[name] for name in names], axis=1)
            profile = _name(path, make_triangles, shape, positions, columns["velocity"])
        elif given:
            profile = _name(path, make_strips, shape, names.index(given[0]), columns[given[0]], columns["velocity"])
        else:
            one, other = names
            text = f"{path.name} has no coordinate; a rectangle on {opening.face} takes {one} and {other}, or one"
            raise CaseError([f"{text} of them (in m): start the file with the line `{one},{other},velocity`."])
    if not profile.mean > 0.0:
        raise CaseError([f"{path.name} lets no gas in: its mean over the inlet is 0; give velocities above 0."])
    return profile


def _read_columns(path: Path, known: dict[str, dict[str, float]], needed: tuple[str, ...]) -> dict[str, np.ndarray]:
    columns = read_table(path, Form(known, needed, _ROWS, _LARGEST, _WORDS, is_all=True)).columns
    if (lowest := float(columns["velocity"].min())) < 0.0:
        text = f"{path.name} has a velocity of {lowest:g} m/s; a profile is of gas that comes in"
        raise CaseError([f"{text}: give it at or above 0, along the inward normal."])
    return columns


def _require_few(path: Path, shape: str, values: np.ndarray) -> None:
    if len(values) > MOST_ROWS[shape]:
        text = f"{path.name} has {len(values)} rows, at most {MOST_ROWS[shape]} are allowed for a {shape}"
        raise CaseError([f"{text}; give every other one, or fewer."])


def _name(path: Path, make: Callable[..., Profile], *given: Any) -> Profile:
    """What `make` makes; its errors name the file."""
    try:
        return make(*given)
    except CaseError as error:
        raise CaseError([f"{path.name}: {problem}" for problem in error.problems]) from None
