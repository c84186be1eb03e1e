"""The mesh of a case with openings: its faces that gas passes, and what each stream has of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from fbcouple.case.bed.streams import Opening, Stream, list_above
from fbcouple.case.problems import naming
from fbcouple.errors import CaseError
from fbcouple.geometry.imported import ImportedMesh, arrange_patches, take_surfaces
from fbcouple.geometry.plane_cover import integrate_parabola
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.sides import Integrate, cover_faces, list_polygons, list_side

_NONE = np.empty(0, np.int64)
_LEAST = 1e-9
"""Part of a face below which an inlet does not have it."""


@dataclass(frozen=True, eq=False)
class Openings:
    """A mesh with the patches inlet, outlet and walls, and the part (streams, faces) that each stream has of each face
    of its inlet, weighted with the profile."""

    mesh: PolyMesh
    shares: np.ndarray


def open_mesh(
    mesh: PolyMesh,
    streams: tuple[Stream, ...],
    outlets: tuple[Opening, ...],
    found: ImportedMesh | None = None,
    kept: Sequence[str] = (),
) -> Openings:
    """Cut the openings into the outer faces of `mesh`, that of the file `found` if there is one; the patches `kept`, in
    which no opening is, stay as they are, and all else is wall.

    Raises: CaseError (one text) if a patch is not there, an outlet has no face, or gas comes in and leaves by one face.
    """
    outer = np.arange(len(mesh.neighbour), len(mesh.owner))
    shares = np.zeros((len(streams), len(mesh.owner)))
    for number in range(len(streams)):
        faces, parts = _cover(mesh, streams, number, found)
        if found is not None:  # whole faces: a later stream takes them
            shares[:number, faces] = 0.0
        shares[number, faces] = parts
    moving = [number for number, stream in enumerate(streams) if not stream.is_closed]
    passes = shares[moving][:, outer].max(axis=0, initial=0.0) > _LEAST
    out = _list_outlet_faces(mesh, outlets, found)
    leaves = np.concatenate(out)
    if shared := len(np.intersect1d(outer[passes], leaves)):
        raise CaseError([f"inlets and outlets share {shared} faces; move them apart, or name other patches."])
    return Openings(arrange_patches(mesh, outer[passes], out, kept), shares[:, outer[passes]])


def _cover(
    mesh: PolyMesh, streams: tuple[Stream, ...], number: int, found: ImportedMesh | None
) -> tuple[np.ndarray, np.ndarray]:
    """Faces on the side of stream `number`, or of its patches, and its part of each."""
    stream, opening = streams[number], streams[number].opening
    if found is not None:
        with naming(f"inlet {number + 1}"):
            faces = take_surfaces(found, opening.key, opening.patches)
        return faces, np.ones(len(faces))
    faces = list_side(mesh, opening.face)
    polygons = list_polygons(mesh, faces, opening.face)
    return faces, cover_faces(polygons, opening.shape, list_above(streams, number), _find_integral(stream))


def _find_integral(stream: Stream) -> Integrate | None:
    """How the stream's profile is integrated over a face; None where it is flat."""
    shape = stream.opening.shape
    if stream.is_flat or shape is None:
        return None
    if stream.profile == "parabolic":
        return partial(integrate_parabola, shape=shape)
    assert not isinstance(stream.profile, str), "find_openings reads it"
    return stream.profile.integrate


def _list_outlet_faces(mesh: PolyMesh, outlets: tuple[Opening, ...], found: ImportedMesh | None) -> list[np.ndarray]:
    """Faces of each outlet that no earlier one has; one of none where there are no outlets."""
    parts: list[np.ndarray] = []
    for number, outlet in enumerate(outlets, start=1):
        with naming(f"outlet {number}"):
            faces = np.setdiff1d(find_outlet_faces(mesh, outlet, found), np.concatenate([_NONE, *parts]))
            if not len(faces):
                raise CaseError(["it has no face that earlier ones have not; remove it, or move it."])
        parts.append(faces)
    return parts or [_NONE]


def find_outlet_faces(mesh: PolyMesh, outlet: Opening, found: ImportedMesh | None = None) -> np.ndarray:
    """Faces of an outlet, of a mesh from the file `found` if it is by patches; of a shape those whose centre it
    holds: pressure is 0 on all of a face or nowhere on it.

    Raises: CaseError (one text) if there are none.
    """
    if found is not None and outlet.patches:
        return take_surfaces(found, outlet.key, outlet.patches)
    faces = list_side(mesh, outlet.face)
    if outlet.shape is not None:
        centres = np.array([polygon.mean(axis=0) for polygon in list_polygons(mesh, faces, outlet.face)])
        faces = faces[outlet.shape.has(centres.reshape(-1, 2))]
    if not len(faces):
        text = f"it holds the centre of no face of the mesh on {outlet.face}"
        raise CaseError([f"{text}; make it larger, or the cells smaller."])
    return faces


def find_stream_areas(openings: Openings) -> np.ndarray:
    """Area [m2] that each stream has of the inlet, (streams,)."""
    vectors = openings.mesh.find_vectors(openings.mesh.list_patch("inlet"))
    return np.asarray(openings.shares @ np.linalg.norm(vectors, axis=1))


def describe(opening: Opening) -> str:
    """Where an opening is, in words that begin a sentence."""
    if opening.patches:
        return f"Patches {', '.join(opening.patches)}"
    if opening.shape is None:
        return f"All of the {opening.face}"
    return f"{type(opening.shape).__name__} on {opening.face}"
