"""The decks: golden texts of patil/c2, nothing in them that a case does not need, a run folder whole or not at all.

The golden texts lie in golden/patil-c2/, laid out like a run folder. After a wanted change of the templates renew them
with `python tests/decks/test_render.py` and read the difference.
"""

from __future__ import annotations

import json
import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from jinja2 import UndefinedError
from jinja2.exceptions import SecurityError

from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Case
from fbcouple.decks import render
from fbcouple.decks.needs import explain, find_needs
from fbcouple.decks.render import DECKS, format_number, make_environment, render_decks, set_up
from fbcouple.errors import CaseError

GOLDEN = Path(__file__).parent / "golden/patil-c2"

FULL = {
    "title": "a case with everything",
    "end_time": 1.0,
    "domain": {"size": [0.01, 0.006, 0.02], "cells": [5, 3, 10]},
    "gas": {
        "density": 1.165,
        "viscosity": 2e-5,
        "inlet_velocity": 1.2,
        "closed_nozzle": [1, 1],
        "turbulence": "smagorinsky",
    },
    "particles": {"diameter": 1e-3, "density": 2500.0, "count": 20, "rotation": True},
    "contact": {
        "restitution": 0.97,
        "wall_restitution": 0.9,
        "friction": 0.2,
        "wall_friction": 0.1,
        "tangential": "no-history",
    },
    "start": {},
    "exchange": {"filter_passes": 2},
    "averages": {"start": 0.5},
}


def build(**changes):
    """The full case with values changed: `build(gas__walls="slip", particles=None)`; None takes a value out."""
    content = json.loads(json.dumps(FULL))
    for key, value in changes.items():
        *path, last = key.split("__")
        table = content
        for name in path:
            table = table[name]
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return Case.model_validate(content)


NO_GAS = {"gas": None, "exchange": None}
NO_PARTICLES = {"particles": None, "contact": None, "start": None, "exchange": None}

CYLINDER = {
    "domain__shape": "cylinder",
    "domain__size": [0.08, 0.08, 0.25],
    "domain__cells": [36, 36, 110],
    "gas__closed_nozzle": None,
}

# Options of the gas that are out of the full case: test_gas_decks.py puts each of them in.
GAS_OPTIONS = (
    "subgrid_energy",
    "lagrangian_averages",
    "viscous_force",
    "lift_force",
    "virtual_mass",
    "accelerated_drag",
)

# Part -> the changes that take it out, and words and files that then must be gone (and are there with it).
TRACES = {
    "gas": (
        NO_GAS,
        [],
        [
            deck
            for deck, (_, part) in DECKS.items()
            if deck.startswith("CFD/") and part not in (*GAS_OPTIONS, "gas_heat")
        ],
    ),
    "particles": (NO_PARTICLES, [], ["DEM/in.liggghts"]),
    "coupling": (NO_GAS, ["couple/cfd", "map array"], []),
    "closed_nozzle": (
        {"gas__closed_nozzle": None},
        ["nozzle"],
        ["CFD/system/topoSetDict", "CFD/system/createPatchDict"],
    ),
    "turbulence": ({"gas__turbulence": "none"}, ["LES", "Smagorinsky", "cubeRootVol"], ["CFD/0/nut"]),
    "pair_friction": ({"contact__friction": 0.0}, ["pair_style      gran model hooke/stiffness tangential"], []),
    "wall_friction": ({"contact__wall_friction": 0.0}, ["wall/gran model hooke/stiffness tangential"], []),
    "rotation": ({"particles__rotation": None}, ["nve/sphere"], []),
    "gravity": ({"gravity": 0.0}, ["gravity"], []),
    "block_mesh": (CYLINDER, ["simpleGrading", "xplane"], ["CFD/system/blockMeshDict"]),
}
# Parts that live in the time loop: the decks are the same with and without them.
NOT_IN_DECKS = {
    "filter": {"exchange__filter_passes": 0},
    "pressure_gradient_force": {"exchange__pressure_gradient": False},
    "averages": {"averages": None},
}
# Parts that are out of the full case: test_contact_decks.py puts each of them in.
CONTACT_OPTIONS = ("tangential_history", "rolling_friction", "hertz")
# Likewise, each with the test that puts it in.
OTHER_OPTIONS = {
    "preset": "tests/case/test_presets.py",
    "lid": "test_inlet_decks.py",
    "openings": "test_opening_decks.py",
    "inlet_ramp": "test_inlet_decks.py",
    "superficial_inlet": "test_inlet_decks.py",
    "periodic": "test_periodic_decks.py",
    "mesh_of_polyhedra": "test_mesh_decks.py",
    "surface_walls": "test_mesh_decks.py",
    "mixture": "test_mixture_decks.py",
    "coarse_graining": "test_coarse_graining_decks.py",
    "feeds_and_outlets": "test_traffic_decks.py",
    "open_walls": "test_traffic_decks.py",
    "empty_start": "test_traffic_decks.py",
    "satellite_points": "test_voidage_parts.py",
    "gaussian_kernel": "test_voidage_parts.py",
    "diffusion": "test_voidage_parts.py",
    "polydisperse_drag": "test_voidage_parts.py",
    "probes": "tests/simulation/test_probes.py",
    **dict.fromkeys(("heat", "particle_heat", "contact_conduction"), "test_heat_decks.py"),
    **dict.fromkeys(("gas_heat", "hot_gas_walls", "inlet_temperatures"), "test_gas_heat_decks.py"),
}
OTHER_OPTIONS |= dict.fromkeys(GAS_OPTIONS, "test_gas_decks.py")


