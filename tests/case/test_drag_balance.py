"""Velocities at which drag carries a weight, of laws that never do, too."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fbcouple.case.bed.drag_balance import (
    find_balance,
    find_drag,
    minimum_fluidization,
    tabulate_onset,
    terminal_velocity,
)
from fbcouple.case.bed.particle_types import Kind, list_kinds
from fbcouple.case.bed.slips import SLIP
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.case.user_laws import DRAG_LAWS
from fbcouple.errors import CaseError

CASE = """
title = "balance"
end_time = 0.01
[domain]
size = [0.2, 0.2, 0.8]
cells = [5, 5, 16]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.5
[particles]
diameter = 1e-3
density = 1000.0
count = 300
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
drag = "tang"
"""


def write(folder, *changes):
    text = CASE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "case.toml").write_text(text)
    return load_case(str(folder / "case.toml"))


def test_a_law_that_never_carries_a_particle_is_told(tmp_path):
    """The drag of `tang` on a lone sphere is 7.554 mN in air at most: one of 10 mm weighs 12.8 mN."""
    case = write(tmp_path, ("diameter = 1e-3\ndensity = 1000.0", "diameter = 1e-2\ndensity = 2500.0"))
    with pytest.raises(CaseError) as caught:
        terminal_velocity(case)
    words = (
        "exchange.drag: `tang` never carries a particle of 0.01 m and 2500 kg/m3: at voidage 1 its drag is 0.007554 N"
    )
    assert str(caught.value).startswith(words)
    assert "at a slip of 83.8 m/s (Re 5.59e+04), at least 0.01284 N is needed; take another law" in str(caught.value)
    with pytest.raises(CaseError, match="`tang` never carries"):
        estimate(case)


def test_a_balance_next_to_the_largest_drag_is_found(tmp_path):
    """Just below the weight that a law carries, between two slips of the search, and just above it."""
    case = write(tmp_path, ("diameter = 1e-3\ndensity = 1000.0", "diameter = 8e-3\ndensity = 2500.0"))
    slips = np.linspace(50.0, 150.0, 100_001)
    most = float((DRAG_LAWS["tang"](1.0, slips, 8e-3, 1.2, 1.8e-5) * slips).max())
    volume = math.pi / 6 * 8e-3**3
    for factor, carried in ((0.9999, True), (1.0001, False)):
        kind = Kind(8e-3, 1.2 + factor * most / (volume * 9.81), 1, 1.0)
        if carried:
            slip = find_balance(case, 1.0, None, kind)
            assert find_drag(case, 1.0, slip, None, kind) * slip == pytest.approx(factor * most, rel=1e-12)
        else:
            with pytest.raises(CaseError, match="never carries"):
                find_balance(case, 1.0, None, kind)


@pytest.mark.parametrize(
    ("name", "law", "carries"),
    [
        ("saturates", lambda eps, slip, d, rho, mu: 1e-9 / (1.0 + slip), False),
        ("ends", lambda eps, slip, d, rho, mu: 1e-9 if slip < 1e3 else math.nan, False),
        ("drops", lambda eps, slip, d, rho, mu: (2e-9 if slip < 3e2 else 1e-9) * slip, True),
        ("creeps", lambda eps, slip, d, rho, mu: 1e-14, True),
    ],
)
def test_any_law_comes_to_an_end(tmp_path, name, law, carries):
    """One that levels off, one that ends, one with a drag crisis on the way, and one that reaches the weight only far
    beyond any Reynolds number of a law."""
    case, (kind,) = (case := write(tmp_path)), list_kinds(case.particles)
    weight = kind.volume * (1000.0 - 1.2) * 9.81
    if carries:
        slip = find_balance(case, 1.0, law, kind)
        assert law(1.0, slip, 1e-3, 1.2, 1.8e-5) * slip == pytest.approx(weight, rel=1e-9), name
    else:
        with pytest.raises(CaseError, match="never carries"):
            find_balance(case, 1.0, law, kind)


def test_onsets_are_told_where_the_law_has_one(tmp_path):
    """`tang` carries no bed of large spheres at 0.30, below what it was made for: a table that a run writes."""
    ramp = ("inlet_velocity = 0.5", "inlet_ramp = [[0.0, 0.0], [0.01, 0.5]]")
    case = write(tmp_path, ("diameter = 1e-3\ndensity = 1000.0", "diameter = 15e-3\ndensity = 2500.0"), ramp)
    rows = tabulate_onset(case)
    assert 0 < len(rows) < 31 and rows[0, 0] > 0.30 and rows[-1, 0] == pytest.approx(0.60)
    assert rows[-1, 1] == pytest.approx(minimum_fluidization(case, 0.60), rel=1e-12)


@pytest.mark.parametrize(
    ("drag", "changes", "reynolds", "verdict"),
    [
        ("tang", [], 0.5e-3 / 1.5e-5, "fit"),
        ("tang", [("inlet_velocity = 0.5", "inlet_velocity = 16.0")], 16e-3 / 1.5e-5, "warn"),
        ("tenneti", [("inlet_velocity = 0.5", "inlet_velocity = 16.0")], 16e-3 / 1.5e-5, "warn"),
        ("beetstra", [("count = 300", "count = 300\nmixture = [[5e-3, 2500.0, 0.5]]")], None, "warn"),
        ("huilin-gidaspow", [("inlet_velocity = 0.5", "inlet_velocity = 16.0")], None, None),
    ],
)
def test_the_fastest_slip_is_held_against_the_range_of_the_law(tmp_path, drag, changes, reynolds, verdict):
    case = write(tmp_path, ('drag = "tang"', f'drag = "{drag}"'), *changes)
    numbers = {number.name: number for number in estimate(case)}
    if verdict is None:
        assert SLIP not in numbers
        return
    if reynolds is None:  # a large sphere that falls
        kind = list_kinds(case.particles)[1]
        fall = math.sqrt(2.0 * 9.81 * (1.0 - 1.2 / 2500.0) * 0.8)
        assert find_balance(case, 1.0, None, kind) > fall
        reynolds = fall * kind.diameter / 1.5e-5
        assert "by a fall" in numbers[SLIP].meaning
    reynolds = max(reynolds, terminal_velocity(case) * 1e-3 / 1.5e-5)
    assert numbers[SLIP].value == pytest.approx(reynolds, rel=1e-9) and numbers[SLIP].verdict == verdict
    assert numbers[SLIP].limit == f"up to {DRAG_LAWS[drag].most:g} (exchange.drag)"
