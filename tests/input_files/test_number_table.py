"""Tables of numbers as programs write them: what is read, and what is told of what cannot be."""

import os

import numpy as np
import pytest

from fbcouple.errors import CaseError
from fbcouple.input_files.number_table import Form, read_table
from fbcouple.input_files.units import DENSITIES, LENGTHS, SPEEDS, find_size, guess_frame

FORM = Form(
    {"x": LENGTHS, "y": LENGTHS, "size": {}},
    ("x", "y"),
    "drops",
    1000,
    aliases={"points:0": "x", "points:1": "y"},
    unclear={"s": "call it `size` if it is that"},
)


def write(folder, content):
    path = folder / "table.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(
    "content",
    [
        "x,y\n0.25,1.5\n-0.5,2\n",
        "\ufeffx,y\n0.25,1.5\n-0.5,2\n",
        "x;y\n0,25;1,5\n-0,5;2\n",
        "X\tY\n0.25\t1.5\n-0.5\t2\n",
        "x  y\n0.25   1.5\n  -0.5 2\n",
        '"x","y"\n0.25,1.5\n"-0.5","2"\n',
        '# x, y\n"0,25", "1,5"\n"-0,5", "2"\n',
        "# who\n#x,y\n0.25,1.5\n# between\n-0.5,2\n",
        "sep=;\nx;y\n0,25;1,5\n-0,5;2\n",
        "x [mm],y (cm)\n250,150\n-500,200\n",
        "x [m] y [m]\n0.25 1.5\n-0.5 2\n",
        "y/m,x/mm\n1.5,250\n2,-500\n",
        "name,x,y,\na,0.25,1.5,\n\nb,-0.5,2,\n",
        "x,y\r\n0.25,1.5\r\n-0.5,2\r\n",
        "x,y\r0.25,1.5\r-0.5,2",
        '"Points:0","Points:1"\n0.25,1.5\n-5e-1,2\n',
        "x\ty\r\n0,25\t1,5\r\n-0,5\t2\r\n".encode("utf-16"),
        "x;y\r\n0,25;1,5\r\n-0,5;2\r\n;\r\n;\r\n",
        "x,y,,\n0.25,1.5,,\n,,,\n-0.5,2,,\n",
        "X [MM];y [cm]\n250;150\n-500;200\n",
    ],
)
def test_columns_are_read_whatever_separates_them(tmp_path, content):
    columns = read_table(write(tmp_path, content), FORM).columns
    np.testing.assert_array_equal(columns["x"], [0.25, -0.5])
    np.testing.assert_array_equal(columns["y"], [1.5, 2.0])
    assert set(columns) == {"x", "y"}


