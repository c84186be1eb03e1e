"""Results are removed by their names; what else lies in a run folder is the user's and stays."""

import pytest

import fbcouple.postproc
from fbcouple.errors import CaseError
from fbcouple.run_folder.manifest import write_manifest
from fbcouple.run_folder.products import PICTURES, remove_products, remove_run

OURS = (
    "results.nc",
    "report.html",
    "frames/frame-000003.nc",
    "figures/history.png",
    "figures/bed.gif",
    "checkpoints/step-000000000005/state.json",
    "checkpoints/step-000000000005.refused/state.json",
    "vtk/particles-000001.vtp",
    "tables/probe_tap.csv",
)
THEIRS = (
    "notes.txt",
    "frames/frame.nc",
    "figures/talk.png",
    "tables/mine.csv",
    "checkpoints/step-notes.txt",
    "vtk/view.pvsm",
)


def fill(run, names):
    for name in names:
        (run / name).parent.mkdir(parents=True, exist_ok=True)
        (run / name).write_text(name)


def list_files(run):
    return {path.relative_to(run).as_posix() for path in run.rglob("*") if path.is_file()}


def test_results_go_and_the_users_files_stay(tmp_path):
    fill(tmp_path, OURS + THEIRS)
    remove_products(tmp_path)
    assert list_files(tmp_path) == set(THEIRS)


def test_folders_that_are_empty_then_go_too(tmp_path):
    fill(tmp_path, OURS)
    remove_products(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_every_figure_is_known_by_its_name():
    assert set(PICTURES) == set(fbcouple.postproc.FIGURES)


def test_a_folder_of_another_program_is_not_touched(tmp_path):
    fill(tmp_path, OURS)
    with pytest.raises(CaseError, match="not a run folder"):
        remove_run(tmp_path)
    assert list_files(tmp_path) == set(OURS)
    write_manifest(tmp_path, {"fbcouple": "0.1.0", "files": {}, "case": {}})
    remove_run(tmp_path)
    assert list_files(tmp_path) == {"manifest.json"}
