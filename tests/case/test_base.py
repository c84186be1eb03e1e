"""Cases on top of cases: bases by name and by path, and what is unset."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fbcouple.case.load import load_case
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.paths import CASES


def problems_of(name: object, *sets: str) -> list[str]:
    with pytest.raises(CaseError) as caught:
        load_case(str(name), sets)
    return caught.value.problems


@pytest.fixture
def common(tmp_path: Path) -> Path:
    """A case of one's own, in a folder above those of its variants."""
    path = tmp_path / "common.toml"
    path.write_text((CASES / "patil/c2/case.toml").read_text())
    (tmp_path / "beds/wide").mkdir(parents=True)
    (tmp_path / "beds/beside").mkdir(parents=True)
    (tmp_path / "beds/beside/case.toml").write_text(path.read_text())
    return path


@pytest.mark.parametrize(
    ("variant", "base"),
    [
        ("case.toml", "common.toml"),
        ("beds/case.toml", "../common.toml"),
        ("beds/wide/v.toml", "../../common.toml"),
        ("beds/wide/w.toml", "../beside/case.toml"),
        ("v.toml", "beds/beside/case.toml"),
    ],
)
def test_base_is_a_case_of_ones_own(common, tmp_path, variant, base):
    (tmp_path / variant).write_text(f'base = "{base}"\ntitle = "mine"\n[particles]\ndensity = 2000\n')
    mine, its = load_case(str(tmp_path / variant)).model_dump(), load_case(str(common)).model_dump()
    assert (mine["title"], mine["particles"].pop("density")) == ("mine", 2000)
    assert its["particles"].pop("density") == 2500
    assert mine["contact"].pop("stiffness") == pytest.approx(0.8 * its["contact"].pop("stiffness"), rel=0.01)
    assert mine | {"title": ""} == its | {"title": ""}


def test_bases_stand_on_each_other(common, tmp_path):
    (tmp_path / "beds/slip.toml").write_text('base = "../common.toml"\nend_time = 3\n[gas]\nwalls = "slip"\n')
    (tmp_path / "beds/wide/case.toml").write_text('base = "../slip.toml"\n[gas]\ninlet_velocity = 1.5\n')
    case = load_case(str(tmp_path / "beds/wide"))
    assert (case.end_time, case.gas.walls, case.gas.inlet_velocity, case.gas.density) == (3.0, "slip", 1.5, 1.165)


def test_files_that_a_base_brings_come_from_its_folder(tmp_path):
    """Of a shipped base, of one of one's own in another folder, and the nearest where several have the name."""
    (tmp_path / "below/mine").mkdir(parents=True)
    (tmp_path / "below/case.toml").write_text('base = "single-impact"\n')
    (tmp_path / "below/mine/case.toml").write_text('base = "../case.toml"\ntitle = "mine"\n')
    for name in ("below", "below/mine"):
        (run,) = lay_out(str(tmp_path / name), tmp_path / name / "run", [], trusted=False, forced=True)
        assert (run / "bead.csv").read_bytes() == (CASES / "single-impact/bead.csv").read_bytes()
    table = (CASES / "single-impact/bead.csv").read_text()
    (tmp_path / "below/bead.csv").write_text(f"# ours\n{table}")
    (run,) = lay_out(str(tmp_path / "below/mine"), tmp_path / "second", [], trusted=False, forced=True)
    assert (run / "bead.csv").read_text().startswith("# ours")


def test_base_of_ones_own_stands_on_a_shipped_one(tmp_path):
    (tmp_path / "a.toml").write_text('base = "patil/c2"\nend_time = 4\n')
    (tmp_path / "b.toml").write_text('base = "a.toml"\ntitle = "b"\n')
    case = load_case(str(tmp_path / "b.toml"))
    assert (case.end_time, case.title, case.particles.mass) == (4.0, "b", 0.075)


