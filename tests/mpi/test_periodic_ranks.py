"""The exchange of a box without side walls on 1, 2 and 4 ranks against one process."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from test_halo_ranks import ENVIRONMENT

PROGRAM = Path(__file__).with_name("periodic_program.py")


@pytest.fixture(scope="module", params=[(1, 1), (2, 0), (4, 2)], ids=lambda p: f"{p[0]}-{p[1]}")
def found(request):
    """What the program found on that many ranks with that many passes of the filter."""
    ranks, passes = request.param
    command = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
    done = subprocess.run(
        [*command, sys.executable, "-m", "mpi4py", PROGRAM, str(passes)],
        env=os.environ | ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    results = json.loads(done.stdout)
    assert results["ranks"] == ranks and results["strayed"] > 30
    return results


@pytest.mark.parametrize("what", ["voidage and drag", "forces", "drag"])
def test_ranks_and_strays_do_not_change_the_exchange(found, what):
    assert found[what] < 1e-12


def test_solids_volume_is_kept(found):
    assert found["volume"] < 1e-12


def test_momentum_is_kept(found):
    assert found["momentum"] < 1e-13
