"""What is told of a run beside its figures."""

from __future__ import annotations

import numpy as np
import pytest

from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.results.reader import NotDrawableError, open_results
from tests.postproc.whole_run import write_whole


@pytest.mark.parametrize("part", [0.05, 0.8])
def test_a_pattern_that_turns_round_is_told_from_one_that_stands(tmp_path, part):
    """Errors that are a part of the map in every cell are that part of it in the root mean square."""
    results = open_results(write_whole(tmp_path / "run"))
    results.data["solids_flux_stderr"] = part * np.abs(results.data["solids_flux"])
    watched = MONITORS["solids_flux_stderr"](results)
    assert watched.value == pytest.approx(part, rel=1e-6) and "0.3" in watched.wanted


def test_no_pattern_without_blocks(tmp_path):
    results = open_results(write_whole(tmp_path / "run"))
    results.data["solids_flux_stderr"][:] = np.nan
    with pytest.raises(NotDrawableError, match="no blocks"):
        MONITORS["solids_flux_stderr"](results)
