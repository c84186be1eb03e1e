"""What LIGGGHTS can do is asked of the library itself: of the one that is here, and of one that lacks something."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from fbcouple.case.load import load_case
from fbcouple.decks import abilities
from fbcouple.decks.abilities import PROBED, REFUSAL, list_lacking, make_case, probe, require_able, tell_able
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks
from fbcouple.doctor.abilities import rate_abilities
from fbcouple.errors import SolverError
from fbcouple.paths import TEMPLATES
from fbcouple.solvers.site_files import LIGGGHTS, find_liggghts

SHIM = r"""
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
// LIGGGHTS without %(lacks)s.
extern "C" char *lammps_command(void *library, char *line)
{
    if (std::strstr(line, "%(lacks)s")) {
        std::FILE *log = std::fopen("liggghts.log", "a");
        std::fputs("ERROR: Unknown style (no/file.cpp:7)\n", log);
        std::fclose(log);
        std::exit(1);
    }
    using Command = char *(*)(void *, char *);
    return reinterpret_cast<Command>(dlsym(RTLD_NEXT, "lammps_command"))(library, line);
}
"""
ANSWERS = dict.fromkeys(PROBED, "")


@pytest.fixture
def lacking(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Make the library here one that does not take commands with a word in them."""

    def build(word: str) -> None:
        real = next(path for path in Path("/usr/lib").glob(f"**/{find_liggghts()}"))
        source = tmp_path / "shim.cpp"
        source.write_text(SHIM % {"lacks": word})
        shim = tmp_path / "libfork.so"
        link = ["-Wl,--no-as-needed", str(real), "-ldl"]
        subprocess.run(["g++", "-shared", "-fPIC", source, "-o", shim, *link], check=True)
        monkeypatch.setenv(LIGGGHTS, str(shim))

    return build


def test_the_library_here_can_do_all_that_decks_ask_for():
    assert probe() == ANSWERS


def test_a_library_that_lacks_a_model_is_told_by_the_command_that_it_refuses(lacking):
    lacking("rolling_friction cdt")
    answers = probe()
    assert [part for part, words in answers.items() if words] == ["rolling_friction"]
    told = answers["rolling_friction"]
    assert re.fullmatch(r"pair_style gran model \S+.* rolling_friction cdt: ERROR: Unknown style", told)


def test_doctor_is_content_with_a_library_that_runs_some_cases(monkeypatch):
    for lacking, ok, found in (
        ({}, True, f"all {len(PROBED)}"),
        ({"hertz": "x: y"}, True, "no hertz (x: y)"),
        ({"coupling": "x: y"}, False, "no coupling"),
    ):
        monkeypatch.setattr("fbcouple.doctor.abilities.probe", lambda lacking=lacking: ANSWERS | lacking)
        row = rate_abilities()
        assert row.ok is ok and found in row.found


def test_without_the_coupling_no_run_works(lacking, tmp_path, monkeypatch):
    """And a case is refused before anything starts; one without gas is not."""
    lacking("couple/cfd/force")
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "cache"))
    said: list[str] = []
    with pytest.raises(
        SolverError, match=r"a fork lacks what this case needs: coupling\b.* \(fix gas all couple/cfd/force: "
    ):
        require_able(load_case("patil/c2"), "a fork", said.append)
    assert not require_able(load_case("anand/hopper"), "a fork", said.append)["particles"] and said == []


def test_a_library_is_asked_once(tmp_path, monkeypatch):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    asked: list[int] = []
    monkeypatch.setattr(abilities, "probe", lambda: asked.append(1) or ANSWERS)
    case = load_case("patil/c2")
    for library in ("one", "one", "another"):
        assert require_able(case, library, asked.append) == ANSWERS
    assert len(asked) == 2 and len(list(tmp_path.glob("liggghts-*.json"))) == 2
    next(tmp_path.glob("liggghts-*.json")).write_text("{}")
    require_able(case, "one", asked.append), require_able(case, "another", asked.append)
    assert len(asked) == 3


def test_an_answer_that_is_not_liggghts_own_refuses_nothing_and_is_not_kept(tmp_path, monkeypatch):
    """A process that was killed says nothing of the library."""
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    killed = ANSWERS | {"coupling": "run 1: ended by SIGKILL"}
    monkeypatch.setattr(abilities, "probe", lambda: killed)
    assert require_able(load_case("patil/c2"), "one", pytest.fail) == killed and not list(tmp_path.iterdir())
    assert list_lacking(load_case("patil/c2"), {"coupling": f"fix: {REFUSAL}", "hertz": f"x: {REFUSAL}"}) == {
        "coupling": f"fix: {REFUSAL}"
    }


def test_a_library_that_cannot_be_asked_is_no_reason_not_to_run(monkeypatch, tmp_path):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    monkeypatch.setenv(LIGGGHTS, str(tmp_path / "none.so"))
    said: list[str] = []
    assert require_able(load_case("patil/c2"), "none", said.append) == {}
    assert len(said) == 1 and "cannot be asked" in said[0] and "none.so: no such file" in said[0]


@pytest.mark.parametrize("part", PROBED)
def test_a_question_is_a_bed_that_has_the_part(part):
    assert find_needs(make_case(part))[part]


def test_questions_have_every_style_that_decks_may_have():
    """A new fix or model in a template wants a row in PROBED."""
    texts = [text for part in PROBED for name, text in render_decks(make_case(part)).items() if name.startswith("DEM/")]
    asked = "\n".join(texts)
    template = "".join(path.read_text() for path in sorted((TEMPLATES / "liggghts").iterdir()))
    fixes = set(re.findall(r"^fix +\S+(?: \S+)? all +([a-z][\w/]+)", template, re.MULTILINE))
    missing = {one for one in fixes if not re.search(rf"^fix .* all +{one}\b", asked, re.MULTILINE)}
    assert len(fixes) >= 8 and missing == set()
    commands = {line.split()[0] for line in template.splitlines() if re.match(r"[a-z_]+ ", line)}
    assert {one for one in commands if not re.search(rf"^{one}\b", asked, re.MULTILINE)} == set()
    parts = set(re.findall(r"needs\.(\w+)", template)) - {"gravity"}
    assert parts <= set(PROBED)


def test_parts_that_fail_by_the_same_command_are_told_together():
    told = {"particles": "atom_style granular: no", "hertz": "pair: no", "coupling": "atom_style granular: no"}
    assert abilities.format_lacking(told) == "particles, coupling (atom_style granular: no); hertz (pair: no)"


def test_what_a_manifest_says():
    told = tell_able({"hertz": "", "rotation": "fix: ERROR"})
    assert told == {"can": ["hertz"], "cannot": {"rotation": "fix: ERROR"}} and json.dumps(told)
