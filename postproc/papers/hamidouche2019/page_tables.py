"""Tables of the page: the runs, the twins, who made them, and numbers beside figures that no claim speaks of."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fbcouple.physics.contact import Impact
from fbcouple.postproc import measures
from fbcouple.postproc.averaging import format_window
from fbcouple.postproc.figures.depth import cut_moment, depth_lines
from fbcouple.postproc.measures import Measured
from fbcouple.postproc.papers.hamidouche2019.impact import SCHEMES
from fbcouple.postproc.papers.hamidouche2019.judging import word
from fbcouple.postproc.papers.hamidouche2019.paper_numerics import list_numerics
from fbcouple.postproc.papers.hamidouche2019.paper_runs import identify, list_twins
from fbcouple.postproc.papers.hamidouche2019.run_uses import Use
from fbcouple.postproc.report.monitors import MONITORS, find_flux_error
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.view import View

Rows = list[dict[str, Any]]
RESTITUTION = 0.97
_MAKERS = ("fbcouple", "commit", "OpenFOAM", "LIGGGHTS", "MPI", "machine")
MEASURES: dict[str, tuple[Callable[[Results], Measured], float]] = {
    "bed height [mm]": (measures.bed_height, 1e3),
    "the centre of mass moves by [%]": (measures.centre_fluctuation, 100.0),
    "flux in the middle over rho U_f, z/H = 0.092": (measures.middle_flux, 1.0),
    "flux at the walls over rho U_f, z/H = 0.092": (measures.wall_flux, 1.0),
    "magnitude of the flux [kg m-2 s-1]": (measures.flux_magnitude, 1.0),
    "solids fraction at the side walls": (measures.wall_solids, 1.0),
    "agitation of the dense bed [m2 s-2]": (measures.bed_agitation, 1.0),
}
"""What is told of a bed: in words with its unit, how it is measured, and the factor to that unit."""


def _try(measure: Callable[[], float]) -> float:
    """A number, or nan where the run does not have it yet."""
    try:
        return measure()
    except NotDrawableError:
        return math.nan


def tabulate_runs(uses: Sequence[Use]) -> Rows:
    """Which bed each run counts for, its length, cost, statistical error, weight and conservation."""
    return [_describe_run(use) for use in uses]


def _describe_run(use: Use) -> dict[str, Any]:
    run = use.run
    contacts, beds = identify(run)
    drop, held = (_measure_history(run, name) for name in ("pressure_drop", "gas_support"))
    weight = run.weight_per_area
    return {
        "run": run.label,
        "bed": ", ".join(beds) or "none of the paper's",
        "counts for": use.words,
        "e": contacts.removeprefix("e = "),
        "numerics that are not the paper's": ", ".join(list_numerics(run.case)) if beds else "",
        "simulated [s]": run.simulated,
        "means over": format_window(run),
        "ended by": str(run.data.attrs.get("ended_by", "")) or ("end" if run.complete else "not complete"),
        "replicas": run.replicas,
        "core-hours": float(run.data.attrs.get("core_seconds", math.nan)) / 3600.0,
        "error of the flux map over the map": _try(lambda: find_flux_error(run)),
        "pressure drop [Pa]": drop.value,
        "its standard error [Pa]": drop.error,
        "weight over the area [Pa]": math.nan if weight is None else weight,
        "pressure drop over the weight": math.nan if weight is None else drop.value / weight,
        "weight that the gas carries": held.value,
        "weight on floor and walls": 1.0 - held.value,
        "closed part of the floor": _find_closed(run),
        "momentum error": _watch(run, "momentum_error"),
        "change of the solids volume": _watch(run, "solids_volume"),
    }


def _measure_history(run: Results, name: str) -> Measured:
    try:
        return measures.mean_of_history(run, name)
    except NotDrawableError:
        return Measured(math.nan, math.nan)


def _watch(run: Results, name: str) -> float:
    return _try(lambda: MONITORS[name](run).value) if name in run.data else math.nan


def _find_closed(run: Results) -> float:
    """Part of the floor that is closed; nan where the case has no closed nozzle by faces."""
    faces = (run.case.get("gas") or {}).get("closed_nozzle")
    cells = run.case["domain"]["cells"]
    return math.prod(faces) / math.prod(cells[:2]) if isinstance(faces, list) and faces else math.nan


def tabulate_makers(runs: Sequence[Results]) -> Rows:
    """With what each run was made, its seed, and the hash of its effective case."""
    rows = []
    for run in runs:
        makers = {name: str(run.data.attrs[name]) for name in _MAKERS if name in run.data.attrs}
        text = str(run.data.attrs.get("case", ""))
        made: dict[str, Any] = {"seed": (run.case.get("start") or {}).get("seed"), "ranks": run.data.attrs.get("ranks")}
        rows.append(
            {"run": run.label, **made, "case, SHA-256": hashlib.sha256(text.encode()).hexdigest()[:16], **makers}
        )
    columns = list(dict.fromkeys(name for row in rows for name in row))
    return [{name: row.get(name, "") for name in columns} for row in rows]


def tabulate_twins(runs: Sequence[Results]) -> Rows:
    """What chance does: the same numbers of pairs of runs of one bed from different seeds."""
    rows = []
    for bed, one, other in list_twins(runs):
        for what, (measure, factor) in MEASURES.items():
            try:
                pair = measure(one), measure(other)
            except NotDrawableError:
                continue
            apart = pair[0] - pair[1]
            rows.append(
                {
                    "bed": bed,
                    "runs": f"{one.label}, {other.label}",
                    "number": what,
                    "one": word(pair[:1], factor),
                    "other": word(pair[1:], factor),
                    "difference over its standard error": apart.value / apart.error if apart.error else math.nan,
                }
            )
    return rows


def tell_beds(runs: Sequence[Results]) -> Rows:
    """The numbers of each bed."""
    rows = []
    for run in runs:
        for what, (measure, factor) in MEASURES.items():
            try:
                rows.append({"run": run.label, "number": what, "ours": word([measure(run)], factor)})
            except NotDrawableError:
                continue
    return rows


def tell_movement(runs: Sequence[Results]) -> Rows:
    """How much the centre of mass of each bed moves."""
    what = "the centre of mass moves by [%]"
    return [row for row in tell_beds(runs) if row["number"] == what]


def tell_slices(runs: Sequence[Results]) -> Rows:
    """How far the outer slices are from the middle one, over the largest value."""
    _, cuts = cut_moment(runs[0])
    middle = cuts[len(cuts) // 2][1].values
    return [
        {
            "slice": name,
            "root mean square off the middle one, over its largest": float(
                np.sqrt(np.mean((cut.values - middle) ** 2)) / middle.max()
            ),
        }
        for name, cut in cuts
        if cut.values is not middle
    ]


def tell_depth(runs: Sequence[Results], height: float) -> Rows:
    """How much the velocity varies along the depth at each place, over its largest size at any."""
    lines = depth_lines(replace(runs[0], view=View((height,))))
    largest = max((float(np.nanmax(np.abs(line))) for line in lines.values()), default=math.nan)
    return [
        {
            "x/L": place,
            "mean over U_f": float(np.nanmean(line)),
            "deviation along the depth over U_f": float(np.nanstd(line)),
            "over the largest velocity": float(np.nanstd(line)) / largest,
        }
        for place, line in lines.items()
    ]


def tell_contact() -> Rows:
    """Restitution of the paper's contact by its schemes, where it begins with a step as in figure 4, and its mean and
    range over the phases of a step at which it may begin."""
    exact, phases = Impact(RESTITUTION), np.arange(50) / 50
    rows = [_tell_restitution("exact", np.array([RESTITUTION]))]
    for name, count, *_ in SCHEMES:
        overlap, velocity = exact.integrate(getattr(exact, name.lower()), count, 2 * count, phases)
        left = np.argmax((overlap <= 0.0) & (velocity < 0.0), axis=0)
        rows.append(_tell_restitution(f"{name}, T_C/{count}", -velocity[left, np.arange(len(phases))]))
    return rows


def _tell_restitution(scheme: str, speeds: np.ndarray) -> dict[str, Any]:
    return {
        "scheme": scheme,
        "restitution": f"{speeds[0]:.4f}",
        "off by [%]": 100.0 * abs(float(speeds[0]) / RESTITUTION - 1.0),
        "mean over the phases": f"{speeds.mean():.4f}",
        "range": f"{speeds.min():.4f} to {speeds.max():.4f}" if len(speeds) > 1 else "",
    }


def tell_run(restitution: float) -> dict[str, Any]:
    """The same of a run of one contact."""
    return _tell_restitution("LIGGGHTS, this run", np.array([restitution]))
