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
from fbcouple.bench.turns import OTHERS, Row, take_turns, watch_others
from fbcouple.case.load import load_case, write_case
from fbcouple.case.schema.sections import Case
from fbcouple.decks.render import set_up
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import SolverError
from fbcouple.launcher.openfoam_mesh import prepare_mesh
from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command
from fbcouple.machine.programs import run_program

_TAIL = 12
_FOUND = "bench.json"
_COUPLED = ("fbcouple", "DPMFoam")
"""Programs that run gas and particles; the others have the particles alone."""


def measure_overhead(
    case: str, sets: Sequence[str], ranks: int, warm: float, seconds: float, turns: int
) -> dict[str, Any]:
    """Stages of each rank beside LIGGGHTS and the gas solver alone, and totals, of the turn with the cheapest steps;
    all turns take the steps that the first took in about `seconds`. Raises CaseError, SolverError."""
    steps = 0

    def turn() -> dict[str, Row]:
        nonlocal steps
        found = _measure_case("overhead", case, sets, ranks, warm, seconds, steps)
        steps = steps or found["total"]["steps"]
        return {"overhead": found}

    (found,) = take_turns(turn, lambda row: row["total"]["wall_seconds"], turns).values()
    told = {name: found.pop(name) for name in (OTHERS, "turns", "spread") if name in found}
    return found | {"total": found["total"] | told}


def measure_memory(case: str, sets: Sequence[str], ranks: int) -> list[Row]:
    """Bytes of a rank's own arrays a particle and a cell, a row a rank. Raises CaseError, SolverError."""
    return _measure_case("memory", case, sets, ranks)["ranks"]


def measure_scaling(cells: int, counts: Sequence[int], steps: int, turns: int, tetrahedra: bool = False) -> list[Row]:
    """Strong and weak scaling of the canonical box of `cells`^3 cells (a rank, for the weak one), each of them cut into
    `tetrahedra` where asked; eqs 46-47."""

    def measure(kind: str, ranks: int) -> Row:
        case = make_box((cells * ranks if kind == "weak" else cells, cells, cells), tetrahedra)
        with _place() as folder:
            set_up(case, folder / "run")
            return {"scaling": kind} | _measure("steps", folder / "run", case, ranks, steps)

    def turn() -> dict[str, Row]:
        return {f"{kind} {ranks}": measure(kind, ranks) for kind in ("strong", "weak") for ranks in counts}

    rows = list(take_turns(turn, lambda row: row["seconds"], turns).values())
    first = {row["scaling"]: row for row in reversed(rows)}
    return [row | compare(row, first[row["scaling"]]) for row in rows]


def measure_strong(
    case: str, sets: Sequence[str], counts: Sequence[int], warm: float, steps: int, turns: int
) -> list[Row]:
    """Strong scaling of a case: the same coupled steps after `warm` [s] on each number of ranks, eq. 46. Raises
    CaseError, SolverError."""

    def turn() -> dict[str, Row]:
        return {str(ranks): _measure_case("steps", case, sets, ranks, steps, warm) for ranks in counts}

    rows = [{"scaling": "strong"} | row for row in take_turns(turn, lambda row: row["seconds"], turns).values()]
    return [row | compare(row, rows[0]) for row in rows]


def measure_parts(case: str, sets: Sequence[str], warm: float, steps: int, turns: int) -> list[Row]:
    """Processor seconds a simulated second of a case without each of its parts, and over those of the whole case."""
    variants = make_variants(load_case(case, sets))

    def measure(variant: Case) -> Row:
        with _place() as folder:
            set_up(variant, folder / "run")
            return _measure("variant", folder / "run", variant, 1, warm, steps)

    def cost(row: Row) -> float:
        return row["cpu_seconds_per_second"]

    best = take_turns(lambda: {name: measure(variant) for name, variant in variants.items()}, cost, turns)
    whole = cost(best["nothing"])
    return [{"left out": name, "of the whole": cost(row) / whole} | row for name, row in best.items()]


def measure_skins(
    case: str, sets: Sequence[str], skins: Sequence[float], ranks: int, warm: float, steps: int, turns: int
) -> list[Row]:
    """Wall seconds a simulated second of LIGGGHTS in a case with neighbour lists of each skin (diameters), and over the
    fastest. Raises CaseError, SolverError."""

    def turn() -> dict[str, Row]:
        return {
            repr(skin): {"skin": skin}
            | _measure_case("dem", case, [*sets, f"contact.skin={skin!r}"], ranks, warm, steps)
            for skin in skins
        }

    rows = list(take_turns(turn, lambda row: row["cheapest"], turns).values())
    best = min(row["cheapest"] for row in rows)
    return [row | {"of the fastest": row["cheapest"] / best} for row in rows]


