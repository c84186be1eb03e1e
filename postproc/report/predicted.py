"""What a run was predicted to cost and how sure its means were to be, beside what came."""

from __future__ import annotations

import math
from typing import Any

from fbcouple.postproc.report.monitors import find_flux_error
from fbcouple.results.reader import NotDrawableError, Results

Rows = list[dict[str, Any]]


def tabulate_predicted(results: Results) -> Rows:
    """A row a number: predicted, the factor that it was to be within, and found; none of a run that has no prediction.

    The wall time is that of the steps up to the time that the run has reached; the error of the means that of the
    window it was predicted for, so that a run that stopped early has none.
    """
    rows = []
    end, reached = (_read(results, name) for name in ("predicted_end", "time"))
    if end > 0.0 and reached > 0.0:
        told, found = _read(results, "predicted_seconds") * reached / end, _sum_steps(results)
        rows.append(_compare("wall time of the steps [s]", told, _read(results, "predicted_factor"), found))
    told = _read(results, "predicted_error")
    if math.isfinite(told) and (results.complete or reached >= end):
        try:
            found = find_flux_error(results)
        except NotDrawableError:
            found = math.nan
        rows.append(_compare("error of the means", told, _read(results, "predicted_error_factor"), found))
    return [row for row in rows if math.isfinite(row["predicted"])]


def _sum_steps(results: Results) -> float:
    """Wall time [s] of the steps: without the row of the start, which a prediction leaves out."""
    walls = results.history("wall_seconds")
    return float(walls.where(walls["time"] > 0.0).sum())


def _read(results: Results, name: str) -> float:
    if name == "time":
        return float(results.data["time"].values[-1]) if results.data.sizes.get("time") else math.nan
    return float(results.data.attrs.get(name, math.nan))


def _compare(what: str, told: float, factor: float, found: float) -> dict[str, Any]:
    ratio = found / told if told > 0.0 else math.nan
    is_within = ratio * factor >= 1.0 and ratio <= factor
    verdict = ("yes" if is_within else "no") if math.isfinite(ratio) else ""
    columns = {"what": what, "predicted": told, "within a factor of": factor, "found": found}
    return columns | {"found over predicted": ratio, "as told": verdict}
