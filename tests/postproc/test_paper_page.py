"""The page of the paper: of any part of its runs, with what is missing named, and the data behind its figures."""

from __future__ import annotations

import csv
import html
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.case.load import load_case, write_case
from fbcouple.cli.main import cli
from fbcouple.paths import list_members
from fbcouple.postproc.papers.hamidouche2019 import figure_data, page_tables
from fbcouple.postproc.papers.hamidouche2019.page import make_page, open_members
from fbcouple.postproc.papers.hamidouche2019.paper_beds import BEDS
from fbcouple.postproc.papers.hamidouche2019.paper_figures import FIGURES
from fbcouple.postproc.papers.hamidouche2019.paper_runs import sort_runs
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.postproc.papers.hamidouche2019.run_uses import list_uses
from fbcouple.results.reader import Results, open_results
from fbcouple.results.replicas import make_replica
from tests.postproc.frames_of_bed import write_frames
from tests.postproc.paper_bed import write_bed
from tests.postproc.whole_run import write_whole

FLUX = 1.165 * 1.2
"""rho U_f."""
PAGES = ("report.html", "report.json", "report/README.md")


def report(*words: str) -> str:
    done = CliRunner().invoke(cli, ["report", *words])
    assert done.exit_code == 0, done.output
    return done.output


def figures_of(told: dict) -> dict:
    return {each["number"]: each for each in told["figures"]}


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Three runs of the paper's, one that was set up, and one that is cut short: the page of these."""
    folder = tmp_path_factory.mktemp("set") / "paper"
    folder.mkdir()
    write_bed(folder / "patil-c1", "c1", wall_solids=0.45)
    write_bed(folder / "patil-c2", "c2")
    write_bed(folder / "patil-c4-0.1", "c4-0.1", ("start.seed=5",))
    write_bed(folder / "patil-c7", "c7", end=3.0)
    (folder / "patil-c3").mkdir()
    write_case(load_case("patil/c3"), folder / "patil-c3/case.toml")
    (folder / "notes").mkdir()
    report(str(folder))
    return folder


def test_a_part_of_the_runs_makes_a_page_with_its_pictures_and_data(made):
    assert all((made / name).is_file() for name in PAGES)
    page = (made / "report/README.md").read_text()
    named = set(re.findall(r"\]\(([^)]+)\)", page))
    lie = {path.name for path in (made / "report").iterdir()} - {"README.md"}
    assert named == lie and {"figure-12-flux.png", "figure-12-flux.nc", "figure-13-profile.csv", "figure-4.png"} <= lie
    text = (made / "report.html").read_text()
    assert text.count("data:image/png;base64,") == sum(name.endswith(".png") for name in lie)
    assert "http" not in text and not re.search(r"\bNone\b|\bnan\b|Undefined", text)


def test_what_is_missing_is_named(made):
    told = json.loads((made / "report.json").read_text())["missing"]
    reasons = {bed: reason for text in told for names, reason in [text.split(": ", 1)] for bed in names.split(", ")}
    assert reasons["c3"] == "no results yet" and reasons["a1"] == "no run in this folder"
    assert reasons["c3-slip"].startswith("no run in this folder; it is none of patil/all")
    assert reasons["c7"] == "patil-c7 averaged 2 s, needed 5 s"
    assert not reasons.keys() & {"c1", "c2", "c4-0.1", "c5-0.1"} and len(told) == len(set(reasons.values()))
    page = (made / "report/README.md").read_text()
    assert all(re.sub(r"([_`])", r"\\\1", f"- {text}") in page for text in told)


def test_every_figure_has_what_the_paper_says_and_how_it_agrees(made):
    figures = {each["number"]: each for each in json.loads((made / "report.json").read_text())["figures"]}
    assert list(figures) == ["4", "7", *map(str, range(10, 22)), "A1"]
    assert all(each["said"] and each["shows"] for each in figures.values())
    assert figures["12"]["agreement"] == "1 of 4 claims hold, 3 open."
    assert figures["21"]["remarks"] == ["No run of c7."]
    used = {name for figure in FIGURES for name in figure.claims}
    assert used == set(CLAIMS)