def compare(row: Row, first: Row) -> Row:
    """Speed-up (eq. 46) or scale-up (eq. 47) over the first row, and its share of the ideal one."""
    name = "speed-up" if row["scaling"] == "strong" else "scale-up"
    grown = row["cells"] / first["cells"]
    gain = first["ranks"] * first["seconds"] / row["seconds"] * grown
    return {"gain": name, "value": gain, "of_ideal": gain / row["ranks"]}


def measure_peers(
    case: str, sets: Sequence[str], ranks: int, warm: float, steps: int, turns: int
) -> dict[str, list[Row]]:
    """Wall seconds a simulated second of this program and of stock DPMFoam for the same bed, mesh, fluid step and
    ranks, one after the other, and their ratio ("peers"); of LIGGGHTS and of LAMMPS, where it takes part, for the
    particles alone ("particles"). Raises CaseError, SolverError."""
    best = take_turns(lambda: _time_peers(case, sets, ranks, warm, steps), lambda row: row["seconds"], turns)
    rows = [best.pop(name) for name in _COUPLED]
    alone = list(best.values())
    for row in rows:
        row["seconds_per_second"] = row["seconds"] / row["step"]
    return {
        "peers": [row | {"of fbcouple": row["seconds_per_second"] / rows[0]["seconds_per_second"]} for row in rows],
        "particles": [row | {"of LIGGGHTS": row["seconds"] / alone[0]["seconds"]} for row in alone],
    }


def _time_peers(case: str, sets: Sequence[str], ranks: int, warm: float, steps: int) -> dict[str, Row]:
    """One turn of every program, in one run folder."""
    with _place() as folder:
        run = folder / "run"
        lay_out(case, run, sets, trusted=False, forced=True)
        content = load_case(str(run))
        check_peer(content)
        own = {"program": "fbcouple"} | _measure("peer", run, content, ranks, warm, steps)
        alone = {"program": "LIGGGHTS"} | own.pop("alone") | {"particles": own["particles"], OTHERS: own.get(OTHERS)}
        write_dpmfoam(content, run / "CFD", np.load(run / "bed.npy")[:, :3], own["step"], steps)
        prepare_mesh(content, run, ranks)
        peer: Row = {"program": "DPMFoam", "step": own["step"]}
        with watch_others(peer):
            peer |= time_dpmfoam(run / "CFD", ranks, steps, skip=2)
        rows = {"fbcouple": own, "DPMFoam": peer, "LIGGGHTS": alone}
        if not explain_absence(content):
            write_lammps(content, run / "lammps", np.load(run / "alone.npy"), alone["steps"])
            rows["LAMMPS"] = {}
            with watch_others(rows["LAMMPS"]):
                rows["LAMMPS"] |= time_lammps(run / "lammps", ranks)
    return rows


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


def measure_prepared(kind: str, case: Case, ranks: int, *numbers: float) -> Row:
    """Set `case` up in a temporary folder, and measure it; its particles start on the lattice. Raises: SolverError."""
    with _place() as folder:
        set_up(case, folder / "run")
        return _measure(kind, folder / "run", case, ranks, *numbers)


def measure_costs(case: str, sets: Sequence[str], ranks: int, warm: float, seconds: float) -> Row:
    """Processor time by phase, and work, of a case from `warm` to `warm + seconds` [s]. Raises: CaseError,
    SolverError."""
    return _measure_case("costs", case, sets, ranks, warm, seconds)


def _measure(kind: str, run: Path, case: Case, ranks: int, *numbers: float) -> dict[str, Any]:
    if case.gas:
        prepare_mesh(case, run, ranks)
    told: Row = {}
    with watch_others(told):
        found = _start(kind, run, ranks, *numbers)
    return found | told


def _start(kind: str, run: Path, ranks: int, *numbers: float) -> dict[str, Any]:
    program = [sys.executable, "-m", "fbcouple.bench.process", kind, str(run), *map(repr, numbers)]
    environment = mpi_environment() | {"PWD": os.getcwd()}
    done = run_program(mpi_command(ranks, program), environment)
    if done.returncode:
        words = "\n".join((done.stdout + done.stderr).strip().splitlines()[-_TAIL:])
        raise SolverError(f"bench {kind} on {ranks} ranks failed:\n{words}")
    return json.loads((run / _FOUND).read_text(encoding="utf-8"))
