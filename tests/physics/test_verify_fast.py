"""The fast checks of `fbcouple verify`: every number within its tolerance, with the real solvers."""

from __future__ import annotations

import pytest

from fbcouple.verify.suite import choose_checks, run_checks


@pytest.mark.parametrize("name", [scene.name for scene in choose_checks((), fast=True)])
def test_scene(name):
    rows = list(run_checks(choose_checks((name,), fast=True)))
    assert rows, "a check without numbers proves nothing"
    missed = [f"{row['name']}: {row['value']:g}, not {row['expected']:g}" for row in rows if not row["passed"]]
    assert not missed, "\n".join(missed)
