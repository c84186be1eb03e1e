"""Frames drawn in 3-D, off screen: `python -m fbcouple.postproc.views.render REQUEST.json`, a process of its own.

Where neither EGL nor OSMesa is there the 3-D library ends its process, so it is never loaded into another one.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from fbcouple.postproc.figures.arrows import sample_arrows
from fbcouple.postproc.views.colours import SPEED, TEMPERATURE, voidage_map
from fbcouple.postproc.views.frames import Frame, read_frame

FINER = 2
"""Pixels drawn for one of the picture, along each axis."""
TURN, RISE = 20.0, 14.0  # degrees from the front view to the right, and up
ARROWS_ACROSS = 9
LONGEST_ARROW = 1.3  # of the distance between arrows
MARGIN = 1.02


@dataclass(frozen=True)
class Request:
    """What is to be drawn: `pictures` are rows of frame, name of `VIEWS`, and PNG file."""

    corner: tuple[float, float, float]
    """Lower left front corner of the box [m]."""
    size: tuple[float, float, float]
    """The box [m]."""
    height: int
    """Pixels of each picture."""
    speed: float
    """Speed of particles [m/s] at which the colour scale ends."""
    gas_speed: float
    """Speed of the gas [m/s] that has the longest arrow."""
    voidage: tuple[float, float]
    """Limits of the colour scale."""
    temperature: tuple[float, float] | None
    """Limits of the colour scale [K]; None in a case without heat."""
    pictures: list[tuple[str, str, str]]


View = Callable[[pyvista.Plotter, Frame, Request], None]
VIEWS: dict[str, View] = {}


def view(function: View) -> View:
    """Register `function(plotter, frame, request)`, which puts what it shows onto the plotter."""
    VIEWS[function.__name__] = function
    return function


@view
def particles(plotter: pyvista.Plotter, frame: Frame, request: Request) -> None:
    """All particles, as large as they are, coloured by their speed."""
    _add_particles(plotter, frame, frame.speeds, SPEED, (0.0, request.speed))


@view
def temperature(plotter: pyvista.Plotter, frame: Frame, request: Request) -> None:
    """All particles, as large as they are, coloured by their temperature."""
    assert frame.temperatures is not None and request.temperature is not None
    _add_particles(plotter, frame, frame.temperatures, TEMPERATURE, request.temperature)


def _add_particles(
    plotter: pyvista.Plotter, frame: Frame, values: np.ndarray, colours: str, limits: tuple[float, float]
) -> None:
    if not len(frame.positions):
        return  # a bed that drained
    cloud = pyvista.PolyData(frame.positions)
    cloud["value"], cloud["radius"] = values, 0.5 * frame.diameters
    look: dict[str, Any] = {"style": "points_gaussian", "render_points_as_spheres": True, "emissive": False}
    actor = plotter.add_points(cloud, scalars="value", cmap=colours, clim=limits, show_scalar_bar=False, **look)
    actor.mapper.scale_array, actor.mapper.scale_factor = "radius", 1.0
    actor.prop.ambient, actor.prop.diffuse = 0.45, 0.75


@view
def gas(plotter: pyvista.Plotter, frame: Frame, request: Request) -> None:
    """The plane in the middle of the depth: voidage as colour, the velocity of the gas as arrows; nothing where it is
    outside of a mesh."""
    assert frame.voidage is not None and frame.gas_velocity is not None
    width, depth, height = request.size
    left, front, floor = request.corner
    nz, _, nx = frame.voidage.shape
    plane = pyvista.ImageData(
        dimensions=(nx + 1, 1, nz + 1), spacing=(width / nx, 1.0, height / nz), origin=(left, front + depth / 2, floor)
    )
    plane.cell_data["voidage"] = cut(frame.voidage).ravel()
    look: dict[str, Any] = {"show_scalar_bar": False, "lighting": False, "nan_opacity": 0.0}
    plotter.add_mesh(plane, scalars="voidage", cmap=voidage_map(), clim=request.voidage, **look)
    flow = cut(frame.gas_velocity[0]), cut(frame.gas_velocity[2])
    x, z, across, up = sample_arrows(*flow, (width, height), ARROWS_ACROSS)
    whole = np.isfinite(across)
    apart = width / x.shape[1]
    x, z, across, up = x[whole], z[whole], across[whole], up[whole]
    # Just before the plane, as the camera sees it.
    before = np.full(x.size, front + 0.49 * depth)
    arrows = pyvista.PolyData(np.column_stack([left + width * x, before, floor + height * z]))
    arrows["velocity"] = np.column_stack([across, np.zeros(x.size), up])
    arrows["speed"] = np.hypot(across, up)
    shape = pyvista.Arrow(start=(-0.5, 0.0, 0.0), shaft_radius=0.05, tip_radius=0.14, tip_length=0.35)
    factor = LONGEST_ARROW * apart / request.gas_speed
    glyphs = arrows.glyph(orient="velocity", scale="speed", factor=factor, geom=shape)
    plotter.add_mesh(glyphs, color="black", lighting=False)


def cut(field: np.ndarray) -> np.ndarray:
    """Middle of the depth of a field (z, y, x): the row there, or the mean of the two beside it, where both are inside
    of the mesh; (z, x)."""
    rows = field.shape[1]
    return field[:, (rows - 1) // 2 : rows // 2 + 1].mean(axis=1)


def look_at(size: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Directions to the camera, to the right and up in the picture, and extents (right, up) [m] of the box in it."""
    turn, rise = np.radians([TURN, RISE])
    back = np.array([np.sin(turn) * np.cos(rise), -np.cos(turn) * np.cos(rise), np.sin(rise)])
    right = np.array([np.cos(turn), np.sin(turn), 0.0])
    up = np.cross(back, right)
    corners = np.array([[(n >> axis & 1) * size[axis] for axis in range(3)] for n in range(8)])
    return back, right, up, np.array([np.ptp(corners @ right), np.ptp(corners @ up)])


