"""Another run's particles as the start: of a checkpoint or a frame, on another mesh, and nothing else of that run."""

from __future__ import annotations

import json
import os
import shutil

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner

from fbcouple.case.bed.positions import start_kinds, start_motion, start_positions
from fbcouple.case.load import load_case
from fbcouple.cli.main import cli
from fbcouple.decks import other_run, starts
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.launcher.launch import launch
from fbcouple.results.frames import Frame, read_frame
from fbcouple.run_folder.manifest import hash_file

CASE = """
title = "where particles come from"
end_time = 0.004
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 100
mixture = [[0.8e-3, 1500.0, 0.3]]
fractions = "number"
rotation = true
[contact]
restitution = 0.9
wall_restitution = 0.9
friction = 0.3
wall_friction = 0.3
stiffness = 100.0
[start]
[output]
record_every = 1e-3
particles_every = 1e-3
[checkpoint]
moment_steps = 5
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 2.0
[exchange]
filter_passes = 1
"""


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A run to its end, with 5 frames and a checkpoint of the end."""
    folder = tmp_path_factory.mktemp("source")
    (folder / "case.toml").write_text(CASE)
    (run,) = lay_out(str(folder), folder / "run", (), False, True)
    launch(run, 1, lambda row: None)
    return run


@pytest.fixture
def bed(source, tmp_path):
    """Set a case up that starts with the particles of that run, with settings; returns its folder and case."""
    (tmp_path / "case.toml").write_text(CASE.replace("[start]", f'[start]\nrun = "{source}"'))

    def set_up(*sets):
        ((run, case),) = lay_out(str(tmp_path), tmp_path / "run", sets, False, True).items()
        return run, case

    return set_up


def last_frame(source):
    return read_frame(max((source / "frames").glob("*.nc")))


def test_checkpoint_starts_a_run_on_a_finer_mesh(bed, source):
    """Positions and kinds as in the frame of the same moment, to its single precision; spins, which frames have not."""
    run, case = bed("domain.cells=[10, 6, 20]", "end_time=1e-3", "gas.inlet_velocity=0.5")
    positions, motion, frame = start_positions(case, run), start_motion(case, run), last_frame(source)
    assert positions == pytest.approx(frame.positions, rel=1e-6) and np.abs(motion[:, 3:]).max() > 0.1
    assert motion[:, :3] == pytest.approx(frame.velocities, rel=1e-6, abs=1e-9)
    sizes = np.array([1e-3, 0.8e-3])[start_kinds(case, run)]
    assert sizes == pytest.approx(frame.diameters) and set(sizes) == {1e-3, 0.8e-3}
    origin = json.loads((run / "manifest.json").read_text())["start"]
    (restart,) = (source / "checkpoints").glob("*/liggghts.restart")
    assert hash_file(restart) in origin and "where particles come from" in origin and str(source) in origin
    rows: list[dict] = []
    launch(run, 1, rows.append)
    assert rows[-1]["time"] >= 1e-3 and rows[0]["bed_height"] > 0


def test_run_folder_stands_without_the_other(bed, source, tmp_path):
    run, case = bed()
    text = (run / "case.toml").read_text()
    assert str(source) not in text and case.start is None
    assert load_case(str(run)) == case
    again = lay_out(str(run), tmp_path / "again", (), False, True)[tmp_path / "again"]
    assert again == case
    assert (tmp_path / "again/DEM/particles.data").read_bytes() == (run / "DEM/particles.data").read_bytes()


def test_frame_of_a_time_is_taken(bed, source):
    run, case = bed("start.time=2.1e-3")
    frame = min((read_frame(path) for path in (source / "frames").glob("*.nc")), key=lambda one: abs(one.time - 2.1e-3))
    assert 1.5e-3 < frame.time < 2.7e-3 and (start_positions(case, run) == frame.positions).all()
    assert not start_motion(case, run)[:, 3:].any()


def test_frame_over_a_periodic_side_is_taken(bed, source, tmp_path):
    """Frames have what LIGGGHTS holds, which brings particles in only where it makes its neighbour lists anew."""
    shutil.copytree(source, tmp_path / "moved", ignore=shutil.ignore_patterns("checkpoints"))
    for path in (tmp_path / "moved/frames").glob("*.nc"):
        with netCDF4.Dataset(path, "a") as file:
            file["position"][:, 0] -= 0.6e-3
    run, case = bed(f"start.run={tmp_path / 'moved'}", 'domain.periodic=["x"]')
    positions, held = start_positions(case, run), last_frame(tmp_path / "moved").positions.astype(float)
    over = held[:, 0] < 0.0
    assert 0 < over.sum() < 50 and (positions[~over] == held[~over]).all()
    assert positions[over, 0] == pytest.approx(held[over, 0] + 0.01)


def test_start_follows_a_run_without_checkpoints_by_its_last_frame(bed, source, tmp_path):
    shutil.copytree(source, tmp_path / "bare", ignore=shutil.ignore_patterns("checkpoints"))
    run, case = bed(f"start.run={tmp_path / 'bare'}")
    assert (start_positions(case, run) == last_frame(source).positions).all()


def test_path_starts_at_the_case_file_and_on_the_command_line_at_the_current_folder(source, tmp_path, monkeypatch):
    monkeypatch.chdir(source.parent)
    (tmp_path / "case.toml").write_text(CASE)
    case = load_case(str(tmp_path), ["start.run=run"])
    assert case.start.run == str(source)
    relative = os.path.relpath(source, tmp_path)
    (tmp_path / "case.toml").write_text(CASE.replace("[start]", f'[start]\nrun = "{relative}"'))
    made = starts.make_start(load_case(str(tmp_path)), tmp_path, tmp_path)
    assert made.particles == starts.make_start(case, tmp_path, tmp_path).particles
    assert made.particles == starts.expect_start(case, tmp_path).particles


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        (("start.run=nowhere",), r"start.run: .*nowhere is no run folder \(no case.toml\)"),
        (("start.time=9",), r"start.run: .* has nothing at 9 s; the nearest checkpoint or frame is of 0.004\d* s"),
        (
            ("particles.count=90",),
            r"start.run: \S*[^v] holds 100 particles and the case 90; give particles.count = 100",
        ),
        (
            ("particles.coarse_graining=1.2",),
            r"start.run: \S*[^v]: it holds particles \(l = 1\) and the case has parcels of l = 1.2 .*start from a run",
        ),
        (("particles.diameter=1.1e-3",), r"start.run: particle \d+ has 0.001 m and 2500 kg m-3, which no kind of the"),
        (("particles.density=2400.0",), r"start.run: particle \d+ has 0.001 m and 2500 kg m-3, which no kind of the"),
        (("particles.mixture=[]",), r"start.run: particle \d+ has 0.0008 m and 1500 kg m-3, which no kind of the case"),
        (("domain.size=[0.009, 0.006, 0.02]",), r"start.run: \S*[^v]: \d+ particles are not inside the box, first is"),
        (('particles.fractions="mass"',), r"start.run: \S*[^v] holds \[70, 30\] particles of each kind and the case"),
    ],
)
def test_what_does_not_fit_is_told_and_nothing_is_written(bed, tmp_path, sets, told):
    with pytest.raises(CaseError, match=told):
        bed(*sets)
    assert not (tmp_path / "run").exists()


@pytest.fixture
def copy(source, tmp_path):
    """A copy of the run to spoil, and its newest checkpoint."""
    shutil.copytree(source, tmp_path / "copy")
    (checkpoint,) = (tmp_path / "copy/checkpoints").iterdir()
    return tmp_path / "copy", checkpoint


def test_a_run_of_parcels_starts_no_bed_of_particles(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    case, other = (load_case(str(tmp_path), [f"particles.coarse_graining={ratio}"]) for ratio in (1.0, 1.2))
    frame = Frame(0.0, np.zeros((2, 3)), np.zeros((2, 3)), np.full(2, 1.2e-3), None, None, np.arange(2))
    source = other_run.Source(tmp_path / "frame-000001.nc", 0.0, frame)
    with pytest.raises(CaseError, match=r"run: it holds parcels of l = 1.2 and the case has particles \(l = 1\)"):
        other_run.read_particles(case, tmp_path / "run", other, source)
    alike = load_case(str(tmp_path), ["particles.diameter=0.6e-3", "particles.coarse_graining=2.0"])
    with pytest.raises(CaseError, match=r"run: it holds parcels of l = 1.2 and the case has parcels of l = 2 "):
        other_run.read_particles(alike, tmp_path / "run", other, source)  # spheres as large, of other grains


def test_damaged_restart_file_is_refused(bed, copy):
    run, checkpoint = copy
    restart = checkpoint / "liggghts.restart"
    content = bytearray(restart.read_bytes())
    content[-20] ^= 1
    restart.write_bytes(content)
    with pytest.raises(CaseError, match=r"start.run: .*refused: liggghts.restart"):
        bed(f"start.run={run}")


def test_checkpoint_of_another_user_is_refused_and_a_frame_of_his_is_taken(bed, copy, source):
    run, checkpoint = copy
    index = json.loads((checkpoint / "index.json").read_text())
    (checkpoint / "index.json").write_text(json.dumps(index | {"signature": "0" * 64}))
    with pytest.raises(CaseError, match=r"was not written by you, and nothing can check .* take a frame"):
        bed(f"start.run={run}")
    shutil.rmtree(checkpoint)
    assert len(start_positions(*reversed(bed(f"start.run={run}")))) == 100


def test_link_in_the_other_run_is_refused(bed, copy):
    run, _ = copy
    (run / "frames/frame-000009.nc").symlink_to("/etc/passwd")
    with pytest.raises(CaseError, match=r"frame-000009.nc: is a"):
        bed(f"start.run={run}")


def test_damaged_frame_is_refused(bed, copy):
    run, checkpoint = copy
    shutil.rmtree(checkpoint)
    max((run / "frames").glob("*.nc")).write_bytes(b"CDF\x01 and no more")
    with pytest.raises(CaseError, match=r"start.run: a frame cannot be read"):
        bed(f"start.run={run}")


def test_frames_of_kinds_of_one_size_are_refused(source):
    with pytest.raises(CaseError, match="has kinds of one diameter, which frames do not tell apart"):
        other_run._read_frame(last_frame(source), np.array([1e-3, 0.8e-3, 0.8e-3]), source, "frame-000000.nc")


def test_check_looks_at_the_other_run(bed, source, tmp_path):
    result = CliRunner().invoke(cli, ["check", str(tmp_path), "--set", "particles.count=90"])
    assert result.exit_code == 1 and "give particles.count = 100" in result.stderr
    assert f"particles of the run {source}" in CliRunner().invoke(cli, ["check", str(tmp_path)]).stdout


SETTLED = (
    "particles.count=4000",
    "particles.mixture=[]",
    "domain.size=[0.02, 0.01, 0.05]",
    "domain.cells=[10, 5, 25]",
    "contact.restitution=0.7",
    "contact.wall_restitution=0.7",
    "gas.inlet_velocity=0.3",
    "end_time=0.2",
)
FINER = "domain.cells=[16, 8, 40]"


@pytest.mark.slow
def test_settled_bed_is_the_same_bed_on_a_finer_mesh(tmp_path):
    """Below fluidization: it stays where it is, and has its pressure drop again where it is taken back.

    The coarse mesh smears the surface over a tenth of the bed, so that the pressure drop there is a bit lower.
    """
    folder = tmp_path / "bed"
    folder.mkdir()

    def run(name: str, *sets: str) -> tuple[float, float, float]:
        """Pressure drop [Pa], bed height and height of the centre of mass [m] at the end."""
        (made,) = lay_out(str(folder), tmp_path / name, (*SETTLED, *sets), False, True)
        rows: list[dict] = []
        launch(made, 1, rows.append)
        return rows[-1]["pressure_drop"], rows[-1]["bed_height"], rows[-1]["solids_centre_z"]

    (folder / "case.toml").write_text(CASE)
    first = run("first")
    short = "end_time=0.05"
    finer = run("finer", f"start.run={tmp_path / 'first'}", FINER, short)
    back = run("back", f"start.run={tmp_path / 'finer'}", short)
    print(first, finer, back)
    assert back == pytest.approx(first, rel=5e-3)
    assert finer[2] == pytest.approx(first[2], rel=1e-3) and finer[1] == pytest.approx(first[1], rel=2e-2)
    assert 1.0 < finer[0] / first[0] < 1.06
