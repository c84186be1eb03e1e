"""A manufactured solution of the averaged gas equations: the discretization has the order it should have.

In a closed box of slip walls, 2-D, with k = pi/L: voidage, flux q = eps u and pressure are products of cosines and
sines that fulfil d(eps)/dt + div q = 0 exactly; the momentum equation is fulfilled by a source S, which comes in the
same way as the drag of particles does. The voidage varies in space and time, a drag coefficient K in space.

The step is small against dx^2/nu: the neighbours' part of diffusion lags by one PISO correction, which leaves an error
of the order (dt nu/dx^2)^correctors of du/dt. Convergence along a constant dt nu/dx^2 of order one would show that.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.gas import close_box
from fbcouple.verify.harness import open_bench
from fbcouple.verify.registry import Number, check

_DENSITY, _VISCOSITY = 1.2, 0.01
_K = math.pi
_OMEGA = 2.0
_MEAN, _WAVE, _SWIRL, _PRESSURE, _DRAG = 0.6, 0.15, 0.08, 0.5, 3.0
_END = 0.2
Field = Callable[[np.ndarray, np.ndarray, float], np.ndarray]

# Eighth-order central difference: its error is far below the discretization's.
_OFFSETS = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
_FACTORS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_H = 2e-3


def _voidage(x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    return _MEAN + _WAVE * np.cos(_K * x) * np.cos(_K * z) * math.sin(_OMEGA * t)


def _flux(x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    """q = grad(chi) + curl(psi), lap(chi) = -d(eps)/dt; no flux through the walls."""
    chi = _WAVE * _OMEGA / (2 * _K) * math.cos(_OMEGA * t)
    psi = _SWIRL * _K * (1.0 + 0.5 * math.cos(_OMEGA * t))
    qx = -chi * np.sin(_K * x) * np.cos(_K * z) + psi * np.sin(_K * x) * np.cos(_K * z)
    qz = -chi * np.cos(_K * x) * np.sin(_K * z) - psi * np.cos(_K * x) * np.sin(_K * z)
    return np.stack([qx, np.zeros_like(qx), qz])


def _velocity(x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    return _flux(x, z, t) / _voidage(x, z, t)


def _pressure(x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    return _PRESSURE * np.cos(_K * x) * np.cos(_K * z) * (1.0 + 0.3 * math.sin(_OMEGA * t))


def _drag_coefficient(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    return _DRAG * (1.0 + 0.5 * np.cos(_K * x) * np.cos(_K * z))


def _differ(field: Field, axis: int, x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    """Derivative of `field` along x (0), z (2) or t (3)."""
    steps = [(_H * o * (axis == 0), _H * o * (axis == 2), _H * o * (axis == 3)) for o in _OFFSETS]
    terms = [f * field(x + a, z + b, t + c) for f, (a, b, c) in zip(_FACTORS, steps, strict=True)]
    return np.sum(terms, axis=0) / _H


def _stress(x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    """eps mu (grad u + grad u^T - 2/3 div u), shape (3, 3, ...)."""
    gradient = np.zeros((3, 3, *x.shape))
    for axis in (0, 2):
        gradient[axis] = _differ(_velocity, axis, x, z, t)
    divergence = gradient[0, 0] + gradient[2, 2]
    both = gradient + gradient.swapaxes(0, 1)
    for axis in range(3):
        both[axis, axis] -= 2.0 / 3.0 * divergence
    return _VISCOSITY * _voidage(x, z, t) * both


def _source(x: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
    """S [N m-3] that the exact solution needs, shape (3, n)."""
    source = _DENSITY * _differ(_flux, 3, x, z, t) + _drag_coefficient(x, z) * _velocity(x, z, t)
    for axis in (0, 2):

        def carried(x: np.ndarray, z: np.ndarray, t: float, axis: int = axis) -> np.ndarray:
            return _DENSITY * _flux(x, z, t)[axis] * _velocity(x, z, t) - _stress(x, z, t)[axis]

        source = source + _differ(carried, axis, x, z, t)
        source[axis] += _voidage(x, z, t) * _differ(_pressure, axis, x, z, t)
    return source


def _open(folder: Path, comm: MPI.Comm, cells: int) -> Simulation:
    domain = {"size": [1.0, 1.0 / cells, 1.0], "cells": [cells, 1, cells]}
    gas = {"density": _DENSITY, "viscosity": _VISCOSITY, "inlet_velocity": 0.0, "walls": "slip"}
    gas |= {"pressure_tolerance": 1e-11, "correctors": 3}
    edits = close_box("type slip;") | {"CFD/0/U": _start_from_exact(cells, close_box("type slip;")["CFD/0/U"])}
    return open_bench(folder, comm, {"domain": domain, "gas": gas}, edits=edits)


def _start_from_exact(cells: int, edit: Callable[[str], str]) -> Callable[[str], str]:
    """Start with the exact velocity in place of a uniform one; cells run along x first."""
    centres = (np.arange(cells) + 0.5) / cells
    z, x = (axis.ravel() for axis in np.meshgrid(centres, centres, indexing="ij"))
    rows = "\n".join(f"({u!r} {v!r} {w!r})" for u, v, w in _velocity(x, z, 0.0).T.tolist())

    def change(text: str) -> str:
        start = text.index("internalField")
        end = text.index(";", start)
        return edit(f"{text[:start]}internalField nonuniform List<vector> {cells * cells} ({rows}){text[end:]}")

    return change


def _solve(bench: Simulation, steps: int) -> np.ndarray:
    """Velocity (cells, 3) at the end, after `steps` steps."""
    gas = bench.gas
    assert gas is not None
    x, z = gas.centres[:, 0], gas.centres[:, 2]
    coefficient, dt = _drag_coefficient(x, z), _END / steps
    gas.start(_voidage(x, z, 0.0))
    for n in range(1, steps + 1):
        drag = np.column_stack([coefficient, *_source(x, z, n * dt)])
        gas.step(dt, _voidage(x, z, n * dt), gas.volumes[:, None] * drag)
    return np.array(gas.velocity)


def _judge_space(measured: dict[str, list[Number]]) -> Iterator[Number]:
    errors = [measured[variant][0].value for variant in _MESHES]
    for level in (1, 2):
        name = f"order in space, {_MESHES[level - 1]} to {_MESHES[level]} cells"
        yield Number(name, math.log2(errors[level - 1] / errors[level]), 2.0, 0.15)


_MESHES = ("16", "32", "64")


@check("manufactured-space", fast=False, variants=_MESHES, judge=_judge_space)
def space(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """Error of the velocity on meshes of 16, 32 and 64 cells, the step falling as dx^2: order 2 in space."""
    cells = int(variant)
    bench = _open(folder, comm, cells)
    velocity = _solve(bench, steps=20 * (cells // 16) ** 2)
    exact = _velocity(bench.gas.centres[:, 0], bench.gas.centres[:, 2], _END).T
    yield Number("velocity error", float(np.sqrt(np.mean((velocity - exact) ** 2))), 0.0, math.inf, "m s-1")


def _judge_time(measured: dict[str, list[Number]]) -> Iterator[Number]:
    velocities = [np.array([number.value for number in measured[variant]]) for variant in _STEPS]
    changes = [np.linalg.norm(fine - coarse) for coarse, fine in itertools.pairwise(velocities)]
    yield Number("order in time, Euler", math.log2(changes[0] / changes[1]), 1.0, 0.15)


_STEPS = ("20", "40", "80")


@check("manufactured-time", fast=False, variants=_STEPS, judge=_judge_time)
def time(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """The same mesh with halved steps: the change of the solution falls with order 1 (Euler)."""
    for number, value in enumerate(_solve(_open(folder, comm, 16), int(variant)).ravel().tolist()):
        yield Number(f"velocity {number}", value, 0.0, math.inf, "m s-1")
