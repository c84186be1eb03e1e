"""Replicas as a pool takes them: of run folders, of a folder of replicas, or of a reduced file."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.errors import CaseError, LeftOutWarning
from fbcouple.input_files.toml_text import parse_toml
from fbcouple.paths import list_replicas
from fbcouple.results.block_errors import estimate_errors
from fbcouple.results.block_means import take_blocks
from fbcouple.results.conventions import STANDARD_ERROR
from fbcouple.results.expected import find_faults
from fbcouple.results.histories import count_lost
from fbcouple.results.stored import load, tell_mend
from fbcouple.results.told import REPLICAS_OF, complete_told, tell_start_up
from fbcouple.results.variables import HISTORIES, MEANS

WINDOW_BLOCKS = 16
"""Blocks, at the fewest, that the rows of a history in the window are cut into, for its error within a replica."""
REDUCED = "reduced"
"""Attribute of a file that has depth-averaged means, and those of each of its replicas."""
OF_EACH = "replica_"
"""How the names begin of what a reduced file has of each replica."""


class NoMeansError(CaseError):
    """A run has no time means yet: it has not begun, ended before it wrote any, or has not come so far."""


@dataclass(frozen=True)
class Replica:
    """One of the runs of a pool: its results, the options of its case, the averaging `window` [s] and the `samples` in
    it, and of each history there the mean over its rows, the standard error of that by blocks, and the rows."""

    data: xr.Dataset
    case: dict[str, Any]
    samples: int
    window: tuple[float, float]
    windows: dict[str, tuple[float, float, int]]
    about: dict[str, Any]
    """What a pooled file tells of it, as JSON has it."""


def make_replica(path: Path, data: xr.Dataset, case: dict[str, Any]) -> Replica:
    """The replica whose results.nc at `path` holds `data`. Raises: NoMeansError if it has no time means yet, CaseError
    if it will have none."""
    start, end = (float(data.attrs.get(f"averaging_{side}", np.nan)) for side in ("start", "end"))
    averages = case.get("averages")
    if averages is None:
        raise CaseError([f"{path}: its case has no [averages], so there are no time means to pool; give the section."])
    if not end > start or not any(name in data for name in MEANS):
        text = f"{path}: has no time means yet, averaging starts at {start:g} s"
        raise NoMeansError([f"{text}; let the run go on, or leave it out."])
    samples = int(data.attrs.get("averaging_samples", 0)) or round((end - start) / float(averages.get("every", 2e-3)))
    name = path.resolve().parent.name
    about = {
        "name": name,
        "seeds": _list_seeds(case),
        "samples": samples,
        "window": [start, end],
        "simulated": max(float(data["time"].values[-1]), end) if data.sizes.get("time") else end,
        "complete": int(data.attrs.get("complete", 0)),
        "source": str(data.attrs.get("source", "")),
        "results": _hash_means(data),
        "set_up": _hash_set_up(path.parent),
        "particles_lost": count_lost(data),
    }
    about |= tell_start_up(data, start)
    about |= {cost: float(data.attrs[cost]) for cost in ("core_seconds", "cpu_seconds") if cost in data.attrs}
    return Replica(data, case, samples, (start, end), average_windows(data, (start, end)), about)


def average_windows(data: xr.Dataset, window: tuple[float, float]) -> dict[str, tuple[float, float, int]]:
    """Of each history over time alone, where it is finite: mean over the rows in `window` [s], error, rows."""
    found: dict[str, tuple[float, float, int]] = {}
    inside = (data["time"].values > window[0]) & (data["time"].values <= window[1]) if "time" in data else np.array([])
    for name in [name for name in HISTORIES if name in data and data[name].dims == ("time",)]:
        values = data[name].values[inside].astype(float)
        if values.size and np.isfinite(values).all():
            found[name] = float(values.mean()), estimate_window_error(values), int(values.size)
    return found


def estimate_window_error(values: np.ndarray) -> float:
    """Standard error of the mean of the rows `values` by blocks of them; nan where they are too short to tell it.

    Long blocks hold the strokes of a bed, whose halves take each other's place; in few of them chance may look like a
    correlation that is too long, which more of them then tell from it.
    """
    error = float("nan")
    for count in (WINDOW_BLOCKS, 2 * WINDOW_BLOCKS, 4 * WINDOW_BLOCKS):
        if np.isnan(error) and (length := len(values) // count):
            blocks = values[len(values) - length * count :].reshape(count, length).mean(axis=1)
            error = float(estimate_errors(blocks[:, None, None])[0, 0])
    return error


def split_reduced(path: Path, data: xr.Dataset, case: dict[str, Any]) -> list[Replica]:
    """The replicas in the reduced file at `path`. Raises: CaseError if it does not hold what it says."""
    try:
        told = complete_told(data)
        return [_take(data, case, number, about, len(told)) for number, about in enumerate(told)]
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise CaseError([f"{path}: is no whole reduced file ({error}); pool its runs again."]) from error


def _take(data: xr.Dataset, case: dict[str, Any], number: int, about: dict[str, Any], count: int) -> Replica:
    own = {}
    for name in [name for mean in MEANS for name in (mean, f"{mean}{STANDARD_ERROR}") if name in data]:
        of_each = f"{OF_EACH}{name}"
        if count == 1 or of_each in data:
            own[name] = data[name] if count == 1 else data[of_each].isel(replica=number, drop=True)
    kept = data.drop_vars([name for name in data.data_vars if str(name).startswith(OF_EACH)]).assign(own)
    kept = take_blocks(kept, 1 + number)
    windows = {name: (float(mean), float(error), int(rows)) for name, (mean, error, rows) in about["windows"].items()}
    start, end = map(float, about["window"])
    return Replica(kept, case, int(about["samples"]), (start, end), windows, about)


def _list_seeds(case: Mapping[str, Any]) -> dict[str, Any]:
    particles, start = case.get("particles", {}), case.get("start")
    found = {"start.seed": start.get("seed")} if start else {}
    found["particles.positions_seed"] = particles.get("positions_seed")
    found["particles.feeds"] = [feed.get("seed") for feed in particles.get("feeds", [])] or None
    return {key: value for key, value in found.items() if value is not None}


def _hash_means(data: xr.Dataset) -> str:
    """SHA-256 of all time means: a run that is given twice has the same."""
    found = hashlib.sha256()
    for name in MEANS:
        if name in data:
            found.update(np.ascontiguousarray(data[name].values).tobytes())
    return found.hexdigest()


def _hash_set_up(run: Path) -> str:
    """SHA-256 over names and hashes of all files that set-up wrote, as the manifest has them; "" without one."""
    try:
        files = json.loads((run / "manifest.json").read_bytes())["files"]
        return hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()
    except (OSError, ValueError, KeyError, TypeError):
        return ""


def read_results(path: Path) -> tuple[xr.Dataset, dict[str, Any]]:
    """What the results.nc at `path` holds, and the options of its case, both looked through.

    Raises: CaseError if it is not NetCDF, or fbcouple did not write it so.
    """
    data = load(path)
    text = data.attrs.get("case")
    if not isinstance(text, str):
        raise CaseError([f"{path} has no attribute `case` (the effective case file): fbcouple did not write it."])
    try:
        case = parse_toml(text)
    except ValueError as error:
        raise CaseError([f"{path}: attribute `case` is not TOML ({error})."]) from error
    if faults := find_faults(data, case):
        raise CaseError([f"{path}: {fault}; fbcouple did not write it so. {tell_mend(path)}" for fault in faults])
    return data, case


def open_replicas(paths: Sequence[Path]) -> list[Replica]:
    """The replicas in `paths`: run folders, folders of replicas, and files, whole ones of a run or reduced ones.

    Of a folder of replicas those that have no time means yet are left out, with a LeftOutWarning that names them.
    Raises: CaseError with everything that cannot be opened.
    """
    found: list[Replica] = []
    problems: list[str] = []
    for path in paths:
        try:
            members = list_replicas(path)
            found += _open_members(path, members) if members else _open(path)
        except CaseError as error:
            problems += error.problems
    if problems:
        raise CaseError(problems)
    return found


def _open_members(folder: Path, members: Sequence[Path]) -> list[Replica]:
    """Those of `members` that have time means. Raises: CaseError if none has, or one cannot be read."""
    found: list[Replica] = []
    problems: list[str] = []
    left_out: list[Path] = []
    for member in members:
        try:
            found += _open(member)
        except NoMeansError:
            left_out.append(member)
        except CaseError as error:
            problems += error.problems
    if problems:
        raise CaseError(problems)
    if not found:
        text = f"none of its {len(members)} replicas has time means yet, so there is nothing to pool"
        raise NoMeansError([f"{folder}: {text}; let them run until averaging has begun."])
    if left_out:
        names = ", ".join(member.name for member in left_out)
        text = f"{names}: no time means yet, left out; {len(found)} of {len(members)} replicas are pooled"
        warnings.warn(f"{folder}: {text}", LeftOutWarning, stacklevel=3)
    return found


def _open(path: Path) -> list[Replica]:
    file = path if path.is_file() else path / "results.nc"
    if not file.is_file():
        raise NoMeansError([f"{file} does not exist: {path} is no run that has results; run it, or leave it out."])
    data, case = read_results(file)
    if data.attrs.get(REDUCED):
        return split_reduced(file, data, case)
    if REPLICAS_OF in data.attrs:
        text = f"{file} is pooled already and holds its replicas no more"
        raise CaseError([f"{text}; give the runs that are in it, or reduced files of them."])
    return [make_replica(file, data, case)]
