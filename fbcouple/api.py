"""fbcouple from Python: cases, run folders and their results.

`import fbcouple` has all of it: `load_case`, `plan_case`, `setup`, `Run`, `report`, `Simulation`, `Task`. Errors are
those of the command line: `CaseError`, `SolverError`, `DivergedError`, `StoppedError` of `fbcouple.errors`.
"""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from fbcouple.arguments import in_python, say_in_python
from fbcouple.case.load import load_case as load
from fbcouple.case.plan.choice import Plan, make_plan
from fbcouple.case.schema.reference import list_defaults
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import list_sets
from fbcouple.decks import set_up
from fbcouple.errors import CaseError, StoppedError
from fbcouple.launcher.change_case import ask
from fbcouple.launcher.launch import launch
from fbcouple.launcher.progress import RunProgress
from fbcouple.launcher.resume import look_at_results
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.launchers import tell_crowd
from fbcouple.paths import LOG
from fbcouple.results.line_log import read_log
from fbcouple.run_folder.checkpoint import list_checkpoints
from fbcouple.run_folder.failure import read_note
from fbcouple.run_folder.lock import is_held
from fbcouple.run_folder.manifest import NAME as MANIFEST

if TYPE_CHECKING:
    import xarray as xr

Watch = Callable[[dict[str, Any]], None]
"""Is given each row of the history, while a run goes on."""


@dataclass(frozen=True)
class Status:
    """How far a run has come."""

    state: str
    """"set up", "running", "stopped" (with a checkpoint, to be resumed), "failed", "damaged" (its results cannot be
    read) or "complete"."""
    time: float
    """Simulated time of the last row of the history [s]; 0 before the first."""
    end_time: float
    """Simulated time at which it is complete [s]."""
    checkpoint: Path | None
    """The newest checkpoint."""
    message: str
    """Why it ended early or failed, if it did, or what is damaged."""


@in_python()
def load_case(name: str | os.PathLike[str], values: Mapping[str, Any] | None = None) -> Case:
    """Read and check a case.

    name: a shipped name (`patil/c2`), a case file, or a folder that holds a case.toml; values: key (`section.option`)
    -> value, on top of the file, as `--set` of the command line: a new `end_time` before the averages start fits them,
    with a warning.

    Raises: CaseError with every mistake found: key, value, what is allowed, and how to fix it.
    """
    name, sets = os.fspath(name), _format_sets(values)
    case = load(name, sets, _warn)
    case.remember_origin(name, sets)
    return case


def _warn(text: str) -> None:
    warnings.warn(say_in_python(text), stacklevel=5)


def _format_sets(values: Mapping[str, Any] | None) -> list[str]:
    return [f"{key}={json.dumps(value, default=_to_plain)}" for key, value in (values or {}).items()]


def _to_plain(value: Any) -> Any:
    """Numbers, lists and texts of NumPy and paths as JSON has them."""
    return value.tolist() if hasattr(value, "tolist") else os.fspath(value)


@in_python()
def setup(
    case: Case | str | os.PathLike[str],
    path: str | os.PathLike[str],
    values: Mapping[str, Any] | None = None,
    *,
    trust: bool = False,
    force: bool = False,
    overwrite: bool = False,
) -> Run:
    """Write the decks of a case into the run folder `path`.

    case: what `load_case` gave, or a name for it; values: key -> value, on top of the case; trust: also with a drag
    law that the case brings, which is run; force: also what the pre-flight numbers of `fbcouple check` call unfit;
    overwrite: what a run left in `path` is removed first, and no file of your own.

    Raises: CaseError, before anything is written, if the case is wrong or unfit, or `path` holds a run.
    """
    name, sets = _find_origin(case)
    (run,) = set_up.lay_out(name, Path(path), [*sets, *_format_sets(values)], trust, force, _warn, overwrite)
    return Run(run)


def _find_origin(case: Case | str | os.PathLike[str]) -> tuple[str, tuple[str, ...]]:
    """The name that `case` was read by, and the settings on top of it. Raises: CaseError if it has none."""
    name, sets = case.origin if isinstance(case, Case) else (os.fspath(case), ())
    if not name or name in list_sets():
        what = f"{name} is a set of cases" if name else "the case was not read by fbcouple.load_case"
        raise CaseError([f"{what}; give one that was, or a name or path."])
    return name, sets


