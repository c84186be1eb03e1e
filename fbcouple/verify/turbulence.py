"""Sub-grid models: the turbulent viscosity that the solver finds in flows whose coefficient is known.

Linear shear u = (g z, 0, 0) between moving plates: Smagorinsky and the one-equation model at its equilibrium have
nu_t = (C_s Delta)^2 |S| with C_s^2 = C_k sqrt(C_k/C_e); a dynamic model must find 0, as L has only normal parts and M
only tangential ones.

Strain u = s (x, y, -2 z): the test filter of variance v along each axis leaves a linear field as it is, so that
L = v A A^T and M = -6 Delta^2 |S| S, which gives C = L:M/M:M = -v (A A^T:S)/(6 Delta^2 |S|^3) with |S| = sqrt(S:S).

Uniform stream between walls that hold it: in the cells beside them M is the difference of two equal tensors, and
C = L:M/M:M, of rounding alone, would be anything.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.gas import Edits, set_patches
from fbcouple.verify.harness import open_bench
from fbcouple.verify.registry import Number, check

_CELL, _VISCOSITY, _RATE = 0.01, 1e-5, 10.0
"""Edge of a cell [m], dynamic viscosity [Pa s] of gas of density 1, and rate of shear or strain [1/s]."""
_CK, _CE = 0.094, 1.048
_CONSTANT = _CK * math.sqrt(_CK / _CE)
"""C_s^2 of both models with fixed coefficients."""
_PATCHES = ("inlet", "outlet", "left", "right", "front", "back")
_ZERO_GRADIENT = dict.fromkeys(_PATCHES, "type zeroGradient;")
_SHEAR_CELLS, _STRAIN_CELLS, _VORTEX_CELLS, _STREAM_CELLS = (4, 4, 10), (12, 12, 12), (16, 16, 16), (12, 6, 12)
Flow = tuple[np.ndarray, dict[str, str], str]
"""Velocity (cells, 3) [m/s], the entry of U at each side, and what the sides are."""
_LEAST, _NOISE = 0.03, 1e-10
"""Least |M| over its two terms of the localized model, and relative differences between cells of the stream."""
_DENSE = 1e9
"""Drag [kg m-3 s-1] that holds the gas to the velocity S/K of its source."""


def name_sides(sides: str, text: str) -> str:
    """Every side of the box a patch of its own, of OpenFOAM's type `sides` (left and right: cyclic or that)."""
    cyclic = {"left": "type cyclic; neighbourPatch right;", "right": "type cyclic; neighbourPatch left;"}
    faces = {"left": "(0 4 7 3)", "right": "(1 2 6 5)", "front": "(0 1 5 4)", "back": "(3 7 6 2)"}
    kind = {name: cyclic.get(name, "type wall;") if sides == "cyclic" else "type patch;" for name in faces}
    entries = "".join(
        f"    {name}\n    {{\n        {kind[name]}\n        faces ({faces[name]});\n    }}\n" for name in faces
    )
    head, _ = text.split("    walls\n")
    return f"{head}{entries});\n"


def start_from(velocity: np.ndarray, entries: dict[str, str], text: str) -> str:
    """Start with `velocity` (cells, 3) [m/s]; cells run along x first, then y."""
    rows = "\n".join(f"({u!r} {v!r} {w!r})" for u, v, w in velocity.tolist())
    field = f"internalField nonuniform List<vector> {len(velocity)} ({rows});"
    return set_patches(entries)(re.sub(r"internalField.*?;", lambda _: field, text, flags=re.DOTALL))


def _open(folder: Path, comm: MPI.Comm, model: str, cells: tuple[int, int, int], flow: Flow) -> Simulation:
    """A box of gas with the sub-grid model `model` that starts in `flow`."""
    velocity, entries, sides = flow
    cyclic = dict.fromkeys(("left", "right"), "type cyclic;") if sides == "cyclic" else {}
    edits: Edits = {
        "CFD/system/blockMeshDict": partial(name_sides, sides),
        "CFD/system/controlDict": lambda text: text.replace("binary", "ascii"),
        "CFD/0/U": partial(start_from, velocity, entries | cyclic),
    }
    scalars = {"p", "voidage", "nut"} | {"keqn": {"k"}, "dynamic-lagrangian": {"flm", "fmm"}}.get(model, set())
    edits |= {f"CFD/0/{name}": set_patches(_ZERO_GRADIENT | cyclic) for name in scalars}
    gas = {"density": 1.0, "viscosity": _VISCOSITY, "inlet_velocity": 0.0, "turbulence": model}
    gas |= {"pressure_tolerance": 1e-10}
    domain = {"size": [_CELL * n for n in cells], "cells": list(cells)}
    return open_bench(folder, comm, {"domain": domain, "gas": gas}, edits=edits)


def _centres(cells: tuple[int, int, int]) -> np.ndarray:
    """Places (n, 3) [m] of the cells from the middle of the box."""
    axes = [(np.arange(n) + 0.5 - n / 2) * _CELL for n in cells]
    z, y, x = (axis.ravel() for axis in np.meshgrid(*axes[::-1], indexing="ij"))
    return np.column_stack([x, y, z])


