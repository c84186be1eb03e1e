"""A case file to spoil, and what the command line says about it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from fbcouple.case.checks import bed as bed_checks
from fbcouple.cli.main import cli
from fbcouple.paths import CASES

Spoil = Callable[..., Path]


@pytest.fixture
def spoil(tmp_path: Path) -> Spoil:
    """Copy patil/c2 into the test's folder with lines replaced: `spoil(("mass = 0.075", "mass = 7.5"))`."""

    def write(*replacements: tuple[str, str]) -> Path:
        text = (CASES / "patil/c2/case.toml").read_text()
        for old, new in replacements:
            assert text.count(old) == 1, f"{old!r} must stand in the case once"
            text = text.replace(old, new)
        path = tmp_path / "case.toml"
        path.write_text(text)
        return path

    return write


@pytest.fixture
def on_a_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory for every shipped case, which this machine may lack."""
    monkeypatch.setattr(bed_checks, "machine_memory", lambda: 10**12)


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Call the command line in this process, in the test's folder."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments: object) -> Result:
        return CliRunner().invoke(cli, [str(argument) for argument in arguments])

    return invoke