class Run:
    """A run folder that was set up. The solvers run in processes of their own, under MPI.

    Works in any thread and in a notebook; only the main thread hears signals that ask a run to stop.
    """

    @in_python()
    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Raises: CaseError if `path` is no run folder."""
        self.path = Path(path).absolute()
        for file, what in (("case.toml", "is not a run folder"), (MANIFEST, "is a case, and no run folder")):
            if not (self.path / file).is_file():
                raise CaseError([f"{self.path}: {what} (no {file}); write one with fbcouple.setup."])

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r})"

    @property
    @in_python()
    def case(self) -> Case:
        """The effective case, every default filled in."""
        return load(str(self.path))

    def start(self, ranks: int = 1, *, fresh: bool = False, **options: Any) -> Status:
        """Run to the end on `ranks` MPI ranks.

        fresh: remove the results of an earlier run first; options: as for `resume`.
        """
        return self._launch(ranks, fresh=fresh, **options)

    def resume(self, ranks: int = 1, values: Mapping[str, Any] | None = None, **options: Any) -> Status:
        """Go on from the newest good checkpoint; without one, from the start.

        values: key -> value that are another from the checkpoint on, as {"gas.inlet_velocity": 1.2, "end_time": 4.0};
        until [s]: stop at the first step at or after it at which a checkpoint may be written; wall_limit [s]: stop with
        a checkpoint before this wall time is over; patience [s]: wall time without a step after which the run is taken
        for hanging; trust, accept_update: as on the command line; progress: a bar on the terminal or in a notebook (the
        default), False, or a function that is given each row of the history.

        Raises: CaseError, SolverError with the solver's own words, DivergedError if a check of the run failed. A run
        that stops early with a checkpoint raises nothing: its status says so.
        """
        return self._launch(ranks, resume=True, sets=_format_sets(values), **options)

    @in_python()
    def _launch(
        self,
        ranks: int,
        *,
        progress: bool | Watch = True,
        trust: bool = False,
        until: float | None = None,
        requests: Requests | None = None,
        **options: Any,
    ) -> Status:
        sets = options.get("sets", ())
        if "say" not in options and (crowd := tell_crowd(ranks)):
            _warn(crowd)
        case = ask(self.case, sets, self.path) if sets else self.case
        end = min(case.end_time, until or math.inf)
        watch: Watch = progress if callable(progress) else lambda row: None
        try:
            with nullcontext(requests) if requests else Requests() as asked:
                arguments: dict[str, Any] = {"until": until, "trusted": trust, "requests": asked} | options
                if progress is True:
                    with RunProgress(Console(), end) as bar:
                        launch(self.path, ranks, bar.show, begin=bar.start, **arguments)
                else:
                    launch(self.path, ranks, watch, **arguments)
        except StoppedError as error:
            status = self.status()  # before the first step no rank has written down why it ended
            return status if status.message else replace(status, message=str(error))
        return self.status()

    @in_python()
    def status(self, history: Sequence[Mapping[str, Any]] | None = None) -> Status:
        """How far the run has come; may be asked from another process while it is under way.

        history: its rows, where they were read already.
        """
        case, checkpoints = self.case, list_checkpoints(self.path)
        rows = self.history() if history is None else history
        message, (complete, damage) = read_note(self.path), look_at_results(self.path, case)
        if is_held(self.path):
            state = "running"
        elif complete:
            state, message = "complete", ""
        elif message and not message.startswith("stopped by"):
            state, message = "failed", f"{message}; results.nc: {damage}" if damage else message
        elif damage:
            state, message = "damaged", f"results.nc: {damage}; the run writes it anew where it is resumed"
        else:
            state = "stopped" if checkpoints else "set up"
        time = rows[-1]["time"] if rows else 0.0
        return Status(state, time, case.end_time, checkpoints[0] if checkpoints else None, message)

    @in_python()
    def history(self) -> list[dict[str, Any]]:
        """Rows of the history so far, also while the run is under way."""
        log = self.path / LOG
        return read_log(log) if log.is_file() else []

    @in_python()
    def results(self) -> xr.Dataset:
        """results.nc: time means, histories, snapshots, in memory. Raises: CaseError if there is none yet."""
        from fbcouple.results.reader import open_results  # noqa: PLC0415  (loads xarray)

        return open_results(self.path).data.load()

    @in_python()
    def post(self, folder: str | os.PathLike[str] | None = None) -> list[Path]:
        """Draw every figure that the results allow, by default into RUN/figures; returns the files."""
        from fbcouple.postproc import draw  # noqa: PLC0415  (loads matplotlib)

        return draw(self.path, Path(folder) if folder else None)


@in_python()
def plan_case(
    case: Case | str | os.PathLike[str],
    error: float,
    *,
    within: float | None = None,
    ranks: int = 1,
    values: Mapping[str, Any] | None = None,
) -> Plan:
    """Find the numerics, length of the means, replicas and ranks that reach an error of the mean map at least cost.

    case: what `load_case` gave, or a name for it; error: of the mean map of vertical solids flux over the map,
    numerical and statistical in squares; within: wall time [s] in which it is to end; ranks: cores for all replicas
    together; values: key -> value, on top of the case, which the plan leaves as they are.

    Returns: the plan; `chosen` is None where nothing reaches the error. Raises: CaseError if nothing is known of the
    error of such a case.
    """
    name, sets = _find_origin(case)
    return make_plan(name, error, within, ranks, [*sets, *_format_sets(values)])


@in_python()
def report(runs: Sequence[Run | str | os.PathLike[str]], path: str | os.PathLike[str]) -> list[Path]:
    """Compare `runs` on one HTML page that stands alone, `path`, with its numbers in a JSON file beside it.

    Returns: the two files. Raises: CaseError if a run cannot be read or a file cannot be written.
    """
    from fbcouple.postproc.report.report import write_report  # noqa: PLC0415  (loads matplotlib)

    return write_report(_list_paths(runs), Path(path))


def _list_paths(runs: Sequence[Run | str | os.PathLike[str]]) -> list[Path]:
    if isinstance(runs, str | os.PathLike):
        raise CaseError([f"runs: {os.fspath(runs)} is given, a list of runs is allowed; give [{runs!r}]."])
    return [Path(run) for run in runs]


@in_python()
def pool(
    runs: Sequence[Run | str | os.PathLike[str]],
    path: str | os.PathLike[str],
    reduced: bool = False,
    start: float | None = None,
) -> xr.Dataset:
    """Pool the means of `runs` of one case with different seeds into the file `path`.

    runs: runs, folders of replicas, or reduced files; reduced: keep depth averages alone, and of each replica what is
    needed to pool it with others later. start: time [s] from which on the blocks of their windows count, as if
    averaging had begun later; depth averages of the solids alone.

    Returns: what is written, like a run's results. Raises: CaseError if they cannot be pooled or written.
    """
    from fbcouple.results.pools import write_pool  # noqa: PLC0415  (loads xarray)

    return write_pool(_list_paths(runs), Path(path), reduced, start, list_defaults())
