"""A case's own law of heat transfer: read without being run, run only when trusted, compiled as shipped ones are."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from fbcouple.case.load import load_case
from fbcouple.case.schema.heat import Heat
from fbcouple.case.user_laws import NUSSELT_LAWS, choose_nusselt, read_nusselt
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.results.reader import open_results

RANZ = """\
import math

def nusselt(voidage, reynolds, prandtl):
    return 2.0 + 0.6 * math.sqrt(reynolds) * prandtl ** (1.0 / 3.0)
"""
CASE = """\
title = "own law of heat transfer"
end_time = 0.004

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
count = 200

[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1

[start]

[exchange]

[heat]
gas_temperature = 300.0
gas_specific_heat = 1010.0
prandtl = 0.7
particle_temperature = 350.0
particle_specific_heat = 840.0
nusselt = "own"
nusselt_file = "mylaw.py"
"""


@pytest.fixture
def case(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    (tmp_path / "mylaw.py").write_text(RANZ)
    return tmp_path


def problems(case, *sets):
    with pytest.raises(CaseError) as caught:
        load_case(str(case), sets)
    return "\n".join(caught.value.problems)


def fbcouple(*words):
    return CliRunner().invoke(cli, [str(word) for word in words])


def test_it_gives_what_its_function_gives(case):
    voidages, numbers = np.linspace(0.4, 1.0, 7), np.geomspace(1e-3, 1e4, 7)
    expected = NUSSELT_LAWS["ranz-marshall"](voidages, numbers, 0.7)
    assert read_nusselt(case / "mylaw.py")(voidages, numbers, 0.7) == pytest.approx(expected, rel=1e-14)


def test_the_case_chooses_it(case):
    own = choose_nusselt(Heat(nusselt="own", nusselt_file="mylaw.py"), case)
    assert own(0.5, 0.0, 0.7) == pytest.approx(2.0, abs=1e-15)
    assert choose_nusselt(Heat(), case) is NUSSELT_LAWS["gunn"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("nusselt = (", "mylaw.py is not Python, line 1; fix it."),
        ("gamma = 1\n", "has no function `nusselt`; write `def nusselt(voidage, reynolds, prandtl):`"),
        ("def nusselt(re):\n    return 1.0\n", "`nusselt` takes (re); write `def nusselt(voidage,"),
    ],
)
def test_check_reads_the_file_without_running_it(case, text, words):
    (case / "mylaw.py").write_text(text + ("raise SystemExit('it was run')\n" if "\n" in text else ""))
    found = problems(case)
    assert "heat.nusselt_file: " in found and words in found


def test_names_and_files_that_do_not_go_together(case):
    assert 'give heat.nusselt = "own" or remove the file' in problems(case, "heat.nusselt=gunn")
    assert "the bare name of a .py file is allowed" in problems(case, "heat.nusselt_file=../mylaw.py")
    assert "cannot be read: No such file" in problems(case, "heat.nusselt_file=other.py")
    (case / "case.toml").write_text(CASE.replace('nusselt_file = "mylaw.py"', ""))
    assert "heat.nusselt is own and no file is given" in problems(case).replace('"', "")


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("return open('x').read()", "cannot be compiled by numba"),
        ("return -1.0", "nusselt is negative or not finite"),
        ("return 1.0 / reynolds", "nusselt is negative or not finite"),
    ],
)
def test_a_law_that_is_none(case, body, words):
    (case / "mylaw.py").write_text(f"def nusselt(voidage, reynolds, prandtl):\n    {body}\n")
    with pytest.raises(CaseError, match=words):
        read_nusselt(case / "mylaw.py")
    refused = fbcouple("setup", case, "-o", case / "run", "--trust")
    assert refused.exit_code == 1 and words in refused.output and not (case / "run").exists()


def test_check_says_that_it_was_not_run(case):
    untrusted, trusted = fbcouple("check", case), fbcouple("check", case, "--trust")
    assert untrusted.exit_code == trusted.exit_code == 0, untrusted.output
    assert "heat.nusselt_file is not run" in untrusted.output and "is not run" not in trusted.output
    assert "terminal velocity" in untrusted.output


def test_a_run_has_it_when_trusted(case):
    refused = fbcouple("setup", case, "-o", case / "run")
    assert refused.exit_code == 1 and not (case / "run").exists()
    assert "heat.nusselt_file: mylaw.py is Python code, which a run executes; read it" in refused.output
    means = {}
    for law in ("own", "ranz-marshall", "gunn"):
        text = CASE if law == "own" else CASE.replace('nusselt_file = "mylaw.py"', "").replace('"own"', f'"{law}"')
        (case / "case.toml").write_text(text)
        assert fbcouple("setup", case, "-o", case / law, "--trust").exit_code == 0
        ran = fbcouple("run", case / law, "-n", "1", "--trust")
        assert ran.exit_code == 0, ran.output
        means[law] = open_results(case / law).data["mean_particle_temperature"].values
    assert (case / "own/mylaw.py").read_text() == RANZ
    cooled = 350.0 - means["ranz-marshall"][-1]
    assert cooled > 0.05
    assert means["own"] == pytest.approx(means["ranz-marshall"], abs=1e-6 * cooled)
    assert abs(means["gunn"][-1] - means["ranz-marshall"][-1]) > 0.05 * cooled


def test_a_law_is_tried_where_the_case_goes(case):
    """One that is negative beyond Re = 2e4, which every law is tried up to half of, in a gas as fast as that."""
    (case / "mylaw.py").write_text("def nusselt(voidage, reynolds, prandtl):\n    return 2.0 - 1e-4 * reynolds\n")
    assert fbcouple("check", case, "--trust").exit_code == 0
    done = fbcouple("check", case, "--trust", "--set", "gas.inlet_velocity=400.0")
    assert done.exit_code == 1 and "heat.nusselt_file: nusselt is -0." in done.output
    assert "of 0.001 m, which this case can have; at least 0 is allowed: fix the file" in done.output
