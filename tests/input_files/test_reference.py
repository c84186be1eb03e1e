"""References: the text that names one, and the CSV file behind it."""

import pytest

from fbcouple.errors import CaseError
from fbcouple.input_files.measured_lines import QUANTITIES, Reference, parse_reference, read_line, read_points
from fbcouple.results.variables import MEANS


def test_a_reference_is_quantity_height_and_file():
    assert parse_reference("solids_velocity@0.025=uy2.csv") == Reference("solids_velocity", 0.025, "uy2.csv")
    assert parse_reference(" voidage @ 16.4e-3 = a=b.csv ") == Reference("voidage", 0.0164, "a=b.csv")


def test_a_reference_may_be_of_a_part_of_the_depth():
    front = parse_reference("solids_velocity@0.025, 0:5e-3=uy2.csv")
    assert front == Reference("solids_velocity", 0.025, "uy2.csv", (0.0, 0.005))
    assert str(front) == "solids_velocity@0.025,0:0.005=uy2.csv" and parse_reference(str(front)) == front


def test_a_reference_may_be_over_the_radius(tmp_path):
    ring = parse_reference("solids_fraction@0.1, r=ring.csv")
    assert ring == Reference("solids_fraction", 0.1, "ring.csv", is_radial=True)
    assert str(ring) == "solids_fraction@0.1,r=ring.csv" and parse_reference(str(ring)) == ring
    path = tmp_path / "line.csv"
    path.write_text("r [mm],value\n0,0.1\n19,0.3\n")
    assert read_line(ring, path, (0.05, 0.04, 0.2), (-0.025, -0.02, 0.0)).x.tolist() == [0.0, 0.019]
    with pytest.raises(CaseError, match=r"r from 0 to 0.019 m, 0 to 0.015 m is allowed"):
        read_line(ring, path, (0.05, 0.03, 0.2))


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_every_quantity_is_a_mean_of_results_in_its_unit(quantity):
    assert MEANS[quantity][0] == QUANTITIES[quantity]
    reference = Reference(quantity, 0.02, "a.csv")
    assert parse_reference(str(reference)) == reference


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("voidage=a.csv", "not a reference"),
        ("voidage@0.1", "not a reference"),
        ("voidage@0.1=", "not a reference"),
        ("porosity@0.1=a.csv", "`porosity` in .* allowed are: solids_fraction, "),
        ("voidage@high=a.csv", "`high` in .*height in m"),
        ("voidage@nan=a.csv", "`nan`"),
        ("voidage@0.1,=a.csv", "`` in .* two places y in m, the lower first, or r are"),
        ("voidage@0.1,0.005=a.csv", "`0.005` in .* two places y in m"),
        ("voidage@0.1,0.01:0.01=a.csv", "the lower first"),
        ("voidage@0.1,0:wall=a.csv", "`0:wall`"),
    ],
)
def test_what_is_wrong_with_a_reference_is_told(text, told):
    with pytest.raises(CaseError, match=told):
        parse_reference(text)


def write(tmp_path, text):
    path = tmp_path / "line.csv"
    path.write_text(text)
    return path


def test_points_are_sorted_by_x_and_other_columns_and_comments_are_allowed(tmp_path):
    points = read_points(write(tmp_path, "# who measured\nvalue, x,mark\n2.0,0.02,a\n\n1.0,0.01,b\n"), "voidage")
    assert points.x.tolist() == [0.01, 0.02] and points.value.tolist() == [1.0, 2.0] and points.error is None


def test_errors_are_read_where_there_are_some(tmp_path):
    points = read_points(write(tmp_path, "x,value,error\n0.01,1.0,0.1\n"), "voidage")
    assert points.error is not None and points.error.tolist() == [0.1]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "line.csv is empty; start it with the line `x,value`"),
        ("z,value\n1,2\n", "line 1, `z,value`, has no column x"),
        ("x,value\n", "holds no points"),
        ("x,value\n1,2\n1\n", "line 3, `1`, has 1 columns and the header, `x,value`, 2"),
        ("x,value\n1,two\n", "line 2 has `two` for value; give a number"),
        ("x,value\n1,nan\n", "line 2 has `nan` for value; give a finite number"),
        ("x,value,error\n1,2,-1\n", "error below zero"),
        ("x,value,Std. Dev.\n1,2,1\n", "has a column `Std. Dev.`; if it is the half width of an error bar call it"),
        ("x;value;standard_error [m]\n1;2;1\n", "has a column `standard_error \\[m\\]`; if it is the half width"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(tmp_path, text, told):
    with pytest.raises(CaseError, match=told):
        read_points(write(tmp_path, text), "voidage")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(CaseError, match=r"none\.csv cannot be read"):
        read_points(tmp_path / "none.csv", "voidage")


def test_units_in_the_head_count(tmp_path):
    points = read_points(write(tmp_path, "x [mm];value (cm/s);error (cm/s)\n5;12,5;1\n"), "gas_velocity")
    assert (points.x[0], points.value[0], points.error[0]) == (0.005, 0.125, 0.01)
    with pytest.raises(CaseError, match="gives value in `Pa`; units that are read: m/s"):
        read_points(write(tmp_path, "x,value [Pa]\n5,12\n"), "gas_velocity")


def test_points_read_off_a_figure_may_lie_a_little_beside_what_can_be(tmp_path):
    reference = Reference("voidage", 0.02, "line.csv")
    path = write(tmp_path, "x,value\n0.01,1.03\n0.02,-0.02\n")
    assert read_line(reference, path, (0.02, 0.01, 0.1)).value.tolist() == [1.03, -0.02]
    with pytest.raises(CaseError, match=r"has 1\.2 at x = 0.01 m, voidage is 0 to 1"):
        read_line(reference, write(tmp_path, "x,value\n0.01,1.2\n"), (0.02, 0.01, 0.1))


@pytest.mark.parametrize("head", ["x,voidage", "x,Voidage [-]", "voidage,x", "x,value", "x,value,solids_fraction"])
def test_the_column_of_the_values_may_have_the_name_of_the_quantity(tmp_path, head):
    cells = {"x": "0.01", "value": "0.5", "solids_fraction": "0.4"}
    row = ",".join(cells.get(name, "0.5") for name in head.split(","))
    assert read_points(write(tmp_path, f"{head}\n{row}\n"), "voidage").value.tolist() == [0.5]


def test_a_column_of_another_quantity_is_named_with_the_mend(tmp_path):
    told = "no column value and has `solids_fraction`; this line is of voidage: name its column `value` or `voidage`"
    with pytest.raises(CaseError, match=f"line 1, .* {told}, or give the line as solids_fraction@height=file"):
        read_points(write(tmp_path, "x,solids_fraction\n0.01,0.5\n"), "voidage")


def test_errors_without_a_unit_have_that_of_the_values(tmp_path):
    bare = read_points(write(tmp_path, "x [mm],value [mm/s],error\n2,-50,10\n"), "solids_velocity")
    assert bare.value.tolist() == [-0.05] and bare.error.tolist() == pytest.approx([0.01])
    own = read_points(write(tmp_path, "x [mm],value [mm/s],error [m/s]\n2,-50,0.02\n"), "solids_velocity")
    assert own.error.tolist() == [0.02]
