"""Recipes: from the list that the install script reads, too, and what a shell can say of them."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

from fbcouple.cli.doctor import RECIPES
from fbcouple.cli.main import cli
from fbcouple.doctor import recipe
from fbcouple.version import __version__

ROOT = Path(__file__).resolve().parents[2]
ASK = 'source <(sed -n "/^suitable_python/,/^missing_packages/p" scripts/install.sh | sed "\\$d"); wanted_packages'


def list_wanted(tmp_path: Path, **environment: str) -> list[str]:
    """What scripts/install.sh wants, where no python is found."""
    for name in ("python3",):
        (tmp_path / name).write_text("#!/bin/sh\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    script = ASK.replace("wanted_packages", "find_python() { return 1; }; wanted_packages", 1)
    told = {"PATH": f"{tmp_path}:{os.environ['PATH']}"} | environment
    done = subprocess.run(["bash", "-c", script], cwd=ROOT, env=told, capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_the_install_script_wants_the_whole_list(tmp_path):
    everything = [debian for debian, _ in recipe.read_packages((*recipe.NEEDED, "tests"))]
    assert list_wanted(tmp_path) == everything and "openfoam" in everything and "python3-venv" in everything


def test_the_install_script_leaves_out_what_the_site_has(tmp_path):
    (tmp_path / "src/OpenFOAM").mkdir(parents=True)
    (tmp_path / "libmine.so").touch()
    wanted = list_wanted(tmp_path, WM_PROJECT_DIR=str(tmp_path), FBCOUPLE_LIGGGHTS=str(tmp_path / "libmine.so"))
    assert "openfoam" not in wanted and "liggghts" not in wanted and "openmpi-bin" in wanted


def test_recipes_of_the_command_line_are_those_there_are():
    assert RECIPES == recipe.RECIPES == tuple(name for name in RECIPES if recipe.write_recipe(name))


@pytest.mark.parametrize("name", ["apptainer", "docker"])
def test_a_container_has_every_package_but_those_of_tests(name):
    text = CliRunner().invoke(cli, ["doctor", "--recipe", name]).output
    assert all(f" {debian}" in text for debian, _ in recipe.read_packages())
    assert not any(debian in text for debian, _ in recipe.read_packages(("tests",)))
    assert f"fbcouple-{__version__}-py3-none-any.whl" in text and "doctor --fix" in text


def test_a_recipe_stands_alone():
    assert CliRunner().invoke(cli, ["doctor", "--recipe", "docker", "--fix"]).exit_code == 2
    assert CliRunner().invoke(cli, ["doctor", "--recipe", "podman"]).exit_code == 2


def test_lines_for_the_shell_are_shell():
    """Of Apptainer's the part that is one."""
    steps = recipe.write_recipe("apptainer").partition("%post\n")[2].partition("%environment")[0]
    for text in (steps, recipe.write_recipe("modules")):
        assert subprocess.run(["bash", "-n"], input=text, text=True, check=False).returncode == 0
