"""Imports point one way: cli -> launch, decks, postproc -> results, case; worker -> engines, exchange, averages.

Read from the source by its syntax tree, imports inside functions included.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# Where gas, particles and the exchange between them meet.
MEETING_PLACES = {"fbcouple.worker", "fbcouple.scene", "fbcouple.recorder"}


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
    graph = {}
    for path in sorted([*ROOT.glob("fbcouple/**/*.py"), *ROOT.glob("postproc/**/*.py")]):
        parts = path.relative_to(ROOT).with_suffix("").parts
        is_package = parts[-1] == "__init__"
        module = ".".join(parts[:-1] if is_package else parts)
        graph[module] = find_imports(path.read_text(), module, is_package)
    return graph


GRAPH = read_graph()


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
        "def f():\n    from fbcouple.exchange.plan import Plan\n    if f:\n        from . import native\n"
        "        from ..case import load\n"
    )
    assert find_imports(source, "fbcouple.engines.liggghts") == {
        "numpy",
        "rich.table",
        "fbcouple",
        "fbcouple.worker",
        "fbcouple.exchange.plan",
        "fbcouple.exchange.plan.Plan",
        "fbcouple.engines",
        "fbcouple.engines.native",
        "fbcouple.case",
        "fbcouple.case.load",
    }


def test_all_files_are_read():
    assert {"fbcouple", "fbcouple.cli", "fbcouple.exchange.plan", "postproc", "postproc.dataset"} <= set(GRAPH)
    assert "fbcouple.exchange.plan.Plan" in GRAPH["fbcouple.scene"] and "mpi4py.MPI" in reach("fbcouple.worker")


def test_postproc_knows_only_errors_and_names_of_results():
    own = {name for name in reach("postproc") if lies_in(name, "fbcouple")}
    allowed = (
        "fbcouple.errors",
        "fbcouple.results",
        "fbcouple.grid",
        "fbcouple.reference",
        "fbcouple.number_table",
        "fbcouple.companion_files",
        "fbcouple.collision",
        "fbcouple.places",
        "fbcouple.__version__",
    )
    assert {name for name in own if name != "fbcouple" and not lies_in(name, *allowed)} == set()
    assert reached("fbcouple.errors", "postproc")


def test_engines_and_exchange_do_not_know_each_other():
    assert reached("fbcouple.exchange", "fbcouple.engines") == set()
    assert reached("fbcouple.engines", "fbcouple.exchange", "fbcouple.averages") == set()


def test_engines_and_exchange_meet_in_the_worker():
    meeting = importers("fbcouple.engines") & importers("fbcouple.exchange")
    assert meeting <= MEETING_PLACES
    assert "fbcouple.scene" in meeting


def test_only_the_command_line_knows_click():
    assert {module for module in importers("click") if not lies_in(module, "fbcouple.commands")} == {"fbcouple.cli"}


def test_only_the_command_line_and_the_progress_print_with_rich():
    assert importers("rich") <= {"fbcouple.cli", "fbcouple.commands.table", "fbcouple.progress"}


def test_nobody_imports_the_command_line():
    assert importers("fbcouple.cli") == set()
    assert importers("fbcouple.commands") == {"fbcouple.cli"}


@pytest.mark.parametrize("end", ["launch", "decks", "case", "progress"])
def test_the_command_line_stands_on_the_rest(end):
    assert reached(f"fbcouple.{end}", "fbcouple.cli")


@pytest.mark.parametrize("low", ["launch", "decks", "results", "case", "failure", "progress"])
def test_the_parent_starts_no_mpi_and_no_solver(low):
    found = reach(f"fbcouple.{low}") | reach("postproc")
    forbidden = ("mpi4py", "fbcouple.worker", "fbcouple.scene", "fbcouple.engines.liggghts", "fbcouple.averages")
    assert {name for name in found if lies_in(name, *forbidden)} == set()


def test_the_worker_does_not_know_who_started_it():
    above = ("cli", "launch", "decks", "doctor", "progress", "batch", "verify", "study")
    names = reach("fbcouple.worker")
    assert {name for name in names if lies_in(name, "postproc", *(f"fbcouple.{part}" for part in above))} == set()


@pytest.mark.parametrize("part", ["engines", "exchange", "averages", "case", "decks", "results", "clock", "contacts"])
def test_parts_do_not_know_the_time_loop(part):
    above = ("fbcouple.worker", "fbcouple.scene", "fbcouple.recorder", "fbcouple.launch", "fbcouple.cli")
    assert {name for name in reach(f"fbcouple.{part}") if lies_in(name, *above)} == set()


def test_case_files_do_not_know_what_is_made_of_them():
    above = ("fbcouple.decks", "fbcouple.results", "fbcouple.engines")
    assert {name for name in reach("fbcouple.case") if lies_in(name, *above)} == set()


def test_no_two_modules_need_each_other():
    circles = [
        (module, name)
        for module in GRAPH
        for name in GRAPH[module]
        if name in GRAPH and module in reach(name) and module.count(".") and name.count(".")
    ]
    assert circles == []
