"""Particles that came and went, in a figure and in the report's table."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.postproc.figures.throughput import find_residence, throughput
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.results.reader import NotMeantError, open_results


@pytest.fixture
def open_traffic(dataset, write):
    """Results of `exits` particles that left, every fourth of the start, the others after 0.5 to 1.5 s."""

    def make(exits: int):
        rows = dataset.sizes["time"]
        fed = np.arange(rows) * 10.0
        dataset["particles"] = ("time", 1000.0 + fed - fed // 2)
        for name, values in (("fed", fed), ("removed", fed // 2), ("owed", np.full(rows, 4.0))):
            dataset[f"particles_{name}"] = ("time", values)
        for name in ("fed", "removed"):
            dataset[f"mass_{name}"] = ("time", 1e-6 * dataset[f"particles_{name}"].values)
        dataset["ledger_error"] = ("time", np.full(rows, 2e-15))
        time = np.linspace(2.0, 3.0, exits)
        dataset["exit_time"] = ("exit", time)
        dataset["exit_feed"] = ("exit", (np.arange(exits) % 4).astype(float))
        dataset["exit_entry_time"] = ("exit", np.where(np.arange(exits) % 4, time - np.linspace(0.5, 1.5, exits), 0.0))
        return open_results(write(dataset))

    return make


def test_residence_is_of_those_that_a_feed_brought(open_traffic):
    times = find_residence(open_traffic(101))
    assert len(times) == 75 and times.min() > 0.5 and times.max() < 1.5
    assert times.mean() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(("exits", "panels"), [(101, 2), (8, 1), (0, 1)])
def test_figure(open_traffic, exits, panels):
    picture = throughput(open_traffic(exits))
    picture.canvas.draw()
    assert len(picture.axes) == panels and len(picture.axes[0].lines) == 3


@pytest.mark.parametrize(("ratio", "what"), [(None, "75 particles"), (2.0, "75 parcels")])
def test_what_left_is_counted_as_what_it_is(open_traffic, ratio, what):
    results = open_traffic(101)
    results.case["particles"]["coarse_graining"] = ratio
    assert any(f"{what} that feeds brought have left" in text.get_text() for text in throughput(results).texts)


def test_no_figure_where_nothing_comes_or_goes(dataset, write):
    with pytest.raises(NotMeantError):
        throughput(open_results(write(dataset)))


def test_table_counts_what_came_and_went(open_traffic):
    results = open_traffic(8)
    found = {name: MONITORS[name](results).value for name in ("particles", "ledger_error", "particles_owed")}
    assert found == {"particles": 0.0, "ledger_error": 2e-15, "particles_owed": 4.0}