def join(decks):
    return "\n".join(decks.values())


def numbers_after(text, pattern):
    (found,) = re.findall(rf"^{pattern}(.*)$", text, re.MULTILINE)
    return [float(word) for word in re.findall(r"[-+.\de]*\d[-+.\de]*", found)]


def split_numbers(text):
    """The text with # for its numbers, and the numbers: their last bit depends on the machine's logarithm."""
    pattern = r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])"
    return re.sub(pattern, "#", text), [float(number) for number in re.findall(pattern, text)]


@pytest.fixture(scope="module")
def c2():
    return render_decks(load_case("patil/c2"))


@pytest.fixture(scope="module")
def stiff():
    return render_decks(load_case("patil/c2", ["contact.stiffness=1000"]))


def test_golden_texts(c2):
    golden = {path.relative_to(GOLDEN).as_posix(): path.read_text() for path in GOLDEN.rglob("*") if path.is_file()}
    assert set(c2) == set(golden)
    for name, text in c2.items():
        words, numbers = split_numbers(text)
        golden_words, golden_numbers = split_numbers(golden[name])
        assert words == golden_words, f"{name}: if this is wanted, run python tests/decks/test_render.py"
        assert numbers == pytest.approx(golden_numbers, rel=1e-14), name


def test_damping_of_pairs_and_walls(stiff):
    """gamman = 2 gamma_n: 757.9 1/s for pairs and, of twice the effective mass, 535.9 1/s for walls."""
    table = numbers_after(stiff["DEM/in.liggghts"], "fix +gamman .* peratomtypepair 2 ")
    assert table == pytest.approx([757.9, 535.9, 535.9, 535.9], abs=0.05)
    assert table[0] / table[1] == pytest.approx(math.sqrt(2.0), rel=1e-12)


def test_contact_and_step_numbers(stiff):
    """k_n = 1000 N/m: T_C = 8.04e-5 s, of which a sixth is the step; gammat dt is a half."""
    deck = stiff["DEM/in.liggghts"]
    (step,) = numbers_after(deck, "timestep +")
    assert step == pytest.approx(8.04e-5 / 6, rel=1e-3)
    assert numbers_after(deck, "fix +kn .* peratomtypepair 2 ") == [1000.0] * 4
    assert numbers_after(deck, "fix +gammat .* peratomtypepair 2 ") == pytest.approx([0.5 / step] * 4)
    assert numbers_after(deck, "fix +friction .* peratomtypepair 2 ") == [0.2] * 4
    assert numbers_after(deck, "# .* gravity = ") == [9.81] and "all gravity" not in deck, "it is held with the gas"
    assert numbers_after(deck, "neighbor +") == [3e-4] and numbers_after(deck, "neigh_modify .* binsize ") == [1.3e-3]


