"""The particles of another run, of a checkpoint or a frame, as the start of a case."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fbcouple.case.bed.particle_types import find_ratio, list_kinds
from fbcouple.case.bed.start_file import StartFile
from fbcouple.case.bed.start_sizes import is_coarse, match_kinds, tell_ratios
from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.decks.alone import Particles, read_restart
from fbcouple.errors import CaseError
from fbcouple.paths import FRAMES
from fbcouple.run_folder.checkpoint import list_checkpoints, read
from fbcouple.run_folder.manifest import hash_file
from fbcouple.run_folder.plain_files import require_plain

if TYPE_CHECKING:
    from fbcouple.results.frames import Frame

_RESTART = "liggghts.restart"
_ALMOST = 1e-6


@dataclass(frozen=True)
class Source:
    """Where in another run its particles are: the file, the time [s] of it, and a checkpoint's folder or a frame."""

    file: Path
    time: float
    frame: Frame | None


def find_source(run: Path, time: float | None) -> tuple[Case, Source]:
    """The case of the run folder `run`, and its checkpoint or frame of `time` [s]; None: the newest, checkpoints first.

    Raises: CaseError (one text, without the key) if there is none.
    """
    if not (run / "case.toml").is_file():
        raise CaseError([f"{run} is no run folder (no case.toml); give the path of one from the folder of the case."])
    require_plain(run)
    case = load_case(str(run))
    if case.particles is None:
        raise CaseError([f"{run} is a run without particles; give one that has some."])
    try:
        return case, _choose(run, case, time)
    except OSError as error:
        raise CaseError([f"{run}: {error.filename} cannot be read: {error.strerror}; is the run under way?"]) from error


def _choose(run: Path, case: Case, time: float | None) -> Source:
    checkpoints, frames = list_checkpoints(run), sorted((run / FRAMES).glob("frame-*.nc"))
    if not checkpoints and not frames:
        raise CaseError([f"{run} has neither checkpoints nor frames; run it, with output.particles_every for frames."])
    if time is None:
        return _look_into(checkpoints[0], case) if checkpoints else _open_frame(frames[-1])
    every = case.output.particles_every
    found = [_look_into(folder, case) for folder in checkpoints]
    found += [_open_frame(path) for path in _list_near(frames, every, time)]
    nearest = min(found, key=lambda source: (round(abs(source.time - time), 9), source.frame is not None))
    if abs(nearest.time - time) > max(every or 0.0, _ALMOST * time):
        text = f"{run} has nothing at {time:g} s"
        raise CaseError([f"{text}; the nearest checkpoint or frame is of {nearest.time:.6g} s."])
    return nearest


def _look_into(folder: Path, case: Case) -> Source:
    """A checkpoint that is whole and this user's own."""
    found = read(folder, case)
    if not found.index.own:
        text = f"{folder} was not written by you, and nothing can check LIGGGHTS' restart file in it"
        raise CaseError([f"{text}; take a frame (start.time), or a dump of it by particles.positions."])
    return Source(folder / _RESTART, found.time, None)


def _open_frame(path: Path) -> Source:
    from fbcouple.results.frames import read_frame  # noqa: PLC0415  (loads xarray)

    frame = read_frame(path)
    return Source(path, frame.time, frame)


def _list_near(frames: list[Path], every: float | None, time: float) -> list[Path]:
    """The frames that are nearest to `time` by their numbers, one each `every` [s]."""
    if every is None:
        return frames
    middle = min(round(time / every), len(frames) - 1)
    return frames[max(middle - 1, 0) : middle + 2]


def read_particles(case: Case, run: Path, other: Case, source: Source) -> Particles:
    """The particles of `source` in the run folder `run` of the case `other`, with the kinds that `case` has for them.

    Raises: CaseError (one text, without the key) if `case` has no such kinds; SolverError if LIGGGHTS fails.
    """
    assert case.particles is not None and other.particles is not None
    known = list_kinds(other.particles)
    if source.frame is None:
        held = read_restart(other, run, source.file)
    else:
        held = _read_frame(source.frame, np.array([kind.diameter for kind in known]), run, source.file.name)
    start = StartFile(
        held.positions,
        types=held.kinds + 1,
        diameters=np.array([kind.diameter for kind in known])[held.kinds],
        densities=np.array([kind.density for kind in known])[held.kinds],
    )
    theirs, ours = find_ratio(other.particles), find_ratio(case.particles)
    if is_coarse(theirs / ours):
        raise CaseError([f"{run}: {tell_ratios(theirs, ours)}"])
    kinds = match_kinds(case.particles, start)
    assert kinds is not None
    return Particles(held.positions, held.motion, kinds, held.temperatures)


def _read_frame(frame: Frame, diameters: np.ndarray, run: Path, name: str) -> Particles:
    """A frame says of the kinds the diameters only; it is in single precision, and of no spin."""
    if not np.isfinite(frame.positions).all() or not np.isfinite(frame.velocities).all():
        raise CaseError([f"{run}: {name} has positions or velocities that are not finite; take another time."])
    apart = np.abs(frame.diameters[:, None].astype(float) / diameters[None] - 1.0)
    kinds = apart.argmin(axis=1)
    if (apart.min(axis=1) > _ALMOST).any():
        raise CaseError([f"{run}: {name} has diameters that its case has not; take another frame, or a checkpoint."])
    if len(np.unique(diameters.astype(np.float32))) < len(diameters):
        text = f"{run} has kinds of one diameter, which frames do not tell apart"
        raise CaseError([f"{text}; take a checkpoint (without start.time the newest)."])
    motion = np.hstack([frame.velocities.astype(float), np.zeros_like(frame.velocities, float)])
    warmth = None if frame.temperatures is None else frame.temperatures.astype(float)
    return Particles(frame.positions.astype(float), motion, kinds, warmth)


def describe(run: Path, other: Case, source: Source) -> str:
    """Say in a line what the particles are of."""
    file_name = source.file.relative_to(run).as_posix()
    title = other.title
    digest = hash_file(source.file)
    return f"particles of the run {run} ({title}) at t = {source.time:.6g} s: {file_name}, SHA-256 {digest}"
