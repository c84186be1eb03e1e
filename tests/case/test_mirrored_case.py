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
