"""One run of a study: set up, run, or left as it is when an earlier call has finished it."""

from __future__ import annotations

import json
import shutil
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FrameType
from typing import Literal

from fbcouple.api import Run
from fbcouple.case.load import load_case, write_case
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import find_case
from fbcouple.decks.set_up import lay_out
from fbcouple.decks.starts import expect_start
from fbcouple.errors import DivergedError, SolverError, StoppedError
from fbcouple.launcher.resume import is_complete
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.stop_signals import WALL_LIMIT
from fbcouple.results.reader import open_results
from fbcouple.run_folder.checkpoint import list_checkpoints
from fbcouple.run_folder.plain_files import require_plain
from fbcouple.run_folder.products import remove_run
from fbcouple.study.source import Settings, format_settings

ENDING = "ending.json"
_GRACE = 30.0
"""Wall time [s] beyond its limit after which a run that has not stopped by itself is ended."""
How = Literal["complete", "diverged", "failed", "out of time", "interrupted", "not run"]


@dataclass(frozen=True)
class Ending:
    """How a run ended, in its own words, and the wall time [s] from set-up to end."""

    how: How
    text: str
    seconds: float
    ranks: int

    @property
    def is_final(self) -> bool:
        """Would the same run end the same way again?"""
        return self.how in ("complete", "diverged")

    @property
    def goes_on(self) -> bool:
        """Does the same run, asked for again, go on from its checkpoint?"""
        return self.how in ("out of time", "interrupted")


class OutOfTimeError(Exception):
    """The wall limit of a run is over."""


def run_case(
    base: str, settings: Settings, run: Path, ranks: int, wall_limit: float, requests: Requests | None = None
) -> Ending:
    """Run the case `base` under `settings` in the folder `run`, unless it has been run to its end there before.

    A run that stopped early with a checkpoint goes on from it, and one that was brought to its end by `fbcouple run`
    stays; a folder that holds another case, or a run that failed, is laid out afresh. requests: to stop, by default the
    signals that come while it is under way.

    Raises: CaseError if the case is wrong or the folder cannot be written.
    """
    if requests is None:
        with Requests() as own:
            return run_case(base, settings, run, ranks, wall_limit, own)
    require_plain(run)
    case = _expect(base, settings)
    holds = _holds(run, case)
    known, complete = _read_ending(run, ranks) if holds else None, holds and is_complete(run, case)
    if known and (known.how == "diverged" or (known.how == "complete" and complete)):
        return known
    if complete and (seconds := _find_seconds(run, ranks)) is not None:
        return _keep_ending(run, Ending("complete", "", seconds, ranks))
    begin, before = time.monotonic(), 0.0
    if holds and not complete and list_checkpoints(run) and (known is None or known.goes_on):
        before = known.seconds if known else 0.0
    else:
        remove_run(run)
        run.parent.mkdir(parents=True, exist_ok=True)
        if not _lay_out(base, settings, run, requests):
            return Ending("interrupted", _stop_early(requests), 0.0, ranks)
    how, text = _start(run, ranks, wall_limit, requests)
    return _keep_ending(run, Ending(how, text, before + time.monotonic() - begin, ranks))


def _lay_out(base: str, settings: Settings, run: Path, requests: Requests) -> bool:
    """Set the case up in `run`; False if a request to stop came before or meanwhile."""
    try:
        with requests.at_once():
            lay_out(base, run, format_settings(settings), trusted=False, forced=True)
    except KeyboardInterrupt:
        if not requests.count:
            raise
    except SolverError:
        if not requests.count:  # a signal to all processes ends also the one that pours
            raise
    return not requests.count


def _stop_early(requests: Requests) -> str:
    return f"stopped by {requests.first} before the first step"


def _keep_ending(run: Path, ending: Ending) -> Ending:
    (run / ENDING).write_text(json.dumps(asdict(ending)) + "\n", encoding="utf-8")
    return ending


def _find_seconds(run: Path, ranks: int) -> float | None:
    """Wall time [s] of the complete run in `run`, by its results; None if it was on another number of ranks."""
    about = open_results(run).data.attrs
    return float(about["core_seconds"]) / ranks if about.get("ranks") == ranks else None