def _shear() -> Flow:
    velocity = _centres(_SHEAR_CELLS) * 0.0
    velocity[:, 0] = _RATE * _centres(_SHEAR_CELLS)[:, 2]
    edge = _RATE * _CELL * _SHEAR_CELLS[2] / 2
    plates = {"inlet": f"type fixedValue; value uniform ({-edge} 0 0);"}
    plates |= {"outlet": f"type fixedValue; value uniform ({edge} 0 0);", "front": "type slip;", "back": "type slip;"}
    return velocity, plates, "cyclic"


def _strain() -> Flow:
    rates = _RATE * np.array([1.0, 1.0, -2.0])
    low = {name: (0.0, 0.0, 0.0) for name in _PATCHES}
    for axis, (first, last) in enumerate((("left", "right"), ("front", "back"), ("inlet", "outlet"))):
        normal = np.eye(3)[axis] * rates[axis] * _CELL * _STRAIN_CELLS[axis] / 2
        low[first], low[last] = tuple((-normal).tolist()), tuple(normal.tolist())
    entries = {name: f"type fixedValue; value uniform ({x} {y} {z});" for name, (x, y, z) in low.items()}
    return rates * _centres(_STRAIN_CELLS), entries, "patch"


def _vortices() -> Flow:
    """Vortices without divergence, no two directions alike; the walls slip."""
    x, y, z = (_centres(_VORTEX_CELLS) * math.pi / (_CELL * _VORTEX_CELLS[0]) * np.array([2.0, 3.0, 2.0])).T
    u, v = np.sin(x) * np.cos(y) * np.cos(z), 0.5 * np.cos(x) * np.sin(y) * np.cos(z + 0.4)
    w = np.cos(x) * np.cos(y) * (-np.sin(z) - 0.75 * np.sin(z + 0.4))
    return np.column_stack([u, v, w]), dict.fromkeys(_PATCHES, "type slip;"), "patch"


def _stream() -> Flow:
    """A stream along z, held by the walls in front and behind, whose cells differ by about rounding."""
    noise = _NOISE * np.random.default_rng(1).uniform(-1.0, 1.0, (math.prod(_STREAM_CELLS), 3))
    entries = _ZERO_GRADIENT | dict.fromkeys(("left", "right"), "type slip;")
    entries |= dict.fromkeys(("front", "back"), "type fixedValue; value uniform (0 0 0);")
    return np.array([0.0, 0.0, 1.0]) + noise, entries, "patch"


def _read(name: str, cells: tuple[int, int, int], margin: int = 0) -> np.ndarray:
    """The written scalar field `name` as (z, y, x), without `margin` cells at each wall."""
    newest = max((path for path in Path("CFD").iterdir() if re.fullmatch(r"[\d.e+-]+", path.name)), key=_as_time)
    text = (newest / name).read_text(encoding="utf-8")
    inside = text[text.index("internalField") : text.index("boundaryField")]
    if "nonuniform" in inside:
        values = np.array(inside[inside.index("(") + 1 : inside.rindex(")")].split(), float)
    else:
        values = np.full(math.prod(cells), float(inside.split()[2].rstrip(";")))
    inner = slice(margin, -margin or None)
    return values.reshape(cells[::-1])[inner, inner, inner]


def _as_time(path: Path) -> float:
    return float(path.name)


def _farthest(values: np.ndarray, expected: np.ndarray | float) -> float:
    """The value that lies farthest from what is expected of it."""
    return float(values.ravel()[np.abs(values - expected).argmax()])


def _hold(bench: Simulation, velocity: np.ndarray, steps: int, dt: float) -> None:
    drag = _DENSE * bench.gas.volumes[:, None] * np.column_stack([np.ones(len(velocity)), velocity])
    for _ in range(steps):
        bench.gas.step(dt, bench.gas.clean_input[0], drag)
    bench.gas.write()


def shear(folder: Path, comm: MPI.Comm, model: str) -> Iterator[Number]:
    """Turbulent viscosity in linear shear, over Delta^2 |S|."""
    flow = _shear()
    bench = _open(folder, comm, model, _SHEAR_CELLS, flow)
    _hold(bench, flow[0], steps=200, dt=0.5 / _RATE)
    dynamic = "dynamic" in model
    viscosity = _read("nut", _SHEAR_CELLS)[2:-2] / (_CELL**2 * _RATE)
    expected, tolerance = (0.0, 1e-8) if dynamic else (_CONSTANT, 1e-4 * _CONSTANT)
    yield Number("nu_t/(Delta^2 |S|) in linear shear", _farthest(viscosity, expected), expected, tolerance)
    if model == "keqn":
        energy = _read("k", _SHEAR_CELLS) / (_CELL * _RATE) ** 2
        yield Number("k/(Delta |S|)^2 in linear shear", _farthest(energy, _CK / _CE), _CK / _CE, 1e-4)


