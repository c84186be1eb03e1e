"""Mistakes that the field has made, put into a copy of the package: the check that should see each of them does."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from fbcouple.case.user_laws import DRAG_LAWS
from fbcouple.solvers.openfoam import build

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("fbcouple", "postproc", "templates", "cases")
PASSED, FAILED = 0, 4


@dataclass(frozen=True)
class Mutation:
    """Texts of files and what stands there instead, wherever they are, and the checks that must then fail."""

    changes: tuple[tuple[str, str, str], ...]
    checks: tuple[str, ...]


MUTATIONS = {
    "every drag law 5 % too strong": Mutation(
        (("fbcouple/physics/drag/laws.py", "beta[p] = ", "beta[p] = 1.05 * "),),
        tuple(f"fixed-bed-{law}" for law in DRAG_LAWS),
    ),
    "drag of the wrong sign": Mutation(
        (("fbcouple/coupling/kernels.py", "(uz - effective[p, 2])", "(effective[p, 2] - uz)"),), ("held-lattice",)
    ),
    "pressure gradient twice on the particles": Mutation(
        (
            (
                "fbcouple/coupling/kernels.py",
                "volume * force.gradient_factor * gz",
                "2.0 * volume * force.gradient_factor * gz",
            ),
        ),
        ("held-lattice",),
    ),
    "pressure gradient twice in the gas, Germano's identity with the width of the mesh": Mutation(
        (
            (
                "fbcouple/solvers/openfoam/adapter/gas.cpp",
                "fvm::laplacian(conductance, p_)",
                "fvm::laplacian(2.0*conductance, p_)",
            ),
            (
                "fbcouple/solvers/openfoam/adapter/turbulence.cpp",
                "coarse(4.0*mag(Sf[i])*Sf[i])",
                "coarse(mag(Sf[i])*Sf[i])",
            ),
        ),
        ("fixed-bed-ergun", "turbulence-localized-dynamic"),
    ),
    "no damping of their own for the walls": Mutation(
        (
            (
                "fbcouple/decks/context.py",
                "kind.mass, find_wall(",
                "kind.mass / 2, find_wall(",
            ),
        ),
        ("wall-restitution",),
    ),
    "six steps for every contact": Mutation(
        (("fbcouple/case/bed/contact_steps.py", "SPINNING = 12.5", "SPINNING = 3.0"),),
        ("settled-bed-hooke", "settled-bed-hertz"),
    ),
    "friction that forgets its contacts": Mutation(
        (("fbcouple/decks/context.py", '"history" if remembers', '"no_history" if remembers'),), ("heap-history",)
    ),
    "no reflection of the filter at walls": Mutation(
        (("fbcouple/coupling/box/filter.py", "0.75 * wall[q]", "0.5 * wall[q]"),), ("filter",)
    ),
    "filter of cells that forgets their volumes": Mutation(
        (
            (
                "fbcouple/coupling/polyhedral/filter.py",
                "field[:-1] /= self._volumes",
                "field[:-1] /= self._volumes.mean()",
            ),
        ),
        ("cylinder-conservation-short",),
    ),
    "walls hold the gas that should slip": Mutation(
        (("templates/openfoam/0/U", '{{ "slip" if case', '{{ "noSlip" if case'),), ("slip-walls",)
    ),
    "lift down, stress against the flow, a whole added mass": Mutation(
        (
            ("fbcouple/coupling/forces.py", "total[p, 2] += size", "total[p, 2] -= size"),
            ("fbcouple/coupling/forces.py", "mass * stress[p, axis]", "-mass * stress[p, axis]"),
            ("fbcouple/coupling/forces.py", "ADDED_MASS = 0.5", "ADDED_MASS = 1.0"),
        ),
        ("lift-force", "viscous-force", "virtual-mass"),
    ),
    "what other forces did in a step of another length": Mutation(
        (("fbcouple/coupling/coupling.py", "dt / (last_dt or dt)", "1.0"),), ("unequal-steps", "unequal-steps-water")
    ),
    "the voidage's change over the gas's own step": Mutation(
        (("fbcouple/solvers/openfoam/adapter/gas.cpp", "displaced_ = dt/moved", "displaced_ = 1"),), ("unequal-steps",)
    ),
}


def run_checks(place: Path, checks: tuple[str, ...]) -> tuple[int, set[str]]:
    """Exit code of `fbcouple verify` with the package in `place`, and the checks with a number that missed."""
    program = [
        sys.executable,
        "-c",
        "from fbcouple.cli.main import main; main()",
        "verify",
        *checks,
        "--json",
        "checks.json",
    ]
    environment = os.environ | {"PYTHONPATH": str(place), "PWD": str(place)}
    if (place / "cache").is_dir():
        environment["FBCOUPLE_CACHE"] = str(place / "cache")
        subprocess.run(
            [sys.executable, "-m", "fbcouple.solvers.openfoam.build"], cwd=place, env=environment, check=True
        )
    done = subprocess.run(program, cwd=place, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode in (PASSED, FAILED), done.stdout + done.stderr
    rows = json.loads((place / "checks.json").read_text())["checks"]
    return done.returncode, {row["name"].split(":")[0] for row in rows if not row["passed"]}


@pytest.mark.parametrize("name", MUTATIONS)
def test_what_a_mistake_changes_is_there(name):
    for file, old, _ in MUTATIONS[name].changes:
        assert old in (ROOT / file).read_text(), f"{file} no longer has what this mutation changes: {old}"


@pytest.mark.slow
@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mistake_is_seen(name, tmp_path):
    mutation = MUTATIONS[name]
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    for file, old, new in mutation.changes:
        text = (tmp_path / file).read_text()
        assert old in text, f"{file} no longer has what this mutation changes: {old}"
        (tmp_path / file).write_text(text.replace(old, new))
    if any(file.endswith(".cpp") for file, _, _ in mutation.changes):
        (tmp_path / "cache").mkdir()
        for headers in build.build_adapter().parent.glob("openfoam-*-headers"):
            (tmp_path / "cache" / headers.name).symlink_to(headers)
    code, missed = run_checks(tmp_path, mutation.checks)
    assert code == FAILED and missed == set(mutation.checks)
