"""Means with mirror images are for beds that are their own mirror image."""

import pytest

from fbcouple.case.cost.means import MIRRORED, predict_means
from fbcouple.case.load import load_case
from fbcouple.errors import CaseError

LEFT = "{rectangle=[[0.01, 0.0], [0.02, 0.015]], velocity=3.0}"
RIGHT = "{rectangle=[[0.06, 0.0], [0.07, 0.015]], velocity=3.0}"
SLOW = "{rectangle=[[0.06, 0.0], [0.07, 0.015]], velocity=2.0}"
DISC = "{circle=[0.04, 0.005, 0.01], velocity=3.0}"
SIDES = [f'{{face="{face}", rectangle=[[0.0, 0.01], [0.015, 0.02]], velocity=1.0}}' for face in ("left", "right")]
SHIPPED = ["patil/c2", "mueller/0.9", "yue/spout"]


def load(name="patil/c1", *sets, axes='["x"]'):
    return load_case(name, [f"averages.mirror={axes}", *sets])


def inlets(*tables):
    return f"gas.inlets=[{', '.join(tables)}]"


def load_inlets(tmp_path, *tables, axes='["x"]'):
    (tmp_path / "case.toml").write_text('base = "patil/c1"\nunset = ["gas.inlet_velocity", "gas.closed_nozzle"]\n')
    return load(str(tmp_path / "case.toml"), inlets(*tables), axes=axes)


@pytest.mark.parametrize("name", SHIPPED)
def test_beds_in_a_box_are_their_own_image(name):
    assert load(name, axes='["x", "y"]').averages.mirror == ("x", "y")


@pytest.mark.parametrize("tables", [(LEFT, RIGHT), (DISC,), SIDES, (LEFT, RIGHT, DISC, *SIDES)])
def test_inlets_that_are_each_others_images(tmp_path, tables):
    assert load_inlets(tmp_path, *tables).averages.mirror == ("x",)


@pytest.mark.parametrize(
    ("tables", "axis", "number"),
    [((LEFT,), "x", 1), ((LEFT, SLOW), "x", 1), ((LEFT, RIGHT, SIDES[0]), "x", 3), ((DISC,), "y", 1)],
)
def test_inlets_at_one_side_are_refused(tmp_path, tables, axis, number):
    with pytest.raises(CaseError) as error:
        load_inlets(tmp_path, *tables, axes=f'["{axis}"]')
    assert f'averages.mirror: "{axis}" is given and inlet {number} of gas.inlets has no image' in str(error.value)


@pytest.mark.parametrize(
    ("name", "sets", "text"),
    [
        ("verma/1.02", (), 'domain.shape is "cylinder" ("box" is allowed)'),
        ("patil/c1", ('gas.outlets=[{face="left", rectangle=[[0.0, 0.2], [0.01, 0.21]]}]',), "gas.outlets are places"),
    ],
)
def test_what_tells_sides_apart_is_refused(name, sets, text):
    with pytest.raises(CaseError) as error:
        load(name, *sets)
    assert text in str(error.value) and "leave it out" in str(error.value)


STRIPS = [
    f"{{rectangle=[[{low}, 0.0], [{high}, 0.015]], velocity={velocity}}}"
    for low, high, velocity in ((0.0, 0.05, 0.6), (0.02, 0.06, 3.0), (0.03, 0.08, 0.6))
]


def test_inlets_upon_each_other_in_another_order_than_their_images_are_refused(tmp_path):
    with pytest.raises(CaseError, match=r"inlet 3 of gas.inlets lies upon inlet 1, and their images the other way"):
        load_inlets(tmp_path, *STRIPS)
    middle_on_top = load_inlets(tmp_path, "{rectangle=[[0.0, 0.0], [0.08, 0.015]], velocity=0.6}", DISC)
    assert middle_on_top.averages.mirror == ("x",)


def test_a_ramp_is_its_own_image_whatever_file_it_lies_in(tmp_path):
    (tmp_path / "ramp.csv").write_text("time,velocity\n0,1\n1,3\n")
    ramped = DISC.replace("velocity=3.0", 'ramp_file="ramp.csv"')
    assert load_inlets(tmp_path, ramped).averages.mirror == ("x",)


def test_a_profile_over_a_circle_is_its_own_image_and_one_over_a_rectangle_is_not_looked_at(tmp_path):
    (tmp_path / "profile.csv").write_text("r,velocity\n0,3\n0.01,1\n")
    assert load_inlets(tmp_path, DISC.replace("velocity", 'profile_file="profile.csv", velocity')).averages.mirror
    (tmp_path / "profile.csv").write_text("x,velocity\n0.03,3\n0.05,1\n")
    middle = '{rectangle=[[0.03, 0.0], [0.05, 0.015]], profile_file="profile.csv", velocity=3.0}'
    with pytest.raises(CaseError, match=r"what lies in profile_file of inlet 1 of gas.inlets is not compared"):
        load_inlets(tmp_path, middle)


def test_walls_of_two_temperatures_are_refused():
    hot = 'heat.walls=[{face="left", temperature=500.0}]'
    with pytest.raises(CaseError, match=r'the walls "left" and "right" of heat.walls are not alike'):
        load("patil/heat-1.20", hot)
    both = 'heat.walls=[{face="left", temperature=500.0}, {face="right", temperature=500.0}]'
    assert load("patil/heat-1.20", both).averages.mirror == ("x",)


def test_an_axis_is_named_once():
    with pytest.raises(CaseError, match="name each axis once"):
        load(axes='["x", "x"]')


def test_the_error_told_before_is_smaller():
    """As far before chaos: a run that ends by its error ends sooner, one that does not has the smaller error."""
    for name, told in (("mueller/0.9", "error"), ("patil/c4-0.0", "window")):
        early = "averages.start=0.5" if told == "error" else "averages.earliest_end=1.1"
        plain, mirrored = (predict_means(load_case(name, [early, *sets])) for sets in ([], ['averages.mirror=["x"]']))
        factor = MIRRORED if told == "error" else MIRRORED**2
        assert getattr(mirrored, told) == pytest.approx(factor * getattr(plain, told), rel=1e-9)