def test_claims_are_counted_on_the_beds_that_they_speak_of(made):
    told = json.loads((made / "report.json").read_text())
    counts = told["counts"]
    assert (counts["of"], counts["yes"], counts["no"]) == (len(CLAIMS) - 1, 1, 0)
    assert counts["beside"].endswith("which the paper did not try. Cannot be told from these runs.")
    assert figures_of(told)["13"]["agreement"] == "0 of 1 claims hold, 1 open."
    assert [number for number, each in figures_of(told).items() if "nearly no particles" in each["said"]] == ["16"]
    pair = [row["verdict"] for row in told["claims"] if row["name"] == "denser-walls" and row["beds"] == "c1, c2"]
    assert pair == ["yes"]


def test_numerics_that_are_not_the_papers_stand_at_the_top_in_each_row_and_of_each_run(made):
    told = json.loads((made / "report.json").read_text())
    line = "Not the paper's numerics: gas.max_courant = 1.5 (0.2 in the paper) in all 4 runs; gas.max_fourier = 1.5"
    assert told["numerics"].startswith(line)
    rows = [row for row in told["claims"] if row["runs"]]
    assert rows and all("CFL 1.5, Fourier 1.5" in row["numerics"] for row in rows)
    assert {row["numerics that are not the paper's"] for row in told["runs"]} == {
        "gas.max_courant = 1.5, gas.max_fourier = 1.5"
    }
    for page in (html.unescape((made / "report.html").read_text()), (made / "report/README.md").read_text()):
        words = page.replace("\\_", "_").replace("<wbr>", "")
        assert line in words and words.index(line) < words.index("Figure 4") and "CFL 1.5, Fourier 1.5" in words


