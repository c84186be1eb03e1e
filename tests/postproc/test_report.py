"""The report: a valid page that stands alone, with the numbers that the synthetic runs are known to have."""

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import html5lib
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.postproc import COMPARISONS, FIGURES
from fbcouple.postproc.report import report
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.report import write_report
from fbcouple.postproc.report.tables import make_plain, tabulate_statistics
from fbcouple.postproc.report.wording import keep_units, show
from fbcouple.results.reader import open_results
from fbcouple.results.variables import HISTORIES
from tests.postproc.frames_of_bed import write_frames
from tests.postproc.whole_run import (
    BUBBLE,
    HEIGHT_FREQUENCY,
    PRESSURE_FREQUENCY,
    RISE,
    SIZE,
    TAP_FREQUENCY,
    write_whole,
)

VOID = {"meta", "img", "link", "br", "hr"}
LINE = "x,value,error\n0.02,-0.3,0.05\n0.04,0.0,0.05\n0.06,0.3,0.05\n"


class Page(HTMLParser):
    """Reads a page and notes tags left open, closed twice or nested wrongly, identifiers, links and pictures."""

    def __init__(self, text):
        super().__init__()
        self.open, self.mistakes, self.ids, self.links, self.images, self.tags = [], [], [], [], [], []
        self.texts = []
        self.feed(text)
        self.mistakes += [f"<{tag}> is never closed" for tag in self.open]

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.tags.append(tag)
        if len(values) < len(attrs):
            self.mistakes.append(f"<{tag}> has an attribute twice")
        self.ids += [values["id"]] if "id" in values else []
        self.links += [values[key] for key in ("href", "src") if key in values]
        if tag == "img":
            self.images.append(values)
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open[-1] != tag:
            self.mistakes.append(f"</{tag}> closes <{self.open[-1] if self.open else ''}>")
        else:
            self.open.pop()

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Two runs on two meshes beside a measured line: the page, its text, and the numbers."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "line.csv").write_text(LINE)
    meshes = {"coarse": (17, 3, 55), "fine": (34, 6, 110)}
    write_whole(folder / "coarse", meshes["coarse"])
    write_whole(folder / "fine", meshes["fine"], shift=0.1, core_seconds=72000.0)
    for name, cells in meshes.items():
        write_frames(folder / name, SIZE, cells=cells)
    page, numbers = write_report(
        [folder / "coarse", folder / "fine"], folder / "two.html", [f"solids_velocity@0.025={folder / 'line.csv'}"]
    )
    text = page.read_text()
    return page, text, json.loads(numbers.read_text())


@pytest.fixture(scope="module")
def content(two):
    return two[2]


def row_of(rows, **wanted):
    (found,) = [row for row in rows if all(row[key] == value for key, value in wanted.items())]
    return found


def test_the_page_is_well_formed(two):
    page = Page(two[1])
    assert two[1].startswith("<!DOCTYPE html>\n<html lang=")
    assert page.mistakes == []
    assert len(set(page.ids)) == len(page.ids)
    assert {"title", "main", "header", "caption"} <= set(page.tags)
    assert page.tags.count("h1") == page.tags.count("main") == 1


def test_it_is_valid_html_for_a_parser_that_forgives_nothing(two):
    """html5lib's strict mode raises at the first parse error of the HTML standard."""
    html5lib.HTMLParser(strict=True).parse(two[1])
    with pytest.raises(html5lib.html5parser.ParseError):
        html5lib.HTMLParser(strict=True).parse(two[1].replace("</table>", "", 1))


def test_it_stands_alone_and_has_no_script(two):
    page = Page(two[1])
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in page.links)
    assert {link[1:] for link in page.links if link.startswith("#")} <= set(page.ids)
    assert "script" not in page.tags and "@import" not in two[1] and "url(" not in two[1]


