"""Thirty meshes by gmsh, and what gmsh itself says of them: `python gmsh_shapes.py FOLDER` writes all that.

It runs as a process of its own: gmsh holds one state, and brings libraries of its own into the process.
"""

import json
import math
import sys
from pathlib import Path

import gmsh

FORMATS = [(4.1, False), (4.1, True), (2.2, False), (2.2, True)]
SHAPES = {}


def shape(function):
    """A geometry: it returns the tags of the surfaces that are inlet and outlet."""
    SHAPES[function.__name__] = function
    return function


def find_surfaces(choose):
    return [tag for _, tag in gmsh.model.getEntities(2) if choose(gmsh.model.occ.getCenterOfMass(2, tag))]


def take_ends(bottom, top, axis=2):
    found = [find_surfaces(lambda place, at=at: abs(place[axis] - at) < 1e-9) for at in (bottom, top)]
    assert all(found)
    return found


@shape
def box():
    gmsh.model.occ.addBox(0, 0, 0, 0.012, 0.012, 0.03)
    gmsh.model.occ.synchronize()
    return take_ends(0.0, 0.03)


@shape
def cylinder():
    """About its own axis."""
    gmsh.model.occ.addCylinder(0, 0, -0.01, 0, 0, 0.03, 0.008)
    gmsh.model.occ.synchronize()
    return take_ends(-0.01, 0.02)


@shape
def cone():
    gmsh.model.occ.addCone(0, 0, 0, 0, 0, 0.02, 0.004, 0.01)
    gmsh.model.occ.synchronize()
    return take_ends(0.0, 0.02)


@shape
def spout():
    """A jet in the middle of the floor."""
    column = gmsh.model.occ.addBox(-0.009, -0.009, 0, 0.018, 0.018, 0.03)
    gmsh.model.occ.fragment([(3, column)], [(2, gmsh.model.occ.addDisk(0, 0, 0, 0.004, 0.004))])
    gmsh.model.occ.synchronize()
    jet = [tag for tag in find_surfaces(lambda place: abs(place[2]) < 1e-9) if gmsh.model.occ.getMass(2, tag) < 1e-4]
    return jet, find_surfaces(lambda place: abs(place[2] - 0.03) < 1e-9)


@shape
def tee():
    """A pipe into the side of a column."""
    column = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 0.03, 0.006)
    pipe = gmsh.model.occ.addCylinder(0, 0, 0.012, 0.014, 0, 0, 0.004)
    gmsh.model.occ.fuse([(3, column)], [(3, pipe)])
    gmsh.model.occ.synchronize()
    return take_ends(0.0, 0.03)


@shape
def bricks():
    """Hexahedra, transfinite."""
    gmsh.model.occ.addBox(0, 0, 0, 0.012, 0.015, 0.03)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.setTransfiniteAutomatic()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.003)
    return take_ends(0.0, 0.03)


@shape
def prisms():
    """A disc of triangles, extruded in layers."""
    disc = gmsh.model.occ.addDisk(0, 0, 0, 0.008, 0.008)
    gmsh.model.occ.extrude([(2, disc)], 0, 0, 0.02, [6])
    gmsh.model.occ.synchronize()
    return take_ends(0.0, 0.02)


@shape
def recombined():
    """A disc of quadrangles, extruded downwards."""
    disc = gmsh.model.occ.addDisk(0, 0, 0.02, 0.008, 0.008)
    gmsh.model.occ.extrude([(2, disc)], 0, 0, -0.02, [6], recombine=True)
    gmsh.model.occ.synchronize()
    for _, tag in gmsh.model.getEntities(2):
        gmsh.model.mesh.setRecombine(2, tag)
    return take_ends(0.0, 0.02)


@shape
def mixed():
    """Tetrahedra on prisms, on one face in common."""
    low = gmsh.model.occ.addRectangle(0, 0, 0, 0.012, 0.012)
    prisms = gmsh.model.occ.extrude([(2, low)], 0, 0, 0.01, [4])
    gmsh.model.occ.extrude([prisms[0]], 0, 0, 0.01)
    gmsh.model.occ.synchronize()
    return take_ends(0.0, 0.02)


def add_group(dimension, tags, name):
    group = gmsh.model.addPhysicalGroup(dimension, tags)
    gmsh.model.setPhysicalName(dimension, group, name)


def find_cell_sizes():
    kinds, tags, _ = gmsh.model.mesh.getElements(3)
    count = sum(map(len, tags))
    volume = sum(
        float(gmsh.model.mesh.getElementQualities(found, "volume").sum()) for _, found in zip(kinds, tags, strict=True)
    )
    return count, volume


def find_area(surfaces):
    """Of the triangles and quadrangles of these surfaces."""
    area = 0.0
    for surface in surfaces:
        _, tags, _ = gmsh.model.mesh.getElements(2, surface)
        area += sum(float(gmsh.model.mesh.getElementQualities(found, "volume").sum()) for found in tags)
    return area


def make(name, size):
    gmsh.clear()
    gmsh.model.add(name)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    inlet, outlet = SHAPES[name]()
    add_group(3, [tag for _, tag in gmsh.model.getEntities(3)], "bed")
    add_group(2, inlet, "Zulauf ö(1)")
    add_group(2, outlet, "top")
    gmsh.model.mesh.generate(3)
    count, volume = find_cell_sizes()
    return {"cells": count, "volume": volume, "inlet": find_area(inlet), "outlet": find_area(outlet)}


def main(folder):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    numbers = {}
    for k, name in enumerate([*SHAPES] * 4):
        version, binary = FORMATS[(k % len(SHAPES) + k // len(SHAPES)) % 4]
        if len(numbers) == 30:
            break
        about = make(name, 0.0034 - 0.0003 * (k // len(SHAPES)))
        file = f"{len(numbers):02d}-{name}-{version:g}-{'binary' if binary else 'text'}.msh"
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", int(binary))
        gmsh.write(str(folder / file))
        numbers[file] = about
    gmsh.finalize()
    assert all(math.isfinite(value) for about in numbers.values() for value in about.values())
    (folder / "numbers.json").write_text(json.dumps(numbers))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
