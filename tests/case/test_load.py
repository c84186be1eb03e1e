"""Good cases load and survive being written; every mistake is told with its place and how to fix it."""

from __future__ import annotations

import codecs
import shutil
import tomllib
from pathlib import Path

import pytest

from fbcouple.case.checks.contact import HERTZ_KEYS, SPRING_KEYS
from fbcouple.case.companions import list_companions
from fbcouple.case.load import load_case, write_case
from fbcouple.case.schema.reference import list_options, list_sections, list_tables
from fbcouple.case.source import SETS_NAME, STUDIES, VALIDATION_NAME, find_case, list_sets, list_shipped
from fbcouple.errors import CaseError
from fbcouple.paths import CASES

PARTICLE = 'title = "one particle"\nend_time = 1\n[domain]\nsize = [1, 1, 1]\ncells = [4, 4, 4]\n'
PARTICLE += "[particles]\ndiameter = 0.1\ndensity = 1000\ncount = 1\n[start]\n"
PARTICLE += "[contact]\nrestitution = 1\nwall_restitution = 1\nfriction = 0\nwall_friction = 0\n"


def problems_of(name: object, *sets: str) -> list[str]:
    with pytest.raises(CaseError) as caught:
        load_case(str(name), sets)
    for problem in caught.value.problems:
        assert "\n" not in problem and len(problem) < 600
    return caught.value.problems


@pytest.mark.parametrize("name", list_shipped())
def test_shipped_case_loads_and_survives_writing(name, tmp_path, on_a_cluster):
    case, folder = load_case(name), find_case(name).parent
    brought = [shutil.copy(folder / own, tmp_path) for own in list_companions(case)]
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path / "case.toml")) == case
    assert load_case(str(tmp_path)) == case
    assert len(list(tmp_path.iterdir())) == 1 + len(brought)


# Table 3 of Hamidouche et al. 2019: bed mass [kg], U_f [m/s], mu_p, mu_w, cells, and whether there is a sub-grid model.
MIDDLE = (35, 6, 110)
PAPER = {
    "c1": (0.075, 1.20, 0.2, 0.2, (17, 3, 55), True),
    "c2": (0.075, 1.20, 0.2, 0.2, MIDDLE, True),
    "c3": (0.075, 1.20, 0.2, 0.2, (70, 12, 220), True),
    "c4-0.0": (0.075, 1.20, 0.1, 0.0, MIDDLE, True),
    "c4-0.1": (0.075, 1.20, 0.1, 0.1, MIDDLE, True),
    "c4-0.2": (0.075, 1.20, 0.1, 0.2, MIDDLE, True),
    "c4-0.4": (0.075, 1.20, 0.1, 0.4, MIDDLE, True),
    "c5-0.0": (0.075, 1.20, 0.0, 0.1, MIDDLE, True),
    "c5-0.1": (0.075, 1.20, 0.1, 0.1, MIDDLE, True),
    "c5-0.2": (0.075, 1.20, 0.2, 0.1, MIDDLE, True),
    "c5-0.4": (0.075, 1.20, 0.4, 0.1, MIDDLE, True),
    "c6": (0.075, 1.71, 0.1, 0.1, MIDDLE, True),
    "c7": (0.125, 1.54, 0.1, 0.1, MIDDLE, True),
    "a1": (0.075, 1.71, 0.1, 0.1, MIDDLE, False),
}


@pytest.mark.parametrize("name", PAPER)
def test_case_of_the_paper_is_as_its_table_says(name):
    case = load_case(f"patil/{name}")
    friction = case.contact.friction, case.contact.wall_friction
    has_model = case.gas.turbulence != "none"
    assert (case.particles.mass, case.gas.inlet_velocity, *friction, case.domain.cells, has_model) == PAPER[name]
    assert (case.domain.size, case.end_time) == ((0.08, 0.015, 0.25), 20.0)
    assert case.contact.restitution == case.contact.wall_restitution == 0.97
    assert name.upper().split("-")[0] in case.title


def test_set_of_all_is_the_table():
    assert list_sets()["patil/all"] == [f"patil/{name}" for name in PAPER]


@pytest.mark.parametrize("name", list_sets())
def test_set_has_shipped_members_once(name):
    members = list_sets()[name]
    assert len(set(members)) == len(members) and set(members) <= set(list_shipped())