def test_every_picture_is_whole_and_in_words(two):
    page = Page(two[1])
    # both runs with all figures of a bed, the comparisons, the measured lines and the error against run time
    assert (
        len(page.images)
        == 2 * len(set(FIGURES) - {"impact", "measured_lines", "radial_profiles", "temperature", "throughput"})
        + len(COMPARISONS)
        + 2
    )
    for image in page.images:
        assert image["alt"].endswith("."), "the whole first paragraph of what draws it"
        assert len(image["alt"]) > 20 and int(image["width"]) > 200 and int(image["height"]) > 100
        assert base64.b64decode(image["src"].partition(",")[2])[:8] == b"\x89PNG\r\n\x1a\n"
    assert len({image["alt"] for image in page.images}) == len(page.images)


def test_two_runs_are_below_5_megabytes(two):
    assert two[0].stat().st_size < 5e6


def test_names_of_the_case_are_not_taken_for_markup(two):
    assert "A whole &lt;synthetic&gt; bed &amp; more" in two[1] and "<synthetic>" not in two[1]


def test_no_word_of_the_template_or_of_python_is_left(two):
    text = " ".join(Page(two[1]).texts)
    assert not re.search(r"\{\{|\}\}|\{%|\bNone\b|\bnan\b|Undefined|array\(|np\.", text)


def test_every_number_of_the_tables_is_in_the_json(two):
    """Cells of the page, four digits each, against the values of all rows."""
    values: set[str] = set()

    def gather(value):
        for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else []:
            gather(inner)
        values.update([show(value), show(value, "time [s]")])

    gather(two[2])
    cells = re.findall(r'<td class="number">([^<]*)</td>', two[1])
    assert len(cells) > 150 and set(cells) <= values | {"–"}


def test_errors_stand_beside_run_time(content):
    """7200 and 72000 core seconds for 20 s."""
    costs = {row["run"]: row["core-hours per simulated second"] for row in content["cost"]}
    assert costs == pytest.approx({"coarse": 0.1, "fine": 1.0})
    solids = row_of(content["errors"], **{"error of": "map of the solids fraction"})
    assert solids["run"] == "fine" and solids["core-hours per simulated second"] == pytest.approx(1.0)
    assert solids["error"] == pytest.approx(1.0 / 3.0, rel=0.03)
    assert {row["run"] for row in content["errors"] if row["error of"].startswith("solids velocity at z = 25 mm")} == {
        "coarse",
        "fine",
    }


def test_the_measured_line_is_missed_by_nothing_where_the_run_is_the_line(content):
    """The run's velocity is linear, 1.2 (x/L - 1/2), and so are the points."""
    for row in content["references"]:
        assert row["rms"] == pytest.approx(0.0, abs=1e-6) and row["error of measurement"] == pytest.approx(0.05)
        assert row["unit"] == "m s-1" and row["points"] == 3


def test_statistics_spectra_and_bubbles_of_a_run(content):
    run = content["runs"][0]
    height = row_of(run["statistics"], quantity=HISTORIES["bed_height"][1])
    assert height["mean"] == pytest.approx(0.07, abs=2e-4) and height["steady from [s]"] == pytest.approx(1.0, abs=0.1)
    assert height["deviation"] == pytest.approx(2e-3 / np.sqrt(2.0), rel=0.05)
    peaks = {row["quantity"]: row["dominant frequency [Hz]"] for row in run["spectra"]}
    assert peaks == pytest.approx(
        {"pressure drop": PRESSURE_FREQUENCY, "bed height": HEIGHT_FREQUENCY, "centre of mass": HEIGHT_FREQUENCY}
        | {"pressure at tap 1": TAP_FREQUENCY, "pressure at tap 2": TAP_FREQUENCY},
        abs=0.02,
    )
    assert all(row["stands out of red noise"] for row in run["spectra"])
    (bubbles,) = run["bubbles"]
    assert bubbles["rise velocity [m s-1]"] == pytest.approx(RISE, rel=0.05)
    assert bubbles["diameter [m]"] == pytest.approx(BUBBLE, rel=0.1)
    assert bubbles["bubbles at a time"] == pytest.approx(1.0)


def test_numbers_of_contacts_have_their_units(content):
    solved = {row["what"]: row["value"] for row in content["runs"][0]["solved"]}
    assert solved["contact: friction"] == 0.1
    assert not [what for what in solved if "[1]" in what]


