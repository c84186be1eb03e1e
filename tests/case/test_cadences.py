"""Cadences that a run does not keep are told before it."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate

PROBES = (
    'probes = [{name = "tap", quantities = ["pressure"], every = 0.01, start = %s, points = [[0.02, 0.007, 0.05]]}]'
)


def list_rows(case):
    return {row.name: row for row in estimate(case) if row.name.startswith(("averages.", "output."))}


@pytest.mark.parametrize("name", ["patil/c1", "patil/c3", "verma/1.02", "mueller/0.9", "yue/spout"])
def test_shipped_cases_keep_theirs(name):
    assert not list_rows(load_case(name))


@pytest.mark.parametrize(
    ("key", "value", "wanted"),
    [
        ("output.snapshots_every", 1e-4, "at least a fluid step, "),
        ("output.particles_every", 6.5, "at most what is left of the run, 6"),
    ],
)
def test_a_cadence_that_the_run_does_not_keep_is_told(key, value, wanted):
    rows = list_rows(load_case("patil/c2", ["end_time=6.0", "averages.start=2.0", f"{key}={value}"]))
    assert list(rows) == [key] and rows[key].value == value
    assert rows[key].verdict == "warn" and rows[key].limit.startswith(wanted)


@pytest.mark.parametrize(("start", "found"), [(1.0, []), (5.995, ["output.probes.1.every"])])
def test_a_probe_that_begins_too_late(tmp_path, start, found):
    (tmp_path / "case.toml").write_text(f'base = "patil/c2"\nend_time = 6.0\n[output]\n{PROBES % start}\n')
    assert list(list_rows(load_case(str(tmp_path / "case.toml")))) == found
