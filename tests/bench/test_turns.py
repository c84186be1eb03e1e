"""Turns of measurements end when they agree, and what others take of the machine meanwhile is told."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from fbcouple.bench import turns
from fbcouple.bench.turns import OTHERS, take_turns, warn_of_others, watch_others

BURN = "import time; end = time.process_time() + 0.5\nwhile time.process_time() < end: pass"


@pytest.mark.parametrize(
    ("taken", "most", "cheapest", "used", "spread"),
    [
        ([2.0, 1.0, 1.02, 1.01], 5, 1.0, 3, 0.02),
        ([1.0, 1.5, 1.4, 1.3], 3, 1.0, 3, 0.4),
        ([1.0, 1.0], 5, 1.0, 2, 0.0),
        ([3.0], 1, 3.0, 1, None),
    ],
)
def test_turns_end_when_the_two_cheapest_agree(taken, most, cheapest, used, spread):
    values = iter(taken)
    found = take_turns(lambda: {"a": {"seconds": next(values)}}, lambda row: row["seconds"], most)["a"]
    assert found["seconds"] == cheapest and found["turns"] == used
    assert found["spread"] == (spread if spread is None else pytest.approx(spread))


def test_all_names_have_as_many_turns_as_the_one_that_agrees_last():
    rows = iter([(1.0, 5.0), (1.0, 7.0), (1.0, 5.1)])
    order = []

    def turn():
        order.append("turn")
        return {name: {"seconds": value} for name, value in zip("ab", next(rows), strict=True)}

    found = take_turns(turn, lambda row: row["seconds"], 9)
    assert len(order) == 3 and [row["turns"] for row in found.values()] == [3, 3]
    assert found["b"]["spread"] == pytest.approx(0.02)


def test_the_share_of_others_is_what_is_busy_less_ones_own(monkeypatch):
    busy, own, clock = iter([10.0, 14.0]), iter([1.0, 3.0]), iter([0.0, 2.0])
    monkeypatch.setattr(turns, "_read_busy", lambda: next(busy))
    monkeypatch.setattr(turns, "_read_own", lambda: next(own))
    monkeypatch.setattr(time, "perf_counter", lambda: next(clock))
    row = {}
    with watch_others(row):
        pass
    assert row == {OTHERS: 1.0}


def test_another_process_is_seen_and_a_child_is_ones_own():
    """An orphan is nobody's child, as another user's program is; it stops after 20 s whatever happens."""
    start = "timeout 20 sh -c 'while :; do :; done' > /dev/null 2>&1 & echo $!"
    orphan = int(subprocess.run(["sh", "-c", start], stdout=subprocess.PIPE, check=True).stdout)
    row = {}
    try:
        with watch_others(row):
            time.sleep(1.5)
    finally:
        os.kill(orphan, signal.SIGTERM)
    assert row[OTHERS] > 0.15
    before = turns._read_own()
    subprocess.run([sys.executable, "-c", BURN], check=True)
    assert turns._read_own() - before > 0.45


def test_a_busy_machine_is_told_below_the_table():
    assert warn_of_others([{"seconds": 1.0}, {OTHERS: 0.02}, {OTHERS: None}]) == ""
    told = warn_of_others([{OTHERS: 0.02}, {OTHERS: 1.3}])
    assert told.startswith("up to 1.3 of ") and "measure again when nothing else runs" in told
