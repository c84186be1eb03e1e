"""Errors of the Python interface speak of its arguments, not of the options of the command line."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import fbcouple
from fbcouple.arguments import in_python, say_in_python
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError, SolverError

ROOT = Path(__file__).resolve().parents[1]
ABOVE = ("cli", "batch", "bench", "study", "validate", "verify", "doctor")
"""Packages that only the command line reaches."""
COMMANDS = ("check", "setup", "run", "post")
OPTIONS = sorted({name for command in COMMANDS for option in cli.commands[command].params for name in option.opts})
FLAG = re.compile(rf"(?<![\w-])({'|'.join(name for name in OPTIONS if name.startswith('-'))})(?![\w-])")


def join(node):
    """The text of a constant, or of a formatted string with an X for each value; nothing of any other node."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    values = [part.value if isinstance(part, ast.Constant) else "X" for part in parts]
    is_text = isinstance(node, ast.JoinedStr) or (isinstance(values[0], str) and values != ["X"])
    return "".join(values) if is_text else ""


def list_texts():
    """Every text of the package that holds an option, but bare ones, which are arguments of programs."""
    found = set()
    for path in [*ROOT.glob("fbcouple/**/*.py"), *ROOT.glob("postproc/**/*.py")]:
        if path.relative_to(ROOT).parts[1] in ABOVE or path.name == "arguments.py":
            continue
        tree = ast.parse(path.read_text())
        docs = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
            and node.body
            and isinstance(node.body[0], ast.Expr)
        }
        joined = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)]
        docs |= {id(part) for node in joined for part in node.values}
        for node in [*joined, *(node for node in ast.walk(tree) if id(node) not in docs)]:
            text = join(node)
            if " " in text.strip() and FLAG.search(text) and "\n" not in text and "gmsh OLD" not in text:
                found.add(text)
    return sorted(found)


TEXTS = list_texts()


def test_there_are_such_texts():
    assert len(TEXTS) > 10


@pytest.mark.parametrize("text", TEXTS)
def test_no_option_of_the_command_line_is_left(text):
    assert not FLAG.search(say_in_python(text)), say_in_python(text)


def test_errors_keep_their_class_and_say_it_in_python():
    with pytest.raises(CaseError) as caught, in_python():
        raise CaseError(["run: holds results (results.nc); --resume goes on, --fresh starts again and removes them"])
    told = "run: holds results (results.nc); resume() or resume=True goes on, fresh=True starts again and removes them"
    assert caught.value.problems == [told] and str(caught.value) == told
    with pytest.raises(SolverError, match="was removed; resume\\(\\) or resume=True goes on"), in_python():
        raise SolverError("the lock was removed; --resume goes on")


def test_a_folder_that_is_none_and_a_value_that_is_wrong(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    with pytest.raises(CaseError) as caught:
        fbcouple.setup("single-impact", tmp_path / "mine" / "notes.txt")
    assert not FLAG.search(str(caught.value))
    with pytest.raises(CaseError, match=r"^values: gas\.no_such"):
        fbcouple.load_case("mueller/0.9", {"gas.no_such": 1.0})
