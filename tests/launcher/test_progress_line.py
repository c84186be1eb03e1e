"""The line of progress: its clocks are whole on a narrow terminal, and lines elsewhere say how long is left."""

import io
import re
import time

import pytest
from rich.console import Console

from fbcouple.launcher.progress import RunProgress, format_clock

WALL = {"dem": 1.0, "cfd": 1.0}
ROW = {"time": 12.5, "wall": WALL, "bed_height": 0.1034, "pressure_drop": 1174.0}


def show_rows(monkeypatch, console):
    """From 2.5 s to 12.5 s of 20 s in 36 000 s of wall time: 7.5 s are left, and 27 000 s of wall time."""
    moments = iter([0.0, 10.0, 36_010.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(moments, 36_010.0))
    progress = RunProgress(console, 20.0)
    progress.start()
    with progress:
        progress.show({"time": 2.5, "wall": WALL})
        progress.show(ROW)


@pytest.mark.parametrize("width", [60, 80, 110, 200])
def test_clocks_are_whole_and_on_one_line(monkeypatch, width):
    screen = io.StringIO()
    show_rows(monkeypatch, Console(file=screen, force_terminal=True, width=width, color_system=None))
    shown = re.sub(r"\x1b\[[0-9?]*[a-zA-Z]", "", screen.getvalue())
    last = next(line for line in re.split(r"[\r\n]+", shown)[::-1] if "12.500" in line)
    assert last.rstrip().endswith("10:00:00 left 7:30:00") and last.startswith("t = 12.500 s of 20")
    assert len(last) <= width and "…" not in last
    assert ("bed 103.4 mm" in last) == (width >= 110) and ("3600 s wall per s" in last) == (width >= 80)


def test_lines_of_a_batch_job_say_how_long_is_left(monkeypatch):
    screen = io.StringIO()
    show_rows(monkeypatch, Console(file=screen, width=80))
    line = "t = 12.500 s of 20, 3600 s wall per s, dp 1174 Pa, bed 103.4 mm, left 7:30:00"
    assert screen.getvalue().splitlines() == [line]


def test_nothing_is_shown_before_the_run_is_under_way():
    screen = io.StringIO()
    with RunProgress(Console(file=screen, force_terminal=True, width=80), 20.0):
        pass
    assert screen.getvalue() == ""


@pytest.mark.parametrize(("seconds", "text"), [(59.6, "0:01:00"), (3661.0, "1:01:01"), (90_061.0, "1 d 1:01:01")])
def test_clock(seconds, text):
    assert format_clock(seconds) == text
