"""The versions that scripts/install.sh asks for: there must be such a version for Debian 12's own Python, too."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).resolve().parents[1]
OLDEST = "3.11.2"
"""Python of Debian 12; the bound of pyproject.toml is no closer than 3.11."""
LINES = (ROOT / "scripts/constraints.txt").read_text().splitlines()
WANTED = [Requirement(line) for line in LINES if line and not line.startswith("#")]


def list_wanted(python: str) -> dict[str, str]:
    """Package -> the one version that is wanted for the Python of that version."""
    found = {}
    for one in WANTED:
        told = {"python_full_version": python, "python_version": python.rpartition(".")[0]}
        if one.marker is None or one.marker.evaluate(told):
            assert one.name not in found and len(one.specifier) == 1
            found[one.name] = str(one.specifier)
    return found


def test_every_package_has_one_version_whatever_the_python():
    assert {one.name for one in WANTED} == set(list_wanted(OLDEST)) == set(list_wanted("3.13.5"))


def test_debian_12_has_a_python_for_each():
    """Of the packages that are installed here in the version that Debian 12 would get."""
    looked = 0
    for name, version in list_wanted(OLDEST).items():
        try:
            found = distribution(name)
        except PackageNotFoundError:
            continue
        if version == f"=={found.version}" and (bound := found.metadata["Requires-Python"]):
            assert SpecifierSet(bound).contains(OLDEST), f"{name} {version} wants Python {bound}"
            looked += 1
    assert looked > len(WANTED) // 2
