"""A case's own drag law: read without being run, run only when trusted, compiled as the shipped ones are."""

import numpy as np
import pytest
from click.testing import CliRunner

from fbcouple.case.load import load_case
from fbcouple.case.schema.sections import Exchange
from fbcouple.case.user_laws import DRAG_LAWS, choose_drag, read_drag
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError

STOKES = """\
import math

def beta(voidage, slip, diameter, density, viscosity):
    return 3 * math.pi * viscosity * diameter / voidage
"""
CASE = """\
title = "own law"
end_time = 0.1

[domain]
size = [0.02, 0.01, 0.06]
cells = [8, 4, 24]

[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 0.8

[particles]
diameter = 1e-3
density = 2500.0
count = 500

[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1

[start]

[exchange]
drag = "own"
drag_file = "mylaw.py"
"""


@pytest.fixture
def case(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    (tmp_path / "mylaw.py").write_text(STOKES)
    return tmp_path


def problems(case, *sets):
    with pytest.raises(CaseError) as caught:
        load_case(str(case), sets)
    return "\n".join(caught.value.problems)


def fbcouple(*words):
    return CliRunner().invoke(cli, [str(word) for word in words])


def test_it_gives_what_its_function_gives(case):
    law = read_drag(case / "mylaw.py")
    voidages = np.linspace(0.4, 1.0, 7)
    assert law(voidages, 1.0, 1e-3, 1.165, 2e-5) == pytest.approx(
        DRAG_LAWS["stokes"](1.0, 1.0, 1e-3, 1.165, 2e-5) / voidages
    )


def test_the_case_chooses_it(case):
    own = choose_drag(Exchange(drag="own", drag_file="mylaw.py"), case)
    assert own(0.5, 1.0, 1e-3, 1.165, 2e-5) == pytest.approx(6e-8 * np.pi * 2, rel=1e-12)
    assert choose_drag(Exchange(), case) is DRAG_LAWS["huilin-gidaspow"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("beta = (", "mylaw.py is not Python, line 1; fix it."),
        ("gamma = 1\n", "has no function `beta`; write `def beta(voidage, slip, diameter, density, viscosity):`"),
        ("def beta(eps, slip):\n    return 1.0\n", "`beta` takes (eps, slip); write `def beta(voidage,"),
    ],
)
def test_check_reads_the_file_without_running_it(case, text, words):
    (case / "mylaw.py").write_text(text + ("raise SystemExit('it was run')\n" if "\n" in text else ""))
    found = problems(case)
    assert "exchange.drag_file: " in found and words in found


def test_names_and_files_that_do_not_go_together(case):
    assert "give the .py file that holds the law" in problems_without_file(case)
    assert 'give exchange.drag = "own" or remove the file' in problems(case, "exchange.drag=ergun")
    assert "the bare name of a .py file is allowed" in problems(case, "exchange.drag_file=../mylaw.py")
    assert "the bare name of a .py file is allowed" in problems(case, "exchange.drag_file=mylaw.txt")
    assert "cannot be read: No such file" in problems(case, "exchange.drag_file=other.py")


def problems_without_file(case):
    (case / "case.toml").write_text(CASE.replace('drag_file = "mylaw.py"', ""))
    found = problems(case)
    (case / "case.toml").write_text(CASE)
    return found


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("return open('x').read()", "cannot be compiled by numba"),
        ("return -1.0", "beta is negative or not finite"),
        ("return 1.0 / slip", "beta is negative or not finite"),
    ],
)
def test_a_law_that_is_none(case, body, words):
    (case / "mylaw.py").write_text(f"def beta(voidage, slip, diameter, density, viscosity):\n    {body}\n")
    with pytest.raises(CaseError, match=words):
        read_drag(case / "mylaw.py")


def test_an_error_in_the_file_is_told(case):
    (case / "mylaw.py").write_text(f"{STOKES}\n1 / 0\n")
    with pytest.raises(CaseError, match="fails \\(ZeroDivisionError: division by zero\\); fix the file"):
        read_drag(case / "mylaw.py")


def test_setup_and_run_ask_for_trust(case):
    refused = fbcouple("setup", case, "-o", case / "run")
    assert refused.exit_code == 1 and not (case / "run").exists()
    assert "exchange.drag_file: mylaw.py is Python code, which a run executes; read it" in refused.output
    assert fbcouple("setup", case, "-o", case / "run", "--trust").exit_code == 0
    assert (case / "run/mylaw.py").read_text() == STOKES
    refused = fbcouple("run", case / "run")
    assert refused.exit_code == 1 and "--trust" in refused.output


def test_check_runs_it_only_when_trusted(case):
    untrusted, trusted = fbcouple("check", case), fbcouple("check", case, "--trust")
    assert untrusted.exit_code == trusted.exit_code == 0
    assert "is not run" in untrusted.output and "terminal velocity" not in untrusted.output
    assert "is not run" not in trusted.output and "terminal velocity" in trusted.output


FIT = """\
import math

def beta(voidage, slip, diameter, density, viscosity):
    reynolds = voidage * density * slip * diameter / viscosity
    return 3 * math.pi * viscosity * diameter * (1 + 0.02 * reynolds - LAST * reynolds**2)
"""
FEED = "{low=[0.0,0.0,0.01],high=[0.02,0.01,0.06],rate=10.0,velocity=[0.0,0.0,-60.0]}"


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        ([], ""),
        (["gas.inlet_velocity=60.0"], "at voidage 0.36, slip 125 m/s, Re 2621 of 0.001 m, which this case can have"),
        ([f"particles.feeds=[{FEED}]"], "voidage 1"),
        (["particles.diameter=4e-3", "domain.size=[0.2,0.1,12.0]", "domain.cells=[8,4,240]"], "of 0.004 m"),
    ],
)
def test_a_law_is_tried_where_the_case_goes(case, sets, words):
    """A fit in Re that is negative from 2030 on: not of the 1 mm sphere in air at 30 m/s that every law is tried at."""
    (case / "mylaw.py").write_text(FIT.replace("LAST", "1.01e-5"))
    done = fbcouple("check", case, "--trust", *(word for one in sets for word in ("--set", one)))
    refused = "exchange.drag_file: beta is -" in done.output and "at least 0 is allowed: fix" in done.output
    assert refused == (done.exit_code == 1) == bool(words) and words in done.output, done.output