def test_histories_that_are_too_short_are_named_once(tmp_path):
    run = open_results(write_whole(tmp_path / "run"))
    rows, remarks = tabulate_statistics(replace(run, data=run.data.isel(time=slice(5))))
    assert rows == []
    (remark,) = remarks
    assert remark.startswith("No mean of `bed_height`, ") and ": each in " in remark
    assert remark.endswith("has 4 rows, 40 are needed.")


def test_monitors_of_a_run(content):
    monitors = {row["monitor"]: row["value"] for row in content["runs"][0]["monitors"]}
    assert monitors["particles lost"] == 0 and monitors["largest relative change of the solids volume"] == 0.0
    assert monitors["Courant number, largest"] == 0.2
    assert monitors["mean gas flux at a height over U_f, farthest from 1"] == pytest.approx(1.0)
    words = "mean steady pressure drop over weight less buoyancy a cross-section"
    assert monitors[words] == pytest.approx(600.0 / 612.8, rel=1e-3)
    assert monitors["net vertical solids flux at a height over the largest flux"] == pytest.approx(0.0, abs=1e-9)


def test_every_monitor_within_its_limit_says_so(content):
    """The pressure drop is 0.979 of the weight; the net flux over a height and the displaced gas have no limit."""
    verdicts = {row["monitor"]: row["verdict"] for row in content["runs"][0]["monitors"]}
    assert verdicts["Courant number, largest"] == verdicts["particles lost"] == "within"
    assert set(verdicts.values()) == {"within", ""}
    assert not any("Courant" in text for text in content["warnings"])


def test_a_step_may_be_a_little_over_the_courant_number_that_the_last_one_chose_it_by(dataset, write):
    """1.503 of 1.5 stood at the head of an ordinary run's page."""
    dataset["max_courant"][:] = 0.218
    watched = MONITORS["max_courant"](open_results(write(dataset)))
    assert (watched.verdict, watched.wanted) == ("within", "at most 0.22, gas.max_courant = 0.2 and 10%")


@pytest.mark.usefixtures("without_figures")
def test_what_is_beyond_its_limit_is_marked_in_words_and_told_first(tmp_path):
    """Courant 1.66 of 1.5, a gas flux half of what it should be, a cell packed too dense, and a particle lost."""
    run = write_whole(tmp_path / "run")
    with xr.open_dataset(run / "results.nc") as stored:
        data = stored.load()
    (run / "results.nc").unlink()
    data.attrs["case"] = data.attrs["case"].replace("max_courant = 0.2", "max_courant = 1.5")
    data["max_courant"][7], data["cells_over_packed"][5], data["particles"][-1] = 1.66, 2, 57295
    data["gas_flux"][:, 4] *= 0.496
    data.to_netcdf(run / "results.nc")
    page, numbers = write_report([run], tmp_path / "a.html")
    content = json.loads(numbers.read_text())
    beyond = {row["monitor"]: row["value"] for row in content["runs"][0]["monitors"] if row["verdict"] == "BEYOND"}
    assert beyond == pytest.approx(
        {
            "Courant number, largest": 1.66,
            "mean gas flux at a height over U_f, farthest from 1": 0.496,
            "cells over the closest packing, most": 2,
            "particles lost": 1,
        }
    )
    assert (
        "run: Courant number, largest: 1.66, wanted at most 1.65, gas.max_courant = 1.5 and 10%." in content["warnings"]
    )
    assert page.read_text().count('<td class="short beyond">BEYOND</td>') == 4
    assert "Read the numbers with care" in page.read_text()


@pytest.fixture
def without_figures(monkeypatch):
    monkeypatch.setattr(report, "FIGURES", {})


def test_cost_by_stage_adds_up(content):
    stages = {row["stage"]: row for row in content["runs"][0]["cost"]}
    assert stages["wait"]["wall [s]"] == pytest.approx(0.2 * 7 * 2001)
    assert stages["all"]["wall [s]"] == pytest.approx(0.2 * 28 * 2001)
    assert stages["all"]["share [%]"] == pytest.approx(100.0)
    assert stages["cfd"]["wall per simulated second [s]"] == pytest.approx(0.2 * 2001 / 20.0)