def run_from_middle(run: Path, again: Path, ranks: int, wall_limit: float, requests: Requests) -> Ending | None:
    """Run in the folder `again` what `run` did after its oldest checkpoint, unless that has been done before.

    Returns: how it ended; None if `run` has no checkpoint from before its end.
    Raises: CaseError if the checkpoint is damaged.
    """
    checkpoints = list_checkpoints(run)
    of_end = int(is_complete(run, load_case(str(run / "case.toml"))))
    if len(checkpoints) == of_end:
        return None
    known = _read_ending(again, ranks)
    if known and known.is_final and (again / ENDING).stat().st_mtime > (run / ENDING).stat().st_mtime:
        return known
    require_plain(again)
    remove_run(again)
    later = [checkpoint.name for checkpoint in checkpoints[:-1]]
    kept = shutil.ignore_patterns(ENDING, "results.nc", "logs", *later)
    shutil.copytree(run, again, ignore=kept, dirs_exist_ok=True)
    (again / "logs").mkdir(exist_ok=True)
    begin = time.monotonic()
    how, text = _start(again, ranks, wall_limit, requests)
    return _keep_ending(again, Ending(how, text, time.monotonic() - begin, ranks))


def require_uninterrupted(folder: Path, requests: Requests, ended: Sequence[Ending], asked: int) -> None:
    """Raise StoppedError if not all of the `asked` runs in `folder` have `ended`, or one of them was interrupted."""
    done = [ending for ending in ended if ending.how != "interrupted"]
    if len(done) < asked:
        cause = f" ({requests.first})" if requests.first else ""
        text = f"interrupted{cause}; {len(done)} of {asked} runs have ended; call it again to go on"
        raise StoppedError(f"{folder}: {text}")


def look_up_case(base: str, settings: Settings, run: Path, ranks: int) -> Ending:
    """How the run of the case `base` under `settings` in the folder `run` ended; nothing is run.

    Raises: CaseError if the case is wrong.
    """
    known = _find_ending(run, _expect(base, settings), ranks)
    return known or Ending("not run", "has not been run to an end", 0.0, ranks)


def _expect(base: str, settings: Settings) -> Case:
    """The case as its run folder has it."""
    return expect_start(load_case(base, format_settings(settings)), find_case(base).parent)


def _find_ending(run: Path, case: Case, ranks: int) -> Ending | None:
    return _read_ending(run, ranks) if _holds(run, case) else None


def _holds(run: Path, case: Case) -> bool:
    """Is the effective case in `run` this one?"""
    if not (run / "case.toml").is_file():
        return False
    wanted = run / ".wanted.toml"
    write_case(case, wanted)
    same = wanted.read_text(encoding="utf-8") == (run / "case.toml").read_text(encoding="utf-8")
    wanted.unlink()
    return same


def _read_ending(run: Path, ranks: int) -> Ending | None:
    """How the run in `run` ended on so many ranks, if it is known."""
    if not (run / ENDING).is_file():
        return None
    ending = Ending(**json.loads((run / ENDING).read_text(encoding="utf-8")))
    return ending if ending.ranks == ranks else None


def _start(run: Path, ranks: int, wall_limit: float, requests: Requests) -> tuple[How, str]:
    if requests.count:
        return "interrupted", _stop_early(requests)
    try:
        with limit_wall(wall_limit + _GRACE):
            status = Run(run).resume(ranks, progress=False, wall_limit=wall_limit, requests=requests)
    except DivergedError as error:
        return "diverged", str(error)
    except SolverError as error:
        return "interrupted" if requests.count > 1 else "failed", str(error)
    except OutOfTimeError as error:
        text, is_late = str(error), not requests.count
    else:
        if status.state == "complete":
            return "complete", ""
        text, is_late = status.message, status.message.startswith(f"stopped by {WALL_LIMIT}")
    return ("out of time", f"{text} (wall_limit = {wall_limit:g} s)") if is_late else ("interrupted", text)


@contextmanager
def limit_wall(seconds: float) -> Iterator[None]:
    """Raise OutOfTimeError in the block when `seconds` of wall time are over (main thread only)."""

    def end(number: int, frame: FrameType | None) -> None:
        raise OutOfTimeError("ended by force")

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