def test_without_gas_gravity_is_a_fix_of_its_own():
    deck = render_decks(build(**NO_GAS))["DEM/in.liggghts"]
    assert numbers_after(deck, "fix +gravity all gravity ") == [9.81, 0.0, 0.0, -1.0]


def test_a_sphere_that_may_roll_gets_a_softer_viscous_limit():
    """Contact velocity of a rolling sphere reacts 7/2 times as much: 1 + m r^2/I."""
    pattern = "fix +gammat .* peratomtypepair 2 "
    sliding = numbers_after(render_decks(build(particles__rotation=None))["DEM/in.liggghts"], pattern)
    rolling = numbers_after(render_decks(build())["DEM/in.liggghts"], pattern)
    assert sliding[0] / rolling[0] == pytest.approx(3.5, rel=1e-12)


def test_gas_numbers(c2):
    """The open floor gets U_f A/(A - A_closed) = 1.1053 U_f; nu = mu/rho."""
    assert numbers_after(c2["CFD/0/U"], r" +inletVelocity +uniform ") == pytest.approx([0, 0, 1.2 * 1.1053], rel=1e-4)
    assert numbers_after(c2["CFD/constant/transportProperties"], "nu ") == pytest.approx([2e-5 / 1.165])
    assert "hex (0 1 2 3 4 5 6 7) (35 6 110) simpleGrading (1 1 1)" in c2["CFD/system/blockMeshDict"]


@pytest.mark.parametrize(("name", "faces"), [("patil/c1", (3, 3)), ("patil/c2", (5, 4)), ("patil/c3", (10, 8))])
def test_the_nozzles_box_holds_its_faces_in_the_middle_of_the_floor(name, faces):
    """Table 2 of the paper: as many face centres in the box, as many open faces on both sides (give or take one)."""
    case = load_case(name)
    x0, y0, z0, x1, y1, z1 = numbers_after(render_decks(case)["CFD/system/topoSetDict"], " +box +")
    assert z0 < 0.0 < z1
    for (low, high), length, cells, wanted in zip(
        ((x0, x1), (y0, y1)), case.domain.size, case.domain.cells, faces, strict=False
    ):
        centres = (np.arange(cells) + 0.5) * length / cells
        inside = np.flatnonzero((centres > low) & (centres < high))
        assert len(inside) == wanted
        assert abs(inside[0] - (cells - 1 - inside[-1])) <= 1
        assert np.abs(np.subtract.outer([low, high], centres)).min() > 0.4 * length / cells, "no face on the edge"


def test_restitution_1_is_no_damping():
    case = build(contact__restitution=1.0, contact__wall_restitution=1.0)
    assert not find_needs(case)["damping"] and find_needs(build())["damping"]
    deck = render_decks(case)["DEM/in.liggghts"]
    assert numbers_after(deck, "fix +gamman .* peratomtypepair 2 ") == [0.0] * 4


@pytest.mark.parametrize("part", TRACES)
def test_no_trace_of_a_part_that_is_out(part):
    changes, words, files = TRACES[part]
    full, lean = build(), build(**changes)
    assert find_needs(full)[part] and not find_needs(lean)[part]
    with_it, without = render_decks(full), render_decks(lean)
    for word in words:
        assert word in join(with_it) and word not in join(without)
    for name in files:
        assert name in with_it and name not in without
    assert words or files


def test_without_any_friction_there_is_no_coefficient_of_it():
    deck = render_decks(build(contact__friction=0.0, contact__wall_friction=0.0))["DEM/in.liggghts"]
    for word in ("tangential", "coefficientFriction", "friction"):
        assert word in render_decks(build())["DEM/in.liggghts"] and word not in deck


@pytest.mark.parametrize("part", NOT_IN_DECKS)
def test_parts_of_the_loop_leave_the_decks_as_they_are(part):
    full, lean = build(), build(**NOT_IN_DECKS[part])
    assert find_needs(full)[part] and not find_needs(lean)[part]
    assert render_decks(full) == render_decks(lean)
    assert not re.search(r"filter|average", join(render_decks(full)), re.IGNORECASE)