def test_columns_that_are_not_read_are_named(tmp_path):
    table = read_table(write(tmp_path, "mark,x,size,y,Who\na,1,3,2,b\n"), FORM)
    assert table.unread == ("mark", "Who") and table.columns["size"].tolist() == [3.0]


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("x,y\n0,25,1,5\n", "line 2, `0,25,1,5`, has 4 columns and the header, `x,y`, 2; commas cannot separate"),
        ("x,y,size\n5,0,05\n", "line 2, `5,0,05`, has `05` for size; commas cannot separate columns and decimals"),
        ("x,y\n1,2\n1,2,3\n", "line 3, `1,2,3`, has 3 columns and the header, `x,y`, 2; give every row"),
        ("x;y\n1,2\n", "line 2, `1,2`, has 1 columns"),
        ("x;y\n1,5;2\n1.5;2\n", "line 2 has a decimal comma and line 3 a decimal point"),
        ("x;y\n1,234,567;2\n", "line 2 has `1,234,567` for x; give a number"),
        ("x,y\n1_0,2\n", "line 2 has `1_0` for x"),
        ("x,y\n\u22121,2\n", r"line 2 has `\u22121` \(with the character U\+2212\) for x"),
        ("x,y\n1,\n", "line 2 has nothing for y"),
        ("x,y\n1,-inf\n", "line 2 has `-inf` for y; give a finite number"),
        ("0.1,0.2\n0.3,0.4\n", "line 1, `0.1,0.2`, holds numbers and no line before it names the columns"),
        ("# a,b\n0.1,0.2\n", "line 2, `0.1,0.2`, holds numbers"),
        ("x,H/H0=0.30\n1,2\n", "line 1, `x,H/H0=0.30`, has no column y"),
        ("a,,b,\nX,Y,X,Y\n1,2,3,4\n", "several data sets side by side"),
        ("X,Y,X,Y\n1,2,3,4\n", "names the column x twice"),
        ("x [inch],y\n1,2\n", "gives x in `inch`; units that are read: m, cm, mm"),
        ("x,y,s [m]\n1,2,3\n", "has a column `s .m.`; call it `size`"),
        ("# x,y\n", "holds no drops"),
        ("", "is empty; start it with the line `x,y`"),
        ("x,y\n1,2\n".encode("utf-16")[:-1], r"is not UTF-16.* text \(byte 0x0a\)"),
        (
            'x,y\n1,2\n"1,234",5\n',
            "line 3 has `1,234` for x, which may be thousands or a decimal comma; write it",
        ),
        (
            "x\ty\n0\t1,234\n1\t2,500\n",
            "line 2 has `1,234` for y, which may be thousands or a decimal comma; write it with a decimal point, or as "
            "1234 .no number of the file tells",
        ),
        ("x;y\n0;7\n1;-12,500\n", "line 3 has `-12,500` for y, which may be thousands or a decimal comma"),
        ("x y\n900 1\n1,000 2\n", "line 3 has `1,000` for x, which may be thousands or a decimal comma"),
        ("x,y\n1,2\n#N/A,3\n", "line 3 has `#N/A` for x; give a number"),
        ("x;y\n1;2\n#WERT!;3\n", "line 3 has `#WERT!` for x"),
        ("x;y\n1;2\n1.234,5;3\n", "line 3 has `1.234,5` for x"),
        ("x;y\n1;2\n1\u202f234;3\n", r"line 3 has `1\\u202f234` \(with the character U\+202F\) for x"),
        ("x,y\n[mm],m\n1,2\n", r"line 2 has `\[mm\]` for x; write it into the header, as `x \[mm\]`"),
        ("Drops of 12.3.;\nx;y\n1;2\n", "has no column x and y; .* stand further down, begin the lines above with `#`"),
        ("x,y\n1,2\n".encode("utf-16-le"), "holds NUL bytes, so it is UTF-16 or no text"),
        ("x [µm],y\n1,2\n".encode("latin-1"), r"is not UTF-8 text \(byte 0xb5\)"),
        (b"PK\x03\x04...", "is a zip archive or a workbook"),
        ("ITEM: TIMESTEP\n0\n", "is a LIGGGHTS or LAMMPS dump"),
        ("x,y\n" + "1,2\n" * 1000, "has 0.004004 MB, at most 0.001 MB are allowed"),
    ],
)
def test_what_cannot_be_read_is_told_as_it_was_found(tmp_path, content, told):
    with pytest.raises(CaseError, match=told) as caught:
        read_table(write(tmp_path, content), FORM)
    assert str(caught.value).startswith("table.csv")


@pytest.mark.parametrize("other", ["0,234", "1,5", "1,2345", "1,234e-3", "1234,567", "0,000"])
@pytest.mark.parametrize("separator", [";", "\t", " "])
def test_one_number_tells_of_decimal_commas(tmp_path, separator, other):
    """In whichever column and row: a program writes all numbers of a file one way."""
    value = float(other.replace(",", "."))
    for rows in ([["1,234", "2"], [other, "3,000"]], [["2", "1,234"], [other, "7"]], [[other, "1"], ["3", "1,234"]]):
        lines = [separator.join(row) for row in [["x", "y"], *rows]]
        found = read_table(write(tmp_path, "\n".join(lines)), FORM).columns
        assert value in found["x"] and 1.234 in (*found["x"], *found["y"])


def test_a_pipe_a_device_and_a_folder_are_no_files(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, type(tmp_path)("/dev/zero")):
        with pytest.raises(CaseError, match="it is not a plain file"):
            read_table(path, FORM)


@pytest.mark.parametrize("unit", ["m/s", "m s-1", "m s⁻¹", "m·s⁻¹", "M/S", "m s^-1"])
def test_units_are_read_however_they_are_spelt(unit):
    assert find_size(unit, SPEEDS) == 1.0 and find_size("kg m-2", SPEEDS) is None
    assert find_size("Kg/m³", DENSITIES) == 1.0


def test_units_are_exact_to_the_last_digit(tmp_path):
    columns = read_table(write(tmp_path, "x [mm],y [um]\n9,7\n0.1,3\n"), FORM).columns
    assert columns["x"].tolist() == [0.009, 0.0001] and columns["y"].tolist() == [7e-6, 3e-6]


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-9.0, 9.0, "(they look like mm from the middle)"),
        (-0.009, 0.009, "(they look like from the middle)"),
        (1.0, 19.0, "(they look like mm)"),
        (0.1, 1.9, "(they look like cm)"),
        (5.0, 500.0, ""),
    ],
)
def test_what_coordinates_may_be_measured_in(low, high, words):
    assert guess_frame([low], [high], [0.02]).strip() == words


def test_every_axis_of_coordinates_tells_of_their_unit():
    """A bed of 10 mm in a column of 160 by 40: by its height alone it may be in cm."""
    assert guess_frame([0.4, 0.4, 0.4], [39.6, 7.6, 10.0], [0.04, 0.008, 0.16]).strip() == "(they look like mm)"
