"""The errors that plans are made from are those of the studies, number by number."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import pytest

from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.load import load_case
from fbcouple.case.plan.measured_errors import (
    FACTOR,
    FINEST_MESH,
    MEASURED,
    MESH,
    NUMERICS,
    PACKING,
    RANGES,
    Measured,
    interpolate,
    list_errors,
    list_meshes,
    list_overlaps,
    list_ratios,
)
from fbcouple.case.source import read_toml
from fbcouple.errors import CaseError

ROOT = Path(__file__).resolve().parents[2]
STUDIES = ROOT / "docs/results/studies"


def read_member(row: Measured) -> float:
    """The error of a row in the table of its study."""
    if row.study == "fluid-step":
        text = (STUDIES / "README.md").read_text().split("### What the fluid step costs before chaos does")[1]
        lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("|")]
        table = {line[0]: line for line in lines}
        head = next(line for line in lines if line[0] == "member")
        return float(table[row.member][head.index("of flux")])
    with (STUDIES / row.study / "members.csv").open() as file:
        found = [r for r in csv.DictReader(file) if r["member"] == row.member and r["measure"] == row.measure]
    assert len(found) == 1 and found[0]["how"] == "complete"
    if row.knob == PACKING:
        return abs(float(found[0]["value"]) / float(found[0]["expected"]) - 1.0)
    return float(found[0]["error"])


@pytest.mark.parametrize("row", MEASURED, ids=lambda row: f"{row.study}-{row.member}".replace(" ", ""))
def test_a_number_is_that_of_its_study(row):
    assert row.error == pytest.approx(read_member(row), abs=5.1e-5)


def test_a_member_has_the_overlap_that_it_stands_for():
    for row in MEASURED:
        if row.member.startswith("max_overlap-"):
            assert float(row.member.removeprefix("max_overlap-")) == float(row.value)


def test_fluid_steps_are_named_with_their_courant_number():
    for row in MEASURED:
        if row.knob == NUMERICS and (courant := re.search(r"Courant ([\d.]+)$", row.value)):
            assert re.search(rf"(^|-){float(courant[1]):g}(\.0)?(,|$)", row.member)


def test_beds_lie_as_far_apart_as_is_told():
    found = [list_errors(NUMERICS, bed)["standard"] for bed in ("patil/c2", "mueller/0.9")]
    assert found[1] / found[0] == pytest.approx(FACTOR, abs=0.1)
    assert list_errors(NUMERICS)["standard"] == found[1]


def test_the_range_of_a_map_is_told_beside_its_study():
    text = " ".join((STUDIES / "README.md").read_text().split())
    found = re.search(r"that of `patil/c2` above, whose map has a range of ([\d.]+) times", text)
    assert float(found[1]) == RANGES["patil/c2"]
    found = re.search(r"the map of `mueller/0.9`, which has a range of ([\d.]+) times its root mean square", text)
    assert float(found[1]) == RANGES["mueller/0.9"]


def test_meshes_have_the_cells_of_the_study():
    study = read_toml(ROOT / "cases/studies/presets-lifted/study.toml", "study")
    meshes = [load_case("mueller/0.9").domain.cells, *map(tuple, reversed(study["knobs"]["domain"]["cells"]))]
    case = load_case("mueller/0.9")
    sizes = [
        (math.prod(case.domain.size) / math.prod(cells)) ** (1 / 3) / largest_diameter(case.particles)
        for cells in meshes
    ]
    assert sizes == pytest.approx([FINEST_MESH, *(float(value) for value in list_errors(MESH))], abs=0.005)


@pytest.mark.parametrize("list_sizes", [list_meshes, list_ratios])
def test_coarser_meshes_and_larger_parcels_are_never_told_to_be_nearer(list_sizes):
    errors = list(list_sizes().values())
    assert errors == sorted(errors) and errors[0] == 0.0 < errors[1]


def test_soft_contacts_add_to_a_lifted_bed_what_they_add_there_and_shake_a_resting_one_down():
    moving, resting = list_overlaps(rests=False), list_overlaps(rests=True)
    assert moving[0.02] == moving[0.05] == 0.0
    whole = list_errors(NUMERICS, "patil/c2")["standard"]
    assert math.hypot(whole, moving[0.1]) == pytest.approx(whole * 47 / 43)
    assert resting[0.05] == list_errors(PACKING)["0.05"] > 2.0 * moving[0.1]


def test_between_measured_values_errors_go_by_the_logarithm_and_beyond_them_nothing_is_known():
    known = {0.1: 1.0, 0.4: 3.0}
    assert [interpolate("k", known, value) for value in (0.1, 0.2, 0.4)] == pytest.approx([1.0, 2.0, 3.0])
    for value in (0.09, 0.41):
        with pytest.raises(CaseError, match=r"^k: .* is given, and errors were measured from 0\.1 to 0\.4; "):
            interpolate("k", known, value)
