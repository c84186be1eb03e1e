"""What an index, a citation and a contributor see of the project says the same everywhere."""

from __future__ import annotations

import re
import tomllib

import yaml
from pages import ROOT

from fbcouple import __version__

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_versions_agree():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == __version__
    versions = re.findall(r"^## (?:Unreleased: )?(\d+\.\d+\.\d+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert __version__ in versions
    assert versions == sorted(versions, reverse=True)


def test_citation_names_licence_and_paper():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert citation["license"] == PROJECT["license"]
    assert citation["authors"] == PROJECT["authors"]
    assert citation["references"][0]["doi"] in (ROOT / "README.md").read_text(encoding="utf-8")


def test_hooks_before_a_commit_download_nothing():
    content = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))
    assert [repo["repo"] for repo in content["repos"]] == ["local"]
    hooks = {hook["id"]: hook for hook in content["repos"][0]["hooks"]}
    assert set(hooks) == {"ruff", "ruff-format", "mypy", "codespell", "clang-format"}
    assert all(hook["language"] == "system" and hook["entry"].startswith(".venv/") for hook in hooks.values())


def test_metadata_is_what_an_index_page_wants():
    assert "urls" not in PROJECT
    assert PROJECT["keywords"] and PROJECT["classifiers"]
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 110
