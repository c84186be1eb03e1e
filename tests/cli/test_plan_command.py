"""`fbcouple plan`: a table, JSON, a picture and a case file; exit code 1 where the error is not reached."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from fbcouple.case.load import load_case
from fbcouple.cli.main import cli


@pytest.fixture
def ask(monkeypatch, tmp_path):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "cache"))
    return lambda *arguments: CliRunner().invoke(cli, ["plan", *map(str, arguments)], prog_name="fbcouple")


def test_the_choice_stands_in_the_table_and_in_sentences(ask):
    found = ask("mueller/0.9", "--error", "0.1")
    assert found.exit_code == 0, found.output
    marked = [line for line in found.output.splitlines() if line.rstrip().endswith("chosen")]
    assert len(marked) == 1 and marked[0].startswith("0.1 ")
    for text in ("chosen: draft", "at the latest", "within a factor of 3.5", "not told: ", "bench calibrate"):
        assert text in found.output


def test_json_has_the_numbers(ask):
    found = ask("patil/c1", "--error", "0.1", "--within", "10:00:00", "-n", "4", "--json")
    content = json.loads(found.stdout)
    assert content["within_seconds"] == 36000 and content["ranks"] == 4 and content["quantity"] == "solids_flux"
    one = content["chosen"]
    assert one["error"] == pytest.approx((one["numerical_error"] ** 2 + one["statistical_error"] ** 2) ** 0.5)
    assert one["settings"]["averages.until_error"] > 0.0 and content["front"] and content["curves"]


def test_the_file_is_a_case_and_the_commands_lead_on(ask, tmp_path):
    file = tmp_path / "planned.toml"
    found = ask("patil/c2", "--error", "0.06", "--within", "1:00:00", "-n", "64", "--write", file)
    assert found.exit_code == 0, found.output
    assert load_case(str(file)).averages.until_error is not None
    assert f"fbcouple setup {file} -o runs/planned" in found.output
    assert "--replicas" in found.output and "fbcouple pool runs/planned" in found.output


def test_an_error_out_of_reach_is_exit_code_1_and_tells_the_best(ask, tmp_path):
    found = ask("patil/c2", "--error", "0.05", "-n", "4", "--within", "0:10:00", "--write", tmp_path / "planned.toml")
    assert found.exit_code == 1 and not (tmp_path / "planned.toml").exists()
    assert "patil/c2: an error of 0.05 is not reached within 600 s on 4 ranks; the least error is" in found.stderr
    assert [line for line in found.stdout.splitlines() if line.rstrip().endswith("best")]


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_the_front_is_drawn(ask, tmp_path, ending):
    picture = tmp_path / f"front.{ending}"
    found = ask("mueller/0.9", "--error", "0.1", "--picture", picture)
    assert found.exit_code == 0 and str(picture) in found.output
    if ending == "svg":
        text = picture.read_text()
        assert all(words in text for words in ("mueller/0.9: error of the mean map", "draft, overlap 0.1 d", "chosen"))
    else:
        assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_picture_of_another_format_is_refused(ask, tmp_path):
    found = ask("mueller/0.9", "--error", "0.1", "--picture", tmp_path / "front.bmp")
    assert found.exit_code == 1 and "--picture: front.bmp is given" in found.stderr


def test_what_cannot_be_written_is_told_before_the_plan_is_made(ask, monkeypatch, tmp_path):
    monkeypatch.setattr("fbcouple.case.plan.choice.make_plan", lambda *arguments: pytest.fail("it was made"))
    (tmp_path / "taken.toml").write_text("")
    places = {"--picture": ("taken.toml/front.png", "front.bmp"), "--write": ("taken.toml", "no.txt", "none/new.toml")}
    for option, names in places.items():
        for name in names:
            found = ask("mueller/0.9", "--error", "0.1", option, tmp_path / name)
            assert found.exit_code == 1 and isinstance(found.exception, SystemExit), found.output


@pytest.mark.parametrize("within", ["2h", "0:00:00", "1:60:00"])
def test_times_are_clocks(ask, within):
    found = ask("mueller/0.9", "--error", "0.1", "--within", within)
    assert found.exit_code == 2 and "--within" in found.stderr
