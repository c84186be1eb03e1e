"""Lays out the runs of a benchmark in a temporary folder, starts their processes, and makes its tables."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.bench.canonical import make_box
from fbcouple.bench.lammps import explain_absence, time_lammps, write_lammps
from fbcouple.bench.parts import make_variants
from fbcouple.bench.peers import check_peer, time_dpmfoam, write_dpmfoam
from fbcouple.case.load import load_case, write_case
from fbcouple.case.schema.sections import Case
from fbcouple.decks.render import set_up
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import SolverError
from fbcouple.launcher.openfoam_mesh import prepare_mesh
from fbcouple.machine.environment import mpi_command, mpi_environment
from fbcouple.machine.programs import run_program

_TAIL = 12
_FOUND = "bench.json"
Row = dict[str, Any]


def measure_overhead(case: str, sets: Sequence[str], ranks: int, warm: float, seconds: float) -> dict[str, Any]:
    """Stages of each rank beside LIGGGHTS and the gas solver alone, and totals. Raises CaseError, SolverError."""
    return _measure_case("overhead", case, sets, ranks, warm, seconds)


def measure_memory(case: str, sets: Sequence[str], ranks: int) -> list[Row]:
    """Bytes of a rank's own arrays a particle and a cell, a row a rank. Raises CaseError, SolverError."""
    return _measure_case("memory", case, sets, ranks)["ranks"]


def measure_scaling(cells: int, counts: Sequence[int], steps: int, repeats: int, tetrahedra: bool = False) -> list[Row]:
    """Strong and weak scaling of the canonical box of `cells`^3 cells (a rank, for the weak one), each of them cut into
    `tetrahedra` where asked; eqs 46-47."""
    rows = []
    for kind in ("strong", "weak"):
        first: Row | None = None
        for ranks in counts:
            case = make_box((cells * ranks if kind == "weak" else cells, cells, cells), tetrahedra)
            with _place() as folder:
                set_up(case, folder / "run")
                row = {"scaling": kind} | _measure("steps", folder / "run", case, ranks, steps, repeats)
            first = first or row
            rows.append(row | compare(row, first))
    return rows


def measure_strong(
    case: str, sets: Sequence[str], counts: Sequence[int], warm: float, steps: int, repeats: int
) -> list[Row]:
    """Strong scaling of a case: the same coupled steps after `warm` [s] on each number of ranks, eq. 46. Raises
    CaseError, SolverError."""
    rows: list[Row] = []
    for ranks in counts:
        row = {"scaling": "strong"} | _measure_case("steps", case, sets, ranks, steps, repeats, warm)
        rows.append(row | compare(row, rows[0] if rows else row))
    return rows


def measure_parts(case: str, sets: Sequence[str], warm: float, steps: int, repeats: int) -> list[Row]:
    """Processor seconds a simulated second of a case without each of its parts, and over those of the whole case; the
    variants take turns, the cheapest turn of each counts."""
    variants = make_variants(load_case(case, sets))
    turns: dict[str, list[Row]] = {name: [] for name in variants}
    for _ in range(repeats):
        for name, variant in variants.items():
            with _place() as folder:
                set_up(variant, folder / "run")
                turns[name].append(_measure("variant", folder / "run", variant, 1, warm, steps))
    best = {name: min(rows, key=lambda row: row["cpu_seconds_per_second"]) for name, rows in turns.items()}
    whole = best["nothing"]["cpu_seconds_per_second"]
    return [
        {"left out": name, "of the whole": row["cpu_seconds_per_second"] / whole} | row for name, row in best.items()
    ]


def measure_skins(
    case: str, sets: Sequence[str], skins: Sequence[float], ranks: int, warm: float, steps: int
) -> list[Row]:
    """Wall seconds a simulated second of LIGGGHTS in a case with neighbour lists of each skin (diameters), and over the
    fastest. Raises CaseError, SolverError."""
    rows = [
        {"skin": skin} | _measure_case("dem", case, [*sets, f"contact.skin={skin!r}"], ranks, warm, steps)
        for skin in skins
    ]
    best = min(row["cheapest"] for row in rows)
    return [row | {"of the fastest": row["cheapest"] / best} for row in rows]


