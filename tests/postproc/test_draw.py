"""`draw`: the files it writes, what it leaves out, and that nothing half done is left behind."""

import os
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from matplotlib.image import imread

from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.postproc import FIGURES, draw
from fbcouple.run_folder.products import remove_products
from tests.postproc.whole_run import write_whole

NAMES = {"solids_fraction", "solids_flux", "flux_profile", "slices", "history", "cost"}
"""What the synthetic results allow; test_whole.py draws the others."""
NOT_MEANT = {"fluidization_curve", "impact", "means_error", "measured_lines", "mixing", "probes"}
NOT_MEANT |= {"radial_profiles", "sections", "temperature", "throughput"}
"""What is for results of another kind, and is left out without a word."""


def test_every_figure_is_a_png_of_its_own_name_and_nothing_else_is_left(run):
    settings = dict(matplotlib.rcParams)
    paths = draw(run)
    assert {path.stem for path in paths} == NAMES
    assert sorted(path.name for path in (run / "figures").iterdir()) == sorted(f"{name}.png" for name in NAMES)
    for path in paths:
        assert path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert imread(path)[..., :3].std() > 0.05, f"{path.name} is blank"
    assert dict(matplotlib.rcParams) == settings


@pytest.mark.parametrize("name", sorted(FIGURES))
def test_every_figure_says_what_it_shows(name):
    assert FIGURES[name].__doc__


def test_resolution_is_200_dots_per_inch(run):
    height, width, _ = imread(next(path for path in draw(run) if path.stem == "history")).shape
    assert width == 7.0 * 200
    assert height > 800


def test_gas_alone_draws_what_it_has_and_removes_older_pictures(dataset, write, caplog):
    dataset["gas_velocity"] = dataset["solids_flux"]
    run = write(dataset.drop_vars([name for name in dataset if name.startswith("solids_")]))
    stale = run / "figures" / "solids_flux.png"
    stale.parent.mkdir()
    stale.write_bytes(b"older")
    assert {path.stem for path in draw(run)} == {"history", "cost"}
    assert not stale.exists()
    assert "solids_flux.png left out" in caplog.text
    assert "no `solids_flux`" in caplog.text


def test_grains_alone_are_drawn(dataset, write):
    case = dataset.attrs["case"]
    dataset.attrs["case"] = case[: case.index("[gas]")] + case[case.index("[particles]") :]
    run = write(dataset.drop_vars(["pressure_drop", "max_courant", "substeps"]))
    assert {path.stem for path in draw(run)} == NAMES


def test_a_scene_without_averages_draws_its_history(dataset, write):
    case = dataset.attrs["case"]
    dataset.attrs["case"] = case[: case.index("[averages]")]
    for side in ("start", "end"):
        del dataset.attrs[f"averaging_{side}"]
    run = write(dataset.drop_vars([name for name in dataset if "x" in dataset[name].dims]))
    assert {path.stem for path in draw(run)} == {"history", "cost"}


@pytest.mark.parametrize("how", ["absent", "not a number"])
def test_before_averaging_has_begun_the_history_is_drawn(dataset, write, caplog, how):
    means = [name for name in dataset if "x" in dataset[name].dims]
    lean = dataset.drop_vars(means) if how == "absent" else dataset.assign({n: dataset[n] * np.nan for n in means})
    assert {path.stem for path in draw(write(lean))} == {"history", "cost"}
    assert "solids_flux.png left out" in caplog.text
    assert "averaging starts at t = 1 s" in caplog.text and "last record is at t = 0.02 s" in caplog.text


def test_missing_results_leave_no_folder(tmp_path):
    with pytest.raises(CaseError, match="does not exist"):
        draw(tmp_path)
    assert not (tmp_path / "figures").exists()


def test_results_that_allow_no_figure_say_why_for_each(dataset, write):
    dataset["gas_velocity"] = dataset["solids_flux"]
    run = write(dataset[["gas_velocity"]])
    with pytest.raises(CaseError, match="none of the figures") as caught:
        draw(run)
    assert [text.split()[0] for text in caught.value.problems[1:]] == [
        f"{name}.png" for name in FIGURES if name not in NOT_MEANT
    ], "a bed with gas is not meant to have an impact, nor a case to have measured lines, probes, a ramp or a radius"


