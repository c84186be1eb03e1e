"""`fbcouple bench predictions`: the first part of beds beside what was predicted of it, by phase."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fbcouple.bench.step_costs import UNITS, StepCosts
from fbcouple.bench.suite import measure_costs
from fbcouple.bench.turns import OTHERS, Row
from fbcouple.case.cost.coefficients import Coefficients, load_coefficients
from fbcouple.case.cost.prediction import combine_factors, time_stages
from fbcouple.case.cost.work import Work, count_work, share_ghosts
from fbcouple.case.load import load_case
from fbcouple.case.source import find_case
from fbcouple.results.tables import write_tables

Say = Callable[[str], None]


def hold_predictions(
    cases: Sequence[str], sets: Sequence[str], ranks: int, warm: float, seconds: float, say: Say = lambda text: None
) -> list[Row]:
    """Run each of `cases` from `warm` to `warm + seconds` [s] of simulated time, in processor time of the slowest rank,
    and hold it against its prediction.

    Returns: a row a case: core-seconds a simulated second, predicted and found, with the factor that was told, and for
    each phase found over predicted; `known work` is the same with the steps and contacts that there were, so that it
    judges the costs of a step alone. Raises: CaseError, SolverError.
    """
    found, rows = load_coefficients(), []
    for name in cases:
        case, folder = load_case(name, sets), find_case(name).parent
        work, ghosts = count_work(case, folder, end=case.end_time), share_ghosts(case, ranks)
        say(f"{name}: {seconds:g} s from {warm:g} s on, {ranks} rank{'s' if ranks > 1 else ''}")
        told = measure_costs(name, sets, ranks, warm, seconds)
        others = told.pop(OTHERS, None)
        rows.append({"case": name} | compare(work, StepCosts(**told), found, ghosts) | {OTHERS: others})
    return rows


def compare(work: Work, costs: StepCosts, found: Coefficients, ghosts: float = 0.0) -> Row:
    """What `costs` are beside the prediction for a run that has to do `work`, a simulated second of each."""
    ranks, length = costs.ranks, costs.seconds
    told = _per_second(time_stages(work, found, ranks, ghosts), work.seconds)
    known = replace(
        work,
        seconds=length,
        particles=float(costs.particles),
        contacts=costs.contacts_each,
        dem_steps=costs.dem_steps,
        rebuilds=costs.rebuilds,
        turnovers=work.turnovers * length / work.seconds,
        fluid_steps=float(costs.fluid_steps),
    )
    informed = _per_second(time_stages(known, found, ranks, ghosts), length)
    taken = {phase: costs.phases[phase] / length for phase in told}
    whole = ranks * sum(taken.values())
    row: dict[str, Any] = {
        "ranks": ranks,
        "particles": costs.particles,
        "cells": costs.cells,
        "predicted": ranks * sum(told.values()),
        "factor": combine_factors(work, found, ranks, time_stages(work, found, ranks, ghosts)),
        "found": whole,
        "found over predicted": sum(taken.values()) / sum(told.values()),
    }
    row |= {f"{phase} over predicted": taken[phase] / told[phase] for phase in UNITS if phase in told}
    row |= {
        "over known work": sum(taken.values()) / sum(informed.values()),
        "DEM steps over predicted": _ratio(costs.dem_steps / length, work.dem_steps / work.seconds),
        "fluid steps over predicted": _ratio(costs.fluid_steps / length, work.fluid_steps / work.seconds),
        "new lists over predicted": _ratio(costs.rebuilds / length, work.rebuilds / work.seconds),
        "contacts a particle": costs.contacts_each,
        "contacts predicted": work.contacts,
        "not predicted": costs.phases_left / (length * sum(taken.values())),
    }
    return row


def _per_second(stages: dict[str, float], seconds: float) -> dict[str, float]:
    return {phase: value / seconds for phase, value in stages.items()}


def _ratio(one: float, other: float) -> float | None:
    return one / other if other else None


def write_predictions(folder: Path, rows: list[Row], found: Coefficients) -> list[Path]:
    """Write predictions.csv and predictions.json into `folder`, with whose costs of a step they are by."""
    about = {"costs": found.measured or "shipped"}
    return write_tables(folder, "predictions", {"predictions": rows}, about)
