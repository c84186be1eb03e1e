"""From a case, or a set of cases, to run folders: what `fbcouple setup` does."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from fbcouple.case.bed.positions import start_kinds, start_motion, start_positions, start_temperatures
from fbcouple.case.load import load_case
from fbcouple.case.preflight import require_fit
from fbcouple.case.problems import naming
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import FILE_NAME, find_case, list_sets, list_shipped
from fbcouple.case.user_code import require_trust
from fbcouple.decks.render import set_up
from fbcouple.decks.replace import refuse_foreign
from fbcouple.decks.starts import make_start
from fbcouple.errors import CaseError
from fbcouple.paths import require_usable
from fbcouple.run_folder.lock import hold
from fbcouple.run_folder.plain_files import require_plain
from fbcouple.run_folder.products import remove_run


def lay_out(
    name: str,
    output: Path | None,
    sets: Sequence[str],
    trusted: bool,
    forced: bool = False,
    say: Callable[[str], None] | None = None,
    overwrite: bool = False,
) -> dict[Path, Case]:
    """Write the run folder of the case `name`, or of each member of the set `name` in one folder.

    output: the folder; None: runs/<name>; forced: also what the pre-flight numbers call unfit; say: takes what
    is fitted to `sets` (see `load_case`), and what start is made; overwrite: what a run left there is removed, once
    every case is known to be right.

    Returns: run folder -> its case.
    Raises: CaseError, before anything is written, if a case is wrong, unfit, or brings code that is not `trusted`; of a
    set each text names the case.
    """
    members = list_sets().get(name)
    target = output or Path("runs") / name_run(name, None if members else find_case(name))
    require_usable(target)
    with tempfile.TemporaryDirectory(prefix="fbcouple-start-") as scratch:
        runs: dict[Path, tuple[Case, Path]] = {}
        for member in members or [name]:
            with naming(member) if members else nullcontext():
                case, source = load_case(member, sets, say), find_case(member)
                require_trust(case, trusted)
                law = read_own_laws(case, source.parent)
                if not forced:
                    require_fit(case, law, source.parent)
                run = target / name_run(member, source) if members else target
                runs[run] = make_start(case, source.parent, Path(scratch), say), source.parent
        _write_runs(runs, overwrite)
    return {run: case for run, (case, _) in runs.items()}


def _write_runs(runs: dict[Path, tuple[Case, Path]], overwrite: bool) -> None:
    """Write each run folder of `runs`: its case, and where the case's own files lie."""
    for run in runs:
        if overwrite and run.is_dir():
            require_plain(run)
            with hold(run):
                remove_run(run)
        refuse_foreign(run)
    for run, (case, folder) in runs.items():
        lay_out_run(case, folder, run)


def read_own_laws(case: Case, folder: Path) -> Any:
    """The drag law that `case` brings, if it brings one, from its file in `folder`; the files of all its laws are run.

    Raises: CaseError if one of them is none, or no law of what the case can have.
    """
    from fbcouple.case.tried_laws import require_sound_laws  # noqa: PLC0415  (loads numba)
    from fbcouple.case.user_laws import choose_drag, choose_nusselt  # noqa: PLC0415  (loads numba)

    drag = nusselt = None
    if case.heat and case.heat.nusselt_file is not None:
        nusselt = choose_nusselt(case.heat, case.find_folder(folder, case.heat.nusselt_file))
    if case.exchange is not None and case.exchange.drag_file is not None:
        drag = choose_drag(case.exchange, case.find_folder(folder, case.exchange.drag_file))
    if drag is not None or nusselt is not None:
        require_sound_laws(case, drag, nusselt)
    return drag


def name_run(case: str, source: Path | None) -> str:
    """Name a run after its case: patil/c2 gives patil-c2; a file gives its stem, or its folder if it is a case.toml.

    source: the case file; None for a set of shipped cases.
    """
    if source is None or case in list_shipped():
        return case.replace("/", "-")
    source = source.resolve()
    return source.parent.name if source.name == FILE_NAME else source.stem


def lay_out_run(case: Case, folder: Path, run: Path) -> None:
    """Set up `run`, with the case's own files (which lie in `folder`) beside the effective case."""
    try:
        read = partial(start_positions, folder=folder), partial(start_kinds, folder=folder)
        more = partial(start_motion, folder=folder), partial(start_temperatures, folder=folder)
        set_up(case, run, *read, *more, folder)
    except OSError as error:
        raise CaseError([f"{run}: cannot be written ({error.strerror}); give another folder with -o."]) from error
