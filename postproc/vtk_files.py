"""Time means and frames of a run as files of VTK, for ParaView and its kin."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr

from postproc.dataset import NotDrawableError, Results, open_results
from postproc.frames import Frame, list_frames, number_of, read_frame

FOLDER = "vtk"


def export(run: Path) -> list[Path]:
    """Write RUN/vtk: the time means on the regular grid, and of every frame the particles and the gas, with a
    collection of each over time. Returns the files to open; names and SI units are those of results.nc.

    Raises: CaseError if there are no results; NotDrawableError if they hold neither means nor frames.
    """
    results = open_results(run)
    means = _list_means(results.data)
    try:
        frames = list_frames(results)
    except NotDrawableError:
        frames = []
    if not (means or frames):
        raise NotDrawableError([f"{results.path} holds no time means, and no frames lie beside it."])
    folder = Path(run) / FOLDER
    folder.mkdir(exist_ok=True)
    found = [_write_grid(folder / "means.vti", results, means)] if means else []
    return found + _write_frames(folder, results, frames)


def _list_means(data: xr.Dataset) -> dict[str, np.ndarray]:
    """Fields (z, y, x) and (z, y, x, 3) of the results that hold a number."""
    means = {}
    for name, field in data.data_vars.items():
        if {"z", "y", "x"} <= set(field.dims) and bool(np.isfinite(field).any()):
            means[str(name)] = field.transpose("z", "y", "x", ...).values
    return means


def _write_grid(path: Path, results: Results, fields: Mapping[str, np.ndarray]) -> Path:
    from pyvista import ImageData  # noqa: PLC0415  (VTK takes a second to load)

    axes = [results.data[axis].values.astype(float) for axis in "xyz"]
    spacing = [length / len(axis) for length, axis in zip(results.size, axes, strict=True)]
    corner = [axis[0] - edge / 2 for axis, edge in zip(axes, spacing, strict=True)]
    grid = ImageData(dimensions=[len(axis) + 1 for axis in axes], spacing=spacing, origin=corner)
    for name, values in fields.items():
        grid.cell_data[name] = values.reshape(grid.n_cells, *values.shape[3:])
    grid.save(path)
    return path


def _write_frames(folder: Path, results: Results, frames: list[Path]) -> list[Path]:
    from pyvista import PolyData  # noqa: PLC0415  (VTK takes a second to load)

    rows: dict[str, list[tuple[float, str]]] = {"particles": [], "gas": []}
    for path in frames:
        frame, number = read_frame(path), number_of(path)
        cloud = PolyData(frame.positions)
        cloud.point_data["velocity"], cloud.point_data["diameter"] = frame.velocities, frame.diameters
        cloud.save(folder / f"particles-{number:06d}.vtp")
        rows["particles"].append((frame.time, f"particles-{number:06d}.vtp"))
        if gas := _list_gas(frame):
            _write_grid(folder / f"gas-{number:06d}.vti", results, gas)
            rows["gas"].append((frame.time, f"gas-{number:06d}.vti"))
    return [_collect(folder / f"{name}.pvd", files) for name, files in rows.items() if files]


def _list_gas(frame: Frame) -> dict[str, np.ndarray]:
    fields = {}
    if frame.voidage is not None:
        fields["voidage"] = frame.voidage
    if frame.gas_velocity is not None:
        fields["gas_velocity"] = np.moveaxis(frame.gas_velocity, 0, -1)
    return fields


def _collect(path: Path, files: list[tuple[float, str]]) -> Path:
    """ParaView's list of files over time."""
    lines = [f'    <DataSet timestep="{time!r}" file={quoteattr(name)}/>' for time, name in files]
    text = '<VTKFile type="Collection" version="0.1">\n  <Collection>\n' + "\n".join(lines)
    path.write_text(text + "\n  </Collection>\n</VTKFile>\n")
    return path
