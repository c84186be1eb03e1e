"""A start that cannot be: refused with the case (exit 1), or found before the first step (exit 4); never a result."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from click.testing import CliRunner
from small_bed import BED, poison, prepare

from fbcouple.cli.main import cli
from fbcouple.errors import DivergedError
from fbcouple.launcher.launch import launch
from fbcouple.run_folder.checkpoint import list_checkpoints

PLACES = [(1e-3 + 1.2e-3 * i, 1e-3 + 1.2e-3 * j, 1e-3) for i, j in itertools.product(range(6), range(3))]


def write_case(folder: Path, places: list[tuple[float, float, float]], *sets: str) -> list[str]:
    """A case with its particles in a file; the words of a call that sets it up."""
    text = BED.replace("count = 250", f'count = {len(places)}\npositions = "start.csv"').replace("[start]\n", "")
    (folder / "case.toml").write_text(text)
    rows = "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in places)
    (folder / "start.csv").write_text(f"x,y,z\n{rows}")
    settings = ("output.tracked=[]", *sets)
    return ["setup", str(folder), "-o", str(folder / "run"), *(word for text in settings for word in ("--set", text))]


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (
            (1.3e-3, 1e-3, 1e-3),
            "particle 1 at (0.001, 0.001, 0.001) m and particle 19 at (0.0013, 0.001, 0.001) m overlap by 0.7 of",
        ),
        ((0.0, 1e-3, 1e-3), "1 particles are not inside the box, first is particle 19 at (0, 0.001, 0.001)"),
        ((1e-3, 1e-3, 1.0), "1 particles are not inside the box, first is particle 19 at (0.001, 0.001, 1)"),
    ],
    ids=["on another", "in a wall", "far away"],
)
def test_place_of_a_particle_is_refused(tmp_path, place, words):
    result = CliRunner().invoke(cli, write_case(tmp_path, [*PLACES, place]))
    assert result.exit_code == 1 and words in result.stderr, result.stderr
    assert len(result.stderr.splitlines()) == 1 and not (tmp_path / "run").exists()


def test_particles_that_touch_are_not_refused(tmp_path):
    touching = [*PLACES, (1e-3, 1e-3, 1.95e-3)]
    assert CliRunner().invoke(cli, write_case(tmp_path, touching)).exit_code == 0


def test_voidage_under_packing_is_refused_and_where_forced_ends_the_run(tmp_path):
    """Cells of half a diameter, all of a particle in the one of its centre: there is no gas left in it."""
    call = write_case(
        tmp_path, PLACES, "domain.cells=[20, 12, 40]", "exchange.voidage=centre", "exchange.filter_passes=0"
    )
    result = CliRunner().invoke(cli, call)
    assert result.exit_code == 1 and "cell size x" in result.stderr and not (tmp_path / "run").exists()
    assert CliRunner().invoke(cli, [*call, "--force"]).exit_code == 0
    words = r"in the step from t = 0 s the voidage is -\d+\.\d+ in cell \(\d+, \d+, \d+\) at .*, above 0.1 is allowed"
    with pytest.raises(DivergedError, match=words):
        launch(tmp_path / "run", 1, lambda row: None)
    assert not (tmp_path / "run/results.nc").exists()


@pytest.mark.parametrize(("name", "words"), [("overlap", "two particles overlap by 0.5"), ("outside", "behind a wall")])
def test_start_that_went_wrong_ends_before_the_first_step(tmp_path, monkeypatch, name, words):
    """Whatever brought it about: the state is looked at before anything is made of it."""
    run = prepare(tmp_path)
    poison(monkeypatch, name, 0)
    with pytest.raises(DivergedError, match=f"at t = 0 s .*{words}"):
        launch(run, 1, lambda row: None)
    assert not (run / "results.nc").exists() and list_checkpoints(run) == []
