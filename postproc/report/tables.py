"""The tables of one run in a report: lists of rows, a row a dict from heading to number or text."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from fbcouple.postproc.averaging import format_window, list_late, list_marks
from fbcouple.postproc.figures.bubbles import find_bubbling, summarise_bubbles
from fbcouple.postproc.figures.cost import SOLVERS, stage_seconds
from fbcouple.postproc.figures.fluidization_curve import list_branches
from fbcouple.postproc.figures.mixing import MIXED, follow_mixing
from fbcouple.postproc.figures.spectrum import describe_signal, spectra_of
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.statistics import format_not_reached, summarise
from fbcouple.results.inlet_speed import is_constant, list_rows
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.told import OVER, list_told

Rows = list[dict[str, Any]]
NOT_REACHED = "not reached"
STEADY = ("bed_height", "solids_centre_z", "pressure_drop", "gas_support", "min_voidage", "substeps")


def _format_cells(results: Results, diameter: float) -> str:
    """Edges of the cells over `diameter` [m]; of a mesh the edge of a cube as large as its mean cell."""
    if results.is_box:
        edges = [length / n for length, n in zip(results.size, results.case["domain"]["cells"], strict=True)]
        return " x ".join(f"{edge / diameter:.3g}" for edge in edges)
    volume = math.prod(results.size) * float(results.data["inside"].mean())
    return f"{(volume / results.cells) ** (1 / 3) / diameter:.3g} (a cube as large as the mean cell)"


def tabulate_solved(results: Results) -> Rows:
    """What the run is of: the numbers that tell one case from another."""
    case = results.case
    gas, particles, contact = (case.get(section) or {} for section in ("gas", "particles", "contact"))
    exchange, cells = case.get("exchange") or {}, case["domain"]["cells"]
    shape = case["domain"].get("shape", "box")
    region = {"box": "box", "file": f"box around the mesh {case['domain'].get('mesh')}"}.get(shape, shape)
    rows: list[tuple[str, Any]] = [
        (f"{region}, width x depth x height [m]", " x ".join(f"{length:g}" for length in results.size))
    ]
    rows += [("cells", " x ".join(map(str, cells)))] if shape == "box" else [("cells of the mesh", results.cells)]
    if gas:
        rows += [("gas: density [kg m-3], viscosity [Pa s]", f"{gas['density']:g}, {gas['viscosity']:g}")]
        rows += [
            ("superficial velocity U_f [m s-1]", _format_inflow(results)),
            ("sub-grid model", gas.get("turbulence", "none")),
        ]
    if particles:
        sizes, mixture = particles.get("sizes") or [], particles.get("mixture") or []
        largest = max([d for d, *_ in sizes] or [particles["diameter"], *(d for d, *_ in mixture)])
        ratio = particles.get("coarse_graining") or 1.0
        parcel = largest * (1.0 if sizes else ratio)
        given = ("mass", " [kg]") if particles.get("mass") is not None else ("count", "")
        rows += [("particles: diameter [m], density [kg m-3]", f"{particles['diameter']:g}, {particles['density']:g}")]
        text = "; ".join(f"{count} of {d:g} m, {density:g} kg m-3" for d, density, count in sizes)
        what = "parcels" if ratio > 1.0 else "particles"
        rows += [(f"{what}: sizes of the start file, in place of these", text)] if sizes else []
        text = "; ".join(f"{d:g} m, {density:g} kg m-3: {fraction:g}" for d, density, fraction in mixture)
        rows += (
            [(f"particles: further species, parts by {particles.get('fractions', 'mass')}", text)] if mixture else []
        )
        rows += [(f"particles: {given[0]}{given[1]}", particles.get(given[0]))]
        rows += [("particles: coarse graining, diameter of a parcel over theirs", f"{ratio:g}")] if ratio > 1.0 else []
        diameter = f"{'largest ' if sizes or mixture else ''}diameter{' of parcels' * (ratio > 1.0)}"
        rows += [(f"cell size over {diameter}", _format_cells(results, parcel))]
    if contact:
        rows += [(f"contact: {_TELLING[key]}", value) for key, value in contact.items() if key in _TELLING]
    if exchange:
        rows += [(f"exchange: {key.replace('_', ' ')}", value) for key, value in exchange.items()]
    window = "; ".join([format_window(results) or "none", *(mark.brief for mark in list_marks(results))])
    time = float(results.data["time"].values[-1]) if results.data.sizes.get("time") else math.nan
    rows += [("simulated time [s]", time), ("time means over", window)]
    rows += [("complete", "yes" if results.complete else f"no, of {case['end_time']:g} s")]
    if results.replicas > 1:
        about = results.data.attrs
        rows += [("replicas", results.replicas), ("averaged time of all replicas [s]", about["averaged_seconds"])]
        rows += [("simulated time of all replicas [s]", results.simulated), ("errors", about["pooled_errors"])]
    if OVER in results.data.attrs:
        rows += [("start-up, found by the run: over at [s]", _tell_found(results))]
    if ended := str(results.data.attrs.get("ended_by", "")):
        error = float(results.data.attrs.get("averaging_error", math.nan))
        name = str(results.data.attrs.get("averaging_error_of", "the time means"))
        rows += [("ended by", ended), (f"error of the mean of {name}", error)]
    return [{"what": what, "value": value} for what, value in rows]


def _tell_found(results: Results) -> float | str:
    """Where a run found that its start-up ends [s], or each of the replicas that looked."""
    told = [one for one in list_told(results.data) if OVER in one]
    if len(told) > 1:
        return ", ".join(f"{one['window'][0]:.6g}" if one[OVER] else NOT_REACHED for one in told)
    begin = float(told[0]["window"][0] if told else results.data.attrs.get("averaging_start", math.nan))
    return begin if results.data.attrs[OVER] else NOT_REACHED


def _format_inflow(results: Results) -> float | str:
    """The constant velocity of the inflow, or what its rows are and which velocity others are put in proportion to."""
    gas = results.case["gas"]
    rows = list_rows(gas)
    if is_constant(gas):
        return rows[0][1]
    if changes := results.data.attrs.get("inlet_changes"):
        return str(changes).replace("\n", "; ")
    words = f"{len(rows)} rows in time, {rows[0][1]:g} to {rows[-1][1]:g}"
    speed = results.inlet_speed
    return (
        f"{words}; none flows in the averaging window"
        if speed is None
        else f"{words}; U_f is the fastest in the averaging window, {speed:g}"
    )


_TELLING = {
    "model": "model",
    "restitution": "restitution",
    "wall_restitution": "wall restitution",
    "friction": "friction",
    "wall_friction": "wall friction",
    "rolling_friction": "rolling friction",
    "stiffness": "stiffness [N m-1]",
}


def tabulate_parameters(results: Results) -> Rows:
    """The effective case, a row an option."""
    rows = []
    for key, value in results.case.items():
        inner = value if isinstance(value, dict) else {"": value}
        rows += [{"option": f"{key}.{name}".rstrip("."), "value": given} for name, given in inner.items()]
    return rows


def tabulate_settings(runs: Sequence[Results]) -> Rows:
    """What differs between the effective cases and the makers of the runs: a row an option, a column a run."""
    options = [_list_settings(run) for run in runs]
    names = list(dict.fromkeys(name for values in options for name in values))
    rows = []
    for name in names:
        values = [given.get(name) for given in options]
        if any(value != values[0] for value in values[1:]):
            pairs = zip(runs, values, strict=True)
            rows.append({"option": name} | {run.label: "absent" if value is None else value for run, value in pairs})
    return rows


_MAKERS = ("ranks", "machine", "fbcouple", "commit", "OpenFOAM", "LIGGGHTS", "MPI")


def _list_settings(run: Results) -> dict[str, Any]:
    """Options of the effective case but for its title, and what it was solved with."""
    values = {row["option"]: row["value"] for row in tabulate_parameters(run) if row["option"] != "title"}
    solved = {name: run.data.attrs.get(name) for name in _MAKERS}
    return values | {name: make_plain(value) for name, value in solved.items() if value is not None}


_INNER = ("title", "in", "case", "files", "replaced")
"""Entries of the manifest that stand elsewhere on the page, or that only `setup` needs."""


def tabulate_provenance(results: Results) -> Rows:
    """Versions, machine and command, and what was left out and why: the manifest beside results.nc, if it is there."""
    path = results.path.parent / "manifest.json"
    rows: Rows = [{"what": "results", "value": str(results.path)}]
    if not path.is_file():
        return [*rows, {"what": "manifest", "value": "there is no manifest.json beside the results"}]
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        return [*rows, {"what": "manifest", "value": f"manifest.json cannot be read ({error})"}]
    for key, value in manifest.items():
        if key in _INNER:
            continue
        inner = value if isinstance(value, dict) else {"": value}
        for name, given in inner.items():
            text = " ".join(map(str, given)) if isinstance(given, list) else given
            if text not in ("", None, {}):
                rows.append({"what": f"{key.replace('_', ' ')} {name.replace('_', ' ')}".strip(), "value": text})
    return rows


def tabulate_statistics(results: Results) -> tuple[Rows, list[str]]:
    """Means of the histories after the start-up with their standard errors, and why some are missing."""
    rows, remarks = [], []
    lacking: dict[str, list[str]] = {}
    for name in STEADY:
        if name not in results.data:
            continue
        try:
            found = summarise(results, name)
        except NotDrawableError as lack:
            lacking.setdefault(str(lack).replace(f"`{name}`", "{}"), []).append(f"`{name}`")
            continue
        reached = not math.isnan(found.start)
        rows.append(
            {
                "quantity": str(results.data[name].attrs.get("long_name", name)),
                "unit": found.unit,
                "mean": found.mean,
                "standard error": found.stderr,
                "deviation": found.deviation,
                "steady from [s]": found.start if reached else NOT_REACHED,
                "rows": found.values,
            }
        )
        if not reached:
            remarks.append(f"No mean of {name}: {format_not_reached(name, found.end)}")
        else:
            remarks += list_late(results, name, found.start)
    return rows, [*(_tell_lack(lack, names) for lack, names in lacking.items()), *remarks]


def _tell_lack(lack: str, names: Sequence[str]) -> str:
    """Of which histories there is no mean, and what they lack; {} in `lack` stands for the name of one."""
    return f"No mean of {', '.join(names)}: {lack.replace('{}', 'each' if len(names) > 1 else names[0])}"


def tabulate_spectra(results: Results) -> Rows:
    """The highest peak of each spectrum. Raises NotDrawableError if the record is too short."""
    return [
        {
            "quantity": describe_signal(found.name)[0].lower(),
            "dominant frequency [Hz]": found.peak,
            "resolution [Hz]": found.resolution,
            "segments": found.segments,
            "stands out of red noise": found.stands_out,
        }
        for found in spectra_of(results)
    ]


def tabulate_onsets(results: Results) -> Rows:
    """U_mf on each branch of a ramp of the gas. Raises NotDrawableError where there is none."""
    return [
        {
            "branch": branch.name,
            "U_mf [m s-1]": branch.onset.velocity if branch.onset else math.nan,
            "standard error [m s-1]": branch.onset.error if branch.onset else math.nan,
            "rows of the packed bed": int(branch.onset.rows.sum()) if branch.onset else 0,
            "voidage of the packed bed": branch.voidage,
            "U_mf by the drag law [m s-1]": branch.by_drag,
        }
        for branch in list_branches(results)
    ]


def tabulate_mixing(results: Results) -> Rows:
    """Mixing of species, of what feeds brought and of halves of the first bed. Raises NotDrawableError where nothing
    mixes."""
    return [
        {
            "particles": each.name,
            "Lacey's index, first": float(each.index[np.isfinite(each.index)][0]),
            "last": float(each.index[-1]),
            f"{MIXED:g} from [s]": NOT_REACHED if math.isnan(each.reached) else each.reached,
        }
        for each in follow_mixing(results)
    ]


def tabulate_bubbles(results: Results) -> Rows:
    """Number, size and rise velocity of bubbles. Raises NotDrawableError without snapshots."""
    units = {"diameter": " [m]", "diameter, deviation": " [m]", "rise velocity": " [m s-1]"}
    units["rise velocity, deviation"] = " [m s-1]"
    return [
        {f"{name}{units.get(name, '')}": value for name, value in summarise_bubbles(find_bubbling(results)).items()}
    ]


def tabulate_monitors(results: Results) -> Rows:
    """What was watched while the run went on, and what was wanted of it."""
    rows = []
    for name, function in MONITORS.items():
        if name in results.data:
            try:
                rows.append(asdict(function(results)))
            except NotDrawableError:
                continue  # time means that do not exist yet, or a case without gas: the figures say so
    return rows


def tabulate_cost(results: Results) -> Rows:
    """Wall seconds of each stage, and its share."""
    seconds = stage_seconds(results)
    total, time = sum(seconds.values()), float(results.data["time"].values[-1])
    rows = [
        {
            "stage": stage,
            "part": "solver" if stage in SOLVERS else "coupling",
            "wall [s]": value,
            "share [%]": 100.0 * value / total if total else math.nan,
            "wall per simulated second [s]": value / time if time else math.nan,
        }
        for stage, value in seconds.items()
    ]
    return [*rows, _sum_rows(rows)]


def _sum_rows(rows: Rows) -> dict[str, Any]:
    sums = {key: sum(row[key] for row in rows) for key in rows[0] if key not in ("stage", "part")}
    return {"stage": "all", "part": ""} | sums


def make_plain(value: Any) -> Any:
    """The same rows as plain numbers and texts for JSON; nan and infinity become null."""
    if isinstance(value, dict):
        return {key: make_plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [make_plain(inner) for inner in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
