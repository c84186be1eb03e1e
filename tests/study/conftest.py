"""A small study file to spoil, and a base case of one bead."""

from __future__ import annotations

from pathlib import Path

import pytest

from fbcouple.paths import CASES

BEAD = CASES / "studies/single-particle"
STUDY = """
title = "steps"
base = "case.toml"
measures = ["path"]
design = "grid"
[set]
gas.max_courant = 10.0
[knobs]
gas.max_step = [1e-3, 2e-3]
exchange.scheme = ["explicit", "exponential"]
"""


@pytest.fixture
def write(tmp_path: Path):
    """Write a study beside its base case, with lines replaced; returns its path."""

    def write_study(*replacements: tuple[str, str], text: str = STUDY) -> Path:
        for old, new in replacements:
            assert text.count(old) == 1, f"{old!r} must stand in the study once"
            text = text.replace(old, new)
        for name in ("case.toml", "bead.csv"):
            (tmp_path / name).write_text((BEAD / name).read_text())
        path = tmp_path / "study.toml"
        path.write_text(text)
        return path

    return write_study