def test_shipped_cases_have_a_readme_and_one_name_each():
    files = [
        path
        for path in CASES.glob("**/*.toml")
        if path.name not in (SETS_NAME, VALIDATION_NAME) and STUDIES not in path.relative_to(CASES).parts
    ]
    assert len(list_shipped()) == len(files)
    for path in list_shipped().values():
        readmes = [folder / "README.md" for folder in (path.parent, path.parent.parent) if folder != CASES]
        assert any(readme.is_file() for readme in readmes), path


@pytest.mark.parametrize(
    ("name", "base", "sets"),
    [
        ("c2-slip", "c2", ["gas.walls=slip"]),
        ("c3-slip", "c3", ["gas.walls=slip"]),
        ("a1", "c6", ["gas.turbulence=none"]),
        ("paper-numerics/c1", "c1", ["accuracy=none", "contact.restitution=1", "contact.wall_restitution=1"]),
        ("paper-numerics/c5-0.0", "c5-0.0", ["accuracy=none", "contact.restitution=1", "contact.wall_restitution=1"]),
    ],
)
def test_variant_differs_from_its_base_in_nothing_else(name, base, sets):
    variant, plain = load_case(f"patil/{name}").model_dump(), load_case(f"patil/{base}", sets).model_dump()
    for left_out in sets:
        others = [setting for setting in sets if setting != left_out]
        assert load_case(f"patil/{base}", others).model_dump() != plain, left_out
    plain["title"] = variant["title"]
    assert variant == plain


def test_own_file_on_a_shipped_base(tmp_path):
    (tmp_path / "case.toml").write_text('base = "patil/c7"\nend_time = 3\n[particles]\ndensity = 2000\n')
    case = load_case(str(tmp_path), ["gas.walls=slip"])
    assert (case.end_time, case.particles.density, case.particles.mass) == (3.0, 2000.0, 0.125)
    assert (case.gas.inlet_velocity, case.gas.walls) == (1.54, "slip")
    write_case(case, tmp_path / "case.toml")
    assert "base" not in tomllib.loads((tmp_path / "case.toml").read_text())
    assert load_case(str(tmp_path)) == case


def test_mistake_in_what_stands_on_a_base(tmp_path):
    (tmp_path / "case.toml").write_text('base = "patil/c2"\ngas = 3\n[contact]\nfrction = 0.1\n')
    problems = problems_of(tmp_path)
    assert len(problems) == 2 and all(problem.startswith(f"{tmp_path}/case.toml: ") for problem in problems)
    assert "gas: 3 is given, a section is allowed" in problems[0] and "did you mean `friction`" in problems[1]


def list_table_keys():
    """Options of tables in lists, of which a case has none unless it says so."""
    return [key for key in list_options() for table in list_tables() if key.startswith(f"{table}.")]


def test_tables_survive_writing_and_say_what_is_wrong_in_them(tmp_path):
    box = "low=[0.0,0.0,0.2],high=[0.044,0.01,0.22]"
    feeds = f"[{{{box},rate=5.0}},{{{box},mass_flow=1e-3,velocity=[0.0,0.0,-1.0]}}]"
    case = load_case("patil/c2", [f"particles.feeds={feeds}"])
    assert [feed.rate for feed in case.particles.feeds] == [5.0, None]
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case
    problems = problems_of("patil/c2", f"particles.feeds=[{{{box},rat=5.0}}]", "gas.viscosity=-1")
    assert any("particles.feeds.rat: [[particles.feeds]] has no such key" in p and "`rate`" in p for p in problems)
    assert any("gas.viscosity" in p for p in problems) and len(problems) == 2
    (problem,) = problems_of("patil/c2", "particles.feeds=[{low=[0.0,0.0,0.2],rate=5.0}]")
    assert "add `high = ...` under [[particles.feeds]]" in problem
    (problem,) = problems_of("patil/c2", f"particles.feeds=[{{{box},rate=5.0,species='a'}}]")
    assert 'particles.feeds.species: [[particles.feeds]] 1: "a" is given, a whole number' in problem


