"""Mixing of a run from its frames: what is followed, and with whom it is mixed."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.coupling.box.cells import BoxCells
from fbcouple.geometry.grid import Grid
from fbcouple.postproc.figures.mixing import follow_mixing, mixing
from fbcouple.postproc.report.tables import tabulate_mixing
from fbcouple.results.reader import NotDrawableError, NotMeantError, open_results
from fbcouple.simulation.tasks.frames import Frames

SIDE, SIZE = 20, 1e-3
SITES = np.stack(np.meshgrid(*[np.arange(SIDE)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * SIZE + 0.5 * SIZE


@pytest.fixture
def make(dataset, write):
    """Results with frames of particles on a cube of sites: the rows of each frame, and further columns."""

    def make_results(rows, columns=lambda numbers: {}, sets=()):
        run = write(dataset)
        cells = np.stack(np.meshgrid(*[np.arange(2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        frames = Frames(MPI.COMM_SELF, BoxCells(Grid((2, 2, 2), (0.02,) * 3), cells), run / "frames", every=0.1)
        for n, (numbers, sites) in enumerate(rows):
            where = SITES[sites]
            particles = {"position": where, "velocity": 0.0 * where, "diameter": np.full(len(sites), SIZE)}
            frames.write(0.1 * n, numbers, particles | columns(numbers), {})
        return open_results(run)

    return make_results


def shuffled(count=SIDE**3):
    return np.random.default_rng(2).permutation(count)


NUMBERS, PLACES = np.arange(1, SIDE**3 + 1), np.arange(SIDE**3)


def test_halves_of_a_bed_that_is_stirred(make):
    results = make([(NUMBERS, PLACES), (NUMBERS, shuffled())])
    found = {each.name: each for each in follow_mixing(results)}
    assert list(found) == [f"{side} half at the start" for side in ("right", "back", "upper")]
    for each in found.values():
        assert each.time.tolist() == [0.0, pytest.approx(0.1)]
        assert each.index[0] < 0.2 and each.index[1] == pytest.approx(1.0, abs=0.02)
        assert each.reached == pytest.approx(0.1)
    assert {row["last"] for row in tabulate_mixing(results)} == {each.index[1] for each in found.values()}
    picture = mixing(results)
    picture.canvas.draw()
    assert len(picture.axes[0].lines) == 4


def test_a_bed_that_moves_as_one_stays_apart(make):
    """Lower and upper half change places, a column of the cube after the other."""
    moved = SITES.copy()
    moved[:, 2] = (moved[:, 2] + 0.5 * SIDE * SIZE) % (SIDE * SIZE)
    there = np.rint((moved - 0.5 * SIZE) / SIZE).astype(int) @ [SIDE**2, SIDE, 1]
    found = follow_mixing(make([(NUMBERS, PLACES), (NUMBERS, there)]))
    assert all(each.index[1] < 0.2 and np.isnan(each.reached) for each in found)


def test_species_and_feeds_and_particles_that_come_and_go(make):
    late = np.concatenate([NUMBERS[SIDE**3 // 2 :], NUMBERS[: SIDE**3 // 2] + SIDE**3])
    rows = [(NUMBERS, PLACES), (late, shuffled())]

    def mark(numbers):
        fed = np.where(numbers > SIDE**3, 1.0, 0.0)
        return {"species": 1 + (numbers % 2), "feed": fed, "entry_time": 0.05 * fed}

    results = make(rows, mark)
    found = {each.name: each for each in follow_mixing(results)}
    assert set(found) == {"species 2", "feed 1", *(f"{side} half at the start" for side in ("right", "back", "upper"))}
    assert np.isnan(found["feed 1"].index[0]) and found["feed 1"].index[1] == pytest.approx(1.0, abs=0.02)
    assert found["species 2"].index[1] == pytest.approx(1.0, abs=0.02)
    assert np.isnan(found["right half at the start"].index[1]), "the left half has gone"


def test_no_frames(dataset, write):
    with pytest.raises(NotMeantError):
        follow_mixing(open_results(write(dataset)))
    dataset["species_centre_z"] = (("time", "species"), np.ones((dataset.sizes["time"], 2)))
    with pytest.raises(NotDrawableError, match=r"output\.particles_every") as caught:
        follow_mixing(open_results(write(dataset)))
    assert not isinstance(caught.value, NotMeantError)
