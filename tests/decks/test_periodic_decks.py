"""Sides that repeat in the decks: cyclic patches in place of walls, and no trace where there are none."""

from __future__ import annotations

import pytest
from test_render import build, join

from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks


@pytest.mark.parametrize(
    ("axes", "boundary", "planes"),
    [((), "f f f", "xyz"), (("x",), "p f f", "yz"), (("y",), "f p f", "xz"), (("y", "x"), "p p f", "z")],
)
def test_walls_stand_where_nothing_repeats(axes, boundary, planes):
    case = build(domain__periodic=list(axes))
    decks = render_decks(case)
    liggghts, mesh = decks["DEM/in.liggghts"], decks["CFD/system/blockMeshDict"]
    assert f"boundary        {boundary}\n" in liggghts
    for axis in "xyz":
        assert liggghts.count(f" {axis}plane ") == (2 if axis in planes else 0)
    for axis in axes:
        assert f"    {axis}lo\n    {{\n        type    cyclic;\n        neighbourPatch {axis}hi;" in mesh
        assert f"    {axis}hi\n    {{\n        type    cyclic;\n        neighbourPatch {axis}lo;" in mesh
    fields = [text for name, text in decks.items() if name.startswith("CFD/0/")]
    assert len(fields) == 4
    for text in (mesh, *fields):
        assert ("    walls\n" in text) == (len(axes) < 2)
        assert ("cyclic" in text) == bool(axes)
    for sides in ("(0 4 7 3)", "(1 2 6 5)", "(0 1 5 4)", "(3 7 6 2)"):
        assert mesh.count(sides) == 1


def test_no_trace_of_a_period_that_is_not_asked_for():
    assert find_needs(build(domain__periodic=["x"]))["periodic"] and not find_needs(build())["periodic"]
    assert "cyclic" not in join(render_decks(build()))