def test_written_case_says_every_default(tmp_path):
    write_case(load_case("patil/c1"), tmp_path / "case.toml")
    written = tomllib.loads((tmp_path / "case.toml").read_text())
    given = {f"{section}.{key}" for section, table in written.items() if isinstance(table, dict) for key in table}
    given |= {key for key, value in written.items() if not isinstance(value, dict)}
    unset = {"particles.count", "particles.positions", "exchange.drag_file", "gas.inlet_ramp", "gas.max_step"}
    unset |= {
        "output.task_file",
        "checkpoint.every",
        "exchange.kernel_width",
        "exchange.diffusion_width",
        "exchange.accelerated",
    }
    unset |= {"averages.error_of"}
    unset |= {key for key in list_options() if key.startswith("heat.")}  # a section that the case does not have
    unset |= {f"domain.{key}" for key in ("elements", "mesh", "scale", "inlet", "outlet")}
    unset |= {f"particles.{key}" for key in ("spread", "deviation", "smallest", "largest")}
    unset |= {"particles.coarse_graining", "particles.parcels"}
    unset |= {f"particles.positions_{key}" for key in ("step", "seed")}
    unset |= {*(f"start.{key}" for key in ("rest_speed", "restart", "run", "time"))}
    unset |= {f"contact.{key}" for key in (*HERTZ_KEYS, *SPRING_KEYS, "max_overlap", "skin")}
    unset |= {"gas.closed_nozzle_size", "gas.inlet_section", "start.region", *list_table_keys()}
    assert set(list_options()) - given == unset


def test_floats_survive_writing_to_the_last_bit(tmp_path):
    case = load_case("patil/c2", ["gas.viscosity=1.8369999999999997e-5", "end_time=0.1e2", "gas.density=0.1"])
    write_case(case, tmp_path / "case.toml")
    read = load_case(str(tmp_path))
    assert read.gas.viscosity == 1.8369999999999997e-5
    assert read == case


def test_awkward_title_survives_writing(tmp_path):
    case = load_case("patil/c2", ["title='quote \" backslash \\ # ü 粒 [x]'"])
    assert case.title == 'quote " backslash \\ # ü 粒 [x]'
    write_case(case, tmp_path / "case.toml")
    assert load_case(str(tmp_path)) == case


def test_integers_are_fine_for_floats_and_arrays_for_tuples(tmp_path):
    (tmp_path / "case.toml").write_text(PARTICLE)
    case = load_case(str(tmp_path))
    assert case.domain.size == (1.0, 1.0, 1.0)
    assert isinstance(case.particles.density, float)
    assert case.gas is None and case.exchange is None


def test_settings_go_on_top():
    sets = ["particles.mass=0.125", "gas.inlet_velocity=1.54", "gas.walls=slip", "exchange.drag=huilin-gidaspow"]
    case = load_case("patil/c2", [*sets, "domain.cells=[17, 4, 56]", "gas.closed_nozzle=[3,2]", "title=a b c"])
    assert (case.particles.mass, case.gas.inlet_velocity, case.gas.walls) == (0.125, 1.54, "slip")
    assert case.domain.cells == (17, 4, 56) and case.gas.closed_nozzle == (3, 2) and case.title == "a b c"


def write_with_ramp(folder, ramp):
    text = (CASES / "patil/c2/case.toml").read_text()
    (folder / "case.toml").write_text(text.replace("inlet_velocity = 1.2", f"inlet_ramp = {ramp}"))


def test_a_ramp_is_read_and_written(tmp_path):
    text = (
        (CASES / "patil/c2/case.toml").read_text().replace("inlet_velocity = 1.2", "inlet_ramp = [[0, 1], [2.0, -0.5]]")
    )
    (tmp_path / "case.toml").write_text(text)
    case = load_case(str(tmp_path))
    assert case.gas.inlet_ramp == ((0.0, 1.0), (2.0, -0.5)) and case.gas.inlet_velocity is None
    write_case(case, tmp_path / "again.toml")
    assert load_case(str(tmp_path / "again.toml")) == case


