"""A run with every quantity, written through `write_results`; its fields are analytic, so every number is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.geometry.grid import Grid
from fbcouple.results.block_means import lay_out_blocks
from fbcouple.results.probes import ProbeSet, Rows
from fbcouple.results.variables import STAGES
from fbcouple.results.writer import Extras, write_results

SIZE = (0.08, 0.015, 0.25)
PRESSURE_FREQUENCY, HEIGHT_FREQUENCY, TAP_FREQUENCY = 2.5, 2.0, 3.0
BUBBLE, RISE = 0.02, 0.25
"""Diameter [m] and rise velocity [m/s] of the bubbles, three a second."""
BED = 0.09

CASE = """
title = "A whole <synthetic> bed & more"
end_time = 20.0
gravity = 9.81
[domain]
size = [0.08, 0.015, 0.25]
cells = {cells}
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
max_courant = 0.2
[particles]
diameter = 1e-3
density = 2500.0
mass = 0.075
[contact]
friction = {friction}
[averages]
start = 2.0
[output]
particles_every = 0.1
references = {references}
[[output.probes]]
name = "tap"
points = [[0.04, 0.0, 0.01], [0.04, 0.0, 0.05]]
quantities = ["pressure"]
every = 5e-3
[[output.probes]]
name = "axis"
line = [[0.04, 0.0075, 0.0], [0.04, 0.0075, 0.25]]
count = 11
quantities = ["solids_fraction", "solids_velocity"]
every = 0.02
[[output.probes]]
name = "cut"
height = 0.05
quantities = ["voidage"]
every = 0.02
"""


def write_whole(
    run: Path,
    cells: tuple[int, int, int] = (8, 3, 25),
    friction: float = 0.1,
    shift: float = 0.0,
    core_seconds: float = 7200.0,
    references: tuple[str, ...] = (),
    corner: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Path:
    """Write RUN/results.nc of 20 s; `shift` is added to the solids fraction in the bed. Returns RUN.

    The bed's lower left front corner lies at `corner` [m], and all in it with it.
    """
    run.mkdir(parents=True, exist_ok=True)
    grid = Grid(cells, SIZE, origin=corner)
    names = "[" + ", ".join(f'"{name}"' for name in references) + "]"
    attributes: dict[str, Any] = {
        "case": CASE.format(cells=list(cells), friction=friction, references=names),
        "averaging_start": 2.0,
        "averaging_end": 20.0,
        "core_seconds": core_seconds,
        "ranks": 2,
        "complete": 1,
    }
    snapshots, probes = make_snapshots(grid), make_probes(run)
    means, history = make_means(grid, shift), make_history()
    blocks = lay_out_blocks(range(2, 20), [500] * 18, make_blocks(means))
    write_results(run / "results.nc", grid, means, history, attributes, Extras(snapshots, probes=probes, blocks=blocks))
    return run


def leave_out(data: xr.Dataset, outside: xr.DataArray) -> xr.Dataset:
    """The results as of a mesh that does not have the places `outside`."""
    places = (outside | xr.zeros_like(data["solids_fraction"], dtype=bool)).transpose("z", "y", "x")
    fields = {name: field.where(~places) for name, field in data.items() if {"x", "y", "z"} <= set(field.dims)}
    return data.assign(fields).assign_coords(inside=~places)


def make_probes(run: Path) -> list[ProbeSet]:
    """Two taps, every 5 ms, at 3 Hz; a line with solids, that go up and down, in its lower part alone; a section that
    a bubble of 30 mm passes every second."""
    rng = np.random.default_rng(11)
    points = np.array([[0.04, 0.0, 0.01], [0.04, 0.0, 0.05]])
    taps = Rows(run / "probes/tap.rows", 2)
    for time in 5e-3 * np.arange(1, 4001):
        wave = 20.0 * np.sin(2 * np.pi * TAP_FREQUENCY * time)
        taps.append(time, np.array([500.0, 200.0]) + wave + rng.standard_normal(2))
    line = np.column_stack([np.full(11, 0.04), np.full(11, 0.0075), np.linspace(0.0, 0.25, 11)])
    axis, bed = Rows(run / "probes/axis.rows", 44), line[:, 2] < BED
    for time in 0.02 * np.arange(1, 1001):
        velocity = np.where(bed[:, None], [0.0, 0.0, np.sin(time)], np.nan)
        axis.append(time, np.concatenate([np.where(bed, 0.3, 0.0), velocity.ravel()]))
    quantities = "solids_fraction", "solids_velocity"
    x, y = np.meshgrid((np.arange(16) + 0.5) * SIZE[0] / 16, (np.arange(3) + 0.5) * SIZE[1] / 3)
    places = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.05)])
    cut, away = Rows(run / "probes/cut.rows", len(places)), np.abs(places[:, 0] - 0.04)
    for time in 0.02 * np.arange(1, 1001):
        cut.append(time, np.where(np.hypot(away, 0.3 * (time % 1.0 - 0.5)) < 0.015, 0.9, 0.5))
    sets = ("tap", points, ("pressure",), taps), ("axis", line, quantities, axis), ("cut", places, ("voidage",), cut)
    return [ProbeSet(*one) for one in sets]


def make_means(grid: Grid, shift: float = 0.0) -> dict[str, np.ndarray]:
    """Solids fraction 0.3 + `shift` up to 0.09 m and none above; velocities linear in x/L; agitation 0.144 m2/s2."""
    x, y, z = (grid.centres(axis) - grid.origin[axis] for axis in range(3))
    above, depth, across = np.meshgrid(z, y, x, indexing="ij")
    bed = above < BED
    solids = np.where(bed, 0.3 + shift, 0.0)
    upward = 1.2 * (across / SIZE[0] - 0.5) + 0.0 * depth
    nothing = np.zeros_like(solids)
    velocity = np.where(bed, np.stack([0.1 * upward, nothing, upward]), np.nan)
    flux = 2500.0 * solids * np.nan_to_num(velocity)
    gas_flux = np.stack([nothing, nothing, np.full_like(solids, 1.2)])
    means = {
        "solids_fraction": solids,
        "solids_flux": flux,
        "solids_velocity": velocity,
        "agitation": np.where(bed, 0.144, np.nan),
        "granular_temperature": np.where(bed, 0.01, np.nan),
        "voidage": 1.0 - solids,
        "gas_velocity": gas_flux / (1.0 - solids),
        "gas_flux": gas_flux,
        "pressure": 600.0 * (1.0 - above / SIZE[2]),
    }
    return means | {f"{name}_stderr": np.full_like(values, 0.01) for name, values in means.items()}


def make_blocks(means: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Solids of 18 blocks, each as far above or below the mean as chance has it, a twentieth."""
    solids, agitation = means["solids_fraction"], np.nan_to_num(means["agitation"])
    square = agitation + (np.nan_to_num(means["solids_velocity"]) ** 2).sum(axis=0)
    row = np.stack([solids, 2500.0 * solids, *means["solids_flux"], 2500.0 * solids * square]).mean(axis=2)
    return [row * (1.0 + 0.05 * chance) for chance in np.random.default_rng(5).standard_normal(18)]


