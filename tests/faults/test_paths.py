"""Paths as people have them, with blanks and quotes and their own letters: they run, or are refused at set-up."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from small_bed import BED

from fbcouple.cli.main import cli

NAME = 'it\'s "my" $(touch gone) b\u00e9d; \u5e8a #1'


def call(*words: object, folder: Path, **variables: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "fbcouple.cli.main", *map(str, words)]
    environment = os.environ | variables
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, encoding="utf-8", check=False)


def test_bed_in_a_path_of_blanks_quotes_and_letters(tmp_path):
    """Mesh tools, both solvers, two ranks, scratch folder and case file: all of them below such names."""
    folder = tmp_path / NAME
    (folder / "scratch").mkdir(parents=True)
    (folder / "my case.toml").write_text(BED, encoding="utf-8")
    small = ("--set", "end_time=1e-3", "--set", "gas.closed_nozzle=[1, 1]")
    small += ("--set", "averages.start=0", "--set", "checkpoint.every=5e-4")
    done = call("setup", folder / "my case.toml", "-o", folder / "run", *small, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    done = call("run", "run", "-n", "2", "--until", "5e-4", folder=folder, TMPDIR=str(folder / "scratch"))
    assert done.returncode == 0, done.stderr
    done = call("run", folder / "run", "--resume", folder=tmp_path)
    assert done.returncode == 0 and (folder / "run/results.nc").exists(), done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == [NAME], "nothing lies beside it"


@pytest.mark.parametrize(
    ("name", "told"), [("a\\b", "U+005C"), ("a\nb", "U+000A"), ("a\tb", "U+0009"), (os.fsdecode(b"a\xfc"), "U+DCFC")]
)
def test_path_that_no_results_can_be_written_to(tmp_path, name, told):
    """Told at set-up; and where a run folder was moved there, before its run."""
    (tmp_path / "case.toml").write_text(BED, encoding="utf-8")
    result = CliRunner().invoke(cli, ["setup", str(tmp_path / "case.toml"), "-o", str(tmp_path / name)])
    assert result.exit_code == 1 and told in result.stderr and len(result.stderr.splitlines()) == 1
    assert not (tmp_path / name).exists()
    (tmp_path / name).mkdir()
    (tmp_path / "case.toml").rename(tmp_path / name / "case.toml")
    result = CliRunner().invoke(cli, ["run", str(tmp_path / name)])
    assert result.exit_code == 1 and told in result.stderr


def test_commands_in_messages_can_be_pasted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text(BED, encoding="utf-8")
    result = CliRunner().invoke(cli, ["setup", "case.toml", "-o", "my bed"])
    assert "`fbcouple run 'my bed'`" in result.stdout
