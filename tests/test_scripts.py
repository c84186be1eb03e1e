"""The scripts a newcomer starts with: valid shell, strict, startable from any folder, honest about wrong words."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = ("run-demo.sh", "run-tests.sh", "scripts/install.sh", ".ci/run", ".ci/newest")


@pytest.mark.parametrize("name", SCRIPTS)
def test_script_is_valid_strict_and_executable(name):
    path = ROOT / name
    lines = path.read_text().splitlines()
    assert lines[0] == "#!/usr/bin/env bash" and "set -euo pipefail" in lines
    assert os.access(path, os.X_OK)
    assert any("BASH_SOURCE[0]" in line and "cd " in line for line in lines), "must not depend on where it is called"
    subprocess.run(["bash", "-n", path], check=True)


@pytest.mark.parametrize("words", [["--fersh"], ["--fresh", "more"]])
def test_demo_refuses_unknown_words(words, tmp_path):
    done = subprocess.run(
        ["bash", ROOT / "run-demo.sh", *words], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "usage: run-demo.sh [--fresh]" in done.stderr and words[0] in done.stderr


def test_without_root_the_rest_is_done_and_one_command_is_left(tmp_path):
    """On a system without sudo whose dpkg knows no package: Python packages are installed, then the command is told."""
    parts = (ROOT / "scripts/install.sh").read_text().replace('cd "$root"', f'cd "{ROOT}"')
    script = tmp_path / "install.sh"
    done = 'python_packages() { echo "python packages: done"; }\nid() { echo 1000; }\n'
    script.write_text(parts.replace("administrator=\n", f"{done}administrator=\n", 1))
    for name in ("dpkg-query", "dirname", "mktemp", "rm", "grep", "python3"):
        real = subprocess.run(["which", name], capture_output=True, text=True, check=False).stdout.strip()
        (tmp_path / name).symlink_to("/bin/false" if name == "dpkg-query" else real)
    told = {"PATH": str(tmp_path)}
    ran = subprocess.run(["/bin/bash", script], env=told, capture_output=True, text=True, check=False)
    assert ran.returncode == 1 and ran.stdout.splitlines()[-1] == "python packages: done", ran.stdout + ran.stderr
    words = "for an administrator, then run this again: apt-get install -y --no-install-recommends openmpi-bin liggghts"
    assert words in ran.stderr and len(ran.stderr.splitlines()) == 1


def test_without_root_and_python_the_command_that_brings_it_is_told(tmp_path):
    """Nothing can be done on such a system before the administrator has been there."""
    (tmp_path / "scripts").mkdir()
    (tmp_path / "fbcouple/doctor").mkdir(parents=True)
    listed = "fbcouple/doctor/system_packages.txt"
    (tmp_path / listed).write_bytes((ROOT / listed).read_bytes())
    bare = "find_python() { return 1; }\nid() { echo 1000; }\nmissing_packages() { wanted_packages; }\n"
    script = tmp_path / "scripts/install.sh"
    parts = (ROOT / "scripts/install.sh").read_text()
    script.write_text(
        parts.replace("administrator=\n", f"{bare}command() {{ [ $2 = dpkg-query ]; }}\nadministrator=\n", 1)
    )
    ran = subprocess.run(["/bin/bash", script], capture_output=True, text=True, check=False)
    assert ran.returncode == 1 and "what needs none is done now" in ran.stdout
    first, second = ran.stderr.splitlines()
    assert "apt-get install -y --no-install-recommends python3 python3-venv openmpi-bin" in first
    assert "no Python >= 3.11 with venv here" in second and not (tmp_path / ".venv").exists()