def strain(folder: Path, comm: MPI.Comm, model: str, variance: float) -> Iterator[Number]:
    """Turbulent viscosity of a dynamic model in u = s (x, y, -2 z); `variance` of its test filter in Delta^2."""
    flow = _strain()
    bench = _open(folder, comm, model, _STRAIN_CELLS, flow)
    _hold(bench, flow[0], steps=20, dt=0.02 / _RATE)
    magnitude = math.sqrt(6.0) * _RATE
    coefficient = variance * 6.0 * _RATE**3 / (6.0 * magnitude**3)
    found = _read("nut", _STRAIN_CELLS, margin=4) / (_CELL**2 * magnitude)
    yield Number("C in axisymmetric strain", _farthest(found, coefficient), coefficient, 0.01, relative=True)


def vortices(folder: Path, comm: MPI.Comm, model: str) -> Iterator[Number]:
    """The localized model before any step, cell by cell, against the identity evaluated with numpy."""
    flow = _vortices()
    bench = _open(folder, comm, model, _VORTEX_CELLS, flow)
    bench.gas.write()
    expected = localize(flow[0].reshape(*_VORTEX_CELLS[::-1], 3))
    inner = slice(3, -3)
    found, expected = _read("nut", _VORTEX_CELLS, margin=3), expected[inner, inner, inner]
    largest = float(expected.max())
    yield Number("largest difference of nu_t", float(np.abs(found - expected).max()) / largest, 0.0, 1e-9)
    yield Number("cells with and without viscosity", float((expected > 0).mean()), 0.5, 0.4)


def stream(folder: Path, comm: MPI.Comm, model: str) -> Iterator[Number]:
    """The localized model before any step beside walls that hold a uniform stream: no coefficient out of rounding.

    The cells there have |S| = u/(sqrt(2) Delta); |L| is 0.07 of the terms of M, so that C is held below
    0.07 _NOISE/_LEAST^2.
    """
    flow = _stream()
    bench = _open(folder, comm, model, _STREAM_CELLS, flow)
    bench.gas.write()
    far_from_ends = _read("nut", _STREAM_CELLS)[4:-4, :, 4:-4]
    at_walls = far_from_ends[:, [0, -1]] / (_CELL**2 / (math.sqrt(2.0) * _CELL))
    yield Number("C beside a wall that holds a uniform stream", _farthest(at_walls, 0.0), 0.0, 1e-5)


def _smooth(field: np.ndarray) -> np.ndarray:
    """(1/4, 1/2, 1/4) along z, y and x; without meaning in the outermost cells."""
    for axis in range(3):
        field = 0.25 * (np.roll(field, 1, axis) + np.roll(field, -1, axis)) + 0.5 * field
    return field


def _deform(velocity: np.ndarray) -> np.ndarray:
    """Deviatoric rate of strain (z, y, x, 3, 3) by central differences."""
    gradient = np.stack([np.gradient(velocity, _CELL, axis=axis) for axis in (2, 1, 0)], axis=-1)
    return _deviate(0.5 * (gradient + gradient.swapaxes(-1, -2)))


def _deviate(tensor: np.ndarray) -> np.ndarray:
    return tensor - np.trace(tensor, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)


def _contract(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...ij,...ij", a, b)


def localize(velocity: np.ndarray) -> np.ndarray:
    """nu_t (z, y, x) [m2/s] of the localized dynamic model for `velocity` (z, y, x, 3) (Germano 1991, Lilly 1992)."""
    rate = _deform(velocity)
    size = np.sqrt(_contract(rate, rate))
    smooth = _smooth(velocity)
    smooth_rate = _deform(smooth)
    smooth_size = np.sqrt(_contract(smooth_rate, smooth_rate))
    products = _smooth(velocity[..., :, None] * velocity[..., None, :])
    leonard = _deviate(products - smooth[..., :, None] * smooth[..., None, :])
    fine, coarse = _smooth(size[..., None, None] * rate), 4 * (smooth_size[..., None, None] * smooth_rate)
    model, scale = 2 * _CELL**2 * (fine - coarse), 4 * _CELL**4
    least = _LEAST**2 * scale * (_contract(fine, fine) + _contract(coarse, coarse))
    above, below = _smooth(_contract(leonard, model)), _smooth(np.maximum(_contract(model, model), least))
    return np.clip(above / below, 0.0, math.sqrt(2.0) * 0.23**2) * _CELL**2 * size


def _collect(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for numbers in measured.values():
        yield from numbers


_FLOWS: dict[str, dict[str, Callable[..., Iterator[Number]]]] = {
    "smagorinsky": {"shear": shear},
    "keqn": {"shear": shear},
    "dynamic-lagrangian": {"shear": shear, "strain": partial(strain, variance=1 / 6)},
    "localized-dynamic": {
        "shear": shear,
        "strain": partial(strain, variance=1 / 2),
        "vortices": vortices,
        "stream": stream,
    },
}


def _run(folder: Path, comm: MPI.Comm, variant: str, model: str) -> Iterator[Number]:
    yield from _FLOWS[model][variant](folder, comm, model)


for _model, _flows in _FLOWS.items():
    _register: Any = check(f"turbulence-{_model}", variants=tuple(_flows), judge=_collect)
    _register(partial(_run, model=_model))
