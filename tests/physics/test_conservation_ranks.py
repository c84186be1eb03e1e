"""Conservation with each voidage method on four ranks; `fbcouple verify` has one and two."""

from __future__ import annotations

from dataclasses import replace

import pytest

from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.verify.registry import load_checks
from fbcouple.verify.suite import run_checks


@pytest.mark.slow
@pytest.mark.parametrize("name", [*VOIDAGE_METHODS, "diffusion"])
def test_nothing_is_lost_on_four_ranks(name):
    rows = list(run_checks([replace(load_checks()[f"conservation-{name}"], ranks=(4,))]))
    assert len(rows) > 3
    missed = [f"{row['name']}: {row['value']:g}, not {row['expected']:g}" for row in rows if not row["passed"]]
    assert not missed, "\n".join(missed)