def test_a_picture_that_fails_leaves_the_older_one_and_no_temporary_file(run, monkeypatch):
    before = {path: path.read_bytes() for path in draw(run)}

    def fail(self, target, **options):
        target.write_bytes(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(CaseError, match=r"cost\.png: cannot be written \(disk full\); give another place with -o"):
        draw(run)
    assert {path: path.read_bytes() for path in (run / "figures").iterdir()} == before


def test_figures_need_neither_mpi_nor_solver_nor_pyplot():
    probe = "import sys, postproc; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "fbcouple.postproc.figures.maps" in loaded
    assert not loaded & {
        "mpi4py",
        "numba",
        "fbcouple.case",
        "fbcouple.simulation.worker",
        "matplotlib.pyplot",
        "pyvista",
    }


def test_post_and_report_load_no_mpi_and_find_no_solver(run):
    """As on a machine that has neither: nothing is on the PATH."""
    probe = (
        "import sys; from fbcouple.cli.main import cli\n"
        f"for words in (['post'], ['report']): cli([*words, {str(run)!r}], standalone_mode=False)\n"
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", probe], env={**os.environ, "PATH": ""}, capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "fbcouple.postproc.report.report" in loaded and (run / "report.html").is_file()
    engines = {
        name
        for name in loaded
        if name.startswith(("fbcouple.engines", "fbcouple.exchange", "fbcouple.simulation.worker"))
    }
    assert not engines | loaded & {"mpi4py", "numba", "fbcouple.launcher.launch"}


def test_figures_go_to_the_folder_that_is_asked_for(run, tmp_path):
    done = CliRunner().invoke(cli, ["post", str(run), "-o", str(tmp_path / "else" / "where"), "--vtk"])
    assert done.exit_code == 0, done.output
    where = tmp_path / "else/where"
    assert {path.stem for path in where.glob("*.png")} == NAMES and (where / "vtk/means.vti").is_file()
    assert not (run / "figures").exists() and not (run / "vtk").exists()


@pytest.mark.parametrize(
    ("blocked", "command", "fix"),
    [
        ("figures", ["post"], "give another place with -o"),
        ("report.html", ["report"], "give another place with -o"),
        ("vtk", ["post", "--vtk"], "give another place with -o"),
        ("claims/claims.json", ["claims", "--json"], "give another file with --json"),
    ],
)
def test_what_cannot_be_written_is_told_in_one_line_with_the_way_out(run, blocked, command, fix):
    """As in a run folder that is read-only; here something else stands in the way, which root cannot pass either."""
    if blocked == "report.html":
        (run / blocked / "kept").mkdir(parents=True)
    else:
        (run / blocked.partition("/")[0]).write_text("a file of the user's")
    words = [*command, str(run / blocked)] if "--json" in command else command
    done = CliRunner().invoke(cli, [*words, str(run)])
    assert done.exit_code == 1 and isinstance(done.exception, SystemExit), done.output
    last = done.output.splitlines()[-1]
    assert f"{run / blocked}" in last and "cannot be written" in last and last.endswith(f"{fix}.")
    assert (run / blocked.partition("/")[0]).exists() and not list(run.glob(".*"))


def test_a_bed_is_not_told_that_it_is_no_single_impact(run, caplog):
    draw(run)
    assert "impact.png" not in caplog.text and "voidage_snapshots.png left out" in caplog.text


@pytest.mark.parametrize(("ending", "head"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_figures_in_the_format_and_of_the_names_that_are_asked_for(run, ending, head):
    done = CliRunner().invoke(cli, ["post", str(run), "--format", ending, "--only", "cost", "--only", "flux_profile"])
    assert done.exit_code == 0, done.output
    files = sorted((run / "figures").iterdir())
    assert [path.name for path in files] == [f"cost.{ending}", f"flux_profile.{ending}"]
    assert all(path.read_bytes().startswith(head) for path in files)
    remove_products(run)
    assert not (run / "figures").exists(), "a new run removes the pictures of the old one"


def test_a_name_that_is_no_figure_is_refused_with_the_nearest(run):
    done = CliRunner().invoke(cli, ["post", str(run), "--only", "histroy"])
    assert done.exit_code == 1 and not (run / "figures").exists()
    assert "--only: 'histroy' is no figure" in done.output and "did you mean `history`?" in done.output


def test_one_figure_that_cannot_be_drawn_says_why(run):
    done = CliRunner().invoke(cli, ["post", str(run), "--only", "measured_lines"])
    assert done.exit_code == 1 and "names no measured lines (output.references)" in done.output


def test_height_and_full_height_on_the_command_line(run):
    plain = imread(next(path for path in draw(run) if path.stem == "solids_fraction")).shape
    done = CliRunner().invoke(cli, ["post", str(run), "--full-height", "--height", "0.05", "--height", "0.06"])
    assert done.exit_code == 0, done.output
    full = imread(run / "figures/solids_fraction.png").shape
    assert full[0] / full[1] > 1.5 * plain[0] / plain[1]
    for height in ("-1", "0", "inf", "nan", "wide"):
        assert CliRunner().invoke(cli, ["post", str(run), "--height", height]).exit_code == 2


def test_measured_lines_of_the_case_are_drawn(tmp_path):
    run = write_whole(tmp_path / "run", references=("voidage@0.03=line.csv",))
    (run / "line.csv").write_text("x,value\n0.01,0.7\n0.07,0.6\n")
    (picture,) = draw(run, only=["measured_lines"])
    assert picture.name == "measured_lines.png" and imread(picture)[..., :3].std() > 0.05
