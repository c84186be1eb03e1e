"""Bubbles of known size that rise at a known speed."""

import numpy as np
import pytest
import xarray as xr

from fbcouple.postproc.figures.bubbles import find_bubbles, find_bubbling, follow, part_tracks, summarise_bubbles
from fbcouple.results.reader import NotDrawableError, open_results

WIDTH, HEIGHT, BED = 0.08, 0.25, 0.15
SPACING = (HEIGHT / 110, WIDTH / 35)


def snapshot(circles, cells=(110, 35)):
    """Voidage 0.45 below z = 0.15 m, 1 above it and in circles (x, z, diameter); cells on an edge get their share."""
    fine = 8
    z = (np.arange(cells[0] * fine) + 0.5) * HEIGHT / cells[0] / fine
    x = (np.arange(cells[1] * fine) + 0.5) * WIDTH / cells[1] / fine
    gas = (z > BED)[:, None] | np.zeros(len(x), dtype=bool)
    for across, above, diameter in circles:
        gas |= (x - across) ** 2 + (z[:, None] - above) ** 2 < 0.25 * diameter**2
    share = gas.reshape(cells[0], fine, cells[1], fine).mean(axis=(1, 3))
    return 0.45 + 0.55 * share


def bubbles_of(field, smallest=5e-3):
    return find_bubbles(field, SPACING, smallest)[0]


def test_size_and_place_of_bubbles():
    """Cells of 2.3 mm: diameters within 5 %, places within a tenth of a cell."""
    circles = [(0.02, 0.05, 0.020), (0.055, 0.08, 0.030), (0.03, 0.12, 0.014)]
    found = sorted(bubbles_of(snapshot(circles)), key=lambda bubble: bubble.z)
    assert [bubble.diameter for bubble in found] == pytest.approx([0.020, 0.030, 0.014], rel=0.05)
    assert [bubble.x for bubble in found] == pytest.approx([0.02, 0.055, 0.03], abs=2e-4)
    assert [bubble.z for bubble in found] == pytest.approx([0.05, 0.08, 0.12], abs=2e-4)


def test_freeboard_and_what_is_open_to_it_are_no_bubbles():
    assert bubbles_of(snapshot([(0.04, BED, 0.03)])) == []
    assert bubbles_of(np.ones((110, 35))) == []


def test_voids_below_the_smallest_size_are_left_out():
    circles = [(0.02, 0.05, 0.010), (0.055, 0.08, 0.030)]
    assert len(bubbles_of(snapshot(circles))) == 2
    assert len(bubbles_of(snapshot(circles), 15e-3)) == 1


def test_what_has_not_left_the_floor_is_counted_apart():
    """One void on the floor layer, one above it, and a layer of cells that is thin of particles all along the floor."""
    field = snapshot([(0.02, 0.0, 0.03), (0.055, 0.08, 0.030)])
    found, at_floor = find_bubbles(field, SPACING, 5e-3)
    assert [bubble.z for bubble in found] == pytest.approx([0.08], abs=2e-4) and at_floor == 1
    field[0] = 0.8
    found, at_floor = find_bubbles(field, SPACING, 5e-3)
    assert [bubble.z for bubble in found] == pytest.approx([0.08], abs=2e-4) and at_floor == 1
    assert find_bubbles(np.ones((110, 35)), SPACING, 5e-3) == ([], 0), "freeboard down to the floor"


def test_a_void_that_stands_still_is_no_bubble_that_rises():
    """A lone bubble of 20 mm rises at 0.31 m/s; one of the two voids is fixed in a corner."""
    times = 0.01 * np.arange(20)
    found = [bubbles_of(snapshot([(0.02, 0.04 + 0.30 * t, 0.02), (0.06, 0.03 + 0.01 * t, 0.02)])) for t in times]
    rising, standing = part_tracks(follow(times, found), 9.81)
    assert [track.rise for track in rising] == pytest.approx([0.30], rel=0.02)
    assert [track.rise for track in standing] == pytest.approx([0.01], abs=5e-3)