def open_plotter(request: Request) -> pyvista.Plotter:
    """An empty white picture that the box fills, without perspective."""
    back, _, up, extent = look_at(request.size)
    height = FINER * request.height
    width = FINER * round(request.height * extent[0] / extent[1])
    plotter = pyvista.Plotter(off_screen=True, window_size=[width, height])
    plotter.background_color = pyvista.Color("white")
    middle = np.array(request.corner) + 0.5 * np.array(request.size)
    plotter.camera.parallel_projection = True
    plotter.camera.position = tuple(middle + 4.0 * max(request.size) * back)
    plotter.camera.focal_point, plotter.camera.up = tuple(middle), tuple(up)
    plotter.camera.parallel_scale = 0.5 * MARGIN * extent[1]
    return plotter


def draw(request: Request) -> None:
    """Draw every picture of `request`, each by a plotter of its own: in one that is used again VTK draws particles as
    dots."""
    frames: dict[str, Frame] = {}
    for path, name, target in request.pictures:
        if path not in frames:
            frames = {path: read_frame(Path(path))}
        plotter = open_plotter(request)
        camera = plotter.camera.copy()
        ends = np.column_stack([request.corner, np.add(request.corner, request.size)])
        plotter.add_mesh(pyvista.Box(tuple(ends.ravel())), style="wireframe", color="#444444", line_width=2)
        VIEWS[name](plotter, frames[path], request)
        plotter.camera = camera
        plotter.renderer.ResetCameraClippingRange()
        pixels = np.asarray(plotter.screenshot(None, return_img=True))
        plotter.close()
        Image.fromarray(pixels).reduce(FINER).save(target, compress_level=1)


def main() -> None:
    """Read the request and draw it."""
    request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    draw(Request(**request))


if __name__ == "__main__":
    main()
