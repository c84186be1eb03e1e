"""Gas that comes back in by outlets, of each of several, in the report's table."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.results.reader import open_results


def test_the_worst_outlet_is_named_and_all_are_told(dataset, write):
    parts = np.zeros((dataset.sizes["time"], 3))
    parts[0] = [0.01, 0.4, 0.2]
    parts[-1] = [0.02, 0.1, 0.3]
    dataset["outlet_backflow"] = (("time", "outlet"), parts)
    found = MONITORS["outlet_backflow"](open_results(write(dataset)))
    assert found.value == pytest.approx(0.4) and "outlet 2" in found.monitor and "0.02, 0.4, 0.3" in found.wanted