def test_profiles_lie_in_a_table(made):
    with (made / "report/figure-13-profile.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["run"] for row in rows} == {"c1", "c2"} and len(rows) == 17 + 35
    for row in rows:
        near = min(float(row["x/L"]), 1.0 - float(row["x/L"])) * 0.08 < 5e-3
        assert float(row["flux over rho U_f"]) == pytest.approx((-20.0 if near else 5.0) / FLUX, rel=1e-4)


def test_maps_lie_in_a_file_each_on_its_own_mesh(made):
    with xr.open_dataset(made / "report/figure-12-fraction.nc") as file:
        data = file.load()
    field = data["solids_fraction_c2"]
    assert field.shape == (110, 35) and data["solids_fraction_c1"].shape == (55, 17)
    assert field.sel(z110=0.1, x35=0.5, method="nearest") == pytest.approx(0.4, rel=1e-4)
    assert field.sel(z110=0.1, x35=0.01, method="nearest") == pytest.approx(0.5, rel=1e-4)
    assert field.sel(z110=0.3, x35=0.5, method="nearest") == 0.0


def test_the_runs_are_told_with_their_weight_and_hashes(made):
    told = json.loads((made / "report.json").read_text())
    rows = {row["run"]: row for row in told["runs"]}
    assert rows["patil-c2"]["weight over the area [Pa]"] == pytest.approx(612.8, abs=0.1)
    assert rows["patil-c7"]["weight over the area [Pa]"] == pytest.approx(1021.4, abs=0.2)
    assert rows["patil-c1"]["closed part of the floor"] == pytest.approx(9 / 51)
    assert rows["patil-c2"]["means over"] == "1–20 s"
    makers = {row["run"]: row for row in told["makers"]}
    assert makers["patil-c4-0.1"]["seed"] == 5 and len({row["case, SHA-256"] for row in told["makers"]}) == 4


def test_drop_and_support_are_put_in_proportion_to_the_weight(tmp_path):
    """A steady drop of 600 Pa and 0.98 of the weight: 0.979 of 612.8 Pa, and 2 % on floor and walls."""
    results = open_results(write_whole(tmp_path / "run"))
    (row,) = page_tables.tabulate_runs(list_uses([results]))
    assert row["pressure drop over the weight"] == pytest.approx(600.0 / 612.8, abs=2e-3)
    assert row["weight on floor and walls"] == pytest.approx(0.02) and row["core-hours"] == 2.0
    assert row["momentum error"] == pytest.approx(1e-14) and row["change of the solids volume"] == 0.0


def test_means_that_end_after_the_last_row_count_as_simulated(tmp_path):
    results = open_results(write_bed(tmp_path / "run", "c2"))
    later = replace(results, data=results.data.assign_attrs(averaging_end=20.004))
    assert later.simulated == 20.004 and results.simulated == 20.0
    told = make_replica(tmp_path / "run/results.nc", later.data, later.case).about
    assert told["simulated"] == 20.004
    older = json.dumps([told | {"simulated": 20.0}])
    assert replace(later, data=later.data.assign_attrs(replicas_of=older)).simulated == 20.004


def test_a_damaged_file_of_means_is_told_with_what_mends_it(tmp_path):
    write_bed(tmp_path / "c2", "c2")
    (tmp_path / "c4-0.1.nc").write_bytes(b"CDF" * 100)
    (text,) = [
        text for text in make_page(tmp_path, open_members(list_members(tmp_path))).content["missing"] if ".nc" in text
    ]
    assert "fbcouple pool RUN -o FILE --reduced" in text and "--resume" not in text
    (tmp_path / "c2/results.nc").write_bytes(b"CDF" * 100)
    (member,) = open_members([tmp_path / "c2"])
    assert "fbcouple run RUN --resume" in member.lack


def test_a_set_that_was_not_run_has_a_page_of_what_is_missing(tmp_path):
    (tmp_path / "c2").mkdir()
    write_case(load_case("patil/c2"), tmp_path / "c2/case.toml")
    report(str(tmp_path))
    told = json.loads((tmp_path / "report.json").read_text())
    named = {bed for text in told["missing"] for bed in text.partition(":")[0].split(", ")}
    assert named == set(BEDS) - {"c2-slip", "c6-smagorinsky"} and told["runs"] == []
    assert not any(each["claims"] and each["agreement"].startswith("0 of 0") for each in told["figures"])


def test_twins_tell_what_chance_does(tmp_path):
    """62.5 and 63.0 mm with errors of the same sine: their difference over its error."""
    write_bed(tmp_path / "one", "c4-0.1", unrest=0.05)
    write_bed(tmp_path / "two", "c5-0.1", unrest=0.05, height=0.063)
    page = make_page(tmp_path, open_members([tmp_path / "one", tmp_path / "two"])).content
    row = next(row for row in page["twins"] if row["number"] == "bed height [mm]")
    assert row["bed"] == "c4-0.1" and row["runs"] == "one, two"
    heights = [float(row[side].split(" ")[0]) for side in ("one", "other")]
    assert heights == pytest.approx([62.5, 63.0], abs=0.06) and row["difference over its standard error"] < -2.0
    assert {row["run"]: row["counts for"] for row in page["runs"]} == {"one": "c4-0.1", "two": "c5-0.1"}
    assert page["choices"] == []
    shown = {each["number"]: each for each in page["figures"]}["18"]["pictures"]
    assert [picture["words"] for picture in shown] == [
        "Figure 18: Ours, of c4-0.1 (one).",
        "Figure 18: Ours, of c5-0.1 (two).",
    ]


def test_scaling_is_told_where_it_was_measured(tmp_path):
    write_bed(tmp_path / "c1", "c1")
    rows = [
        {"scaling": kind, "ranks": ranks, "seconds": 2.0, "gain": "speed-up", "value": 1.8, "of_ideal": 0.9, "cells": 1}
        for kind in ("strong", "weak")
        for ranks in (1, 2)
    ]
    table = {"scaling": rows, "traffic": [{"ranks": 2}]}
    (tmp_path / "scaling.json").write_text(json.dumps({"cells": "tetrahedra"} | table))
    members = open_members([tmp_path / "c1"])
    figure = make_page(tmp_path, members).content["figures"][1]
    assert figure["number"] == "7" and len(figure["numbers"]) == 4 and figure["numbers"][1]["of_ideal"] == 0.9
    for cells, words in (({}, "cells that it does not name"), ({"cells": "hexahedra"}, "hexahedra")):
        (tmp_path / "scaling.json").write_text(json.dumps(cells | table))
        figure = make_page(tmp_path, members).content["figures"][1]
        assert figure["numbers"] == [] and f"is of {words}, the figure of tetrahedra" in figure["remarks"][0]
        command = f"fbcouple bench scaling -n 1 -n 2 --tetrahedra --json {tmp_path / 'scaling.json'}"
        assert f"`{command}`" in figure["remarks"][0]
    (tmp_path / "scaling.json").write_text("[1]")
    figure = make_page(tmp_path, members).content["figures"][1]
    assert figure["numbers"] == [] and "is not what bench scaling writes" in figure["remarks"][0]


def test_the_papers_step_is_off_by_less_than_it_says():
    """RK2 with T_C/6, as it meets the wall with a step: 1.0128 in place of 0.97, below the 5 % of section 2.4.2."""
    rows = {row["scheme"]: row for row in page_tables.tell_contact()}
    assert rows["RK2, T_C/6"]["off by [%]"] == pytest.approx(4.41, abs=0.01)
    assert rows["RK2, T_C/6"]["mean over the phases"] == "1.0165"


def test_other_runs_have_the_ordinary_report(tmp_path):
    for name, shift in (("a", 0.0), ("b", 0.1)):
        write_whole(tmp_path / name, shift=shift)
        (tmp_path / name / "case.toml").write_text("")
    report(str(tmp_path), "-o", str(tmp_path / "all.html"))
    assert [row["label"] for row in json.loads((tmp_path / "all.json").read_text())["runs"]] == ["a", "b"]
    assert not (tmp_path / "all").exists()


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Results:
    run = write_whole(tmp_path_factory.mktemp("whole") / "run")
    results = open_results(run)
    write_frames(run, results.size)
    return results


def test_pictures_and_data_go_into_no_folder_of_runs(tmp_path):
    """Beside the folder `set`, set.html would have them in it, and the next report took them for members."""
    folder = tmp_path / "set"
    folder.mkdir()
    for name in ("c1", "c2"):
        run = write_bed(tmp_path / name, name)
        (run / "results.nc").rename(folder / f"{name}.nc")
    for _ in range(2):
        report(str(folder), "-o", str(tmp_path / "set.html"))
        assert sorted(path.name for path in folder.iterdir()) == ["c1.nc", "c2.nc"]
    assert (tmp_path / "set-page/README.md").is_file() and (tmp_path / "set-page/figure-12-flux.nc").is_file()
    assert "set-page" in (tmp_path / "set.html").read_text()
    told = json.loads((tmp_path / "set.json").read_text())
    assert [row["run"] for row in told["runs"]] == ["c1", "c2"] and not any(
        "figure" in text for text in told["missing"]
    )


@pytest.mark.parametrize("name", ["page.json", "page", "scaling.html"])
def test_a_page_takes_the_place_of_nothing_that_it_is_made_of(tmp_path, name):
    (tmp_path / "c2").mkdir()
    write_case(load_case("patil/c2"), tmp_path / "c2/case.toml")
    (tmp_path / "scaling.json").write_text("{}")
    done = CliRunner().invoke(cli, ["report", str(tmp_path), "-o", str(tmp_path / name)])
    assert done.exit_code == 1 and ("ends in .html" in done.output or "holds what figure 7 is made of" in done.output)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["c2", "scaling.json"]


def test_lines_along_the_depth(whole):
    """The velocity is linear across the bed and does not change along the depth."""
    rows = figure_data.collect_depth([whole], 0.04)
    assert {row["y/D"] for row in rows} == set(np.round((np.arange(3) + 0.5) / 3, 12)) or len(rows) == 15
    for row in rows:
        assert row["velocity over U_f"] == pytest.approx(row["x/L"] - 0.5, abs=1e-6)
    assert all(row["deviation along the depth over U_f"] < 1e-12 for row in page_tables.tell_depth([whole], 0.04))


def test_slices_and_snapshots(whole):
    slices = figure_data.collect_slices([whole])
    assert len(slices.data_vars) == 3 and all(field.shape == (25, 8) for field in slices.data_vars.values())
    assert float(slices.to_array().max()) == pytest.approx(0.6, abs=1e-5)
    rows = page_tables.tell_slices([whole])
    assert len(rows) == 2 and all(row["root mean square off the middle one, over its largest"] == 0.0 for row in rows)
    snapshots = figure_data.collect_snapshots([whole])
    assert len(snapshots.data_vars) == 5 and float(snapshots.to_array().min()) >= 0.44


def test_a_run_that_is_too_short_is_named_as_on_the_page(tmp_path):
    """A file of reduced means has the name of the file, not that of the folder around it."""
    write_bed(tmp_path / "run", "c7", end=3.0)
    results = replace(open_results(tmp_path / "run"), label="c7-of-june")
    assert sort_runs([results])[1]["c7"] == "c7-of-june averaged 2 s, needed 5 s"
