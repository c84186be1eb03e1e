"""Stiff and extreme scenes: what `fbcouple check` predicts, what happens, and where each exchange form gives up."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fbcouple.case.bed.exchange_numbers import response_times
from fbcouple.case.bed.fluid_step import coupling_step
from fbcouple.case.bed.lattice import lay_out
from fbcouple.case.bed.particle_types import mean_volume
from fbcouple.case.bed.slips import SLIP
from fbcouple.case.bed.stacks import LIFTED, LOOSE
from fbcouple.case.bed.step_limits import measure_limits
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.case.schema.sections import Case
from fbcouple.launcher.stop_signals import Requests
from fbcouple.results.line_log import read_line
from fbcouple.study.indicators import judge, read_indicators
from fbcouple.study.runs import Ending, require_uninterrupted, run_case, run_from_middle
from fbcouple.study.scenes import Scene, list_scenes
from fbcouple.study.schema import Stability
from fbcouple.study.side_by_side import run_side_by_side
from fbcouple.study.source import Source

RUNS = "scenes"
RESTARTS = "restarts"
PREDICTIONS = ("fit", "warn", "unfit")
OUTCOMES = ("stable", "inaccurate", "unstable", "unfinished")
TOLD = ("predicted", "verdict", "indicators", "restart")
"""Columns that are told of each scene as it ends."""
Row = dict[str, Any]
Say = Callable[[str], None]


def run_scenes(study: Stability, source: Source, folder: Path, say: Say, jobs: int = 1) -> list[Row]:
    """Run every scene that has not been run to its end in `folder` before, `jobs` at a time; a row for each.

    Raises: CaseError if the study is wrong; StoppedError if a signal interrupted it.
    """
    scenes = list_scenes(study, source)
    rows, ended = [], []
    calls = [(scene, folder, study) for scene in scenes]
    with Requests() as requests:
        both = run_side_by_side(_run, calls, jobs, requests)
        for n, (scene, endings) in enumerate(zip(scenes, both, strict=True), 1):
            if endings is None:
                continue
            ended.append(endings[1] or endings[0])
            told: list[str | None] = ["interrupted"]
            if ended[-1].how != "interrupted":
                rows.append(_tabulate(study, scene, folder, *endings))
                told = [rows[-1].get(key) for key in TOLD]
            say(f"{n}/{len(scenes)} {scene.name}: {', '.join(filter(None, told))} ({endings[0].seconds:.1f} s)")
        require_uninterrupted(folder, requests, ended, len(scenes))
    return rows


def _run(scene: Scene, folder: Path, study: Stability, requests: Requests) -> tuple[Ending, Ending | None]:
    """How a scene ended, and where the study asks for it how its second half did once more."""
    run, again = folder / RUNS / scene.name, folder / RESTARTS / scene.name
    ending = run_case(scene.base, scene.settings, run, scene.ranks, study.wall_limit, requests)
    if not study.restart or ending.how == "interrupted":
        return ending, None
    return ending, run_from_middle(run, again, scene.ranks, study.wall_limit, requests)


def _tabulate(study: Stability, scene: Scene, folder: Path, ending: Ending, again: Ending | None) -> Row:
    run = folder / RUNS / scene.name
    row = _describe(scene, ending, run)
    return row | _compare(run, folder / RESTARTS / scene.name, again) if study.restart else row


def _describe(scene: Scene, ending: Ending, run: Path) -> Row:
    case = load_case(str(run))
    verdict, why, indicators = _judge_run(case, ending, _read_rows(run))
    predicted, doubts = predict(case, run)
    varied = ", ".join(f"{key} = {value}" for key, value in scene.varied.items())
    row: Row = {"scene": scene.group, "varied": varied, "form": scene.form, "predicted": predicted, "doubts": doubts}
    row |= {"verdict": verdict, "indicators": why, "how": ending.how, "why": ending.text[:200]}
    row |= find_stiffness(case, run)
    return row | {"seconds": ending.seconds} | indicators


def _compare(run: Path, again: Path, ending: Ending | None) -> Row:
    """Verdict of a run that went on from the middle of `run`, and whether it has the same numbers to the last bit; ""
    where `run` was over before its middle."""
    if ending is None:
        return {"restart": "", "same rows": None, "restart seconds": None}
    whole, rows = ([_bare(row) for row in _read_rows(folder)] for folder in (run, again))
    verdict, _, _ = _judge_run(load_case(str(again)), ending, rows)
    return {"restart": verdict, "same rows": repr(rows) == repr(whole), "restart seconds": ending.seconds}


def _bare(row: Row) -> Row:
    """A history row without what is different each time: wall times, and the checksum over them."""
    return {name: value for name, value in row.items() if name not in ("wall", "crc32")}


def _read_rows(run: Path) -> list[Row]:
    """History rows of a run, also of one that blew up."""
    log = run / "logs/run.jsonl"
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines() if log.is_file() else []
    return [row for line in lines if (row := read_line(line))]


def _judge_run(case: Case, ending: Ending, rows: list[Row]) -> tuple[str, str, dict[str, float]]:
    indicators = read_indicators(case, rows) if rows else {}
    verdict, why = judge(indicators)
    if ending.how == "out of time" and verdict != "unstable":
        return "unfinished", why, indicators
    if ending.how in ("diverged", "failed"):
        return "unstable", ", ".join(filter(None, [f"run {ending.how}", why])), indicators
    return verdict, why, indicators


def predict(case: Case, folder: Path = Path()) -> tuple[str, str]:
    """The worst verdict of the pre-flight numbers of a case whose files lie in `folder`, and which say so."""
    # Whether columns of the start stand or fall is no question of stability, nor how right the drag is.
    asked = [number for number in estimate(case, folder=folder) if number.name not in (LIFTED, LOOSE, SLIP)]
    judged = [number for number in asked if number.verdict]
    worst = max((PREDICTIONS.index(number.verdict or "fit") for number in judged), default=0)
    said = [number.name for number in judged if number.verdict == PREDICTIONS[worst]] if worst else []
    return PREDICTIONS[worst], ", ".join(said)


def find_stiffness(case: Case, folder: Path = Path()) -> dict[str, float | None]:
    """Expected step over tau_g and tau_p of a packed bed, and over tau_g of the start lattice if the bed is one;
    the case's own files lie in `folder`."""
    if not (case.gas and case.particles and case.exchange and case.contact):
        return {"dt/tau_g": None, "dt/tau_p": None, "dt/tau_g of the lattice": None}
    step, times = coupling_step(case, measure_limits(case, folder)), response_times(case)
    own = None
    if case.start:
        layout = lay_out(case)
        voidage = 1.0 - mean_volume(case.particles) / math.prod(layout.spacing)
        own = step / response_times(case, voidage=voidage)["tau_g"]
    return {"dt/tau_g": step / times["tau_g"], "dt/tau_p": step / times["tau_p"], "dt/tau_g of the lattice": own}