def test_snapshots_are_out_unless_asked_for_and_never_in_the_decks():
    case = build()
    asked = case.model_copy(update={"output": case.output.model_copy(update={"snapshots_every": 0.01})})
    assert not find_needs(case)["voidage_snapshots"] and find_needs(asked)["voidage_snapshots"]
    assert render_decks(case) == render_decks(asked)


def test_every_part_of_a_scene_is_looked_at():
    assert {part.name for part in explain(build())} == {
        *TRACES,
        *NOT_IN_DECKS,
        *CONTACT_OPTIONS,
        *OTHER_OPTIONS,
        "damping",
        "voidage_snapshots",
        "frames",
        "tracked_particles",
    }


@pytest.mark.parametrize("changes", [{}, *(changes for changes, *_ in TRACES.values())], ids=["full", *TRACES])
def test_decks_are_whole(changes):
    """No template syntax, no Python word and no empty value is left over, and brackets close."""
    for name, text in render_decks(build(**changes)).items():
        assert not re.search(r"\{\{|\}\}|\{%|None|Undefined|nan|inf\b|True|False", text), name
        if name.startswith("CFD/"):
            assert text.count("{") == text.count("}") and text.count("(") == text.count(")"), name


@pytest.mark.parametrize("walls", ["slip", "no-slip"])
def test_walls_of_the_gas(walls):
    text = render_decks(build(gas__walls=walls))["CFD/0/U"]
    word, other = ("slip;", "noSlip;") if walls == "slip" else ("noSlip;", "type    slip;")
    assert text.count(word) == 2 and other not in text


@pytest.mark.parametrize("value", [1e-3, 0.1 + 0.2, 1 / 3, 5e-324, -0.0, 1e22, 35])
def test_numbers_read_back_as_the_same(value):
    assert float(format_number(value)) == value


@pytest.mark.parametrize("value", ["1.0\nshell rm -rf x", "x", None, [1.0]])
def test_only_numbers_pass_as_numbers(value):
    with pytest.raises((ValueError, TypeError)):
        format_number(value)


@pytest.mark.parametrize(
    "template",
    [
        "{{ case.__class__ }}",
        "{{ case.title.__class__.__mro__ }}",
        "{{ ''.__class__ }}",
        "{{ needs.__init__.__globals__ }}",
        "{{ case.gas.__dict__ }}",
        "{{ needs.update(gas=false) }}",
        "{{ needs.clear() }}",
    ],
)
def test_templates_cannot_leave_their_context(template):
    case = build()
    needs = find_needs(case)
    with pytest.raises(SecurityError):
        make_environment().from_string(template).render(case=case, needs=needs)
    assert needs == find_needs(case)


@pytest.mark.parametrize(
    "template", ["{{ skni }}", "{{ case.gass }}", "{% if needs.fliter %}x{% endif %}", "{{ x.y }}"]
)
def test_a_name_that_is_not_there_is_an_error(template):
    with pytest.raises(UndefinedError):
        make_environment().from_string(template).render(case=build(), needs=find_needs(build()))


def read_particles(path):
    lines = path.read_text().splitlines()
    start = lines.index("Atoms") + 2
    return lines[:start], np.array([[float(word) for word in line.split()] for line in lines[start:]])


def test_a_run_folder_holds_decks_case_manifest_and_logs(tmp_path):
    case, run = build(), tmp_path / "run"
    set_up(case, run)
    files = {path.relative_to(run).as_posix() for path in run.rglob("*") if path.is_file()}
    decks = render_decks(case)
    assert files == {*decks, "DEM/particles.data", "case.toml", "manifest.json"} and (run / "logs").is_dir()
    assert {name: (run / name).read_text() for name in decks} == decks
    assert load_case(str(run)) == case
    manifest = json.loads((run / "manifest.json").read_text())
    parts = {part.name: part.why for part in explain(case)}
    assert manifest["in"] | manifest["left_out"] == parts and manifest["in"].keys().isdisjoint(manifest["left_out"])
    assert manifest["particles"] == 20
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_particles_are_written_to_the_last_bit(tmp_path):
    positions = np.random.default_rng(1).random((20, 3)) * [0.01, 0.006, 0.02]
    set_up(build(), tmp_path / "run", lambda case: positions)
    head, table = read_particles(tmp_path / "run/DEM/particles.data")
    assert (table[:, 4:] == positions).all()
    assert table[:, 0].tolist() == list(range(1, 21)) and (table[:, 1:4] == [1, 1e-3, 2500.0]).all()
    assert {"20 atoms", "2 atom types", "0.0 0.01 xlo xhi", "0.0 0.006 ylo yhi", "0.0 0.02 zlo zhi"} <= set(head)


