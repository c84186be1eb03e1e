"""The shipped beds, and one of them from its name to its page."""

from __future__ import annotations

import csv
import json

import pytest
from click.testing import CliRunner

from fbcouple.case.load import load_case, write_case
from fbcouple.case.preflight import require_fit
from fbcouple.cli.main import cli
from fbcouple.results.reader import open_results
from fbcouple.validate.comparisons import COMPARISONS
from fbcouple.validate.score import score
from fbcouple.validate.source import list_beds, read_bed
from tests.postproc.whole_run import write_whole


def call(*arguments):
    return CliRunner().invoke(cli, ["validate", *map(str, arguments)])


@pytest.mark.parametrize("name", list_beds())
def test_every_shipped_bed_can_be_run_and_scored(name):
    bed = read_bed(name)
    require_fit(load_case(name), None, bed.folder)
    assert bed.tasks and (bed.folder / "README.md").is_file()


def test_every_comparison_is_used_by_a_shipped_bed():
    used = {task.measurement.compare for name in list_beds() for task in read_bed(name).tasks}
    assert used == set(COMPARISONS)


def test_list_has_every_bed():
    done = call()
    assert done.exit_code == 0
    for name in list_beds():
        assert name in done.output


def test_stored_means_of_sedifoam_are_as_known(tmp_path):
    """As by numpy from the files: its lines begin 0.1 mm behind the first measured point, which is left out."""
    rows = score(read_bed("mueller/0.9"), open_results(write_whole(tmp_path / "run"))).rows
    peers = [row for row in rows if row["by"] == "SediFoam"]
    assert [row["rms"] for row in peers] == pytest.approx([0.0396, 0.1137, 0.0209, 0.0246, 0.0919], abs=6e-5)
    assert [row["points"] for row in peers] == [21, 21, 23, 23, 24]
    assert peers[-1]["amplitude"] == pytest.approx(0.58, abs=0.01)


def test_a_file_is_scored_into_the_folder_of_its_name(tmp_path):
    write_case(load_case("mueller/0.9"), tmp_path / "effective.toml")
    results = open_results(write_whole(tmp_path / "run")).data
    results.assign_attrs(case=(tmp_path / "effective.toml").read_text()).to_netcdf(tmp_path / "bed.nc")
    (tmp_path / "out").write_text("a file of the user's")
    done = call("mueller/0.9", "--run", tmp_path / "bed.nc")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "bed/validation.html").is_file()
    done = call("mueller/0.9", "--run", tmp_path / "bed.nc", "-o", tmp_path / "out/in")
    assert done.exit_code == 1 and "cannot be written" in done.output and "another folder with -o" in done.output


def test_a_bed_is_run_scored_and_scored_again(tmp_path):
    run = tmp_path / "run"
    first = call("kharaz/oblique", "-o", run)
    assert first.exit_code == 0, first.output
    with (run / "validation.csv").open() as file:
        rows = {row["measurement"]: row for row in csv.DictReader(file)}
    assert float(rows["angle of rebound"]["rms"]) < 0.7 and float(rows["tangential restitution"]["rms"]) < 0.02
    assert {row["verdict"] for row in rows.values()} == {"within"}
    table = json.loads((run / "validation.json").read_text())
    assert table["run"]["ranks"] == 1 and table["run"]["machine"] and table["run"]["core-seconds"] > 0.0
    assert table["run"]["differs from the bed's case in"] == "nothing" and table["remarks"] == []
    page = (run / "validation.html").read_text()
    assert "data:image/png;base64" in page and "Kharaz" in page
    made = (run / "results.nc").stat().st_mtime_ns

    again = call("kharaz/oblique", "-o", run)
    assert again.exit_code == 1 and "holds a run" in again.stderr
    resumed = call("kharaz/oblique", "-o", run, "--resume")
    assert resumed.exit_code == 0 and (run / "results.nc").stat().st_mtime_ns == made
    elsewhere = call("kharaz/oblique", "--run", run, "-o", tmp_path / "table")
    assert elsewhere.exit_code == 0 and sorted(path.name for path in (tmp_path / "table").iterdir()) == [
        "validation.csv",
        "validation.html",
        "validation.json",
        "validation.png",
    ]
    refused = call("kharaz/oblique", "-o", run, "--resume", "--set", "contact.friction=0.3")
    assert refused.exit_code == 1 and "leave --set or --resume out" in refused.stderr


def test_a_changed_case_is_told(tmp_path):
    done = call("kharaz/oblique", "-o", tmp_path / "run", "--set", "contact.wall_friction=0.2")
    assert done.exit_code == 0 and "contact.wall_friction = 0.2 (0.092)" in done.output
    assert "BEYOND" in done.output
