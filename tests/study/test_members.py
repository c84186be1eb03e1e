"""A study file: its members, and every mistake of it at once."""

from __future__ import annotations

import pytest

from fbcouple.case.source import read_toml
from fbcouple.errors import CaseError
from fbcouple.study.error_vs_time import plan_members
from fbcouple.study.scenes import list_scenes
from fbcouple.study.schema import Stability, Study
from fbcouple.study.source import list_studies, read_study


def plan(path):
    return plan_members(*read_study(str(path), Study))


def problems_of(path) -> list[str]:
    with pytest.raises(CaseError) as caught:
        plan(path)
    return caught.value.problems


def test_grid_has_every_combination_once(write):
    members = plan(write())
    assert [m.knobs for m in members] == [
        {"gas.max_step": step, "exchange.scheme": scheme}
        for step in (1e-3, 2e-3)
        for scheme in ("explicit", "exponential")
    ]
    assert [m.name for m in members][1::2] == ["max_step-0.001", "max_step-0.002"]
    assert all(m.settings["gas.max_courant"] == 10.0 for m in members)
    assert "exchange.scheme" not in members[1].settings, "the base's own value is not set again"


def test_each_has_the_base_and_one_knob_at_a_time(write):
    members = plan(write(('design = "grid"\n', "")))
    assert [m.name for m in members] == ["base", "max_step-0.001", "max_step-0.002", "scheme-explicit"]


def test_reference_is_the_last_and_ranks_are_no_case_key(write):
    text = ('"exponential"]', '"exponential"]\nranks = [1, 2]\n[reference]\ngas.max_step = 5e-4')
    members = plan(write(text, ('["path"]', '["path", "finest:solids_centre_z"]')))
    assert len(members) == 9 and members[-1].name == "reference"
    assert members[-1].settings["gas.max_step"] == 5e-4
    assert sorted({m.ranks for m in members}) == [1, 2] and all("ranks" not in m.settings for m in members)


PARCELS = """
title = "parcels"
base = "case.toml"
measures = ["path"]
[set]
particles.coarse_graining = 2.0
[knobs]
particles.parcels = [200, 800]
[reference]
particles.coarse_graining = 1.5
"""
BED = """
title = "bed"
end_time = 0.02
[domain]
size = [0.03, 0.012, 0.08]
cells = [4, 1, 10]
[particles]
diameter = 1e-3
density = 1500.0
count = 3000
[contact]
stiffness = 500.0
restitution = 0.9
wall_restitution = 0.95
friction = 0.1
wall_friction = 0.1
[start]
"""


def test_a_knob_takes_the_place_of_what_the_set_says_in_another_way(write):
    """Parcels of l = 2 by [set], by their number as a knob; each is listed by what its case has."""
    path = write(text=PARCELS)
    (path.parent / "case.toml").write_text(BED)
    found = {member.name: (member.settings, member.knobs["particles.parcels"]) for member in plan(path)}
    assert found["base"] == ({"particles.coarse_graining": 2.0}, 375)
    assert found["parcels-200"] == ({"particles.parcels": 200}, 200)
    assert found["reference"] == ({"particles.coarse_graining": 1.5}, 889)
    over = PARCELS.replace("coarse_graining = 2.0", "parcels = 300").replace("parcels = [200", "parcels = [100")
    (path.parent / "study.toml").write_text(over)
    found = {member.name: member.settings for member in plan(path)}
    assert found["base"] == {"particles.parcels": 300} and found["reference"] == {"particles.coarse_graining": 1.5}


def test_a_ratio_of_1_is_the_bed_without_parcels(write):
    """The dearest member of all is not run twice."""
    path = write(text="")
    (path.parent / "case.toml").write_text(BED)
    text = PARCELS.replace("coarse_graining = 2.0", "diameter = 1e-3")
    path.write_text(text.replace("parcels = [200, 800]", "coarse_graining = [1.0, 2.0]"))
    found = {member.name: member.knobs["particles.coarse_graining"] for member in plan(path)}
    assert list(found.values()) == [1.0, 2.0, 1.5] and "base" in found


def test_a_scene_takes_the_place_of_what_the_set_says_in_another_way(write):
    text = 'title = "s"\nbase = "case.toml"\nspan = "fall"\n[set]\nparticles.coarse_graining = 2.0\n'
    path = write(text=f"{text}[scenes.few]\nparticles.parcels = [200, 400]\n")
    (path.parent / "case.toml").write_text(BED)
    few, more = list_scenes(*read_study(str(path), Stability))
    assert few.settings["particles.parcels"] == 200 and "particles.coarse_graining" not in more.settings