def test_every_option_of_the_case_is_told(content):
    options = {row["option"]: row["value"] for row in content["runs"][0]["parameters"]}
    assert options["gas.inlet_velocity"] == 1.2 and options["domain.cells"] == [17, 3, 55]


def test_the_manifest_is_told_where_there_is_one(tmp_path):
    run = write_whole(tmp_path / "run")
    manifest = {
        "fbcouple": "9.9",
        "left_out": {"rotation": "not asked for"},
        "run": {"ranks": 4, "command": ["a", "b"], "changed": [], "updates": []},
        "replaced": [],
    }
    (run / "manifest.json").write_text(json.dumps(manifest))
    _, numbers = write_report([run], tmp_path / "a.html")
    told = {row["what"]: row["value"] for row in json.loads(numbers.read_text())["runs"][0]["provenance"]}
    assert all(value not in ("", None) for value in told.values()) and "replaced" not in told
    assert told["fbcouple"] == "9.9" and told["left out rotation"] == "not asked for"
    assert told["run ranks"] == 4 and told["run command"] == "a b"


def test_a_run_that_has_only_begun_is_reported_with_what_it_has(dataset, write):
    lean = dataset.drop_vars([name for name in dataset if "x" in dataset[name].dims])
    run = write(lean)
    done = CliRunner().invoke(cli, ["report", str(run)])
    assert done.exit_code == 0, done.output
    assert done.output.splitlines() == [str(run / "report.html"), str(run / "report.json")]
    page = Page((run / "report.html").read_text())
    assert page.mistakes == [] and len(page.images) == 2
    assert any("averaging starts at t = 1 s" in text for text in page.texts)


def test_a_reference_on_the_command_line(tmp_path):
    run = write_whole(tmp_path / "run")
    (tmp_path / "line.csv").write_text(LINE)
    arguments = ["report", str(run), "-o", str(tmp_path / "sub" / "page.html")]
    done = CliRunner().invoke(cli, [*arguments, "--reference", f"solids_velocity@0.025={tmp_path / 'line.csv'}"])
    assert done.exit_code == 0, done.output
    assert len(json.loads((tmp_path / "sub/page.json").read_text())["references"]) == 1
    done = CliRunner().invoke(cli, [*arguments, "--reference", "velocity@0.025=line.csv"])
    assert done.exit_code == 1 and "allowed are: solids_fraction" in done.output


def test_nothing_is_written_if_a_run_is_missing(tmp_path):
    run = write_whole(tmp_path / "run")
    with pytest.raises(CaseError, match=r"none/results\.nc does not exist"):
        write_report([run, tmp_path / "none"], tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists() and not (tmp_path / "page.json").exists()


def test_a_run_that_is_given_twice_is_told(tmp_path):
    run = write_whole(tmp_path / "run")
    with pytest.raises(CaseError, match=r"run is given twice, .*; leave one out"):
        write_report([run, tmp_path / "x" / ".." / "run"], tmp_path / "page.html")


@pytest.mark.parametrize("name", ["page.json", "page", "page.JSON", "page.nc"])
def test_a_page_of_another_ending_is_refused(tmp_path, name):
    run = write_whole(tmp_path / "run")
    done = CliRunner().invoke(cli, ["report", str(run), "-o", str(tmp_path / name)])
    assert done.exit_code == 1 and f"{name}: is given for an HTML page, a name that ends in .html" in done.output
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_what_is_made_of_a_file_goes_beside_it(tmp_path):
    """Figures, tables and the report of bed.nc into the folder bed; of a file of another name into one of its own."""
    run = write_whole(tmp_path / "run")
    for name, home in (("bed.nc", "bed"), ("means", "means-made")):
        (run / "results.nc").rename(tmp_path / name)
        done = CliRunner().invoke(cli, ["post", str(tmp_path / name), "--only", "cost", "--csv", "--vtk"])
        assert done.exit_code == 0, done.output
        assert CliRunner().invoke(cli, ["report", str(tmp_path / name)]).exit_code == 0
        for made in ("figures/cost.png", "tables/history.csv", "vtk/means.vti", "report.html"):
            assert (tmp_path / home / made).is_file()
        (tmp_path / name).rename(run / "results.nc")


def test_nothing_of_a_file_goes_into_the_run_of_its_name(tmp_path):
    write_whole(tmp_path / "bed")
    (tmp_path / "bed/case.toml").write_text("")
    (tmp_path / "bed.nc").write_bytes((tmp_path / "bed/results.nc").read_bytes())
    before = sorted((tmp_path / "bed").iterdir())
    for words in (["post", "--csv"], ["report"]):
        done = CliRunner().invoke(cli, [*words, str(tmp_path / "bed.nc")])
        assert done.exit_code == 1 and "goes into" in done.output and "that is a run folder" in done.output
    assert sorted((tmp_path / "bed").iterdir()) == before


def test_numbers_that_are_none_become_null():
    assert make_plain({"a": [np.float64(np.nan), np.int64(3), (1.5, float("inf"))]}) == {"a": [None, 3, [1.5, None]]}


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (float("nan"), "–"), (True, "yes"), (3, "3"), (0.123456, "0.1235"), ([1, 2.0], "1, 2"), ([], "none")],
)
def test_values_are_shown_in_four_digits(value, text):
    assert show(value) == text


