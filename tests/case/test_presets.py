"""Presets of accuracy: they fill what the case leaves out, and everything can be seen and overruled."""

from __future__ import annotations

import json

import pytest

from fbcouple.case.load import load_case, write_case
from fbcouple.case.presets import PRESETS
from fbcouple.case.schema.reference import list_options
from fbcouple.decks.needs import find_needs
from fbcouple.errors import CaseError

FREE = "mueller/0.9"
"""A shipped case that leaves out all that presets set."""


OVERLAP = "contact.max_overlap"


def look_up(case, dotted):
    section, key = dotted.split(".")
    return getattr(getattr(case, section), key)


def test_presets_are_words_of_the_schema_and_set_options_with_defaults():
    assert list_options()["accuracy"].allowed == " or ".join(f'"{name}"' for name in ("none", *PRESETS))
    assert all(not list_options()[key].required for preset in PRESETS.values() for key in preset)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_sets_its_options_and_nothing_else(name):
    plain, preset = load_case(FREE), load_case(FREE, [f"accuracy={name}"])
    taken = {key: value for key, value in PRESETS[name].items() if key != OVERLAP}  # the case has a spring
    assert {key: look_up(preset, key) for key in taken} == taken
    assert load_case(FREE, [f"{key}={value!r}" for key, value in taken.items()]) == plain.model_copy(
        update={"gas": preset.gas, "contact": preset.contact}
    )


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_chooses_the_spring_of_a_case_that_has_none(name):
    case, wanted = load_case("patil/c1", [f"accuracy={name}"]), PRESETS[name][OVERLAP]
    assert case.contact.stiffness == load_case("patil/c1", [f"{OVERLAP}={wanted}", "accuracy=none"]).contact.stiffness
    own = load_case("patil/c1", [f"accuracy={name}", "contact.stiffness=1234"])
    assert own.contact.stiffness == 1234.0


def test_each_preset_is_at_least_as_fine_as_the_one_before():
    draft, standard, reference = PRESETS.values()
    for coarse, fine in ((draft, standard), (standard, reference)):
        assert set(coarse) == set(fine) and coarse != fine
        for key, value in coarse.items():
            finer_is_more = key in ("gas.correctors", "contact.steps_per_contact")
            assert (fine[key] >= value) if finer_is_more else (fine[key] <= value), key


def test_what_the_case_or_the_command_line_says_stays():
    case = load_case(FREE, ["accuracy=draft", "gas.max_courant=0.3"])
    assert case.gas.max_courant == 0.3 and case.gas.pressure_tolerance == PRESETS["draft"]["gas.pressure_tolerance"]


def test_the_file_s_own_values_stay(tmp_path):
    (tmp_path / "case.toml").write_text(f'base = "{FREE}"\naccuracy = "draft"\n[gas]\ncorrectors = 4\n')
    case = load_case(str(tmp_path), ["output.references=[]"])
    assert case.gas.correctors == 4 and case.gas.max_courant == PRESETS["draft"]["gas.max_courant"]


def test_a_section_that_the_case_lacks_stays_out(tmp_path):
    text = 'title = "gas"\nend_time = 1.0\naccuracy = "draft"\n[domain]\nsize = [1.0, 1.0, 1.0]\ncells = [4, 4, 4]\n'
    (tmp_path / "case.toml").write_text(text + "[gas]\ndensity = 1.2\nviscosity = 2e-5\ninlet_velocity = 1.0\n")
    case = load_case(str(tmp_path))
    assert case.contact is None and case.gas.max_courant == PRESETS["draft"]["gas.max_courant"]


def test_a_written_case_reads_back_the_same(tmp_path):
    case = load_case("patil/c2", ["accuracy=reference", "gas.correctors=1"])
    write_case(case, tmp_path / "case.toml")
    text = (tmp_path / "case.toml").read_text()
    assert "max_courant = 0.2" in text and "steps_per_contact = 12" in text
    assert load_case(str(tmp_path)) == case


def test_an_unknown_preset_is_told():
    with pytest.raises(CaseError) as caught:
        load_case(FREE, ["accuracy=standart"])
    (problem,) = caught.value.problems
    assert "accuracy" in problem and 'did you mean "standard"' in problem


def test_setup_explains_what_the_preset_set_and_the_manifest_holds_it(call, tmp_path):
    sets = ("--set", "accuracy=draft", "--set", "gas.correctors=3")
    done = call("setup", FREE, "-o", "run", "--explain", *sets)
    assert done.exit_code == 0 and "preset" in done.output
    why = json.loads((tmp_path / "run/manifest.json").read_text())["in"]["preset"]
    first = "stiffness = 200, by contact.max_overlap = 0.1 unless given, gas.max_courant = 2"
    first += ", gas.max_fourier = 2, gas.pressure_tolerance = 0.0001"
    assert why.startswith(f"accuracy = draft: {first}")
    assert why.endswith("; of the case itself: gas.correctors = 3")
    assert not find_needs(load_case(FREE))["preset"]
