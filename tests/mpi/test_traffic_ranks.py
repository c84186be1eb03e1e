"""Particles that come and go do so alike on 1, 2 and 4 ranks, and the ledger closes on each."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fbcouple.machine.environment import mpi_environment
from fbcouple.machine.launchers import mpi_command

HERE = Path(__file__).parent
IDENTITY, PLACE, VELOCITY, FORCE = slice(0, 3), slice(3, 6), slice(6, 9), slice(10, 13)


@pytest.fixture(scope="module", params=["traffic", "openings"])
def found(tmp_path_factory, request):
    """Ranks -> what the program found on so many."""
    results = {}
    for ranks in (1, 2, 4):
        place = tmp_path_factory.mktemp(f"ranks-{ranks}")
        if request.param == "openings":
            subprocess.run([sys.executable, HERE / "vessel_mesh.py", place / "vessel.msh"], check=True)
        command = mpi_command(ranks, [sys.executable, str(HERE / f"{request.param}_program.py"), str(place)])
        done = subprocess.run(command, env=mpi_environment(), capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        results[ranks] = json.loads((place / "found.json").read_text())
        assert results[ranks]["ranks"] == ranks
    return results


def test_there_is_something_to_compare(found):
    ledger = found[1]["ledger"]
    assert ledger["fed"]["count"] > 50 and ledger["removed"]["count"] > 30 and found[1]["owed"] > 0
    assert {row[4] for row in found[1]["exits"]} == {1.0, 2.0}, "both outlets"
    assert {row[2] for row in found[1]["rows"]} == {0.0, 1.0, 2.0}, "those of the start and of both feeds"


@pytest.mark.parametrize("ranks", [2, 4])
def test_ranks_do_not_change_who_comes_and_goes(found, ranks):
    one, other = (np.array(found[n]["rows"]) for n in (1, ranks))
    assert np.array_equal(one[:, 0], other[:, 0]) and np.array_equal(one[:, 2], other[:, 2])
    for columns, scale in ((IDENTITY, 1e-3), (PLACE, 1e-3), (VELOCITY, 1.0), (FORCE, np.abs(one[:, FORCE]).max())):
        assert np.abs(one[:, columns] - other[:, columns]).max() < 1e-9 * scale
    exits = [np.array(found[n]["exits"]) for n in (1, ranks)]
    assert np.abs(exits[0] - exits[1]).max() < 1e-12


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_ledger_closes(found, ranks):
    ledger, rows = found[ranks]["ledger"], np.array(found[ranks]["rows"])
    assert ledger["start"]["count"] + ledger["fed"]["count"] - ledger["removed"]["count"] == len(rows)
    assert len(found[ranks]["exits"]) == ledger["removed"]["count"]
    assert found[ranks]["error"] < 1e-13 and found[ranks]["momentum"] < 1e-9
    assert found[ranks].get("solids", 0.0) < 1e-12
    everybody = np.sort(np.concatenate([rows[:, 0], np.array(found[ranks]["exits"])[:, 0]]))
    assert np.array_equal(everybody, np.arange(1, len(everybody) + 1)), "no number is lost, or used twice"