def test_a_knob_of_lists(write):
    members = plan(write(("gas.max_step = [1e-3, 2e-3]", "domain.cells = [[1, 1, 6], [2, 2, 12]]")))
    assert [m.name for m in members] == ["scheme-explicit", "base", "cells-2x2x12_scheme-explicit", "cells-2x2x12"]


@pytest.mark.parametrize(
    ("old", "new", "key", "fix"),
    [
        ("title", "titel", "titel", "did you mean `title`"),
        ('design = "grid"', 'design = "gird"', "design", 'did you mean "grid"'),
        ("gas.max_step =", "gas.max_stp =", "knobs.gas.max_stp", "did you mean `gas.max_step`"),
        ("[1e-3, 2e-3]", "1e-3", "knobs.gas.max_step", "write [a, b, ...]"),
        ("[1e-3, 2e-3]", "[1e-3, -2.0]", "gas.max_step", "a number above 0"),
        ('"explicit", ', '"explizit", ', "exchange.scheme", 'did you mean "explicit"'),
        ('["path"]', '["pat"]', "measures", "did you mean `path`"),
        ('["path"]', '["path:z"]', "measures", "`path` without an argument"),
        ('["path"]', '["finest:solids_center_z"]', "measures", "did you mean `finest:solids_centre_z`"),
        ('["path"]', '["finest:solids_centre_z"]', "measures", "add [reference]"),
        ("gas.max_courant = 10.0", "gas.max_couran = 10.0", "set.gas.max_couran", "did you mean `gas.max_courant`"),
        ('"case.toml"', '"cas.toml"', "base", "neither a shipped case nor a file"),
        ("[1e-3, 2e-3]", str([1e-3] * 501), "knobs", "501 x 2 = 1002 combinations are given, at most 1000 are allowed"),
    ],
)
def test_mistake_names_key_and_mend(write, old, new, key, fix):
    problems = problems_of(write((old, new)))
    assert any(key in problem and fix in problem for problem in problems), problems


def test_a_grid_is_counted_before_it_is_made(write):
    """30 values of eight knobs are 656 thousand million members."""
    keys = ("density", "viscosity", "inlet_velocity", "max_fourier", "pressure_tolerance", "max_courant")
    more = "".join(f"gas.{key} = {list(range(1, 31))}\n" for key in keys)
    path = write(("[1e-3, 2e-3]\n", f"{list(range(1, 31))}\n{more}contact.stiffness = {list(range(1, 31))}\n"))
    (problem,) = problems_of(path)
    assert "30 x 30 x 30 x 30 x 30 x 30 x 30 x ... = " in problem
    assert "at most 1000 are allowed" in problem and 'design = "each"' in problem
    path.write_text(path.read_text().replace('design = "grid"\n', "").replace("[1, 2, 3,", f"[{'1, ' * 900}"))
    (problem,) = problems_of(path)
    assert "more than 1000 members" in problem


def test_scenes_are_counted_before_they_are_made(write):
    text = """title = "many"
base = "case.toml"
[scenes.all]
"""
    keys = ("density", "viscosity", "inlet_velocity", "max_fourier", "pressure_tolerance", "max_courant", "max_step")
    text += "".join(f"gas.{key} = {list(range(1, 31))}\n" for key in keys)
    with pytest.raises(CaseError, match=r"scenes\.all: 30 x 30 .* at most 1000 are allowed"):
        list_scenes(*read_study(str(write(text=text)), Stability))


def test_mistakes_come_all_at_once(write):
    path = write(("gas.max_step =", "gas.max_stp ="), ('["path"]', '["pat"]'), ("gas.max_courant", "gas.max_couran"))
    assert len(problems_of(path)) == 3


def test_mistakes_of_several_members(write):
    path = write(("[1e-3, 2e-3]", "[1e-3, -2.0]"), ('"explicit", ', '"explizit", '))
    text = "\n".join(problems_of(path))
    assert "-2" in text and "explizit" in text


SHIPPED = {name: "scenes" in read_toml(path, name) for name, path in list_studies().items()}


@pytest.mark.parametrize("name", [name for name, has_scenes in SHIPPED.items() if not has_scenes])
def test_shipped_error_studies_have_a_front_of_many_members(name):
    """Twelve, but for parcels: six ratios and one without the scaling of restitution, each a bubbling bed for 6 s."""
    assert len(plan(name)) >= (7 if name.startswith("coarse-graining") else 12)


@pytest.mark.parametrize("name", [name for name, has_scenes in SHIPPED.items() if has_scenes])
def test_shipped_stability_studies_have_different_scenes(name):
    names = [scene.name for scene in list_scenes(*read_study(name, Stability))]
    assert len(names) == len(set(names)) >= 12


def test_studies_of_both_kinds_are_shipped():
    assert {"single-particle", "fixed-bed", "cloud", "mueller", "stability", "explicit-limit"} <= set(SHIPPED)
