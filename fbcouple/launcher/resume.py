"""Where a run that is resumed goes on: the newest whole checkpoint, and what has changed since it was written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import fbcouple.run_folder.checkpoint
from fbcouple.case.bed.derived import dem_step
from fbcouple.case.schema.sections import Case
from fbcouple.decks.abilities import Answers
from fbcouple.errors import CaseError
from fbcouple.machine.own_key import key_file
from fbcouple.run_folder.checkpoint import Checkpoint
from fbcouple.run_folder.plain_files import format_path
from fbcouple.run_folder.provenance import Versions, list_makers
from fbcouple.solvers.versions import list_versions

_ALMOST = 1 - 1e-9

Say = Callable[[str], None]


@dataclass(frozen=True)
class Start:
    """What a run starts with: versions, the checkpoint that it goes on from, and the updates since its start."""

    versions: Versions
    checkpoint: Checkpoint | None = None
    updates: tuple[str, ...] = ()
    changed: tuple[str, ...] = ()
    """Decks and files that were changed since set-up, and trusted."""
    liggghts: Answers = field(default_factory=dict)
    """What LIGGGHTS can do, and what it cannot."""


@dataclass(frozen=True)
class Choice:
    """How a run is started, as `launch` says of each."""

    fresh: bool = False
    resume: bool = False
    until: float | None = None
    trusted: bool = False
    accept_update: bool = False
    say: Say = lambda text: None
    begin: Callable[[], None] = lambda: None
    """Called when it is sure that there is something to do."""
    sets: tuple[str, ...] = ()


def is_complete(run: Path, case: Case, say: Say = lambda text: None) -> bool:
    """Did an earlier run reach the end of the case as it is now, by its results? Not by results that cannot be read,
    which `say` is told."""
    complete, damage = look_at_results(run, case)
    if damage:
        say(f"{run / 'results.nc'}: {damage}; it is written anew")
    return complete


def look_at_results(run: Path, case: Case) -> tuple[bool, str]:
    """The same, and why results.nc cannot be read; "" where it can, or there is none."""
    path = run / "results.nc"
    if not path.exists():
        return False, ""
    import xarray as xr  # noqa: PLC0415  (loads pandas, which a run that begins has no use for)

    try:
        with xr.open_dataset(path, decode_times=False) as results:
            is_sure = results.attrs.get("ended_by") == "until_error"
            at_end = is_sure or float(results["time"][-1]) >= case.end_time * _ALMOST
            return bool(results.attrs["complete"]) and at_end, ""
    except (OSError, ValueError, LookupError, TypeError, RuntimeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        return False, f"cannot be read ({reason})"


def choose_start(run: Path, case: Case, choice: Choice) -> Start | None:
    """Where a run that is resumed goes on; None if there is nothing left to do."""
    say, until = choice.say, choice.until
    if is_complete(run, case, say):
        if choice.sets:
            text = f"the run has come to its end, {case.end_time:g} s, from which on nothing could be another"
            raise CaseError([f"--set: {run}: {text}; give a later end_time, too, or set up another run."])
        say(f"{run}: is complete: nothing is left to do")
        return None
    for stray in fbcouple.run_folder.checkpoint.list_strays(run):
        say(f"{format_path(stray)}: is no checkpoint and is left alone")
    checkpoint = _find_checkpoint(run, case, say)
    if checkpoint and checkpoint.time * _ALMOST > case.end_time + _find_dem_step(case):
        text = f"end_time: {case.end_time:g} s is given, and the run has come to t = {checkpoint.time:.6g} s"
        raise CaseError([f"{run}: {text}, its newest checkpoint; give a later one, or set up another run with it."])
    if checkpoint and until is not None and checkpoint.time >= until * _ALMOST:
        say(f"{run}: has reached t = {checkpoint.time:.6g} s already: nothing is left to do up to {until:g} s")
        return None
    versions = list_versions(case)
    if checkpoint is None:
        return Start(versions)
    updates = _list_updates(checkpoint, versions, choice.accept_update)
    if other := _note_moments(checkpoint, case):
        say(f"{run}: warning: {other}")
        updates = (*updates, other)
    if not checkpoint.index.own:
        updates = (*updates, _note_foreign(checkpoint, choice.trusted))
    return Start(versions, checkpoint, updates)


def _note_moments(checkpoint: Checkpoint, case: Case) -> str:
    """A line on moments for a checkpoint that are others than before, where the particles' solver is set up anew; "" if
    they are not."""
    before, now = checkpoint.index.moment_steps, case.checkpoint.moment_steps
    if before in (None, now):
        return ""
    text = f"checkpoint.moment_steps was {before} and is {now} now, equal to an uninterrupted run up to rounding"
    return f"from t = {checkpoint.time:.6g} s on: {text}"


def _note_foreign(checkpoint: Checkpoint, trusted: bool) -> str:
    """A line on a checkpoint that another wrote. Raises: CaseError if it is not trusted."""
    if not trusted:
        text = "its liggghts.restart is read by LIGGGHTS without a check; if you trust whoever made it say --trust"
        raise CaseError(
            [f"{format_path(checkpoint.folder)}: was not written by you, or not with the key in {key_file()}: {text}."]
        )
    return f"from t = {checkpoint.time:.6g} s on: a checkpoint of another user or machine"


def _find_dem_step(case: Case) -> float:
    """The DEM step [s], by less than which the end of a run is beyond its end_time; 0 without particles."""
    return dem_step(case.contact, case.particles) if case.contact and case.particles else 0.0


def _find_checkpoint(run: Path, case: Case, say: Say) -> Checkpoint | None:
    checkpoint, refusals = fbcouple.run_folder.checkpoint.choose(run, case)
    for line in refusals:
        say(line)
    say(
        f"{run}: resumes at t = {checkpoint.time:.6g} s from {checkpoint.folder.name}"
        if checkpoint
        else f"{run}: has no checkpoint yet: starts at t = 0"
    )
    return checkpoint


def _list_updates(checkpoint: Checkpoint, versions: Versions, accepted: bool) -> tuple[str, ...]:
    """With what else than before the run has gone on since its start, a line each time.

    Raises: CaseError if what wrote the checkpoint is not what is here, unless that is `accepted`.
    """
    before, now = checkpoint.index.made_by, list_makers(versions)
    changed = [name for name in sorted({*before, *now}) if before.get(name) != now.get(name)]
    if not changed:
        return tuple(checkpoint.index.updates)
    told = "; ".join(f"{name}: {before.get(name, 'none')} then, {now.get(name, 'none')} now" for name in changed)
    if not accepted:
        text = "the run would be of two programs; --accept-update goes on with it and notes it in results.nc"
        raise CaseError([f"{checkpoint.folder}: was written with other versions ({told}): {text}."])
    return (*checkpoint.index.updates, f"from t = {checkpoint.time:.6g} s on: {told}")
