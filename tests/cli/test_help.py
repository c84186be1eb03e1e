"""Every command has its help, under a heading and uncut; version and completion."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest
from click.shell_completion import BashComplete
from click.testing import CliRunner

import fbcouple
from fbcouple.case.source import list_sets, list_shipped
from fbcouple.cli.group import WORKFLOW
from fbcouple.cli.main import cli
from fbcouple.solvers.versions import find_commit
from fbcouple.verify.registry import load_checks

ROOT = Path(fbcouple.__file__).parents[1]


def list_commands(group: click.Group, above: tuple[str, ...] = ()) -> dict[tuple[str, ...], click.Command]:
    found: dict[tuple[str, ...], click.Command] = {}
    for name, command in group.commands.items():
        found[*above, name] = command
        if isinstance(command, click.Group):
            found |= list_commands(command, (*above, name))
    return found


COMMANDS = list_commands(cli)


def ask(*arguments: str) -> str:
    result = CliRunner().invoke(cli, arguments, prog_name="fbcouple", terminal_width=80)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize("names", COMMANDS, ids=" ".join)
def test_h_is_help(names):
    assert ask(*names, "-h") == ask(*names, "--help")


@pytest.mark.parametrize("names", COMMANDS, ids=" ".join)
def test_every_option_has_a_sentence(names):
    for parameter in COMMANDS[names].params:
        if isinstance(parameter, click.Option):
            assert parameter.help and parameter.help.rstrip("]").endswith((".", "0.7")), parameter.name


def test_every_command_is_under_a_heading_of_the_workflow():
    assert sorted(name for names in WORKFLOW.values() for name in names) == sorted(cli.commands)
    lines = ask("--help").splitlines()
    assert [line[:-1] for line in lines if line.rstrip(":") in WORKFLOW] == list(WORKFLOW)
    assert "Others:" not in lines


@pytest.mark.parametrize("group", [(), ("study",), ("bench",)], ids=str)
def test_no_sentence_of_the_list_is_cut(group):
    page = ask(*group, "--help")
    words = " ".join(page.split())
    assert "..." not in words.partition("COMMAND [ARGS]...")[2]
    for names, command in COMMANDS.items():
        if names[:-1] == group:
            first = " ".join((command.help or "").split("\n\n")[0].split())
            assert first.partition(". ")[0].rstrip(".") in words, names


def test_module_and_version():
    done = subprocess.run(
        [sys.executable, "-m", "fbcouple", "--version"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    assert done.stdout.startswith(f"fbcouple, version {fbcouple.__version__}")
    commit = find_commit()
    assert (f"commit {commit}" in done.stdout) is (ROOT / ".git").exists()


def test_version_stands_in_one_file():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert "version" not in project["project"] and "version" in project["project"]["dynamic"]
    source = ROOT / project["tool"]["hatch"]["version"]["path"]
    scope: dict[str, str] = {}
    exec(source.read_text(), scope)
    assert scope["__version__"] == fbcouple.__version__
    others = [path for path in (ROOT / "fbcouple").rglob("*.py") if path != source]
    assert not [path for path in others if f'"{fbcouple.__version__}"' in path.read_text()]


def complete(*words: str) -> list[tuple[str, str]]:
    completion = BashComplete(cli, {}, "fbcouple", "_FBCOUPLE_COMPLETE")
    return [(item.type, item.value) for item in completion.get_completions(list(words[:-1]), words[-1])]


@pytest.mark.parametrize("command", [("check",), ("setup",), ("bench", "overhead")], ids=" ".join)
def test_names_of_shipped_cases_are_completed(command):
    found = complete(*command, "patil/c")
    assert found[0] == ("file", "patil/c")
    plain = [value for kind, value in found if kind == "plain"]
    assert set(plain) >= {name for name in list_shipped() if name.startswith("patil/c")} != set()
    assert all(value.startswith("patil/c") for value in plain)
    sets = {value for _, value in complete(*command, "patil/") if value in list_sets()}
    assert sets == (set(list_sets()) if command == ("setup",) else set())


def test_every_check_of_verify_says_what_it_checks():
    silent = [name for name, check in load_checks().items() if not (check.function.__doc__ or "").strip()]
    assert silent == []