def confuse(rows: list[Row]) -> list[Row]:
    """The confusion table: predictions down, outcomes across, number of scenes in each, for each form."""
    table = []
    for form in dict.fromkeys(row["form"] for row in rows):
        for predicted in PREDICTIONS:
            of = [row["verdict"] for row in rows if row["form"] == form and row["predicted"] == predicted]
            counts = {outcome: of.count(outcome) for outcome in OUTCOMES}
            table.append({"form": form or "none", "predicted": predicted} | counts)
    return table


def find_limits(rows: list[Row]) -> list[Row]:
    """Where each form gives up along a group whose scenes differ in dt/tau_g: the largest ratio below which all are
    not unstable, the smallest that is unstable, and their geometric mean."""
    limits = []
    key = "dt/tau_g of the lattice"
    for group, form in dict.fromkeys((row["scene"], row["form"]) for row in rows):
        along = sorted(
            (row[key], row["verdict"] == "unstable")
            for row in rows
            if (row["scene"], row["form"]) == (group, form) and row[key] is not None
        )
        if len({ratio for ratio, _ in along}) < 3:
            continue
        first = next((ratio for ratio, broken in along if broken), None)
        below = [ratio for ratio, _ in along if first is None or ratio < first]
        last = max(below, default=None)
        middle = math.sqrt(first * last) if first and last else None
        limits.append({"scene": group, "form": form, "last stable": last, "first unstable": first, "limit": middle})
    return limits
