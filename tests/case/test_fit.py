"""What the pre-flight numbers call unfit is not set up without --force."""

from __future__ import annotations

import pytest

from fbcouple.case.bed.fluid_step import coupling_step, gas_step
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate, require_fit
from fbcouple.case.source import find_case, list_shipped
from fbcouple.errors import CaseError

STIFF = ("exchange.scheme=explicit", "gas.max_courant=5", "gas.max_fourier=5")


@pytest.mark.parametrize("name", list_shipped())
def test_shipped_cases_are_fit(name, on_a_cluster):
    require_fit(load_case(name), folder=find_case(name).parent)


def test_unfit_case_is_refused_with_number_limit_and_mend(call, tmp_path):
    sets = [word for text in STIFF for word in ("--set", text)]
    refused = call("setup", "patil/c1", "-o", "run", *sets)
    assert refused.exit_code == 1 and not (tmp_path / "run").exists()
    assert refused.stderr.startswith("fluid step/tau_g: ") and "below 2" in refused.stderr
    assert "--force" in refused.stderr
    assert call("setup", "patil/c1", "-o", "run", "--force", *sets).exit_code == 0
    assert (tmp_path / "run/case.toml").is_file()


@pytest.mark.parametrize(
    ("setting", "start"),
    [
        ("particles.coarse_graining=2.5", "patil/c3: cell size x: "),
        ("particles.coarse_graining=0.2", "patil/c1: --set: particles.coarse_graining: "),
    ],
)
def test_every_line_of_a_refused_set_names_its_case(call, tmp_path, setting, start):
    refused = call("setup", "patil/all", "-o", "runs", "--set", setting)
    lines = refused.stderr.splitlines()
    assert refused.exit_code == 1 and lines[0].startswith(start) and not (tmp_path / "runs").exists()
    assert all(line.startswith(f"{start.partition(':')[0]}: ") for line in lines)


def test_every_unfit_number_is_told():
    with pytest.raises(CaseError) as caught:
        require_fit(load_case("patil/c1", [*STIFF, "contact.stiffness=1.0"]))
    assert {problem.split(":")[0] for problem in caught.value.problems} == {"fluid step/tau_g", "overlap"}


def test_longest_step_and_dem_step_bound_the_coupling_step():
    case = load_case("patil/c2", ["gas.max_step=5e-5"])
    assert gas_step(case) == 5e-5 and coupling_step(case) == 5e-5
    soft = load_case("patil/c2", ["gas.max_step=5e-5", "contact.stiffness=1.0"])
    assert coupling_step(soft) > 5e-5
    numbers = {number.name: number for number in estimate(soft)}
    assert numbers["DEM steps per fluid step"].verdict == "warn"
    assert "the gas, solved every DEM step, is what costs" in numbers["DEM steps per fluid step"].meaning
