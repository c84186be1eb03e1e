"""`fbcouple options`: every option of the schema, and the JSON schema for editors."""

from __future__ import annotations

import json
import tomllib

import pytest
from cli.schema_validator import list_errors
from click.testing import CliRunner

from fbcouple.case.base import read_case
from fbcouple.case.schema.reference import FILE_KEYS, list_options, list_sections
from fbcouple.case.schema.sections import LAWS
from fbcouple.case.source import STUDIES, list_shipped
from fbcouple.case.user_code import OWN
from fbcouple.cli.main import cli
from fbcouple.paths import CASES


def ask(*arguments: str, code: int = 0) -> str:
    result = CliRunner().invoke(cli, ["options", *arguments])
    assert result.exit_code == code, result.output
    return result.stderr if code else result.stdout


SCHEMA = json.loads(ask("--schema"))


def test_every_option_is_listed():
    found = {option["key"]: option for option in json.loads(ask("--json"))}
    assert list(found) == [*FILE_KEYS, *list_options()]
    assert all(option["sentence"].endswith((".", ")", "].")) and option["allowed"] for option in found.values())
    assert found["gas.viscosity"] == {
        "key": "gas.viscosity",
        "allowed": "a number above 0",
        "unit": "Pa s",
        "default": None,
        "required": True,
        "sentence": "Dynamic viscosity.",
    }
    page = ask()
    assert [key for key in found if key not in page] == []


@pytest.mark.parametrize("section", [name for name in list_sections() if name])
def test_section_is_listed_alone(section):
    keys = [option["key"] for option in json.loads(ask(section, "--json"))]
    assert keys == [key for key in list_options() if key.startswith(f"{section}.")]


def test_keys_are_found_by_their_last_part():
    assert [option["key"] for option in json.loads(ask("density", "--json"))] == ["gas.density", "particles.density"]
    assert "kg m-3" in ask("gas.density") and "particles" not in ask("gas.density")


@pytest.mark.parametrize(
    ("given", "meant"), [("gas.densty", "gas.density"), ("particels", "particles"), ("spacng", "spacing")]
)
def test_wrong_name_gets_a_suggestion(given, meant):
    assert ask(given, code=1) == f'"{given}": no section or key of a case file; did you mean `{meant}`.\n'


def test_every_drag_law_is_named_to_lists_and_editors():
    from fbcouple.case.user_laws import DRAG_LAWS  # noqa: PLC0415

    assert list(DRAG_LAWS) == list(LAWS)
    assert SCHEMA["properties"]["exchange"]["properties"]["drag"]["enum"] == [*LAWS, OWN]
    assert all(f'"{name}"' in list_options()["exchange.drag"].allowed for name in (*LAWS, OWN))


def test_schema_is_of_the_whole_file():
    ask("gas", "--schema", code=2)


def list_files():
    return [path for path in CASES.rglob("*.toml") if path.name not in ("sets.toml", "study.toml", "validation.toml")]


@pytest.mark.parametrize("path", list_files(), ids=lambda path: path.relative_to(CASES).as_posix())
def test_cases_fit_the_schema_as_they_are_and_with_their_base(path):
    assert list(list_errors(tomllib.loads(path.read_text()), SCHEMA)) == []
    assert list(list_errors(read_case(path, path.name)[0], SCHEMA)) == []


def test_all_shipped_cases_are_among_them():
    assert set(list_shipped().values()) <= set(list_files())
    assert any(STUDIES in path.parts for path in list_files())


def spoil(section: str, **keys):
    case, _ = read_case(CASES / "patil/c2/case.toml", "c2")
    (case[section] if section else case).update(keys)
    return case


@pytest.mark.parametrize(
    ("case", "error"),
    [
        (spoil("gas", densty=1.0), "file.gas: additionalProperties ['densty']"),
        (spoil("", gass={}), "file: additionalProperties ['gass']"),
        (spoil("gas", density="1.2"), "file.gas.density: type"),
        (spoil("gas", density=0), "file.gas.density: exclusiveMinimum"),
        (spoil("gas", walls="moving"), "file.gas.walls: enum"),
        (spoil("exchange", drag="ergn"), "file.exchange.drag: enum"),
        (spoil("gas", closed_nozzle=[1]), "file.gas.closed_nozzle: minItems"),
        (spoil("domain", cells=[1, 2, 3.5]), "file.domain.cells[2]: type"),
        (spoil("particles", rotation=1), "file.particles.rotation: type"),
        (spoil("averages", start="soon"), "file.averages.start: anyOf"),
        (spoil("averages", start=-1.0), "file.averages.start: anyOf"),
        (spoil("", averages={}), "file.averages: required ['start']"),
        ({"title": "t", "end_time": 1}, "file: required ['domain']"),
        ({"base": "patil/c2", "unset": ["gas.closed_nozle"]}, "file.unset[0]: enum"),
    ],
)
def test_mistakes_do_not_fit_the_schema(case, error):
    assert list(list_errors(case, SCHEMA)) == [error]


def test_a_time_may_be_a_number_or_a_word():
    assert list(list_errors(spoil("averages", start="auto"), SCHEMA)) == []
    assert list_options()["averages.start"].allowed == 'a number at least 0 or "auto"'


def test_schema_has_every_option_with_its_unit():
    properties = SCHEMA["properties"]
    for key, option in list_options().items():
        section, *table, name = ["", *key.split(".")][-max(2, key.count(".") + 1) :]
        held = properties[section]["properties"] if section else properties
        rules = (held[table[0]]["items"]["properties"] if table else held)[name]
        assert rules["description"].startswith(option.sentence)
        assert (f"[{option.unit}]" in rules["description"]) is (option.unit != "1")
        assert "null" not in json.dumps(rules)
