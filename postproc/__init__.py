"""Figures of a run, drawn from its results.nc alone: no MPI, no solver, no running simulation."""

from __future__ import annotations

import difflib
import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fbcouple.errors import CaseError
from fbcouple.paths import find_home
from fbcouple.postproc.averaging import list_warnings
from fbcouple.postproc.figures import (
    bubbles,
    cost,
    depth,
    fluidization_curve,
    history,
    maps,
    means_error,
    measured_lines,
    mixing,
    probes,
    profiles,
    radial_profiles,
    sections,
    snapshots,
    spectrum,
    temperature,
    throughput,
)
from fbcouple.postproc.figures.registry import COMPARISONS, FIGURES
from fbcouple.postproc.files import remove
from fbcouple.postproc.papers.hamidouche2019 import impact
from fbcouple.postproc.style import journal_style, save
from fbcouple.postproc.views import views
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results, open_results
from fbcouple.results.view import BED, View

__all__ = [
    "COMPARISONS",
    "FIGURES",
    "FORMATS",
    "NotDrawableError",
    "Results",
    "View",
    "bubbles",
    "cost",
    "depth",
    "draw",
    "fluidization_curve",
    "history",
    "impact",
    "maps",
    "means_error",
    "measured_lines",
    "mixing",
    "open_results",
    "probes",
    "profiles",
    "radial_profiles",
    "sections",
    "snapshots",
    "spectrum",
    "temperature",
    "throughput",
    "views",
]


_log = logging.getLogger(__name__)


FORMATS = ("png", "svg", "pdf")


def draw(
    run: Path, folder: Path | None = None, only: Sequence[str] = (), ending: str = "png", view: View = BED
) -> list[Path]:
    """Draw every figure of `FIGURES`, or those named in `only`, that the results allow.

    A figure whose quantities the case does not have (no gas, no particles) is left out with a warning that says
    why, one that is meant for another kind of case without a word; an older picture of that name is removed, for it
    would show other results.

    Parameters: `run`, the folder that holds results.nc; `folder` of the figures, by default RUN/figures; `ending` of
    the files, of `FORMATS`; `view`: heights of profiles, and how far up maps go.
    Returns: the files written, in the order of the registry.
    Raises: CaseError if results.nc is missing, is not readable, or allows no figure, if a name is no figure's, or if a
    file cannot be written.
    """
    _require_figures(only)
    results = replace(open_results(run), view=view)
    folder = folder or find_home(Path(run)) / "figures"
    for text in list_warnings([results]):
        _log.warning(text)
    written: list[Path] = []
    left_out: list[str] = []
    for name in [name for name in FIGURES if name in only or not only]:
        path = folder / f"{name}.{ending}"
        try:
            with journal_style():
                written.append(save(FIGURES[name](results), path, results.title))
        except NotDrawableError as reason:
            _remove_older(folder, name)
            if not isinstance(reason, NotMeantError) or only:
                left_out.append(f"{path.name} left out: {reason}")
                _log.warning(left_out[-1])
    if not written:
        raise NotDrawableError([f"{results.path}: none of the figures can be drawn.", *left_out])
    return written


def _require_figures(names: Sequence[str]) -> None:
    """Raise CaseError with every name that is no figure's."""
    problems = []
    for name in names:
        if name not in FIGURES:
            close = difflib.get_close_matches(name, FIGURES, 1)
            hint = f"; did you mean `{close[0]}`?" if close else "."
            problems.append(f"--only: {name!r} is no figure, there are {', '.join(sorted(FIGURES))}{hint}")
    if problems:
        raise CaseError(problems)


def _remove_older(folder: Path, name: str) -> None:
    """Remove the pictures of that name of other results, whatever their format."""
    for ending in FORMATS:
        remove(folder / f"{name}.{ending}")