def test_a_long_list_is_counted():
    """Twenty-five zero crossings of a young run made a column of the printed page 25 lines high."""
    assert show([0.001, 0.002, 0.003, 0.004]) == "0.001, 0.002, 0.003, 0.004"
    assert show([0.001 * n for n in range(1, 26)]) == "25 values"


def test_times_are_shown_in_three_digits():
    """The last step ends a little behind end_time."""
    assert show(0.05001, "simulated [s]") == "0.05" and show(11.0004, "simulated time [s]") == "11"
    assert show(0.05001, "rms") == "0.05001"


def test_what_differs_between_the_runs_is_the_first_table(two, content):
    """The two runs have other meshes and nothing else."""
    assert content["settings"] == [
        {"option": "domain.cells", "coarse": [17, 3, 55], "fine": [34, 6, 110]},
    ]
    captions = re.findall(r"<caption>([^<]*)", two[1])
    assert captions[0].strip() == "What differs between the runs" and captions[1].strip() == "Run time"


def test_runs_that_do_not_differ_say_so(tmp_path):
    runs = [write_whole(tmp_path / name) for name in ("one", "other")]
    page, numbers = write_report(runs, tmp_path / "same.html")
    assert json.loads(numbers.read_text())["settings"] == []
    assert "have the same options and were made with the same programs" in page.read_text()


def test_pictures_of_a_run_come_before_its_tables(two):
    for part in two[1].split('<section class="run"')[1:]:
        last_picture, first_table = part.rindex("<img"), part.index("<table")
        assert last_picture < first_table


def test_no_unit_can_break_and_every_table_can_scroll(two):
    assert not re.search(r"\[[^\]<>]* [^\]<>]*\]</th>", two[1]), "a blank that breaks inside of a unit"
    assert "[kg\u00a0m-3]" in two[1]
    assert two[1].count("<table>") == len(re.findall(r'<div class="table( wide)?"', two[1]))


def test_one_run_has_no_figure_of_errors_against_run_time(tmp_path):
    (tmp_path / "line.csv").write_text(LINE)
    reference = f"solids_velocity@0.025={tmp_path / 'line.csv'}"
    page, _ = write_report([write_whole(tmp_path / "run")], tmp_path / "one.html", [reference])
    assert "Error of each run" not in page.read_text() and "Measured lines, and the runs on them" in page.read_text()


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("rise velocity [m s-1]", "rise velocity [m\u00a0s-1]"),
        ("gas: density [kg m-3], viscosity [Pa s]", "gas: density [kg\u00a0m-3], viscosity [Pa\u00a0s]"),
        ("up to 25 mm high", "up to 25\u00a0mm high"),
        ("3 s of the bed", "3\u00a0s of the bed"),
        ("a plain sentence", "a plain sentence"),
    ],
)
def test_blanks_in_units_do_not_break(text, kept):
    assert keep_units(text) == kept
