"""[[output.probes]]: what cannot be had is told with its place, what is allowed and how to mend it."""

import numpy as np
import pytest

from fbcouple.case.bed.probes import list_points
from fbcouple.case.load import load_case, write_case
from fbcouple.errors import CaseError

SET = 'name="tap", every=1e-3, quantities=["pressure"]'


def problems_of(*tables, case="patil/c2", sets=()):
    with pytest.raises(CaseError) as caught:
        load_case(case, [f"output.probes=[{', '.join(f'{{{table}}}' for table in tables)}]", *sets])
    return caught.value.problems


def test_probes_come_back_from_a_run_folder(tmp_path):
    sets = f"output.probes=[{{{SET}, points=[[0.0, 0.0, 0.0], [0.08, 0.015, 0.25]]}}]"
    case = load_case("patil/c2", [sets])
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path / "case.toml")).output.probes == case.output.probes


@pytest.mark.parametrize(
    ("table", "told"),
    [
        (
            f"{SET}, points=[[0.04, 0.007, 0.1], [0.1, 0.007, 0.1]]",
            'set 1 ("tap"): point 2 at (0.1, 0.007, 0.1) m is not in the box of x from 0 to 0.08, y from 0 to 0.015, '
            "z from 0 to 0.25 m; give points in the bed, in m.",
        ),
        (f"{SET}, points=[[40.0, 7.0, 100.0]]", "(they look like mm)"),
        (f"{SET}, line=[[0.0, 0.0, 0.0], [0.0, 0.0, 0.5]], count=11", "point 7 at (0, 0, 0.3) m and 4 more are not in"),
        (f"{SET}", "one of points, line, height says where the points are, none of them is given; give one (in m)"),
        (f"{SET}, points=[[0,0,0]], line=[[0,0,0],[0,0,0.1]]", "points, line are given; give one (in m)"),
        (f"{SET}, height=0.1, line=[[0,0,0],[0,0,0.1]], count=3", "line, height are given; give one (in m)"),
        (f"{SET}, height=0.1, count=3", "count is given and no line"),
        (f"{SET}, height=0.3", "point 1 at (0.00114286, 0.00125, 0.3) m and 209 more are not in the box"),
        (f"{SET}, line=[[0,0,0],[0,0,0.1]]", "line is given and no count"),
        (f"{SET}, points=[[0,0,0]], count=4", "count is given and no line"),
        (SET.replace("pressure", "gas_temperature") + ", points=[[0,0,0]]", "the case has no [heat]; remove it or add"),
        (SET.replace("tap", "Tap 1") + ", points=[[0,0,0]]", "a small letter, then small letters, digits and"),
        (f"{SET}, points=[[0,0,0]], start=99.0", "start = 99 s is given and the run ends at"),
        (SET.replace('["pressure"]', '["pressure", "pressure"]') + ", points=[[0,0,0]]", "name each quantity once"),
        (SET.replace("1e-3", "1e-8") + ", points=[[0,0,0]]", "at most 5e+07 are allowed; sample more seldom"),
        (SET.replace('"pressure"', '"presure"') + ", points=[[0,0,0]]", 'each entry "pressure" or "voidage" or'),
        (f"{SET}, point=[[0,0,0]]", "[[output.probes]] has no such key"),
        ('name="tap", points=[[0,0,0]], quantities=["pressure"]', "every: is missing; add `every = ...`"),
    ],
)
def test_sets_that_cannot_be_had(table, told):
    assert told in "\n".join(problems_of(table))


def test_two_sets_of_a_name():
    (problem,) = problems_of(f"{SET}, points=[[0,0,0]]", f"{SET}, points=[[0,0,0]]")
    assert 'set 2 ("tap"): another set has this name' in problem


def test_quantities_need_their_phase(spoil):
    path = spoil()
    text = path.read_text()
    path.write_text(text[: text.index("[gas]")] + text[text.index("[particles]") : text.index("[exchange]")])
    (problem,) = problems_of(f"{SET}, points=[[0,0,0]]", case=str(path))
    assert '"pressure" is given and the case has no [gas]; remove it or add [gas].' in problem


def test_a_section_of_more_points_than_a_set_may_have():
    problems = problems_of(f"{SET}, height=0.1", sets=["domain.cells=[350, 60, 110]"])
    assert "with a point in each of 21000 cells, at most 10000 are allowed; give points." in "\n".join(problems)


def test_a_section_has_the_middles_of_cells_within_the_walls():
    """Of the 8 x 8 cells across a cylinder the corners lie outside, or too near the wall that its mesh has."""
    probe = f"output.probes=[{{{SET}, height=0.1}}]"
    box = load_case("patil/c2", [probe])
    points = list_points(box.output.probes[0], box.domain)
    assert points.shape == (35 * 6, 3) and points[1] - points[0] == pytest.approx([0.08 / 35, 0.0, 0.0])
    size = ["domain.shape=cylinder", "domain.size=[0.08, 0.08, 0.25]", "domain.cells=[8, 8, 25]"]
    column = load_case("mueller/0.9", [probe, *size])
    points = list_points(column.output.probes[0], column.domain)
    from_axis = np.hypot(*(points[:, :2] - 0.04).T)
    assert len(points) == 44 and from_axis.max() <= 0.0375 and set(points[:, 2]) == {0.1}


def test_points_beside_a_cylinder_are_outside_of_its_mesh():
    size = ["domain.shape=cylinder", "domain.size=[0.08, 0.08, 0.25]", "domain.cells=[8, 8, 25]"]
    inside = f"output.probes=[{{{SET}, points=[[0.04, 0.04, 0.0], [0.0401, 0.04, 0.25]]}}]"
    assert load_case("mueller/0.9", [inside, *size]).output.probes
    (problem,) = problems_of(f"{SET}, points=[[0.04, 0.04, 0.1], [0.001, 0.001, 0.1]]", case="mueller/0.9", sets=size)
    assert "point 2 at (0.001, 0.001, 0.1) m is not in a cell of the mesh, which lies in the box of x from 0" in problem