def test_two_bubbles_are_followed_at_their_own_speeds():
    """0.30 m/s up, and 0.18 m/s up with 0.05 m/s across, seen every 10 ms: speeds within 2 %."""
    times = 0.01 * np.arange(20)
    found = [
        bubbles_of(snapshot([(0.02, 0.04 + 0.30 * t, 0.02), (0.05 + 0.05 * t, 0.05 + 0.18 * t, 0.024)])) for t in times
    ]
    tracks = sorted(follow(times, found), key=lambda track: track.rise)
    assert [len(track.times) for track in tracks] == [20, 20]
    assert [track.rise for track in tracks] == pytest.approx([0.18, 0.30], rel=0.02)
    assert [track.diameter for track in tracks] == pytest.approx([0.024, 0.02], rel=0.05)


def test_a_merger_ends_both_tracks():
    """Two that become one of twice the area and more: 5 snapshots of each, then 5 of a third."""
    times = 0.01 * np.arange(10)
    apart = [snapshot([(0.025, 0.05 + 0.2 * t, 0.02), (0.055, 0.05 + 0.2 * t, 0.02)]) for t in times[:5]]
    joined = [snapshot([(0.04, 0.05 + 0.2 * t, 0.036)]) for t in times[5:]]
    found = [bubbles_of(field) for field in apart + joined]
    tracks = follow(times, found)
    assert [len(track.times) for track in tracks] == [5, 5, 5]
    assert [track.rise for track in tracks] == pytest.approx([0.2, 0.2, 0.2], rel=0.05)


def test_a_bubble_that_bursts_through_the_bed_is_followed_up_to_there():
    times = 0.01 * np.arange(30)
    found = [bubbles_of(snapshot([(0.04, 0.05 + 0.5 * t, 0.02)])) for t in times]
    (track,) = follow(times, found)
    assert track.bubbles[-1].z + 0.01 < BED and track.rise == pytest.approx(0.5, rel=0.02)


def with_snapshots(dataset, every=0.01, speed=0.25):
    """Steady histories of 2 s and a bubble of 20 mm a third of a second apart."""
    time = 0.01 * np.arange(201)
    rng = np.random.default_rng(1)
    shots = np.arange(0.0, 2.0, every)
    fields = [snapshot([(0.04, 0.02 + speed * (t % (1 / 3)), 0.02)], (55, 17)).astype(np.float32) for t in shots]
    lean = dataset.drop_vars([*(name for name in dataset if "time" in dataset[name].dims), "time", "x", "z"])
    lean = lean.drop_vars([name for name in lean if "x" in lean[name].dims])
    return lean.assign_coords(
        time=time, snapshot_time=shots, x=(np.arange(17) + 0.5) * WIDTH / 17, z=(np.arange(55) + 0.5) * HEIGHT / 55
    ).assign(
        bed_height=("time", 0.06 + 1e-3 * rng.standard_normal(201)),
        voidage_snapshots=(("snapshot_time", "z", "x"), fields),
    )


def test_bubbles_of_a_run_on_the_coarse_mesh(dataset, write):
    """Cells of 4.6 mm, 0.25 m/s: the mean rise within 5 %, the diameter within 10 %."""
    found = find_bubbling(open_results(write(with_snapshots(dataset))))
    assert all(len(bubbles) == 1 for bubbles in found.found)
    assert len(found.tracks) >= 5
    assert np.mean([track.rise for track in found.tracks]) == pytest.approx(0.25, rel=0.05)
    assert np.mean([track.diameter for track in found.tracks]) == pytest.approx(0.02, rel=0.1)


def test_voids_left_out_of_the_numbers_are_told_beside_them(dataset, write):
    """A corner without particles from 10 to 30 mm, and a void on the floor in every snapshot."""
    data = with_snapshots(dataset)
    data["voidage_snapshots"][:, 0:3, 8:11] = 0.9
    data["voidage_snapshots"][:, 8:14, 0:3] = 0.9
    numbers = summarise_bubbles(find_bubbling(open_results(write(data))))
    assert (
        numbers["voids at the floor at a time, left out"] == 1.0 and numbers["tracks that stand still, left out"] >= 1
    )
    assert numbers["rise velocity"] == pytest.approx(0.25, rel=0.1)


def test_without_snapshots_it_is_said_how_to_get_them(run):
    with pytest.raises(NotDrawableError, match=r"output\.snapshots_every"):
        find_bubbling(open_results(run))


def test_snapshots_of_the_start_up_alone_are_too_few(dataset, write):
    data: xr.Dataset = with_snapshots(dataset)
    data["bed_height"][:80] += 0.1
    with pytest.raises(NotDrawableError, match="0 snapshots after the start-up"):
        find_bubbling(open_results(write(data.sel(snapshot_time=slice(0.0, 0.5)))))
