"""Options that another one leaves without effect are told, unless they have their default or a run folder has them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fbcouple.case.checks.idle import ROWS, drop_idle
from fbcouple.case.load import load_case, write_case
from fbcouple.case.plan.case_file import write_case_file
from fbcouple.case.schema.reference import list_options
from fbcouple.errors import CaseError

CASE = """
title = "a small bed"
end_time = 0.5
[domain]
size = [0.02, 0.01, 0.06]
cells = [8, 4, 24]
[gas]
density = 1.2
viscosity = 1.8e-5
inlet_velocity = 0.9
[particles]
diameter = 1e-3
density = 2500.0
count = 2000
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.3
wall_friction = 0.3
[start]
[exchange]
"""
HERTZ = 'model = "hertz"\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nimpact_speed = 1.0\n'
GASLESS = re.sub(r"\[gas\].*(?=\[particles\])|\[exchange\]\n", "", CASE, flags=re.DOTALL)
HEAT = "[heat]\nparticle_temperature = 300.0\nparticle_specific_heat = 840.0\n"
SPREAD = "spread = 'normal'\ndeviation = 1e-4\nsmallest = 7e-4\nlargest = 1.3e-3\n"
TOLD = {
    "contact.stiffness": (
        "400.0",
        CASE.replace("[contact]", f"[contact]\n{HERTZ}"),
        '400 is given and model = "hertz"',
    ),
    "contact.scale_restitution": ("false", CASE, "false is given and the particles are no parcels"),
    "start.spacing": ("1.5", CASE.replace("[start]", "[start]\nmethod = 'pour'"), '1.5 is given and method = "pour"'),
    "start.jitter": ("0.2", CASE.replace("[start]", "[start]\nrun = 'a'"), "0.2 is given and run does not look at it"),
    "start.rest_speed": ("0.1", CASE, "0.1 is given and a lattice does not look at it"),
    "start.settle_limit": ("1.0", CASE, "1 is given and a lattice does not look at it"),
    "start.seed": ("3", CASE.replace("[start]", "[start]\njitter = 0.0"), "jitter = 0 leaves nothing to chance"),
    "particles.classes": ("20", CASE, "20 is given and no spread; remove it, or give the spread"),
    "particles.fractions": ('"number"', CASE, '"number" is given and no mixture and no spread'),
    "gas.inlet_section": ("2e-4", CASE, "0.0002 is given and no inlets"),
    "heat.nusselt": ('"ranz-marshall"', f"{GASLESS}{HEAT}", "the case has no [gas]"),
    "monitors.heat": ("1e-6", f"{CASE}[monitors]\n", "1e-06 is given and the case has no [heat]; remove it, or add"),
}


def put(text: str, dotted: str, value: str) -> str:
    section, _, key = dotted.partition(".")
    return text.replace(f"[{section}]", f"[{section}]\n{key} = {value}", 1)


def problems_of(folder: Path, text: str, *sets: str) -> list[str]:
    (folder / "case.toml").write_text(text)
    with pytest.raises(CaseError) as caught:
        load_case(str(folder), sets)
    return caught.value.problems


def test_every_row_is_tried():
    assert {row.key for row in ROWS} == set(TOLD)
    assert {key for row in ROWS for key in row.by} <= {*list_options(), "gas", "particles", "heat"}


@pytest.mark.parametrize("key", TOLD)
def test_what_nothing_looks_at_is_told(tmp_path, key):
    value, text, words = TOLD[key]
    (problem,) = problems_of(tmp_path, put(text, key, value))
    assert problem.startswith(f"{tmp_path}/case.toml: {key}: ") and words in problem and "remove it, or " in problem
    (problem,) = problems_of(tmp_path, text, f"{key}={value}")
    assert problem.startswith(f"--set: {key}: ") and words in problem


@pytest.mark.parametrize("key", [key for key in TOLD if list_options()[key].default is not None])
def test_the_default_may_be_said(tmp_path, key):
    default, text = list_options()[key].default, TOLD[key][1]
    (tmp_path / "case.toml").write_text(text)
    value = f'"{default}"' if isinstance(default, str) else str(default).lower()
    assert load_case(str(tmp_path), [f"{key}={value}"]) == load_case(str(tmp_path))


@pytest.mark.parametrize(
    ("key", "value", "sets"),
    [
        ("contact.stiffness", "400.0", HERTZ.splitlines()),
        ("start.spacing", "1.5", ['method = "pour"']),
        ("start.seed", "3", ["jitter = 0.0"]),
    ],
)
def test_a_setting_may_leave_what_the_file_gives_without_effect(tmp_path, key, value, sets):
    """The file is not at fault: what it gives is left out, so that the case of the run folder loads again."""
    section, _, name = key.partition(".")
    (tmp_path / "case.toml").write_text(put(CASE, key, value))
    given = [f"{section}.{one.replace(' = ', '=')}" for one in sets]
    case = load_case(str(tmp_path), given)
    assert getattr(getattr(case, section), name) == list_options()[key].default
    assert drop_idle(case, {key}) == case
    planned = write_case_file(tmp_path / "planned.toml", str(tmp_path), given, {}, ["A note."])
    assert f'unset = ["{key}"]' in planned.read_text() and load_case(str(planned)) == case
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case


def test_a_case_that_was_written_may_have_anything(tmp_path):
    """Run folders of earlier versions have what was without effect, and go on."""
    (tmp_path / "case.toml").write_text(CASE)
    write_case(load_case(str(tmp_path)), tmp_path / "case.toml")
    text = (tmp_path / "case.toml").read_text()
    for old, new in (("classes = 8", "classes = 20"), ("settle_limit = 5.0", "settle_limit = 1.0")):
        assert text.count(old) == 1
        text = text.replace(old, new)
    (tmp_path / "case.toml").write_text(text.replace("heat = 1e-09\n", ""))  # an option that it did not know
    assert load_case(str(tmp_path)).particles.classes == 20


def test_what_the_base_brought_is_unset(tmp_path):
    (tmp_path / "bed.toml").write_text(CASE.replace("count = 2000", f"count = 2000\n{SPREAD}classes = 4"))
    keys = ["particles.spread", "particles.deviation", "particles.smallest", "particles.largest"]
    (problem,) = problems_of(tmp_path, f'base = "bed.toml"\nunset = {keys}\n'.replace("'", '"'))
    assert 'particles.classes: 4 is given and no spread; remove it by unset = ["particles.classes"]' in problem


@pytest.mark.parametrize(("table", "face"), [("inlet", "left"), ("outlet", "floor")])
def test_a_face_beside_patches(tmp_path, table, face):
    text = CASE.replace("inlet_velocity = 0.9\n", "") if table == "inlet" else CASE
    velocity = "velocity = 1.0\n" if table == "inlet" else ""
    told = problems_of(tmp_path, f'{text}[[gas.{table}s]]\npatches = ["a"]\nface = "{face}"\n{velocity}')
    words = f'gas.{table}s: {table} 1: face = "{face}" is given with patches, which say where it is; remove it, or give'
    assert [problem for problem in told if words in problem]
