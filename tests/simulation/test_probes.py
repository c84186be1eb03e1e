"""Probes of known fields: what a point is given of its cell, when samples are taken, and what cases have none."""

import sys
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from fbcouple.case.load import load_case
from fbcouple.case.schema.probes import Probe
from fbcouple.coupling.box.cells import BoxCells
from fbcouple.coupling.polyhedral.bricks import find_grid
from fbcouple.coupling.polyhedral.cells import MeshCells
from fbcouple.decks.needs import find_needs
from fbcouple.decks.render import render_decks
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import find_centres, take_apart
from fbcouple.geometry.tetrahedra import cut
from fbcouple.simulation.tasks.probes import Probes

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_meshes import make_bricks

COMM = MPI.COMM_SELF
GRID = Grid((4, 3, 5), (0.04, 0.03, 0.05))
SLOPE = np.array([300.0, -200.0, -9000.0])
SETTING = 'output.probes=[{name="tap", every=0.1, quantities=["pressure"], points=[[0.0, 0.0, 0.0]]}]'
TAP = {"name": "tap", "every": 0.1, "quantities": ["pressure", "gas_flux"]}


def open_box():
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    owned = np.random.default_rng(5).permutation(cells)
    return BoxCells(GRID, owned), (owned + 0.5) * GRID.spacing


def open_mesh(mesh, as_bricks):
    order = np.random.default_rng(2).permutation(mesh.count)
    cells = take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points))).select(order)
    parts = cut(cells)
    volumes = np.bincount(parts.owners, parts.volumes)
    return MeshCells(COMM, GRID, cells, volumes, find_grid(COMM, cells, volumes) if as_bricks else None), cells.centres


CELLS = {
    "box": open_box,
    "bricks": lambda: open_mesh(make_bricks(GRID.cells, GRID.size), as_bricks=True),
    "polyhedra": lambda: open_mesh(make_bricks(GRID.cells, GRID.size), as_bricks=False),
    "tetrahedra": lambda: open_mesh(make_cylinder(0.03, 0.05, 4, 6, "tetrahedra"), as_bricks=False),
}


def open_simulation(kind, *probes):
    """A gas with a pressure linear in space, and a velocity that numbers the cells."""
    cells, centres = CELLS[kind]()
    count = len(centres)
    gas = SimpleNamespace(
        centres=centres,
        pressure=1000.0 + centres @ SLOPE,
        pressure_gradient=np.broadcast_to(SLOPE, (count, 3)),
        velocity=np.outer(np.arange(count), [1.0, 10.0, 100.0]),
        voidage=np.full(count, 0.5),
    )
    output = SimpleNamespace(probes=[Probe.model_validate(table) for table in probes])
    case = SimpleNamespace(output=output, domain=SimpleNamespace(shape="box", size=GRID.size, cells=GRID.cells))
    timers = lambda stage: nullcontext()  # noqa: E731
    return SimpleNamespace(case=case, comm=COMM, cells=cells, gas=gas, has_gas=True, timers=timers, time=0.0)


def read_rows(probes, set_number=0):
    return np.concatenate(list(probes.records[set_number].rows.read()))


@pytest.mark.parametrize("kind", CELLS)
def test_a_linear_pressure_is_exact_at_any_point_and_the_rest_is_that_of_the_cell(tmp_path, kind):
    points = np.random.default_rng(3).uniform([0.011, 0.0105, 0.0], [0.019, 0.0145, 0.05], (20, 3))
    sim = open_simulation(kind, TAP | {"points": points.tolist()})
    probes = Probes(sim, tmp_path)
    probes.after_step(sim)
    ((time, *row),) = read_rows(probes).tolist()
    pressure, flux = np.array(row[:20]), np.array(row[20:]).reshape(20, 3)
    assert time == 0.0 and pressure == pytest.approx(1000.0 + points @ SLOPE, rel=1e-12)
    cells = np.rint(flux[:, 0] / 0.5).astype(int)
    assert flux == pytest.approx(0.5 * sim.gas.velocity[cells], rel=1e-12)
    away = np.abs(points - sim.gas.centres[cells])
    limit = GRID.spacing / 2 if kind != "tetrahedra" else np.full(3, 0.01)
    assert (away <= limit * (1 + 1e-9)).all()