def test_start_velocities_are_written_beside_the_positions_and_only_where_there_are_some(tmp_path):
    motion = np.random.default_rng(2).standard_normal((20, 6))
    set_up(build(), tmp_path / "run", read_motion=lambda case: motion)
    atoms, _, rows = (tmp_path / "run/DEM/particles.data").read_text().partition("\nVelocities\n\n")
    table = np.array([[float(word) for word in line.split()] for line in rows.splitlines()])
    assert (table[:, 1:] == motion).all() and table[:, 0].tolist() == list(range(1, 21))
    set_up(build(), tmp_path / "still")
    assert (tmp_path / "still/DEM/particles.data").read_text() == atoms


@pytest.mark.parametrize(("changes", "gone", "there"), [(NO_GAS, "CFD", "DEM"), (NO_PARTICLES, "DEM", "CFD")])
def test_a_phase_that_is_not_there_has_no_folder(tmp_path, changes, gone, there):
    set_up(build(**changes), tmp_path / "run")
    assert (tmp_path / "run" / there).is_dir() and not (tmp_path / "run" / gone).exists()


def test_an_earlier_set_up_is_replaced_and_leaves_nothing_behind(tmp_path):
    run = tmp_path / "run"
    set_up(build(), run)
    set_up(build(**NO_GAS), run)
    assert not (run / "CFD").exists() and load_case(str(run)).gas is None
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_an_empty_folder_is_taken(tmp_path):
    (tmp_path / "run").mkdir()
    set_up(build(), tmp_path / "run")
    assert (tmp_path / "run/manifest.json").is_file()


@pytest.mark.parametrize("foreign", ["a file in it", "a file itself", "results"])
def test_what_is_not_ours_to_replace_is_refused_and_kept(tmp_path, foreign):
    run, words = tmp_path / "run", "not a run folder"
    if foreign == "a file itself":
        kept = run
    else:
        kept, words = (run / "thesis.tex", words) if foreign == "a file in it" else (run / "results.nc", r"results\.nc")
        set_up(build(), run)
        (run / "manifest.json").unlink(missing_ok=foreign == "results")
    kept.write_text("years of work")
    with pytest.raises(CaseError, match=words):
        set_up(build(), run)
    assert kept.read_text() == "years of work" and [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.fixture
def broken_template(tmp_path, monkeypatch):
    """The templates with an undefined name in one of the last to be rendered."""
    templates = tmp_path / "templates"
    shutil.copytree(render.TEMPLATES, templates)
    with (templates / "liggghts/in.liggghts").open("a") as file:
        file.write("{{ not_there }}\n")
    monkeypatch.setattr(render, "TEMPLATES", templates)


def test_when_rendering_fails_nothing_is_written(tmp_path, broken_template):
    with pytest.raises(UndefinedError, match="not_there"):
        set_up(build(), tmp_path / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["templates"]


def test_when_rendering_fails_an_earlier_set_up_stays(tmp_path, request):
    run = tmp_path / "run"
    set_up(build(), run)
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    request.getfixturevalue("broken_template")
    with pytest.raises(UndefinedError):
        set_up(build(gas__inlet_velocity=9.0), run)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before


def test_when_positions_fail_an_earlier_set_up_stays(tmp_path):
    run = tmp_path / "run"
    set_up(build(), run)
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}

    def fail(case):
        raise CaseError(["no such positions"])

    with pytest.raises(CaseError, match="no such positions"):
        set_up(build(gas__inlet_velocity=9.0), run, fail)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    set_up(build(), run)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


if __name__ == "__main__":
    shutil.rmtree(GOLDEN, ignore_errors=True)
    for deck, text in render_decks(load_case("patil/c2")).items():
        place = GOLDEN / deck
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)
