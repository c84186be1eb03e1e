"""The site builds without a warning, and its pages have all that the code has."""

from __future__ import annotations

import html
import os
import re
import subprocess
import sys
from pathlib import Path

import click
import pytest
from pages import DOCS, ROOT

from fbcouple.case.presets import PRESETS
from fbcouple.case.schema.reference import list_options
from fbcouple.case.source import list_sets, list_shipped
from fbcouple.cli.main import cli
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.coupling.forces import FORCES
from fbcouple.coupling.kernels import DRAG_SCHEMES
from fbcouple.decks.render import DECKS
from fbcouple.errors import FbcoupleError
from fbcouple.paths import FRAMES, HEARTBEAT, START, WALLS
from fbcouple.physics.drag.laws import DRAG_LAWS
from fbcouple.postproc import COMPARISONS, FIGURES
from fbcouple.results.variables import HISTORIES, MEANS, STAGES
from fbcouple.run_folder.failure import SOLVER_LOGS
from fbcouple.validate.comparisons import COMPARISONS as COMPARED
from fbcouple.validate.schema import Validation
from fbcouple.validate.source import list_beds
from fbcouple.verify.registry import MODULES


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built site; a warning is an error."""
    place = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", "-d", str(place / "trees")]
    done = subprocess.run(
        [*command, str(DOCS), str(place / "html")],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return place / "html"


def strip(markup: str) -> str:
    """Text of a piece of HTML, blanks as one."""
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", markup)).split())


def read_body(site: Path, page: str) -> str:
    """The article of a page, without menus."""
    text = (site / f"{page}.html").read_text(encoding="utf-8")
    return text[text.index("<article") : text.index("</article>")]


def read_codes(site: Path, page: str) -> set[str]:
    """All that stands in `code` on a page."""
    return {strip(code) for code in re.findall(r"<code[^>]*>(.*?)</code>", read_body(site, page), re.DOTALL)}


def read_entries(site: Path, page: str) -> dict[str, str]:
    """Terms of the definition lists of a page with what is said of them."""
    pairs = re.findall(r"<dt[^>]*>(.*?)</dt>\s*<dd[^>]*>(.*?)</dd>", read_body(site, page), re.DOTALL)
    return {strip(term): strip(text) for term, text in pairs}


def read_rows(site: Path, page: str) -> dict[str, list[str]]:
    """Rows of the tables of a page by their first cell."""
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", read_body(site, page), re.DOTALL)
    cells = [[strip(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row, re.DOTALL)] for row in rows]
    return {row[0]: row[1:] for row in cells if row}


def test_every_option_has_its_range_unit_and_sentence(site):
    entries = read_entries(site, "reference/options")
    assert set(entries) == set(list_options())
    for key, option in list_options().items():
        assert entries[key].startswith(option.allowed), key
        assert option.unit == "1" or f"[{option.unit}]" in entries[key], key
        assert option.default is not None or ("required" if option.required else "no default") in entries[key], key
        assert entries[key].endswith(strip(html.escape(option.sentence.replace("`", "")))), key


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("gas.max_courant", "a number above 0 · default 0.2"),
        ("particles.rotation", "default false"),
        ("contact.stiffness", "[N m-1] · default 1000"),
        ("domain.shape", 'default "box"'),
        ("domain.periodic", "default []"),
        ("particles.diameter", "[m] · required"),
    ],
)
def test_defaults_are_written_as_in_a_case_file(site, key, words):
    assert words in read_entries(site, "reference/options")[key]


def test_every_preset_is_listed(site):
    rows = read_rows(site, "reference/options")
    for column, values in enumerate(PRESETS.values()):
        assert {key: float(rows[key][column]) for key in values} == values


def test_every_law_has_its_formula_and_source(site):
    text = strip(read_body(site, "reference/drag"))
    for name, law in DRAG_LAWS.items():
        assert name in read_codes(site, "reference/drag")
        assert strip(html.escape((law.__doc__ or "").replace("`", ""))) in text, name


def test_every_scheme_force_and_voidage_method_is_listed(site):
    entries = set(read_entries(site, "reference/drag"))
    assert entries == {*DRAG_SCHEMES, *(f"exchange.{name}" for name in FORCES), *VOIDAGE_METHODS}


def test_every_variable_and_stage_is_listed(site):
    rows = read_rows(site, "reference/results-file")
    for name, (unit, text) in (MEANS | HISTORIES).items():
        assert rows[name] == [unit, " ".join(text.split())]
    assert all(rows[stage][0] for stage in STAGES)


def test_results_of_a_run_hold_no_other_variable(site):
    writer = (ROOT / "fbcouple/results/writer.py").read_text(encoding="utf-8")
    written = set(re.findall(r'data\["(\w+)"\]', writer)) | set(re.findall(r'"(\w+)": \(', writer))
    assert len(written) >= 15
    assert written <= {name for code in read_codes(site, "reference/results-file") for name in code.split(", ")}


def walk(command: click.Command, path: str):
    """Every command below `command`, with its path."""
    yield path, command
    for name, inner in getattr(command, "commands", {}).items():
        yield from walk(inner, f"{path} {name}")


def test_every_command_and_option_is_listed(site):
    codes = read_codes(site, "reference/commands")
    terms = " ".join(read_entries(site, "reference/commands"))
    for path, command in walk(cli, "fbcouple"):
        if path == "fbcouple":
            continue
        assert path in codes
        for parameter in command.params:
            if isinstance(parameter, click.Option) and not parameter.hidden:
                assert all(name in terms for name in parameter.opts), f"{path} {parameter.opts}"


def test_every_exit_code_is_listed(site):
    rows = read_rows(site, "reference/exit-codes")
    for error in FbcoupleError.__subclasses__():
        assert rows[str(error.exit_code)][1] == error.__name__


def test_every_case_figure_and_check_is_listed(site):
    assert set(read_rows(site, "reference/cases")) == {*list_shipped(), *list_sets()}
    assert set(read_rows(site, "reference/figures")) == {*FIGURES, *COMPARISONS}
    rows = read_rows(site, "reference/checks")
    for module in MODULES:
        source = (ROOT / f"fbcouple/verify/{module}.py").read_text(encoding="utf-8")
        names = set(re.findall(r'^@check\(\s*"([^"]+)"', source, re.MULTILINE))
        assert names <= set(rows), module
    assert all(row[-1] for row in rows.values()), "each says what it compares"


def test_every_measured_bed_comparison_and_key_is_listed(site):
    assert set(list_options(Validation)) == set(read_entries(site, "reference/validation"))
    assert {*list_beds(), *COMPARED} == set(read_rows(site, "reference/validation"))


def test_every_limit_and_file_of_a_run_is_listed(site):
    limits = {key for key in list_options() if key.startswith("monitors.")}
    assert limits <= read_codes(site, "reference/monitors")
    codes = read_codes(site, "reference/run-folder")
    assert {START, WALLS, HEARTBEAT, f"{FRAMES}/", *(f"logs/{name}" for name in SOLVER_LOGS)} <= codes
    assert {name for name in DECKS if name.startswith("DEM/")} <= codes
    assert {name.split("/")[0] + "/" for name in DECKS} <= codes | {"DEM/"}


def test_every_result_and_page_of_code_is_reached(site):
    reports = {path.parent.relative_to(DOCS) for path in (DOCS / "results").rglob("README.md")}
    assert len(reports) >= 9
    assert all((site / folder / "README.html").is_file() for folder in reports)


def test_pages_need_no_network(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r'<(?:script|link|img)[^>]*(?:src|href)="(?:https?:)?//', text), page.name


def test_paths_of_code_on_pages_exist():
    missing = []
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *DOCS.rglob("*.md")]:
        if {"_build", "results"} & set(page.parts):
            continue
        found = re.findall(r"`((?:fbcouple|postproc|templates|tests|docs|cases|scripts)/[\w./-]*)`", page.read_text())
        missing += [(page.name, path) for path in found if not (ROOT / path).exists() and path != "docs/_build/"]
    assert missing == []
