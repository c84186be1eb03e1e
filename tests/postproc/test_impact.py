"""Figure 4 of the paper: the shipped case by LIGGGHTS on the exact contact, and what is no such contact."""

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.physics.contact import Impact
from fbcouple.postproc.papers.hamidouche2019.impact import find_contact, impact
from fbcouple.results.reader import NotDrawableError, open_results

# Times over T_C, overlap, velocity: physics of the paper, eqs 43-45, e = 0.97.
EXACT = [(0.25, 0.71248, 0.69494), (0.5, 0.99995, -0.00955), (0.75, 0.70171, -0.69784), (1.0, 0.0, -0.97)]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The shipped case, set up and run."""
    place = tmp_path_factory.mktemp("impact") / "run"
    for words in (["setup", "single-impact", "-o", str(place)], ["run", str(place)]):
        done = CliRunner().invoke(cli, words)
        assert done.exit_code == 0, done.output
    return place


@pytest.mark.parametrize(("time", "overlap", "velocity"), EXACT)
def test_exact_contact_has_the_numbers_worked_out_elsewhere(time, overlap, velocity):
    found = Impact(0.97).solve(np.array([time]))
    assert [float(value[0]) for value in found] == pytest.approx([overlap, velocity], abs=1e-5)


def test_liggghts_follows_the_exact_contact(run):
    found = find_contact(open_results(run))
    overlaps, velocities = Impact(0.97).solve(found.times)
    inside = found.times <= 1.0
    assert inside.sum() > 25 and found.times[0] == 0.0
    assert found.overlaps[inside] == pytest.approx(overlaps[inside], abs=0.01)
    assert found.velocities[inside] == pytest.approx(velocities[inside], abs=0.01)
    assert found.restitution == pytest.approx(0.97, abs=0.002) and found.speed == 1.0
    assert found.duration == pytest.approx(2**0.5 * 8.04e-5, rel=1e-3)


def test_the_figure_has_the_run_and_the_schemes_of_the_paper(run):
    axes, _ = impact(open_results(run)).axes
    assert [line.get_label().split(",")[0] for line in axes.lines[:4]] == ["exact", "Euler", "RK2", "LIGGGHTS"]
    assert axes.lines[2].get_ydata()[3] == pytest.approx(1.02, abs=0.01), "the midpoint rule goes too deep"


def test_nothing_but_the_tracked_particle_is_in_the_results(run):
    with xr.open_dataset(run / "results.nc") as data:
        assert not {"solids_fraction", "voidage_snapshots", "pressure_drop"} & set(data)
    assert not (run / "CFD").exists() and not (run / "frames").exists()


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda results: results.case.update(gravity=9.81), "gravity"),
        (lambda results: results.case.update(gas={}), "gas"),
        (lambda results: results.case["contact"].update(model="hertz"), "contact.model = hertz"),
        (lambda results: results.data["tracked_position"].__setitem__(slice(None), 5e-3), "does not meet the floor"),
    ],
)
def test_another_contact_is_not_drawn(run, spoil, told):
    results = open_results(run)
    spoil(results)
    with pytest.raises(NotDrawableError, match=told):
        find_contact(results)
