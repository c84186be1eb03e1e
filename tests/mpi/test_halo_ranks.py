"""The exchange on 1, 2 and 4 ranks against one process, with cells scattered over ranks otherwise than particles."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("halo_program.py")
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMP_NUM_THREADS": "1",
}


@pytest.fixture(
    scope="module",
    params=[
        (1, "random", {"filter_passes": 1}),
        (2, "random", {}),
        (2, "random", {"filter_passes": 2}),
        (4, "random", {"filter_passes": 1}),
        (4, "slabs", {"filter_passes": 1}),
        (4, "slabs", {"voidage": "divided"}),
        (4, "random", {"voidage": "gaussian", "kernel_width": 3.0}),
        (4, "random", {"voidage": "centre", "diffusion_width": 1.5}),
    ],
    ids=lambda p: "-".join(map(str, (*p[:2], *p[2].values()))),
)
def found(request):
    """What the program found on that many ranks, with that scatter of the cells and that exchange."""
    ranks, scatter, exchange = request.param
    command = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
    done = subprocess.run(
        [*command, sys.executable, "-m", "mpi4py", PROGRAM, scatter, json.dumps(exchange)],
        env=os.environ | ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    results = json.loads(done.stdout)
    assert results["ranks"] == ranks and sum(results["particles"]) == 300
    return results | {"scatter": scatter}


@pytest.mark.parametrize("what", ["voidage and drag", "forces", "drag", "reverse", "forward", "transpose"])
def test_ranks_do_not_change_the_exchange(found, what):
    assert found[what] < 1e-13


def test_solids_volume_is_kept(found):
    assert found["volume"] < 1e-12


def test_momentum_is_kept(found):
    assert found["momentum"] < 1e-13


def test_the_ranks_are_as_uneven_as_the_test_wants(found):
    """Cells everywhere, a rank without any particle, and particles that have just left their rank's box."""
    assert min(found["cells"]) > 0
    if found["ranks"] > 1:
        assert found["particles"][-1] == 0 and min(found["particles"][:-1]) > 0
    if found["ranks"] > 2:
        assert found["strays"] > 0


def test_messages_go_only_where_cells_are_shared(found):
    assert found["messages"] == [len(ranks) for ranks in found["shared"]]
    if found["scatter"] == "slabs":
        near = [{rank - 1, rank + 1} & set(range(found["ranks"])) for rank in range(found["ranks"])]
        assert all(set(ranks) <= allowed for ranks, allowed in zip(found["shared"], near, strict=True))
        assert sum(found["messages"]) == 2 * (found["ranks"] - 1)


def test_a_cell_that_nobody_owns_is_told_by_the_ranks_that_want_it(found):
    assert "cells of its local grid" in found["missing cell"][0] and "rank 0" in found["missing cell"][0]
    assert [bool(words) for words in found["missing cell"]] == found["first cell"]
