"""Blocks of the solids: written and read again, joined, taken apart, mirrored, and made into means."""

import numpy as np
import pytest
import xarray as xr

from fbcouple.results.block_means import (
    BLOCKS,
    REPLICA,
    SAMPLES,
    START,
    has_blocks,
    join_blocks,
    lay_out_blocks,
    mirror,
    pack_blocks,
    pair_blocks,
    take_blocks,
    unpack_means,
)


def make(blocks=5, first=0.0, seed=3):
    rows = np.random.default_rng(seed).random((blocks, 6, 4, 3)).astype(np.float32)
    coords = {"component": ["x", "y", "z"], "x": [0.1, 0.2, 0.3], "z": [1.0, 2.0, 3.0, 4.0]}
    return rows, xr.Dataset(lay_out_blocks(first + np.arange(blocks), [8] * blocks, rows), coords)


def test_rows_come_back():
    rows, data = make()
    assert has_blocks(data) and np.array_equal(pack_blocks(data), rows)
    assert not has_blocks(data.drop_vars("block_solids_energy"))
    assert all(data[name].attrs["units"] == unit for name, (unit, _) in BLOCKS.items())


def test_blocks_of_replicas_are_joined_and_taken_apart():
    (rows, one), (more, other) = make(), make(3, 1.0, 4)
    joined = one.drop_dims("block").assign(join_blocks([one, other]))
    assert list(joined[REPLICA].values) == [1] * 5 + [2] * 3
    for number, wanted in ((1, rows), (2, more)):
        taken = take_blocks(joined, number)
        assert np.array_equal(pack_blocks(taken), wanted) and REPLICA not in taken
    assert take_blocks(one, 1) is one
    assert join_blocks([one, other.drop_dims("block")]) == {}


def test_pairs_keep_the_mean_and_the_samples():
    rows, data = make(11)
    data[SAMPLES].values[-1] = 3
    paired = pair_blocks(data, 3)
    assert list(paired[SAMPLES].values) == [32, 32, 19] and list(paired[START].values) == [0.0, 4.0, 8.0]
    mean = np.average(pack_blocks(paired), axis=0, weights=paired[SAMPLES].values)
    assert mean == pytest.approx(np.average(rows, axis=0, weights=data[SAMPLES].values), rel=1e-5)
    assert pair_blocks(data, 11) is data


def test_a_mirror_turns_round_x_and_the_flux_along_it():
    rows, _ = make()
    turned = mirror(rows)
    assert np.array_equal(turned[:, 2], -rows[:, 2, :, ::-1])
    assert np.array_equal(turned[:, [0, 1, 3, 4, 5]], rows[:, [0, 1, 3, 4, 5]][..., ::-1])
    assert np.array_equal(mirror(turned), rows)


def test_means_of_a_row():
    """Two particles a place, of mass 1 and 3 and velocities 2 and -1 along z: their mean is -0.25, their agitation
    7/4 - 1/16."""
    row = np.zeros((6, 1, 2))
    row[:, 0, 0] = 0.3, 4.0, 0.0, 0.0, 2.0 - 3.0, 4.0 + 3.0
    means = unpack_means(row, {"x": [0.0, 1.0], "y": [0.5], "z": [0.0], "component": ["x", "y", "z"]})
    assert means["solids_velocity"].sel(component="z").values[0, 0, 0] == -0.25
    assert means["agitation"].values[0, 0] == pytest.approx([7.0 / 4.0 - 1.0 / 16.0, 0.0])