@pytest.mark.parametrize("ramp", ["[]", "[[0, 1], [1]]", "[[-1, 1]]", "[0, 1]", "3", "[[0, nan]]", '[[0, "1"]]'])
def test_a_ramp_that_is_none_is_refused_with_what_is_allowed(tmp_path, ramp):
    write_with_ramp(tmp_path, ramp)
    (problem,) = problems_of(str(tmp_path))
    assert "gas.inlet_ramp" in problem
    assert "a list of rows, each of a number at least 0 and a number at least -10000 and at most 10000" in problem


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("gas.densty=1.2", ["--set: gas.densty", "did you mean `density`"]),
        ("particels.mass=1", ["--set: particels", "did you mean `particles`"]),
        ("diameter=1e-3", ["--set: diameter", "did you mean `particles.diameter`"]),
        ("gas.density", ["--set:", "gas.density", "write key=value"]),
        ("gas..density=1", ["--set:", "write key=value"]),
        ("a.b.c=1", ["--set:", "write key=value"]),
        ("gas.density=", ["--set: gas.density", "no value"]),
        ("title.x=1", ["--set: title", "not a section"]),
        ("domain.cells=20,4,80", ["--set: domain.cells", "write a list in square brackets: [20,4,80]"]),
        ("domain.size=0.1 0.02 0.3", ["--set: domain.size", "write a list in square brackets: [0.1,0.02,0.3]"]),
        ("gas.density=1.2 kg", ["--set: gas.density", '"1.2 kg"', "above 0", "without quotes or unit"]),
        ("gas.density=true", ["--set: gas.density: true is given"]),
        ("gas.density=nan", ["--set: gas.density: nan is given"]),
        ("gas.density=inf", ["--set: gas.density: inf is given"]),
        ("gas.correctors=2.0", ["--set: gas.correctors: 2.0 is given, a whole number"]),
        ("gas.walls=no_slip", ["--set: gas.walls", 'did you mean "no-slip"']),
        ("gas=3", ["--set: gas: 3 is given, a section is allowed"]),
        ("domain.size=[1, 2]", ["--set: domain.size: [1, 2] is given, a list of 3 values"]),
        ("domain.size=[1, 2, 3, 4]", ["--set: domain.size: [1, 2, 3, 4] is given, a list of 3 values"]),
        ("domain.size=[1, 2, -3]", ["--set: domain.size: [1, 2, -3] is given", "above 0"]),
        ("domain.periodic=['z']", ['--set: domain.periodic: ["z"] is given, a list, each entry "x" or "y" is allowed']),
        ("domain.periodic=x", ['--set: domain.periodic: "x" is given, a list, each entry "x" or "y" is allowed']),
        ("domain.cells=[35, 6, 110.0]", ["--set: domain.cells: [35, 6, 110.0] is given", "whole number"]),
        ("title=\udcff", ["--set:", "not UTF-8"]),
        ("title='a\\tb\u2028'", ["--set: title", "one line"]),
    ],
)
def test_setting_that_is_wrong(setting, words):
    (problem,) = problems_of("patil/c2", setting)
    for word in words:
        assert word in problem


def test_setting_cannot_smuggle_in_another_key():
    (problem,) = problems_of("patil/c2", "gas.density=1.0\ntitle='x'")
    assert "gas.density" in problem and "number" in problem


def test_unknown_shipped_name_is_suggested():
    (problem,) = problems_of("patil/c22")
    assert "did you mean `patil/c2`" in problem and "fbcouple cases" in problem


def test_mistake_in_a_shipped_file_names_it(monkeypatch, tmp_path):
    monkeypatch.setattr("fbcouple.paths.CASES", tmp_path)
    (tmp_path / "bed").mkdir()
    (tmp_path / "bed/deep.toml").write_text("end_time = 1\n")
    assert all(problem.startswith("bed/deep.toml: ") for problem in problems_of("bed/deep"))


def test_set_is_no_case():
    (problem,) = problems_of("patil/all")
    assert "is a set of cases" in problem


def test_name_does_not_leave_the_shipped_cases():
    (problem,) = problems_of("../cases/patil/nowhere")
    assert "neither a shipped case nor a file" in problem


@pytest.mark.parametrize("name", ["no/such.toml", "x" * 5000, "nul\0byte", "\udcff", "/dev/zero", "/"])
def test_name_that_is_no_case(name):
    (problem,) = problems_of(name)
    assert "case" in problem


def test_folder_without_case_file(tmp_path):
    (problem,) = problems_of(tmp_path)
    assert "holds no case.toml" in problem


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"title = \n", "case.toml: line 1, column 9: is not TOML"),
        (b"end_time = 1\n" + b"x" * 200 + b" = 1 2\n", "line 2, column 206: is not TOML"),
        (b"title = 'x'\nend_time = 1,25\n", "line 2, column 13"),
        (b"end_time = -1,2e-3\n", "-1,2e-3 has a decimal comma; write a decimal point: -1.2e-3."),
        (b"[domain]\nsize = [0,02, 0,02, 0,06]\n", "line 2, column 12"),
        (b"[domain]\nsize = [0,02, 0,02, 0,06]\n", "0,02 has a decimal comma; write a decimal point: 0.02."),
        (b"[domain]\nsize = [1,2, 1,2, 1,6]\n", "[1, 2, 1, 2, 1, 6] is given"),
        (b"[domain]\nsize = [1,2, 1,2, 1,6]\n", "a comma parts two numbers, so write decimal points"),
        (b'end_time = "1,2"', "write a decimal point: 1.2"),
        (b'title = "never closed', "end of document: is not TOML"),
        (b"[domain]\ncells = [1, 2\n\n[gas]\ndensity = 1\n", "close the bracket or the quotes that a line before"),
        ("title = 'x'".encode("utf-16"), "case.toml: is UTF-16 text; save the file as UTF-8"),
        (b"title = 'x'\n# \xfc\n", "case.toml: line 2: is not UTF-8 text (byte 0xFC)"),
        (b"a = 1\na = 2\n", "given twice"),
        (b"[gas]\n[gas]\n", "given twice"),
        (b'title = "\xff"', "not UTF-8"),
        (b"a = " + b"[" * 100_000, "nested too deeply"),
        (b"end_time = " + b"9" * 5000, "cannot be read"),
        (b'title = "' + b"x" * 4_900_000 + b'"\n', "4900000 characters"),
        (b"end_time = 0x" + b"f" * 10_000, "40000 bits"),
        (b'end_time = "' + b"x" * 4_900_000 + b'"\n', "4900000 characters"),
        (b"end_time = " + b"[" * 100 + b"]" * 100, "[[[[...]]]] is given"),
        (b'"a\\nb\\u001b[31m" = 1', '"a\\nb\\u001b[31m": a case file has no such key'),
        (b"end_time = 2024-01-01", "2024-01-01 is given"),
        (b"[[gas]]", "a section is allowed"),
        (b"", "domain: the section is missing"),
    ],
)
def test_file_that_is_no_case(tmp_path, content, words):
    (tmp_path / "case.toml").write_bytes(content)
    assert words in "\n".join(problems_of(tmp_path))


