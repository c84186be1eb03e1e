"""`--set end_time=...` before the averages start: they are fitted, and a line says so."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case, write_case
from fbcouple.errors import CaseError


def load(*sets: str):
    said: list[str] = []
    return load_case("patil/c2", sets, said.append), said


def test_averages_start_after_half_of_a_shorter_run(tmp_path):
    case, said = load("end_time=0.1")
    assert (case.averages.start, case.averages.every) == (0.05, 0.002)
    assert said == ["patil/c2/case.toml: averages.start = 0.05: end_time = 0.1 of --set is too early for "
                    "averages.start = 1"]  # fmt: skip
    write_case(case, tmp_path / "case.toml")
    assert "start = 0.05" in (tmp_path / "case.toml").read_text()


def test_averages_of_a_run_that_is_too_short_for_them_are_left_out():
    case, said = load("end_time=0.01")
    assert case.averages is None
    assert len(said) == 1 and "no averages are taken" in said[0] and "10 samples" in said[0]


def test_a_window_without_a_sample_a_block_is_fitted_too():
    case, said = load("end_time=1.01")
    assert case.averages.start == 0.505 and len(said) == 1


@pytest.mark.parametrize("sets", [(), ("end_time=1.02",), ("end_time=30",), ("end_time=0.1", "averages.start=0.02")])
def test_averages_that_fit_stay(sets):
    case, said = load(*sets)
    assert said == [] and case.averages.start in (1.0, 0.02)


@pytest.mark.parametrize(
    "sets", [("end_time=0.1", "averages.start=0.2"), ("end_time=0.01", "averages.blocks=20"), ("end_time=-1",)]
)
def test_what_was_set_itself_is_not_changed(sets):
    with pytest.raises(CaseError):
        load(*sets)


def test_nothing_is_fitted_in_silence():
    with pytest.raises(CaseError, match=r"averages\.start: 1 s is given and the run ends at 0\.1 s"):
        load_case("patil/c2", ["end_time=0.1"])
