"""Time means and frames of a run as files of VTK, for ParaView and its kin.

Means stand on their own cells: those of a box in a regular grid (means.vti), those of a mesh of polyhedra in the mesh
(means.vtu).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr

from fbcouple.paths import find_home
from fbcouple.postproc.files import write_whole, writing
from fbcouple.postproc.views.frames import Frame, list_frames, number_of, read_frame
from fbcouple.postproc.views.library import require_pyvista
from fbcouple.results.reader import NotDrawableError, Results, open_results

FOLDER = "vtk"
_TETRAHEDRON = 17
"""Entries of a cell of four triangles in mesh_faces."""


def export(run: Path, folder: Path | None = None) -> list[Path]:
    """Write `folder`, by default RUN/vtk: the time means on their cells, and of every frame the particles and the gas,
    with a collection of each over time. Returns the files to open; names and SI units are those of results.nc.

    Raises: CaseError if there are no results, or a file cannot be written; NotDrawableError if they hold neither means
    nor frames.
    """
    require_pyvista()
    results = open_results(run)
    means = _list_means(results.data)
    try:
        frames = list_frames(results)
    except NotDrawableError:
        frames = []
    if not (means or frames):
        raise NotDrawableError([f"{results.path} holds no time means, and no frames lie beside it."])
    folder = folder or find_home(Path(run)) / FOLDER
    with writing(folder):
        folder.mkdir(exist_ok=True, parents=True)
    found: list[Path] = []
    if means and "mesh_faces" in results.data:
        found.append(_write_mesh(folder / "means.vtu", results))
    elif means:
        found.append(_write_grid(folder / "means.vti", results, means))
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

    counts = [results.data.sizes[axis] for axis in "xyz"]
    spacing = [length / count for length, count in zip(results.size, counts, strict=True)]
    grid = ImageData(dimensions=[count + 1 for count in counts], spacing=spacing, origin=results.corner)
    for name, values in fields.items():
        grid.cell_data[name] = values.reshape(grid.n_cells, *values.shape[3:])
    return _save(grid, path)


def _save(data: Any, path: Path) -> Path:
    """Save a set of data of VTK, which says on stderr, and to nobody else, that it could not."""
    with writing(path):
        path.unlink(missing_ok=True)
        data.save(path)
        if not path.is_file() or not path.stat().st_size:
            raise OSError("VTK could not write it")
    return path


def _write_mesh(path: Path, results: Results) -> Path:
    """The means in the cells of the mesh: tetrahedra as such, all other shapes as polyhedra."""
    from pyvista import CellType, UnstructuredGrid  # noqa: PLC0415  (VTK takes a second to load)

    points, starts, stream = (results.data[f"mesh_{name}"].values for name in ("points", "starts", "faces"))
    rows, kinds = [], []
    for first, last in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        row = stream[first:last]
        if len(row) == _TETRAHEDRON:
            # The first face is anticlockwise from outside; VTK wants it so from the fourth point.
            a, b, c = row[2:5]
            (top,) = set(row[6:9].tolist()) - {a, b, c}
            rows += [4, a, c, b, top]
            kinds.append(CellType.TETRA)
        else:
            rows += [len(row), *row.tolist()]
            kinds.append(CellType.POLYHEDRON)
    grid = UnstructuredGrid(np.array(rows), np.array(kinds, np.uint8), points)
    with xr.open_dataset(results.path, decode_times=False) as data:
        for name, field in data.data_vars.items():
            if "cell" in field.dims and bool(np.isfinite(field).any()):
                grid.cell_data[str(name)] = field.transpose("cell", ...).values
    return _save(grid, path)


def _write_frames(folder: Path, results: Results, frames: list[Path]) -> list[Path]:
    from pyvista import PolyData  # noqa: PLC0415  (VTK takes a second to load)

    rows: dict[str, list[tuple[float, str]]] = {"particles": [], "gas": []}
    for path in frames:
        frame, number = read_frame(path), number_of(path)
        cloud = PolyData(frame.positions)
        columns: dict[str, np.ndarray | None] = {"velocity": frame.velocities, "diameter": frame.diameters}
        if frame.grain_diameters is not None:  # as the frame files have them
            columns |= {"diameter": frame.grain_diameters, "parcel_diameter": frame.diameters}
        columns |= {"species": frame.species, "feed": frame.feeds, "temperature": frame.temperatures}
        for name, column in columns.items():
            if column is not None and len(frame.positions):  # a bed that drained has no points, and no columns
                cloud.point_data[name] = column
        _save(cloud, folder / f"particles-{number:06d}.vtp")
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
    if frame.gas_temperature is not None:
        fields["gas_temperature"] = frame.gas_temperature
    return fields


def _collect(path: Path, files: list[tuple[float, str]]) -> Path:
    """ParaView's list of files over time."""
    lines = [f'    <DataSet timestep="{time!r}" file={quoteattr(name)}/>' for time, name in files]
    text = '<VTKFile type="Collection" version="0.1">\n  <Collection>\n' + "\n".join(lines)
    text += "\n  </Collection>\n</VTKFile>\n"
    return write_whole(path, lambda place: place.write_text(text, encoding="utf-8"))