def test_byte_order_mark_is_no_part_of_the_case(tmp_path):
    """As some editors write it in front of a file."""
    (tmp_path / "case.toml").write_bytes(PARTICLE.encode())
    without = load_case(str(tmp_path))
    (tmp_path / "case.toml").write_bytes(codecs.BOM_UTF8 + PARTICLE.encode())
    assert load_case(str(tmp_path)) == without


def test_unreadable_file(tmp_path, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied")

    (tmp_path / "case.toml").touch()
    monkeypatch.setattr(Path, "read_bytes", refuse)
    (problem,) = problems_of(tmp_path)
    assert "Permission denied" in problem and "check the path" in problem


def test_several_mistakes_are_told_at_once(spoil):
    path = spoil(
        ("diameter = 1e-3", "diameter = -1e-3"),
        ("[exchange]", '[exchange]\ndrag = "huilin"'),
        ("viscosity", "viscosty"),
        ("end_time = 20.0", "end_time = 0.5"),
        ("closed_nozzle = [5, 4]", "closed_nozzle = [4, 4]"),
        ("friction = 0.2\nwall_friction = 0.2", "friction = 0.2"),
    )
    problems = problems_of(path, "gas.walls=3")
    keys = [problem.removeprefix(f"{path}: ").split(":")[0] for problem in problems if not problem.startswith("--set")]
    assert sorted(keys) == [
        "averages.start",
        "contact.wall_friction",
        "exchange.drag",
        "gas.closed_nozzle",
        "gas.viscosty",
        "particles.diameter",
    ]
    assert [problem for problem in problems if problem.startswith("--set: gas.walls: 3 is given")]
    assert len(problems) == 7


def test_spoiled_key_of_each_option_is_named():
    """No option is exempt: a table in its place is refused, and the text names key, kind and given value."""
    for key, option in list_options().items():
        setting, place = f"{key}={{a=1}}", ""
        if key in list_table_keys():
            table, _, name = key.rpartition(".")
            setting, place = f"{table}=[{{{name}={{a=1}}}}]", f"[[{table}]] 1: "
        problems = problems_of("patil/c2", setting)
        assert [p for p in problems if p.startswith(f"--set: {key}: {place}a table is given, {option.allowed}")], (
            problems
        )


@pytest.mark.parametrize("section", [name for name in list_sections() if name])
def test_section_that_is_no_table_or_misspelt_is_told_once(section, spoil):
    (problem,) = problems_of("patil/c2", f"{section}=1")
    assert problem.startswith(f"--set: {section}: 1 is given, a section is allowed")
    if section not in ("output", "checkpoint", "monitors", "heat"):
        (problem,) = problems_of(spoil((f"[{section}]", f"[{section}x]")))
        assert f"case.toml: {section}x: a case file has no such key" in problem


@pytest.mark.parametrize("key", [key for key, option in list_options().items() if "number" in option.allowed])
@pytest.mark.parametrize("value", ["1e308", "5e-324", "-1e308", "9999999999999999999999", "0", "-1"])
def test_extreme_numbers_never_raise_anything_else(key, value):
    try:
        load_case("patil/c2", [f"{key}={value}"])
    except CaseError as error:
        assert error.problems