@pytest.mark.parametrize(
    ("base", "words"),
    [
        ('"patil/c22"', "did you mean `patil/c2`"),
        ('"../../secret"', "the name of a shipped case, or the relative path of a .toml file"),
        ("3", "3 is given, the name of a shipped case, or the relative path"),
        ('["patil/c2"]', "`fbcouple cases` lists the shipped cases"),
        ('"/etc/pyproject.toml"', "in or beside the folder of this file or above it, is allowed"),
        ('"../../elsewhere/v.toml"', "in or beside the folder of this file or above it, is allowed"),
        ('"../elsewhere/v.toml"', "cannot be read: No such file or directory"),
        ('"none.toml"', "cannot be read: No such file or directory"),
        ('"folder.toml"', "is not a plain file"),
        ('"link.toml"', "is a link that leads out of its folder"),
    ],
)
def test_base_that_is_none(common, tmp_path, base, words):
    folder = tmp_path / "beds/mine"
    (folder / "folder.toml").mkdir(parents=True)
    (folder / "link.toml").symlink_to(common)
    (folder / "case.toml").write_text(f"base = {base}\n")
    (problem,) = problems_of(folder)
    assert problem.startswith(f"{folder}/case.toml: base: ") and words in problem


def test_bases_in_a_circle_are_an_error(tmp_path, monkeypatch):
    (tmp_path / "a.toml").write_text('base = "b.toml"\n')
    (tmp_path / "b.toml").write_text('base = "a.toml"\n')
    monkeypatch.chdir(tmp_path)
    (problem,) = problems_of("a.toml")
    assert problem.startswith("b.toml: base: ") and "in a circle (a.toml -> b.toml -> a.toml)" in problem
    (tmp_path / "a.toml").write_text('base = "a.toml"\n')
    assert "in a circle (a.toml -> a.toml)" in problems_of("a.toml")[0]


def test_too_many_bases_are_an_error(tmp_path):
    for number in range(8):
        (tmp_path / f"{number}.toml").write_text(f'base = "{number + 1}.toml"\n')
    (problem,) = problems_of(tmp_path / "0.toml")
    assert "more than 5 cases stand on each other" in problem


def test_mistake_in_a_base_names_its_file(tmp_path):
    (tmp_path / "beds").mkdir()
    (tmp_path / "common.toml").write_text("end_time = 1,5\n")
    (tmp_path / "beds/case.toml").write_text('base = "../common.toml"\n')
    (problem,) = problems_of(tmp_path / "beds")
    assert problem.startswith(f"{tmp_path}/common.toml: line 1") and "1,5 has a decimal comma" in problem


def write_unset(folder: Path, unset: str, more: str = "") -> Path:
    (folder / "case.toml").write_text(f'base = "patil/c2"\nunset = {unset}\n{more}')
    return folder


def test_unset_takes_inherited_keys_and_sections_away(tmp_path):
    case = load_case(str(write_unset(tmp_path, '["gas.closed_nozzle", "averages", "accuracy"]')))
    assert case.gas.closed_nozzle is None and case.averages is None and case.accuracy == "none"
    assert load_case("patil/c2").gas.closed_nozzle == (5, 4)


def test_unset_section_is_replaced_as_a_whole(tmp_path):
    case = load_case(str(write_unset(tmp_path, '["output"]', "[output]\ntracked = [1]\n")))
    assert (case.output.tracked, case.output.snapshots_every) == ((1,), None)


@pytest.mark.parametrize(
    ("unset", "words"),
    [
        ('["gas.closed_nozle"]', "did you mean `gas.closed_nozzle`"),
        ('["gas.inlet_ramp"]', '"gas.inlet_ramp" is not set by patil/c2'),
        ('["checkpoint"]', '"checkpoint" is not set by patil/c2'),
        ('"gas.closed_nozzle"', "a list of keys and sections in quotes is allowed"),
        ("[1]", "a list of keys and sections in quotes is allowed"),
    ],
)
def test_unset_that_is_wrong(tmp_path, unset, words):
    (problem,) = problems_of(write_unset(tmp_path, unset))
    assert problem.startswith(f"{tmp_path}/case.toml: unset: ") and words in problem


def test_unset_of_what_the_case_needs_is_missed(tmp_path):
    (problem,) = problems_of(write_unset(tmp_path, '["particles.density"]'))
    assert "particles.density: is missing" in problem


def test_unset_without_a_base(tmp_path):
    (tmp_path / "case.toml").write_text((CASES / "patil/c2/case.toml").read_text().replace("end", "unset = []\nend", 1))
    (problem,) = problems_of(tmp_path)
    assert "unset: is given without `base`" in problem