def compare(row: Row, first: Row) -> Row:
    """Speed-up (eq. 46) or scale-up (eq. 47) over the first row, and its share of the ideal one."""
    name = "speed-up" if row["scaling"] == "strong" else "scale-up"
    grown = row["cells"] / first["cells"]
    gain = first["ranks"] * first["seconds"] / row["seconds"] * grown
    return {"gain": name, "value": gain, "of_ideal": gain / row["ranks"]}


def measure_peers(case: str, sets: Sequence[str], ranks: int, warm: float, steps: int) -> dict[str, list[Row]]:
    """Wall seconds a simulated second of this program and of stock DPMFoam for the same bed, mesh, fluid step and
    ranks, one after the other, and their ratio ("peers"); of LIGGGHTS and of LAMMPS, where it takes part, for the
    particles alone ("particles"). Raises CaseError, SolverError."""
    with _place() as folder:
        run = folder / "run"
        lay_out(case, run, sets, trusted=False, forced=True)
        content = load_case(str(run))
        check_peer(content)
        own = _measure("peer", run, content, ranks, warm, steps)
        alone = [{"program": "LIGGGHTS"} | own.pop("alone") | {"particles": own["particles"]}]
        write_dpmfoam(content, run / "CFD", np.load(run / "bed.npy")[:, :3], own["step"], steps)
        prepare_mesh(content, run, ranks)
        peer = time_dpmfoam(run / "CFD", ranks, steps, skip=2)
        if not explain_absence(content):
            write_lammps(content, run / "lammps", np.load(run / "alone.npy"), alone[0]["steps"])
            alone.append(time_lammps(run / "lammps", ranks))
    rows = [{"program": "fbcouple"} | own, {"program": "DPMFoam", "step": own["step"]} | peer]
    for row in rows:
        row["seconds_per_second"] = row["seconds"] / row["step"]
    return {
        "peers": [row | {"of fbcouple": row["seconds_per_second"] / rows[0]["seconds_per_second"]} for row in rows],
        "particles": [row | {"of LIGGGHTS": row["seconds"] / alone[0]["seconds"]} for row in alone],
    }


def count_traffic(cells: int, counts: Sequence[int]) -> list[Row]:
    """Messages and bytes a rank of the canonical box, strong and weak, by making the plans of all ranks."""
    rows = []
    for kind in ("strong", "weak"):
        for ranks in counts:
            case = make_box((cells * ranks if kind == "weak" else cells, cells, cells))
            with _place() as folder:
                (folder / "run").mkdir()
                write_case(case, folder / "run/case.toml")
                rows.append({"scaling": kind} | _start("traffic", folder / "run", 1, ranks))
    return rows


@contextmanager
def _place() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="fbcouple-bench-") as folder:
        yield Path(folder)


def _measure_case(kind: str, case: str, sets: Sequence[str], ranks: int, *numbers: float) -> dict[str, Any]:
    """Lay a case out as a user's command would, and measure it."""
    with _place() as folder:
        run = folder / "run"
        lay_out(case, run, sets, trusted=False, forced=True)
        return _measure(kind, run, load_case(str(run)), ranks, *numbers)


def _measure(kind: str, run: Path, case: Case, ranks: int, *numbers: float) -> dict[str, Any]:
    if case.gas:
        prepare_mesh(case, run, ranks)
    return _start(kind, run, ranks, *numbers)


def _start(kind: str, run: Path, ranks: int, *numbers: float) -> dict[str, Any]:
    program = [sys.executable, "-m", "fbcouple.bench.process", kind, str(run), *map(repr, numbers)]
    environment = mpi_environment() | {"PWD": os.getcwd()}
    done = run_program(mpi_command(ranks, program), environment)
    if done.returncode:
        words = "\n".join((done.stdout + done.stderr).strip().splitlines()[-_TAIL:])
        raise SolverError(f"bench {kind} on {ranks} ranks failed:\n{words}")
    return json.loads((run / _FOUND).read_text(encoding="utf-8"))
