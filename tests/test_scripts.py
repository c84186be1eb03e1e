"""The scripts a newcomer starts with: valid shell, strict, startable from any folder, honest about wrong words."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = ("run-demo.sh", "run-tests.sh", "scripts/install.sh", ".ci/run")


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
