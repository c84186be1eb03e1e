"""3-D views: what is drawn where and how large, the film of them, and what is said where there is nothing to draw."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib import colormaps
from matplotlib.image import imread
from mpi4py import MPI
from PIL import Image

from fbcouple.cli.main import cli
from fbcouple.coupling.box.cells import BoxCells
from fbcouple.geometry.grid import Grid
from fbcouple.postproc import draw
from fbcouple.postproc.views.colours import list_colours, voidage_map
from fbcouple.postproc.views.frames import choose_frames, list_frames, read_frame
from fbcouple.postproc.views.views import bed_views, find_scales
from fbcouple.results.reader import NotDrawableError, open_results
from fbcouple.simulation.tasks.frames import Frames
from tests.postproc.conftest import SIZE
from tests.postproc.frames_of_bed import write_frames
from tests.postproc.whole_run import write_whole

SLOW, FAST = (np.array(colormaps["viridis"](place)[:3]) for place in (0.0, 1.0))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    run = write_whole(tmp_path_factory.mktemp("views") / "run")
    write_frames(run, SIZE)
    return run


def hue_of(pixels):
    """Mean colour of what is far from white, over its brightest channel: shading does not count."""
    drawn = pixels[..., :3][pixels[..., :3].min(axis=-1) < 0.3]
    mean = drawn.mean(axis=0)
    return mean / mean.max()


def test_still_pictures_show_slow_and_fast_particles_where_they_are_and_the_gas(run):
    figure = bed_views(open_results(run))
    titles = [axes.get_title() for axes in figure.axes if axes.images]
    assert titles == ["Particles, t = 0.100 s", "Particles, t = 0.200 s", "Gas, t = 0.200 s"]
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert any("Particle speed" in label and "U_f" in label for label in labels)
    assert any("Voidage" in label for label in labels)
    first, last, gas = (np.asarray(axes.images[0].get_array()) for axes in figure.axes if axes.images)
    middle, lower = first.shape[1] // 2, slice(int(0.8 * first.shape[0]), None)
    left, right = hue_of(first[lower, : middle - 20]), hue_of(first[lower, middle + 20 :])
    assert np.abs(left - SLOW / SLOW.max()).max() < 0.2 and np.abs(right - FAST / FAST.max()).max() < 0.2
    tops = [np.flatnonzero((pixels[..., :3].min(axis=-1) < 0.9).sum(axis=1) > 60)[0] for pixels in (first, last)]
    assert tops[1] < tops[0], "the later one is higher"
    dense = np.median(gas[int(0.7 * len(gas)) :, 30:-30, :3].reshape(-1, 3), axis=0)
    assert np.abs(dense - np.array(voidage_map()((0.4 - 0.35) / 0.65)[:3])).max() < 0.02


def test_a_particle_is_drawn_as_large_as_it_is(tmp_path):
    """One alone in a box of 20 mm: its disc has the area of its cross section, in the first picture and the second."""
    areas, turn, rise = [], np.radians(20.0), np.radians(14.0)
    tall = 0.02 * (np.cos(rise) + (np.cos(turn) + np.sin(turn)) * np.sin(rise))
    for diameter in (2e-3, 4e-3):
        place = tmp_path / f"{diameter}"
        place.mkdir()
        frames = Frames(MPI.COMM_SELF, BoxCells(Grid((1, 1, 1), (0.02,) * 3), np.zeros((1, 3), dtype=int)), place, 1.0)
        middle = {"position": np.full((1, 3), 0.01), "velocity": np.zeros((1, 3)), "diameter": np.array([diameter])}
        frames.write(0.0, np.array([1]), middle, {})
        request = {
            "corner": [0.0] * 3,
            "size": [0.02] * 3,
            "height": 400,
            "speed": 1.0,
            "gas_speed": 0.0,
            "voidage": [0.35, 1.0],
            "temperature": None,
        }
        names = [str(place / name) for name in ("one.png", "two.png")]
        request["pictures"] = [(str(place / "frame-000000.nc"), "particles", name) for name in names]
        (place / "request.json").write_text(json.dumps(request))
        subprocess.run(
            [sys.executable, "-m", "fbcouple.postproc.views.render", str(place / "request.json")], check=True
        )
        for pixels in map(imread, names):
            centre = pixels[150:250, pixels.shape[1] // 2 - 50 : pixels.shape[1] // 2 + 50, :3]
            areas.append(float((centre.min(axis=-1) < 0.9).sum()) * (1.02 * tall / 400) ** 2)
    assert areas == pytest.approx([np.pi * 1e-6] * 2 + [np.pi * 4e-6] * 2, rel=0.05)


def test_the_film_has_every_frame(run):
    done = CliRunner().invoke(cli, ["post", str(run), "--animate"])
    assert done.exit_code == 0 and done.output.splitlines()[-1] == str(run / "figures/bed.gif"), done.output
    with Image.open(run / "figures/bed.gif") as film:
        assert film.n_frames == 3 and film.info["duration"] == 2660
        shots = []
        for number in range(3):
            film.seek(number)
            shots.append(np.asarray(film.convert("RGB")))
    assert (shots[0] != shots[1]).any() and (shots[1] != shots[2]).any()
    colours = {tuple(colour) for colour in shots[0].reshape(-1, 3).tolist()}
    assert colours <= {tuple(colour) for colour in list_colours().tolist()} and len(colours) > 30
    assert (run / "figures/bed_views.png").stat().st_size > 50_000


def test_particles_without_gas_have_no_picture_of_it(run, tmp_path):
    alone = write_whole(tmp_path / "run")
    write_frames(alone, SIZE, count=1, gas=False)
    figure = bed_views(open_results(alone))
    assert [axes.get_title() for axes in figure.axes if axes.images] == ["Particles, t = 0.000 s"]


def test_temperatures_have_a_picture_and_a_part_of_the_film_of_their_own(tmp_path):
    warm = write_whole(tmp_path / "run")
    write_frames(warm, SIZE, count=2, heat=True)
    figure = bed_views(open_results(warm))
    pictures = {axes.get_title(): np.asarray(axes.images[0].get_array()) for axes in figure.axes if axes.images}
    assert list(pictures)[-2:] == ["Gas, t = 0.100 s", "Temperature, t = 0.100 s"]
    assert any("temperature [K]" in axes.get_ylabel() for axes in figure.axes)
    pixels = pictures["Temperature, t = 0.100 s"]
    middle, lower = pixels.shape[1] // 2, slice(int(0.8 * pixels.shape[0]), None)
    for half, value in ((pixels[lower, : middle - 20], 0.0), (pixels[lower, middle + 20 :], 1.0)):
        colour = np.array(colormaps["plasma"](value)[:3])
        assert np.abs(hue_of(half) - colour / colour.max()).max() < 0.2
    CliRunner().invoke(cli, ["post", str(warm), "--animate"])
    with Image.open(warm / "figures/bed.gif") as film:
        assert film.n_frames == 2
        colours = {tuple(colour) for colour in np.asarray(film.convert("RGB")).reshape(-1, 3).tolist()}
    known = list_colours(has_heat=True)
    assert known.shape == (256, 3) and colours <= {tuple(colour) for colour in known.tolist()}


@pytest.mark.parametrize(("speeds", "scale"), [([0.0] * 199 + [2.0], 1.0), ([], 1.0), ([0.5] * 200, 0.5)])
def test_where_hardly_anything_moves_the_scale_is_one(monkeypatch, speeds, scale):
    frame = SimpleNamespace(speeds=np.array(speeds), gas_velocity=None, temperatures=None)
    monkeypatch.setitem(find_scales.__globals__, "read_frame", lambda path: frame)
    assert find_scales([Path("frame")]).speed == scale


def test_a_bed_that_drains_is_drawn_to_its_end(tmp_path):
    run = write_whole(tmp_path / "run")
    write_frames(run, SIZE, count=1, gas=False, heat=True, drained=True)
    assert len(bed_views(open_results(run)).axes) >= 2


def test_scales_are_common_to_all_frames(run):
    scales = find_scales(list_frames(open_results(run)))
    assert scales.speed == pytest.approx(1.0) and scales.gas == pytest.approx(2.0) and scales.temperature is None


def test_of_many_frames_some_are_chosen_evenly(tmp_path):
    paths = [tmp_path / str(n) for n in range(11)]
    assert choose_frames(paths, 3) == [paths[0], paths[5], paths[10]]
    assert choose_frames(paths, 3, 0.5) == [paths[5], paths[8], paths[10]] and choose_frames(paths, 99) == paths
    assert choose_frames(paths[:1], 3, 0.5) == paths[:1]


def test_no_frames_are_told_with_the_option_that_takes_them(tmp_path):
    run = write_whole(tmp_path / "run")
    done = CliRunner().invoke(cli, ["post", str(run), "--animate"])
    assert done.exit_code == 1 and "output.particles_every" in done.output


def test_a_damaged_frame_is_told_by_its_name(tmp_path):
    (tmp_path / "frame-000000.nc").write_bytes(b"no netCDF")
    with pytest.raises(NotDrawableError, match=r"frame-000000\.nc cannot be read as NetCDF"):
        read_frame(tmp_path / "frame-000000.nc")


def test_a_machine_that_cannot_draw_gets_all_other_figures(run, monkeypatch, caplog):
    """Without Mesa's drivers the 3-D library ends its process: the figure is left out with its last words."""
    monkeypatch.setenv("LIBGL_DRIVERS_PATH", str(run / "nowhere"))
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    drawn = {path.stem for path in draw(run)}
    assert "bed_views" not in drawn and {"solids_fraction", "moment_slices"} <= drawn
    assert "bed_views.png left out: the 3-D pictures cannot be drawn (exit code" in caplog.text
    assert "`fbcouple doctor` says what is missing" in caplog.text and "\x1b" not in caplog.text
