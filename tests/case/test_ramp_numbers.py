"""A ramp that goes on after the end of the run is told: what the run meets is less than what it is set up for."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate

NAME = "inflow in the run"


@pytest.mark.parametrize(
    ("ramp", "end", "within"),
    [
        ([[0.0, 0.1], [10.0, 20.1]], 1.0, 2.1),
        ([[0.0, -0.1], [10.0, -20.1]], 1.0, 2.1),
        ([[0.0, 0.1], [1.0, 2.1]], 1.0, None),
        ([[0.0, 2.1], [10.0, 0.1]], 1.0, None),
    ],
)
def test_a_ramp_that_grows_after_the_end_is_told(tmp_path, ramp, end, within):
    text = 'base = "patil/c1"\nunset = ["gas.inlet_velocity", "averages"]\n'
    (tmp_path / "case.toml").write_text(f"{text}end_time = {end}\n[gas]\ninlet_ramp = {ramp}\n")
    case = load_case(str(tmp_path / "case.toml"))
    found = [number for number in estimate(case) if number.name == NAME]
    assert [number.value for number in found] == ([] if within is None else [pytest.approx(within)])
    assert all(number.verdict == "warn" and "20.1" in number.meaning for number in found)
