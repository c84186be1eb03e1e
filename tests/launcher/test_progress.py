"""What a person sees of a run: its rate from where this job took it up."""

import io
import time

from rich.console import Console

from fbcouple.cli.prediction import format_outcome
from fbcouple.launcher.progress import RunProgress

WALL = {"dem": 1.0, "cfd": 1.0}


def test_rate_of_a_resumed_run_counts_from_where_it_goes_on(monkeypatch):
    """100 s of wall time from t = 4.0 to 4.5 s are 200 s a second, whatever earlier jobs took."""
    moments = iter([0.0, 10.0, 110.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(moments))
    screen = io.StringIO()
    progress = RunProgress(Console(file=screen), 20.0)
    for t in (4.0, 4.5):
        progress.show({"time": t, "wall": WALL})
    assert "200 s wall per s" in screen.getvalue()


def test_particles_at_the_outlet_are_told_while_the_run_goes_on_and_at_its_end():
    screen = io.StringIO()
    progress = RunProgress(Console(file=screen, force_terminal=True, width=200), 20.0)
    progress.show({"time": 1.0, "wall": WALL, "particles_at_outlet": 0})
    assert progress.list_warnings() == []
    progress.start()
    with progress:
        for count in (12, 7):
            progress.show({"time": 2.0, "wall": WALL, "particles_at_outlet": count})
    assert "7 at the outlet" in screen.getvalue()
    (warning,) = progress.list_warnings()
    assert warning.startswith("up to 12 particles reached the outlet") and "a wall for particles" in warning


def test_gas_that_comes_back_in_is_told_where_it_is_more_than_a_hundredth():
    progress = RunProgress(Console(file=io.StringIO()), 20.0)
    progress.show({"time": 1.0, "wall": WALL, "gas_backflow": 0.009})
    assert progress.list_warnings() == []
    for part in (0.123, 0.0):
        progress.show({"time": 2.0, "wall": WALL, "gas_backflow": part})
    (warning,) = progress.list_warnings()
    assert warning.startswith("up to 12.3 % of the gas at the outlets came back in by them, with the voidage")
    progress.show({"time": 3.0, "wall": WALL, "gas_backflow": 0.2, "outlet_backflow": [0.02, 0.9, 0.0]})
    (warning,) = progress.list_warnings()
    assert "20 % of the gas at the outlets came back in by them, most of it by outlet 2, with" in warning


def test_a_run_that_ends_by_its_error_shows_it_and_the_time_up_to_then(monkeypatch):
    """At 100 s of wall time a second, 12 s are left up to where the error is expected to be small enough, not 20."""
    moments = iter([0.0, 10.0, 110.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(moments))
    screen = io.StringIO()
    progress = RunProgress(Console(file=screen), 20.0)
    for t in (4.0, 5.0):
        progress.show({"time": t, "wall": WALL, "averages_error": 0.1234, "expected_end": 12.0})
    assert "error 12.3 %" in screen.getvalue() and "left 0:11:40" in screen.getvalue()


def test_a_prediction_is_held_against_the_steps_between_the_rows():
    """Of 200 s for 20 s of a run, 20 s for the 2 s shown: 2 rows after the first, 15 s of DEM and 3 s of gas each."""
    progress = RunProgress(Console(file=io.StringIO()), 20.0)
    assert progress.sum_up() == (0.0, {})
    for t in (4.0, 5.0, 6.0):
        progress.show({"time": t, "wall": {"dem": 15.0, "cfd": 2.0, "map": 0.5, "react": 0.5, "wait": 2.0}})
    seconds, walls = progress.sum_up()
    assert seconds == 2.0 and walls["dem"] == 30.0
    stages = {"start-up": 50.0, "dem": 150.0, "cfd": 40.0, "exchange": 10.0}
    line = format_outcome({"stages": stages, "simulated_seconds": 20.0, "wall_factor": 1.3}, seconds, walls)
    assert line.startswith("predicted 20 s for these 2 s, within a factor of 1.3; took 40 s, 2 of it")
    assert line.endswith("(dem 2, cfd 1, exchange 2)")


def test_a_run_that_finds_its_start_up_tells_when_it_was_over():
    screen = io.StringIO()
    progress = RunProgress(Console(file=screen, force_terminal=True, width=200), 20.0)
    progress.start()
    with progress:
        progress.show({"time": 2.0, "wall": WALL, "averages_start": float("nan")})
        (warning,) = progress.list_warnings()
        assert warning.startswith("the start-up is not seen to be over; the means begin where")
        assert progress.format_begin() == ""
    assert "start-up not over" in screen.getvalue()
    progress.show({"time": 8.0, "wall": WALL, "averages_start": 2.3456})
    assert progress.list_warnings() == []
    assert progress.format_begin() == "; its start-up ended at t = 2.346 s, where its means begin"


def test_a_run_that_is_told_its_start_says_nothing_of_it():
    progress = RunProgress(Console(file=io.StringIO()), 20.0)
    progress.show({"time": 2.0, "wall": WALL})
    assert progress.list_warnings() == [] and progress.format_begin() == ""
