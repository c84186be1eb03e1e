"""The fast scenes of `fbcouple verify`: every number within its tolerance, with the real solvers."""

from __future__ import annotations

import pytest

from fbcouple.verify.suite import choose_scenes, run_scenes


@pytest.mark.parametrize("name", [scene.name for scene in choose_scenes((), fast=True)])
def test_scene(name):
    rows = list(run_scenes(choose_scenes((name,), fast=True)))
    assert rows, "a scene without numbers proves nothing"
    missed = [f"{row['name']}: {row['value']:g}, not {row['expected']:g}" for row in rows if not row["passed"]]
    assert not missed, "\n".join(missed)