def make_history() -> list[dict[str, Any]]:
    """20 s every 10 ms: the start-up, a bed 50 mm too high and 250 Pa too much, is over at 1 s."""
    rng = np.random.default_rng(7)
    rows = []
    for time in 0.01 * np.arange(2001):
        early = 5.0 * (time < 1.0)
        height = 0.07 + 0.01 * early + 2e-3 * np.sin(2 * np.pi * HEIGHT_FREQUENCY * time)
        pressure = 600.0 + 50.0 * early + 20.0 * np.sin(2 * np.pi * PRESSURE_FREQUENCY * time)
        rows.append(
            {
                "time": float(time),
                "bed_height": height + 2e-4 * rng.standard_normal(),
                "pressure_drop": pressure + 2.0 * rng.standard_normal() if time else float("nan"),
                "inlet_velocity": 1.2 - 0.12 * abs(float(time) - 10.0),
                "gas_support": 0.98,
                "solids_volume": 3e-5,
                "solids_centre_z": 0.5 * height,
                "particles": 57296,
                "momentum_error": 1e-14,
                "gas_mass_error": 1e-9,
                "gas_inflow_error": 1e-16,
                "displaced_gas_error": 1e-3,
                "gas_backflow": 0.0,
                "particles_at_outlet": 0,
                "max_courant": 0.2,
                "min_voidage": 0.4,
                "cells_over_packed": 0,
                "max_overlap": 0.02,
                "substeps": 8,
                "wall": {stage: 0.2 * place for place, stage in enumerate(STAGES)},
            }
        )
    return rows


def make_snapshots(grid: Grid) -> list[tuple[float, np.ndarray]]:
    """Every 10 ms up to 6 s: a bubble that starts at 20 mm and rises, three times a second."""
    fine = 6
    z, x = ((np.arange(grid.cells[axis] * fine) + 0.5) * grid.spacing[axis] / fine for axis in (2, 0))
    taken = []
    for time in 0.01 * np.arange(600):
        place = 0.025 + RISE * (time % (1 / 3))
        inside = (x - 0.04) ** 2 + (z[:, None] - place) ** 2 < 0.25 * BUBBLE**2
        gas = inside | (z > 0.15)[:, None]
        share = gas.reshape(grid.cells[2], fine, grid.cells[0], fine).mean(axis=(1, 3))
        taken.append((float(time), (0.45 + 0.55 * share).astype(np.float32)))
    return taken
