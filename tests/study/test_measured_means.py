"""Distance of time means from the finest member's: fields whose distance is known, on one mesh and on two."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.case.load import load_case
from fbcouple.errors import CaseError
from fbcouple.results.reader import Results
from fbcouple.study.measures import Finished, check_needs, find_error

CASE = load_case("mueller/0.9")


def make(cells: tuple[int, int, int], field, error: float) -> Finished:
    """A finished run whose time-mean solids fraction is `field` of x and z in a unit box, with one standard error."""
    axes = {name: (np.arange(n) + 0.5) / n for name, n in zip("xyz", cells, strict=True)}
    z, _, x = np.meshgrid(axes["z"], axes["y"], axes["x"], indexing="ij")
    fields = {"solids_fraction": field(x, z), "solids_fraction_stderr": np.full(x.shape, error)}
    data = xr.Dataset({name: (("z", "y", "x"), values) for name, values in fields.items()}, coords=axes)
    return Finished(Results(Path("none"), data, {"domain": {"size": [1.0, 1.0, 1.0]}}), CASE)


def test_a_shift_is_the_distance_and_the_errors_of_both_its_bar():
    one = make((8, 2, 10), lambda x, z: x + 0.03, 0.04)
    finest = make((8, 2, 10), lambda x, z: x, 0.03)
    found = find_error("means:solids_fraction", one, finest)
    scale = 7 / 8
    assert found.error == pytest.approx(0.03 / scale) and found.stderr == pytest.approx(0.05 / scale)
    assert found.value - found.expected == pytest.approx(0.03)


def make_history(values) -> Finished:
    """A finished run with a history of pressure drops, a row a second, and a window from 10 to 29 s."""
    times = np.arange(float(len(values)))
    data = xr.Dataset({"pressure_drop": ("time", np.array(values))}, coords={"time": times})
    data.attrs |= {"averaging_start": 10.0, "averaging_end": 29.0}
    return Finished(Results(Path("none"), data, {}), CASE)


def test_mean_of_a_history_against_the_finest_member_s():
    """In the window 10 to 29 s are ten blocks of two rows each, whose means are 100 and 104 in turn."""
    rows = [0.0] * 10 + [99.0, 101.0, 103.0, 105.0] * 5
    steady = [0.0] * 10 + [51.0] * 20
    found = find_error("history-mean:pressure_drop", make_history(rows), make_history(steady))
    assert found.value == 102.0 and found.expected == 51.0 and found.error == 1.0
    assert found.stderr == pytest.approx(np.std([100.0, 104.0] * 5, ddof=1) / np.sqrt(10.0) / 51.0)


def test_another_mesh_is_compared_on_the_coarser_one():
    """A plane is the same on both; what is added to it is the distance, over the range of the finest's own cells."""
    finest = make((16, 2, 40), lambda x, z: 2.0 * x + z, 0.0)
    assert find_error("means:solids_fraction", make((6, 1, 10), lambda x, z: 2.0 * x + z, 0.0), finest).error < 1e-12
    away = find_error("means:solids_fraction", make((6, 1, 10), lambda x, z: 2.0 * x + z + 0.1, 0.0), finest)
    assert away.error == pytest.approx(0.1 / (2 * 15 / 16 + 39 / 40))


def test_what_lies_at_the_walls_counts_on_a_coarser_mesh():
    """Solids of 1 in the outermost eighth at either wall and of none elsewhere, on four cells for eight: the coarse run
    has none at all, and misses 0.5 in two of its four cells."""
    finest = make((8, 1, 4), lambda x, z: np.where(abs(x - 0.5) > 0.4, 1.0, 0.0), 0.01)
    coarse = make((4, 1, 4), lambda x, z: 0.0 * x, 0.01)
    found = find_error("means:solids_fraction", coarse, finest)
    assert found.error == pytest.approx(np.sqrt(0.5 * 0.5**2)) and found.stderr == pytest.approx(0.01 * np.sqrt(2.0))
    assert found.expected == pytest.approx(0.25) and found.value == 0.0


def test_places_without_a_number_are_left_out_on_both_meshes():
    """Where no particle ever came there is none, on the finer mesh from z = 0.5 on, on the coarser from 0.75 on."""
    finest = make((8, 1, 8), lambda x, z: np.where(z > 0.5, np.nan, x), 0.0)
    coarse = make((4, 1, 4), lambda x, z: np.where(z > 0.75, np.nan, x + 0.07), 0.0)
    found = find_error("means:solids_fraction", coarse, finest)
    assert found.error == pytest.approx(0.07 / (7 / 8)) and found.expected == pytest.approx(0.5)


def test_errors_that_are_not_known_are_told_as_such():
    one, finest = make((8, 2, 10), lambda x, z: x + 0.03, np.nan), make((8, 2, 10), lambda x, z: x, 0.03)
    assert math.isnan(find_error("maps:solids_fraction", one, finest).stderr)


def test_another_box_and_a_missing_map_are_refused():
    one = make((8, 2, 10), lambda x, z: x, 0.0)
    wide = Finished(Results(Path("none"), one.results.data.assign_coords(x=2.0 * one.results.data["x"]), {}), CASE)
    wide.results.case["domain"] = {"size": [2.0, 1.0, 1.0]}
    with pytest.raises(CaseError, match="the box is not that of the finest member"):
        find_error("means:solids_fraction", wide, one)
    with pytest.raises(CaseError, match="has no `solids_flux`"):
        find_error("maps:solids_flux", one, one)


def test_over_the_map_is_over_its_root_mean_square():
    one = make((8, 2, 10), lambda x, z: x + 0.03, 0.04)
    finest = make((8, 2, 10), lambda x, z: x, 0.03)
    found, over_range = (find_error(f"{measure}:solids_fraction", one, finest) for measure in ("maps", "means"))
    scale = float(np.sqrt(np.mean(((np.arange(8) + 0.5) / 8) ** 2)))
    assert found.error == pytest.approx(0.03 / scale) and found.stderr == pytest.approx(0.05 / scale)
    assert over_range.error * (7 / 8) == pytest.approx(found.error * scale)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("maps:solids_flux", "[averages]"),
        ("experiment:solids_velocity", "output.references"),
        ("mixing:right", "output.particles_every"),
        ("bubbles:number", "output.snapshots_every"),
    ],
)
def test_what_the_runs_would_lack_is_told_before_they_are_run(text, key):
    case = load_case("patil/demo")
    output = case.output.model_copy(update={"particles_every": None, "snapshots_every": None, "references": ()})
    bare = case.model_copy(update={"averages": None, "output": output})
    problems = [str(problem) for problem in check_needs([text, "history-mean:bed_height"], bare)]
    assert any(f"measures: {json.dumps(text)} is given and the case has no {key}; give it" in one for one in problems)
    assert not list(check_needs(["maps:solids_flux"], case))
