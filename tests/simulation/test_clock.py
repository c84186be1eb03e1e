"""Steps from Courant and Fourier limits, whole DEM steps without drift, and what is due when."""

import math

import pytest

from fbcouple.simulation.clock import Cadence, Clock

DEM = 1.34e-5


def take(clock, steps, courant=0.0):
    for _ in range(steps):
        clock.tick()
        clock.choose(courant, 0.0, 0.2, 0.15)


def test_without_particles_the_first_step_is_the_one_given():
    clock = Clock(end=1.0, dem_step=None, first_step=2e-3)
    assert clock.dt == 2e-3 and clock.time == 0.0 and clock.steps == 0 and clock.running


@pytest.mark.parametrize(
    ("courant", "fourier", "factor"),
    [(0.4, 0.0, 0.5), (0.0, 0.3, 0.5), (0.4, 0.6, 0.25), (0.19, 0.1, 0.2 / 0.19), (0.01, 0.01, 1.2), (0.0, 0.0, 1.2)],
)
def test_the_sharper_limit_chooses_and_growth_is_a_fifth_at_most(courant, fourier, factor):
    clock = Clock(end=1.0, dem_step=None, first_step=2e-3)
    clock.tick()
    clock.choose(courant, fourier, 0.2, 0.15)
    assert clock.dt == pytest.approx(2e-3 * factor, rel=1e-14)


@pytest.mark.parametrize("dem_step", [None, DEM])
def test_a_clock_that_goes_on_with_a_shorter_longest_step_keeps_to_it(dem_step):
    before = Clock(end=1.0, dem_step=dem_step, first_step=DEM, longest=10.4 * DEM)
    take(before, 100)
    same, shorter = (Clock(end=1.0, dem_step=dem_step, first_step=DEM, longest=n * DEM) for n in (10.4, 3.5))
    for clock in (same, shorter):
        clock.load(before.save())
    assert (same.dt, same.substeps) == (before.dt, before.substeps)
    assert shorter.dt == pytest.approx((3.5 if dem_step is None else 3.0) * DEM, rel=1e-12)


@pytest.mark.parametrize("dem_step", [None, DEM])
def test_no_step_is_longer_than_the_longest(dem_step):
    clock = Clock(end=1.0, dem_step=dem_step, first_step=DEM, longest=10.4 * DEM)
    take(clock, 100)
    assert clock.dt == pytest.approx((10.4 if dem_step is None else 10.0) * DEM, rel=1e-12)


def take_all(clock):
    sizes = []
    while clock.running:
        sizes.append(clock.substeps or clock.dt)
        take(clock, 1, courant=0.2)
    return sizes


def test_without_particles_the_time_left_is_shared_out_among_the_last_steps():
    clock = Clock(end=0.01, dem_step=None, first_step=3e-3)
    assert take_all(clock) == pytest.approx([2.5e-3] * 4) and clock.time == pytest.approx(0.01, rel=1e-14)


@pytest.mark.parametrize("over", [1, 2, 9, 18])
def test_with_particles_no_stub_is_left_for_the_end(over):
    clock = Clock(end=(20 * 19 + over) * DEM, dem_step=DEM, first_step=19 * DEM)
    sizes = take_all(clock)
    assert sum(sizes) == 20 * 19 + over and len(sizes) == 21
    assert max(sizes) == 19 and min(sizes) >= 17


def test_the_step_stands_at_the_end_for_a_run_that_is_made_longer():
    clock = Clock(end=40 * DEM, dem_step=DEM, first_step=8 * DEM)
    take_all(clock)
    longer = Clock(end=80 * DEM, dem_step=DEM, first_step=DEM)
    longer.load(clock.save())
    assert (longer.substeps, longer.last_dt) == (8, 8 * DEM)


def test_the_length_of_the_last_step_is_known():
    clock = Clock(end=1.0, dem_step=DEM, first_step=3 * DEM)
    assert clock.last_dt == 0.0
    taken = clock.dt
    take(clock, 1)
    assert clock.last_dt == taken and clock.dt != taken


def test_a_step_is_whole_dem_steps_and_never_longer_than_the_limit():
    clock = Clock(end=1.0, dem_step=DEM, first_step=10.4 * DEM)
    take(clock, 30)
    for courant in (0.21, 0.37, 0.19, 0.55):
        before = clock.dt
        clock.tick()
        clock.choose(courant, 0.0, 0.2, 0.15)
        assert clock.dt == clock.substeps * DEM
        assert clock.dt <= before * 0.2 / courant * (1 + 1e-12) < clock.dt + DEM


def test_few_sub_steps_grow_by_one_and_many_by_a_fifth():
    clock = Clock(end=100.0, dem_step=DEM, first_step=DEM)
    sizes = []
    for _ in range(14):
        sizes.append(clock.substeps)
        take(clock, 1)
    assert sizes == [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 19]


@pytest.mark.parametrize("limit", [0.9, 0.01, 0.0])
def test_a_limit_below_one_dem_step_gets_one(limit):
    assert Clock(end=1.0, dem_step=DEM, first_step=limit * DEM).substeps == 1
    clock = Clock(end=1.0, dem_step=DEM, first_step=DEM)
    clock.tick()
    clock.choose(0.2 / max(limit, 1e-9), 0.0, 0.2, 0.15)
    assert (clock.substeps, clock.dt) == (1, DEM)


def test_time_is_a_multiple_of_the_dem_step_without_drift():
    clock = Clock(end=20.0, dem_step=DEM, first_step=DEM)
    done = 0
    for n in range(100_000):
        done += clock.substeps
        take(clock, 1, courant=0.15 + 0.1 * (n % 3 == 0))
    assert clock.steps == 100_000 and clock.time == done * DEM


@pytest.mark.parametrize("end", [1e-3, 75 * DEM, 75 * DEM * (1 + 1e-13), 0.5 * DEM])
def test_with_particles_the_run_ends_at_the_first_dem_step_at_or_after_the_end(end):
    clock = Clock(end=end, dem_step=DEM, first_step=4 * DEM)
    while clock.running:
        take(clock, 1)
    assert round(clock.time / DEM) == math.ceil(end / DEM * (1 - 1e-9))


def test_due_at_the_start_and_once_a_multiple():
    cadence = Cadence(every=0.01)
    assert [cadence.due(time) for time in (0.0, 0.004, 0.0101, 0.0199, 0.021, 0.055, 0.059, 0.06)] == [
        True,
        False,
        True,
        False,
        True,
        True,
        False,
        True,
    ]


def test_due_counts_a_multiple_that_rounding_puts_just_before():
    """0.1 + 0.1 + ... is 0.7999999999999999 at the eighth step: that is 0.8, and due once."""
    cadence, time, due = Cadence(every=0.1), 0.0, 0
    for _ in range(101):
        due += cadence.due(time)
        time += 0.1
    assert due == 101


def test_nothing_is_due_before_the_start():
    cadence = Cadence(every=2e-3, start=1.0)
    assert [cadence.due(time) for time in (0.0, 0.5, 0.9999, 1.0005, 1.0015, 1.0021)] == [
        False,
        False,
        False,
        True,
        False,
        True,
    ]


def test_a_start_between_multiples_is_due_itself():
    cadence = Cadence(every=0.3, start=1.0)
    assert [cadence.due(time) for time in (0.95, 1.0, 1.15, 1.2, 1.4, 1.5)] == [False, True, False, True, False, True]
