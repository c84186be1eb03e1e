"""Figures of a run, drawn from its results.nc alone: no MPI, no solver, no running simulation."""

from __future__ import annotations

import logging
from pathlib import Path

from fbcouple.postproc.figures import bubbles, cost, depth, history, maps, profiles, snapshots, spectrum
from fbcouple.postproc.figures.registry import COMPARISONS, FIGURES
from fbcouple.postproc.files import remove
from fbcouple.postproc.papers.hamidouche2019 import impact
from fbcouple.postproc.style import journal_style, save
from fbcouple.postproc.views import views
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results, open_results

__all__ = [
    "COMPARISONS",
    "FIGURES",
    "NotDrawableError",
    "Results",
    "bubbles",
    "cost",
    "depth",
    "draw",
    "history",
    "impact",
    "maps",
    "open_results",
    "profiles",
    "snapshots",
    "spectrum",
    "views",
]


_log = logging.getLogger(__name__)


def draw(run: Path, folder: Path | None = None) -> list[Path]:
    """Draw every figure of `FIGURES` that the results allow.

    A figure whose quantities the case does not have (no gas, no particles) is left out with a warning that says
    why, one that is meant for another kind of case without a word; an older picture of that name is removed, for it
    would show other results.

    Parameters: `run`, the folder that holds results.nc; `folder` of the figures, by default RUN/figures.
    Returns: the PNG files written, in the order of the registry.
    Raises: CaseError if results.nc is missing, is not readable, or allows no figure, or if a file cannot be written.
    """
    results = open_results(run)
    folder = folder or Path(run) / "figures"
    written: list[Path] = []
    left_out: list[str] = []
    for name, make in FIGURES.items():
        path = folder / f"{name}.png"
        try:
            with journal_style():
                written.append(save(make(results), path, results.title))
        except NotMeantError:
            remove(path)
        except NotDrawableError as reason:
            remove(path)
            left_out.append(f"{path.name} left out: {reason}")
            _log.warning(left_out[-1])
    if not written:
        raise NotDrawableError([f"{results.path}: none of the figures can be drawn.", *left_out])
    return written
