"""Profiles over the radius of a column, whose rings are known, and the tables for a spreadsheet."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.geometry.grid import Grid
from fbcouple.postproc.figures.radial_profiles import radial_profiles
from fbcouple.postproc.radial import find_radial_profile, list_radial_heights
from fbcouple.postproc.spreadsheets import export_tables
from fbcouple.postproc.style import journal_style
from fbcouple.results.reader import NotMeantError, open_results
from fbcouple.results.writer import MeshTable, write_results
from tests.postproc.test_labels import list_cut
from tests.postproc.whole_run import write_whole

CELLS, SIZE, CORNER = (4, 4, 5), (0.08, 0.08, 0.25), (-0.04, -0.04, 0.1)
CASE = """
title = "A round bed about its own axis"
end_time = 20.0
gravity = 9.81
[domain]
shape = "file"
size = [0.08, 0.08, 0.25]
cells = [4, 4, 5]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[particles]
diameter = 1e-3
density = 2500.0
[averages]
start = 1.0
[output]
radial_heights = [0.05, 0.125]
"""


@pytest.fixture
def run(tmp_path):
    """Twelve of sixteen places of each layer are in the mesh: four at r = 14.1 mm, eight at 31.6 mm. Solids and gas
    change with x, y and z, and the solids' velocity is with them or against them."""
    grid = Grid(CELLS, SIZE, origin=CORNER)
    z, y, x = np.meshgrid(*(np.arange(n) for n in CELLS[::-1]), indexing="ij")
    inside = ~(np.isin(x, (0, 3)) & np.isin(y, (0, 3)))
    samples = np.full(inside.shape, -1)
    samples[inside] = np.arange(inside.sum())[::-1]
    places = np.stack([grid.centres(axis)[index[inside]] for axis, index in zip(range(3), (x, y, z), strict=True)])
    centres = places.T[::-1]
    solids = np.where(centres[:, 0] > 0.0, 0.3, 0.1)
    upward = np.where(centres[:, 0] > 0.0, 1.0, -1.0) + centres[:, 2]
    none = 0.0 * upward
    means = {
        "solids_fraction": solids,
        "solids_fraction_stderr": np.full(len(solids), 0.01),
        "solids_velocity": np.stack([none, none, upward]),
        "gas_flux": np.stack([none, none, 2.0 + 100.0 * np.hypot(*centres[:, :2].T) + 40.0 * centres[:, 2]]),
    }
    stages = ("dem", "cfd", "map", "drag", "react", "average", "record", "wait")
    drops = enumerate((np.nan, 3.5))
    history = [{"time": 0.1 * n, "pressure_drop": drop, "wall": dict.fromkeys(stages, 0.0)} for n, drop in drops]
    about = {"case": CASE, "averaging_start": 1.0, "averaging_end": 20.0, "complete": 1, "bed_section": 0.005}
    table = {"centres": centres, "volumes": np.full(len(centres), 1e-6), "samples": samples}
    write_results(tmp_path / "results.nc", grid, means, history, about, mesh=MeshTable(**table))
    return tmp_path


def test_rings_are_about_the_middle_of_the_bed(run):
    found = find_radial_profile(open_results(run), "gas_flux", 0.05)
    radii = np.hypot([0.01, 0.01], [0.01, 0.03])
    assert found.radius == pytest.approx(radii) and found.stderr is None
    assert found.value == pytest.approx(2.0 + 100.0 * radii + 40.0 * 0.15)


def test_velocity_of_particles_is_weighted_with_the_solids(run):
    results = open_results(run)
    assert find_radial_profile(results, "solids_fraction", 0.125).value == pytest.approx([0.2, 0.2])
    assert find_radial_profile(results, "solids_fraction", 0.125).stderr == pytest.approx([0.01, 0.01])
    assert find_radial_profile(results, "solids_velocity", 0.125).value == pytest.approx([0.5 + 0.225] * 2)


def test_picture_has_a_panel_a_quantity_and_a_line_a_height(run):
    panels = radial_profiles(open_results(run)).axes
    assert len(panels) == 3
    note = " ".join(radial_profiles(open_results(run)).texts[1].get_text().split())
    assert "bands: ± 1 standard error, not known of solids velocity, gas flux" in note
    assert all(sum(len(line.get_xdata(orig=False)) == 2 for line in axes.lines) >= 2 for axes in panels)
    assert [text.get_text() for text in panels[0].get_legend().get_texts()] == ["$z$ = 50 mm", "$z$ = 125 mm"]
    assert panels[0].lines[0].get_xdata() == pytest.approx([14.142, 31.623], abs=1e-3)


def test_no_label_is_cut(run):
    with journal_style():
        assert list_cut(radial_profiles(open_results(run))) == []


def test_a_bed_that_is_no_column_has_none(tmp_path):
    with pytest.raises(NotMeantError, match=r"is no cylinder, and its case has no output.radial_heights"):
        list_radial_heights(open_results(write_whole(tmp_path / "run")))


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def test_tables_have_units_in_their_heads(run):
    history, radial = map(read, export_tables(run))
    assert history == [["time [s]", "pressure_drop [Pa]"], ["0.0", ""], ["0.1", "3.5"]]
    assert radial[0] == [
        *("height [m]", "radius [m]", "solids_fraction [-]", "solids_fraction standard error [-]"),
        *("solids_velocity [m s-1]", "gas_flux [m s-1]"),
    ]
    assert len(radial) == 5 and float(radial[4][0]) == 0.125 and float(radial[4][2]) == pytest.approx(0.2)


def test_probes_are_a_table_each(tmp_path):
    """As results.nc has them, point by point, of a vector its three components; nothing where nothing was."""
    folder = write_whole(tmp_path / "run")
    done = CliRunner().invoke(cli, ["post", str(folder), "--only", "probes", "--csv"])
    assert done.exit_code == 0 and f"{folder}/tables/probe_tap.csv" in done.output
    data = open_results(folder).data
    tap, axis = read(folder / "tables/probe_tap.csv"), read(folder / "tables/probe_axis.csv")
    assert tap[0] == ["time [s]", *(f"pressure at x=0.04 y=0 z={z} m [Pa]" for z in ("0.01", "0.05"))]
    rows = np.array(tap[1:], float)
    assert np.array_equal(rows[:, 0], data["probe_tap_time"])
    assert np.array_equal(rows[:, 1:], data["probe_tap_pressure"])
    velocity = data["probe_axis_solids_velocity"].values
    columns = [n for n, head in enumerate(axis[0]) if head.startswith("solids_velocity_")]
    assert axis[0][columns[1]].startswith("solids_velocity_y at x=0.04 ") and axis[0][columns[1]].endswith(" m [m s-1]")
    values = np.array([[float(row[n] or "nan") for n in columns] for row in axis[1:]])
    assert np.array_equal(values, velocity.reshape(len(velocity), -1), equal_nan=True)
    assert np.isnan(velocity).any()
