"""What `check`, `setup` and `run` say of the cost of a run, and of how sure its means will be."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from fbcouple.case.cost.coefficients import load_coefficients
from fbcouple.case.cost.prediction import PHASES, Prediction, predict
from fbcouple.case.cost.ranks import WORTH, Proposal
from fbcouple.case.schema.sections import Case
from fbcouple.cli.table import print_explained
from fbcouple.errors import CaseError
from fbcouple.launcher.progress import format_clock

MEASURE = "measure this machine, in about two minutes, by `fbcouple bench calibrate`"


def format_time(seconds: float) -> str:
    """Wall time: seconds below 100, then a clock."""
    return f"{seconds:.2g} s" if seconds < 99.5 else format_clock(seconds)


def print_prediction(found: Prediction) -> None:
    """A table of what is predicted, each number with its factor and where it is from."""
    ranks = f"{found.ranks} rank{'s' if found.ranks > 1 else ''}"
    memory = f"{found.memory / 1e9:.3g} GB"
    rows = [
        ("wall time", format_time(found.wall), f"{found.factor:.2g}", _share_out(found)),
        ("core-hours", f"{found.core_hours:.3g}", f"{found.factor:.2g}", "Wall time times the ranks."),
        ("memory", memory, f"{found.memory_factor:.2g}", "Of all ranks together, programs and solvers included."),
    ]
    if sure := found.means:
        meaning = "Standard error of the mean map of vertical solids flux over the map: "
        meaning += f"{sure.window:.3g} s hold {sure.periods:.3g} bubble periods of {sure.period:.2g} s."
        if sure.wanted:
            meaning += f" The run ends at about {sure.end:.3g} s, for averages.until_error."
        rows.append(("error of the means", f"{sure.error:.2g}", f"{sure.factor:.2g}", meaning))
    print_explained([f"predicted on {ranks}", "value", "within a factor of", "meaning"], rows)
    click.echo(tell_source(found))


def _share_out(found: Prediction) -> str:
    work = found.work
    parts = [f"{name} {100.0 * found.stages[name] / found.wall:.0f} %" for name in PHASES if name in found.stages]
    text = f"{', '.join(parts)}: {work.dem_steps} DEM steps" if work.dem_steps else ", ".join(parts)
    if work.cells:
        text += f"{',' if work.dem_steps else ':'} about {work.fluid_steps:.3g} fluid steps"
    return f"{text}."


def tell_source(found: Prediction) -> str:
    """Whose costs of a step the prediction is made with."""
    if not found.measured:
        return f"by the costs of a step that are shipped, of another machine; {MEASURE}"
    return f"by the costs of a step of {found.measured}"


def format_proposal(found: Proposal) -> str:
    """The ranks that are proposed, how sure that is, and why not twice as many."""
    ranks, twice = f"{found.ranks} rank{'s are' if found.ranks > 1 else ' is'}", 2 * found.ranks
    unsure = f" ({found.least} to {found.most} within what is unsure)" if found.least < found.most else ""
    why = f"{twice} would be {found.gain:.3g} times as fast, {2.0 * WORTH:.2g} is asked for"
    if twice > found.limit:
        why = f"{twice} would have too little work each"
    return f"{ranks} proposed{unsure}, {format_time(found.walls[found.ranks])}: {why}"


def format_line(case: Case, folder: Path) -> str:
    """What a run of `case` on one rank will cost, in a line, or why that cannot be told."""
    try:
        found = predict(case, 1, load_coefficients(), folder)
    except CaseError as error:
        return f"what it will cost is not predicted: {error}"
    sure = f"; error of the means about {found.means.error:.2g}" if found.means else ""
    of = "" if found.measured else f" ({MEASURE})"
    return f"about {format_time(found.wall)} on 1 rank, within a factor of {found.factor:.2g}{of}{sure}"


def format_outcome(predicted: Mapping[str, Any], seconds: float, walls: Mapping[str, float]) -> str:
    """What was predicted for `seconds` [s] of simulated time beside `walls`, the wall seconds of the stages in them."""
    told = {name: value for name, value in predicted["stages"].items() if name in PHASES}
    part = seconds / predicted["simulated_seconds"]
    found = {name: sum(walls.get(stage, 0.0) for stage in stages) for name, stages in PHASES.items()}
    whole, taken = part * sum(told.values()), sum(walls.values())
    ratios = ", ".join(f"{name} {found[name] / (part * value):.2g}" for name, value in told.items() if value)
    words = (
        f"predicted {format_time(whole)} for these {seconds:.4g} s, within a factor of {predicted['wall_factor']:.2g}"
    )
    return f"{words}; took {format_time(taken)}, {taken / whole:.2g} of it ({ratios})"