def test_misspelt_and_misplaced_keys_of_the_file(tmp_path):
    (tmp_path / "case.toml").write_text('base = "patil/c2"\nunsett = []\n')
    assert "did you mean `unset`" in problems_of(tmp_path)[0]
    assert problems_of("patil/c2", "base=patil/c1") == [
        "--set: base: is read from case files alone; write it into one."
    ]


JET = "[[gas.inlets]]\nrectangle = [[0.0, 0.0], [0.01, 0.01]]\nvelocity = 1.0\n"


@pytest.mark.parametrize(
    ("base", "text", "keys"),
    [
        ("patil/c2", JET, ["gas.inlet_velocity", "gas.closed_nozzle"]),
        ("patil/c2", "[gas]\ninlet_ramp = [[0.0, 0.0], [0.05, 1.0]]\n", ["gas.inlet_velocity"]),
        ("patil/c2", "[particles]\ncount = 1000\n", ["particles.mass"]),
        ("patil/c2", "[gas]\nclosed_nozzle_size = [0.004, 0.004]\n", ["gas.closed_nozzle"]),
        ("mueller/0.9", "[contact]\nmax_overlap = 0.01\n", ["contact.stiffness"]),
        ("patil/heat-1.20", "[heat]\ngas_conductivity = 0.026\n", ["heat.prandtl"]),
        ("mueller/0.9", '[particles]\npositions = "bed.csv"\n', ["start"]),
    ],
)
def test_both_that_say_the_same_are_told_by_what_the_base_brought(tmp_path, base, text, keys):
    (tmp_path / "bed.csv").write_text("x,y,z\n0.01,0.005,0.01\n")
    (tmp_path / "case.toml").write_text(f'base = "{base}"\n{text}')
    told = problems_of(tmp_path)
    for key in keys:
        assert [problem for problem in told if f'unset = ["{key}"]' in problem], told
    unset = f"unset = {json.dumps(keys)}\n"
    (tmp_path / "case.toml").write_text(f'base = "{base}"\n{unset}{text}')
    if keys != ["start"]:  # whose file of one particle is another bed
        load_case(str(tmp_path))


def test_both_in_one_file_name_no_base(tmp_path):
    text = 'base = "patil/c2"\nunset = ["particles.mass"]\n[particles]\nmass = 0.075\ncount = 1000\n'
    (tmp_path / "case.toml").write_text(text)
    assert problems_of(tmp_path) == [
        f"{tmp_path}/case.toml: particles.mass: mass and count are both given; remove one."
    ]


RAMP = ((0.0, 0.0), (0.05, 1.0))


@pytest.mark.parametrize(
    ("sets", "section", "values"),
    [
        (["gas.inlet_ramp=[[0, 0], [0.05, 1]]"], "gas", {"inlet_velocity": None, "inlet_ramp": RAMP}),
        (["particles.count=1000"], "particles", {"mass": None, "count": 1000}),
        (["gas.closed_nozzle_size=[0.004, 0.004]"], "gas", {"closed_nozzle": None}),
        (["gas.inlets=[]"], "gas", {"inlet_velocity": 1.2}),
    ],
)
def test_a_setting_goes_on_top_of_what_says_the_same(sets, section, values):
    found = getattr(load_case("patil/c2", sets), section)
    assert {key: getattr(found, key) for key in values} == values


def test_tables_go_on_top_of_a_velocity_and_not_the_other_way_round(tmp_path):
    (tmp_path / "case.toml").write_text('base = "patil/c2"\nunset = ["gas.closed_nozzle"]\n')
    table = "gas.inlets=[{rectangle = [[0.0, 0.0], [0.01, 0.01]], velocity = 1.0}]"
    gas = load_case(str(tmp_path), [table]).gas
    assert (gas.inlet_velocity, len(gas.inlets)) == (None, 1)
    (tmp_path / "case.toml").write_text(
        f'base = "patil/c2"\nunset = ["gas.inlet_velocity", "gas.closed_nozzle"]\n{JET}'
    )
    for key, value in (("inlet_velocity", "1"), ("inlet_ramp", "[[0, 1]]")):
        (problem,) = problems_of(tmp_path, f"gas.{key}={value}")
        assert problem.startswith(f"--set: gas.{key}: is given for the whole floor and the case has [[gas.inlets]]")
    gas = load_case(str(tmp_path), ["gas.inlet_velocity=1", "gas.inlets=[]"]).gas
    assert (gas.inlet_velocity, gas.inlets) == (1.0, ())