def test_a_section_has_each_cell_of_its_layer_once(tmp_path):
    """The third of five layers: its cells are numbered by their velocity."""
    sim = open_simulation("box", TAP | {"quantities": ["gas_flux"], "height": 0.025})
    probes = Probes(sim, tmp_path)
    probes.after_step(sim)
    ((_, *row),) = read_rows(probes).tolist()
    cells = np.rint(np.array(row).reshape(-1, 3)[:, 0] / 0.5).astype(int)
    assert sorted(cells) == sorted(np.flatnonzero(np.abs(sim.gas.centres[:, 2] - 0.025) < 1e-9))
    assert sim.gas.centres[cells] == pytest.approx(probes.records[0].points)


def test_temperature_of_the_gas_is_that_of_the_cell(tmp_path):
    sim = open_simulation("box", TAP | {"quantities": ["gas_temperature"], "points": [[0.015, 0.015, 0.025]]})
    sim.heat = SimpleNamespace(gas=SimpleNamespace(temperatures=300.0 + np.arange(len(sim.gas.centres))))
    probes = Probes(sim, tmp_path)
    probes.after_step(sim)
    ((_, found),) = read_rows(probes).tolist()
    assert sim.gas.centres[round(found - 300.0)] == pytest.approx([0.015, 0.015, 0.025])


@pytest.mark.parametrize("kind", ["box", "bricks", "polyhedra"])
def test_points_on_walls_are_in_the_cells_inside(tmp_path, kind):
    corners = [[0.0, 0.0, 0.0], [0.04, 0.03, 0.05], [0.04, 0.0, 0.05]]
    sim = open_simulation(kind, TAP | {"points": corners})
    probes = Probes(sim, tmp_path)
    probes.after_step(sim)
    assert read_rows(probes)[0, 1:4] == pytest.approx(1000.0 + np.array(corners) @ SLOPE, rel=1e-12)


def test_each_set_has_its_own_cadence_and_start(tmp_path):
    line = {"name": "line", "every": 0.25, "start": 0.5, "quantities": ["voidage"], "count": 3}
    line["line"] = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.05]]
    sim = open_simulation("box", TAP | {"points": [[0.01, 0.01, 0.01]]}, line)
    probes = Probes(sim, tmp_path)
    for sim.time in np.arange(1, 17) * 0.0625:
        probes.after_step(sim)
    assert read_rows(probes)[:, 0] == pytest.approx(
        [0.0625, 0.125, 0.25, 0.3125, 0.4375, 0.5, 0.625, 0.75, 0.8125, 0.9375, 1.0]
    )
    found = read_rows(probes, 1)
    assert found[:, 0] == pytest.approx([0.5, 0.75, 1.0]) and (found[:, 1:] == 0.5).all()


def test_they_go_on_where_they_were_saved_and_refuse_other_rows(tmp_path):
    sim = open_simulation("box", TAP | {"points": [[0.01, 0.01, 0.01]]})
    first, whole = Probes(sim, tmp_path), Probes(sim, tmp_path / "whole")
    (tmp_path / "whole").mkdir()
    for step in range(1, 13):
        sim.time = 0.09 * step
        sim.gas.pressure += 1.0
        first.after_step(sim)
        whole.after_step(sim)
        if step == 6:
            saved, pressure = first.save(sim, tmp_path), sim.gas.pressure.copy()
    other = Probes(sim, tmp_path)
    other.load(sim, saved, tmp_path)
    sim.gas.pressure[:] = pressure
    for step in range(7, 13):
        sim.time = 0.09 * step
        sim.gas.pressure += 1.0
        other.after_step(sim)
    assert (read_rows(other) == read_rows(whole)).all() and len(read_rows(whole)) > 8
    (tmp_path / "probes/tap.rows").write_bytes(b"")
    with pytest.raises(ValueError, match="has not the 6 rows that the checkpoint goes on from"):
        Probes(sim, tmp_path).load(sim, saved, tmp_path)


def test_a_case_without_probes_has_no_trace_of_them():
    with_probes = load_case("patil/c2", [SETTING])
    without = load_case("patil/c2")
    assert find_needs(with_probes)["probes"] and not find_needs(without)["probes"]
    assert render_decks(with_probes) == render_decks(without), "probes are no part of a deck"
