"""What a run is made with: found without a solver that runs, and enough of it to tell one run from another."""

from __future__ import annotations

from pathlib import Path

from test_layers import GRAPH, ROOT, reach

from fbcouple.case.load import load_case
from fbcouple.run_folder.provenance import list_makers
from fbcouple.solvers import versions


def test_every_source_that_a_rank_runs_is_in_the_hash(monkeypatch):
    """The modules that the time loop reaches lie in no folder that is left out."""
    parts = {name.split(".")[1] for name in reach("fbcouple.simulation.worker") if name in GRAPH and name.count(".")}
    assert not parts & set(versions._NO_PART) and "coupling" in parts


def test_a_change_of_the_sources_changes_the_hash(tmp_path, monkeypatch):
    (tmp_path / "coupling").mkdir()
    (tmp_path / "study").mkdir()
    monkeypatch.setattr(versions, "PACKAGE", tmp_path)
    hashes = []
    for name in ("coupling/law.py", "coupling/gas.cpp", "study/plots.py"):
        (tmp_path / name).write_text(name)
        versions.hash_sources.cache_clear()
        hashes.append(versions.hash_sources())
    versions.hash_sources.cache_clear()
    assert len(set(hashes)) == 2 and hashes[1] == hashes[2]


def test_both_solvers_and_what_counts_are_told():
    found = versions.list_versions(load_case("patil/c2"))
    assert found["OpenFOAM"][0].isdecimal() and found["adapter"].startswith("adapter-")
    assert found["LIGGGHTS"].startswith("LIGGGHTS-PUBLIC 3") and "Open MPI" in found["MPI"]
    assert set(found) - set(list_makers(found)) == {"commit", "python", "machine", "MPI"}


def test_a_program_that_is_not_there_is_told_and_no_error(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("WM_PROJECT_DIR", str(tmp_path))
    found = versions.list_versions(load_case("patil/c2"))
    assert found["OpenFOAM"] == found["adapter"] == found["MPI"] == versions.NOT_FOUND


def test_the_commit_is_that_of_the_checkout(monkeypatch, tmp_path):
    assert len(versions.find_commit()) >= 12 or not (Path(ROOT) / ".git").exists()
    monkeypatch.setattr(versions, "ABOVE", tmp_path)
    assert versions.find_commit() == "not a checkout"
