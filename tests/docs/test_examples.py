"""The examples of README and documentation: run as they stand, or held against the parser of the command line.

docs/developer/tests.md says what the mark before a block asks for.
"""

from __future__ import annotations

import ast
import importlib.util
import json
import os
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from unittest.mock import patch

import click
import pytest
from click.testing import CliRunner
from pages import MARKS, ROOT, Block, list_inline, list_pages, name_page, read_blocks

from fbcouple.case.schema.reference import list_options, list_sections
from fbcouple.cli.main import cli
from fbcouple.cli.placement import list_site_options
from fbcouple.study.schema import Study
from fbcouple.validate.schema import Validation

PAGES = {name_page(page): list(read_blocks(page.read_text(encoding="utf-8"))) for page in list_pages()}
ANY_PROGRAM = ("pip", "pre-commit")
LONG = ("docs/how-to/move-run-folder.md", "docs/how-to/replicas.md", "docs/how-to/validate.md")
"""Pages whose examples run for most of a minute each: with the slow tests, but for their syntax."""
LIMIT = 600.0
"""Wall time [s] of a command; the slowest takes some seconds of a machine with nothing else to do."""


def is_run(block: Block) -> bool:
    if block.language not in ("console", "python") or block.mark in ("syntax", "later"):
        return False
    return block.mark != "needs" or block.word in cli.commands


RUN = [name for name, blocks in PAGES.items() if any(map(is_run, blocks))]


def check_syntax(command: str) -> None:
    """A command of fbcouple must be one that its parser takes; of others the program, module or file must be there."""
    words = shlex.split(command, comments=True)
    program, rest = words[0], words[1:]
    if program == "fbcouple":
        with patch.object(click.Command, "invoke", lambda self, context: None):
            done = CliRunner().invoke(cli, rest)
        assert done.exit_code == 0, f"{command}: {done.output}"
        keys = {words[n + 1].partition("=")[0] for n, word in enumerate(words) if word == "--set"}
        assert keys <= set(list_options()), command
    elif program.endswith("bin/python"):
        assert rest[0] == "-m" and importlib.util.find_spec(rest[1]), command
        assert all((ROOT / word).exists() for word in rest if word.startswith("tests/")), command
    elif program.startswith("./"):
        assert os.access(ROOT / program, os.X_OK), command
    else:
        assert program in ANY_PROGRAM, f"{command}: nothing here can tell whether it is right"


def check_inline(command: str) -> None:
    """A command in running text must be whole where it is more than the name of one, or of one with its options."""
    words = shlex.split(command)
    if words[1].isupper():  # any command
        return
    if len(words) == 2:
        assert words[1] in cli.commands or words[1].startswith("-"), f"{command}: no such command"
        return
    with patch.object(click.Command, "invoke", lambda self, context: None):
        done = CliRunner().invoke(cli, words[1:])
    assert done.exit_code == 0 or "Missing argument" in done.output, f"{command}: {done.output}"


def run_block(block: Block, folder: Path) -> None:
    """Run a block in `folder`, with this checkout's fbcouple first on the paths."""
    paths = {
        "PATH": os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])),
        "PYTHONPATH": str(ROOT),
    }
    commands = [[sys.executable, "-c", block.text]]
    if block.language == "console":
        commands = [["bash", "-euo", "pipefail", "-c", command] for command in block.commands]
    for command in commands:
        done = subprocess.run(
            command, cwd=folder, env=os.environ | paths, capture_output=True, text=True, check=False, timeout=LIMIT
        )
        assert done.returncode == 0, f"{command[-1]}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"


@pytest.mark.parametrize("page", [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in RUN])
def test_examples_run(page, tmp_path):
    for block in PAGES[page]:
        if block.mark == "file":
            path = tmp_path / block.word
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        elif is_run(block):
            run_block(block, tmp_path)


@pytest.mark.parametrize("page", PAGES)
def test_examples_are_well_formed(page):
    for block in PAGES[page]:
        assert block.mark in ("", *MARKS), f"no such mark: {block.mark}"
        if block.language == "console" and block.mark != "needs":
            for command in block.commands:
                if block.mark in ("syntax", "later") or command.startswith("fbcouple "):
                    check_syntax(command)
        elif block.language == "python":
            ast.parse(block.text)
        elif block.language == "toml":
            check_toml(tomllib.loads(block.text))


@pytest.mark.parametrize("page", list_pages(), ids=name_page)
def test_commands_in_running_text_are_whole(page):
    for command in list_inline(page.read_text(encoding="utf-8")):
        check_inline(command)


@pytest.mark.parametrize("command", ["fbcouple batch runs/c2", "fbcouple run a --rank 2", "fbcouple setpu"])
def test_wrong_commands_in_running_text_are_found(command):
    with pytest.raises(AssertionError):
        check_inline(command)


def check_toml(content: dict) -> None:
    """Keys of a case, of a study, of a measured bed, or of a site must be options."""
    if all(isinstance(value, dict) and "scheduler" in value for value in content.values()):
        assert {key for table in content.values() for key in table} <= set(list_site_options(cli.commands["batch"]))
        return
    if "measurements" in content:
        Validation.model_validate(content)
        return
    if "knobs" in content:
        assert set(content) <= set(Study.model_fields)
        return
    sections = [name for name, value in content.items() if isinstance(value, dict)]
    keys = {name for name in content if name not in sections} - {"base"}
    keys |= {f"{section}.{key}" for section in sections for key in content[section]}
    assert set(sections) <= set(list_sections())
    assert keys <= set(list_options())


@pytest.mark.parametrize(
    "command", ["fbcouple setpu a", "fbcouple run a --rank 2", "fbcouple setup a --set gas.velocity=1", "solve it"]
)
def test_wrong_commands_are_found(command):
    with pytest.raises(AssertionError):
        check_syntax(command)


@pytest.mark.parametrize("page", ["README.md", *(f"docs/tutorials/{name}.md" for name in ("first-bed", "own-bed"))])
def test_first_steps_are_run_and_not_only_parsed(page):
    commands = [command for block in PAGES[page] if is_run(block) for command in block.text.splitlines()]
    for step in ("check", "setup", "run", "post", "report"):
        assert any(command.startswith(f"$ fbcouple {step} ") for command in commands)


def test_notebook_has_the_cells_of_its_page():
    notebook = json.loads((ROOT / "docs/tutorials/first_bed.ipynb").read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert cells == [block.text.rstrip("\n") for block in PAGES["docs/tutorials/notebook.md"]]
    assert not any(cell.get("outputs") for cell in notebook["cells"])


def test_notebook_runs(tmp_path):
    """Its cells one after the other, as a kernel would; the bed is run for less long."""
    notebook = json.loads((ROOT / "docs/tutorials/first_bed.ipynb").read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    long = '{"end_time": 0.05, "averages.start": 0.02}'
    assert long in cells[0]
    cells[0] = cells[0].replace(long, '{"end_time": 0.02, "averages.start": 0.01, "averages.blocks": 2}')
    (tmp_path / "cells.py").write_text("\n".join(cells), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    command = [sys.executable, "cells.py"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=LIMIT
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert (tmp_path / "notebook.html").is_file() and list((tmp_path / "runs/notebook/figures").glob("*.png"))
