"""Imports point one way: down the floors of FLOORS, and in no circle.

Read from the source by its syntax tree, imports inside functions included.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FLOORS = (
    ("errors", "version"),
    ("paths", "arguments"),
    ("machine", "input_files"),
    ("physics",),
    ("geometry",),
    ("results",),
    ("case",),
    ("run_folder",),
    ("solvers", "coupling"),
    ("decks",),
    ("simulation",),
    ("postproc",),
    ("launcher",),
    ("api", "live"),
    ("doctor", "batch"),
    ("bench", "study", "validate", "verify"),
    ("cli",),
    ("__main__",),
)
"""Files and folders of fbcouple, the lowest first: each imports of itself and of what lies below its floor."""


def find_imports(source: str, module: str, is_package: bool = False) -> set[str]:
    """Dotted names that `source` imports, wherever in it; of `from a import b` both a and a.b."""
    names: set[str] = set()
    package = module if is_package else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*above, base] if base else above)
            names |= {base} | {f"{base}.{alias.name}" for alias in node.names}
    return names


def read_graph() -> dict[str, set[str]]:
    """Module -> all that it imports, for every file of the package and of postproc."""
    files = {path: path.relative_to(ROOT) for path in ROOT.glob("fbcouple/**/*.py") if "postproc" not in path.parts}
    files |= {path: Path("fbcouple") / path.relative_to(ROOT) for path in ROOT.glob("postproc/**/*.py")}
    graph = {}
    for path, inner in files.items():
        parts = inner.with_suffix("").parts
        is_package = parts[-1] == "__init__"
        module = ".".join(parts[:-1] if is_package else parts)
        graph[module] = find_imports(path.read_text(), module, is_package)
    return graph


GRAPH = read_graph()
PACKAGES = {module.rpartition(".")[0] for module in GRAPH}
"""Named in every `from package import module`, which needs the module alone."""


def find_room(module: str) -> str:
    return module.split(".")[1]


def lies_in(name: str, *places: str) -> bool:
    return any(name == place or name.startswith(f"{place}.") for place in places)


def importers(*places: str) -> set[str]:
    """Modules that import something of `places`, from outside of them."""
    return {
        module
        for module, names in GRAPH.items()
        if not lies_in(module, *places) and any(lies_in(name, *places) for name in names)
    }


def reach(*starts: str) -> set[str]:
    """Everything that the modules in `starts` import, directly or through our own modules."""
    seen: set[str] = set()
    waiting = [module for module in GRAPH if lies_in(module, *starts)]
    while waiting:
        for name in GRAPH[waiting.pop()] - seen:
            seen.add(name)
            if name in GRAPH:
                waiting.append(name)
    return seen


def reached(name: str, *starts: str) -> set[str]:
    return {found for found in reach(*starts) if lies_in(found, name)}


def test_imports_are_found_wherever_they_stand():
    source = (
        "import numpy as np, rich.table\nfrom fbcouple import worker\n"
        "def f():\n    from fbcouple.coupling.halo import LocalGrid\n    if f:\n        from . import native\n"
        "        from ..case import load\n"
    )
    assert find_imports(source, "fbcouple.solvers.liggghts") == {
        "numpy",
        "rich.table",
        "fbcouple",
        "fbcouple.worker",
        "fbcouple.coupling.halo",
        "fbcouple.coupling.halo.LocalGrid",
        "fbcouple.solvers",
        "fbcouple.solvers.native",
        "fbcouple.case",
        "fbcouple.case.load",
    }


def test_all_files_are_read():
    assert {"fbcouple", "fbcouple.cli.main", "fbcouple.coupling.box.halo", "fbcouple.postproc.style"} <= set(GRAPH)
    assert "fbcouple.coupling.coupling.Coupling" in GRAPH["fbcouple.simulation.simulation"]
    assert "mpi4py.MPI" in reach("fbcouple.simulation.worker")
    assert len(GRAPH) > 250


def test_every_room_has_its_floor():
    rooms = {find_room(module) for module in GRAPH if module != "fbcouple"}
    assert rooms == {room for floor in FLOORS for room in floor}
    assert len([room for room in rooms if (ROOT / "fbcouple" / room).is_dir()]) <= 20


def test_imports_point_down_the_floors():
    height = {room: number for number, floor in enumerate(FLOORS) for room in floor}
    up = [
        (module, name)
        for module, names in GRAPH.items()
        for name in names
        if module != "fbcouple" and name in GRAPH and name != "fbcouple" and find_room(name) != find_room(module)
        if height[find_room(name)] >= height[find_room(module)]
    ]
    assert up == []


def test_no_two_modules_need_each_other():
    circles = [
        (module, name)
        for module in GRAPH
        for name in GRAPH[module]
        if name in GRAPH and name not in PACKAGES and module in reach(name)
    ]
    assert circles == []


def test_drawing_needs_no_case_and_no_run_folder():
    own = {name.split(".")[1] for name in reach("fbcouple.postproc") if name in GRAPH and name.count(".")}
    below = {"errors", "version", "paths", "machine", "input_files", "physics", "geometry", "results"}
    assert own <= below | {"postproc"}


def test_what_runs_in_the_ranks_does_not_know_who_started_it():
    above = ("launcher", "cli", "doctor", "batch", "verify", "validate", "study", "bench", "postproc", "api", "live")
    names = reach("fbcouple.simulation")
    assert [name for name in names if lies_in(name, *(f"fbcouple.{room}" for room in above))] == []


def test_solvers_and_coupling_meet_in_the_simulation():
    meeting = importers("fbcouple.solvers.liggghts", "fbcouple.solvers.openfoam.gas") & importers("fbcouple.coupling")
    assert meeting and {find_room(module) for module in meeting} <= {"simulation", "verify"}


def test_only_the_command_line_knows_click():
    assert {find_room(module) for module in importers("click")} == {"cli"}


def test_only_the_command_line_and_the_progress_print_with_rich():
    assert importers("rich") <= {
        *(f"fbcouple.cli.{name}" for name in ("main", "run", "run_set", "status", "table")),
        "fbcouple.launcher.progress",
        "fbcouple.api",
    }


@pytest.mark.parametrize("low", ["launcher", "decks", "results", "case", "run_folder", "postproc"])
def test_the_parent_starts_no_mpi_and_no_solver(low):
    forbidden = ("mpi4py", "fbcouple.simulation", "fbcouple.solvers.liggghts", "fbcouple.solvers.openfoam.gas")
    assert {name for name in reach(f"fbcouple.{low}") if lies_in(name, *forbidden)} == set()
