"""Options of the region and its mesh, [domain], and of the gas, [gas]."""

from __future__ import annotations

from typing import Literal

from fbcouple.case.schema.inlets import Inlets, Outlets
from fbcouple.case.schema.option import (
    Cells,
    Faces,
    Lengths,
    NonNegative,
    Positive,
    Ramp,
    Section,
    Sides,
    Sizes,
    option,
)

FROM_MESH = ("size", "cells")
"""Options of [domain] that a mesh from a file says where the case does not."""


class Domain(Section):
    size: Sizes = option(
        "Inner width, depth and height of the bed; z is up, the floor is z = 0. Of a cylinder twice the diameter and "
        "the height, of a mesh from a file the box around it, within 1 % (a round wall of flat faces is a little "
        "narrower); may be left out there: the mesh says it.",
        "m",
    )
    cells: Cells = option(
        "Cells of the gas mesh along x, y and z; also the grid of the averages. Of a cylinder the cells across it, "
        "twice, and up; with a mesh from a file only the grid that its results are sampled on, which may be left out: "
        "as coarse as the mesh."
    )
    shape: Literal["box", "cylinder", "file"] = option(
        "A box of equal cells, an upright cylinder meshed here, or the mesh of `mesh`.", default="box"
    )
    elements: Literal["tetrahedra", "prisms"] | None = option(
        "Cells of a cylinder, absent: tetrahedra (the paper's kind); of a box six tetrahedra or two prisms from each "
        "of its `cells`, absent: hexahedra.",
        default=None,
    )
    mesh: str | None = option(
        'Mesh beside the case, for shape = "file": a gmsh file (.msh), or a folder (polyMesh) as OpenFOAM\'s tools '
        "write it.",
        default=None,
    )
    scale: float | None = option(
        "Factor that the lengths in the file of the mesh are multiplied by, 1e-3 for a mesh in mm; absent: 1, the mesh "
        "is in m.",
        default=None,
        gt=0.0,
        le=1e9,
        allow_inf_nan=False,
    )
    inlet: str | None = option(
        "Patch of the mesh, or physical surface, that the gas comes in by, along the inward normal of each face; one "
        "without a name by its number; absent: inlet.",
        default=None,
    )
    outlet: str | None = option(
        "Patch of the mesh that the gas leaves by; absent: outlet. A wall for particles, as all patches are.",
        default=None,
    )
    periodic: Sides = option(
        "Axes along which the bed repeats itself in place of two walls, for both phases.", default=()
    )

    @property
    def is_plain_box(self) -> bool:
        """Is the region a box of equal hexahedra?"""
        return self.shape == "box" and self.elements is None


class Gas(Section):
    density: float = option("Gas density.", "kg m-3", **Positive)
    viscosity: float = option("Dynamic viscosity.", "Pa s", **Positive)
    inlet_velocity: float | None = option(
        "Superficial velocity over the whole floor, a closed nozzle included; of a mesh from a file over the patch "
        "`inlet`, along the inward normal of each face. Give this, `inlet_ramp` or `inlets`.",
        "m s-1",
        None,
        **NonNegative,
    )
    inlet_ramp: Ramp | None = option(
        "Times [s] and superficial velocities as of `inlet_velocity`, any number of rows, linear between, the last one "
        "from then on; a time given twice is a jump, below 0 the gas leaves by the inlet. A step has the velocity of "
        "its end. Give this, `inlet_velocity` or `inlets`.",
        "m s-1",
        None,
    )
    inlets: Inlets = option(
        "Where gas comes in, in place of `inlet_velocity` or `inlet_ramp`: tables [[gas.inlets]]. What none of them "
        "covers is wall; where two overlap the later one lies on top.",
        default=(),
    )
    outlets: Outlets = option(
        "Where gas leaves, at pressure 0, in place of the whole top: tables [[gas.outlets]].", default=()
    )
    inlet_section: float | None = option(
        "Area that the superficial velocity of all `inlets` together counts for: of a box or a cylinder the floor, of "
        "a mesh from a file the inlets; filled in.",
        "m2",
        None,
        **Positive,
    )
    closed_nozzle: Faces | None = option(
        "Faces along x and y in the middle of the floor that let no gas through; absent: the whole floor is open.",
        default=None,
    )
    closed_nozzle_size: Lengths | None = option(
        "Width and depth of the closed nozzle in the middle of the floor, in place of `closed_nozzle`: the same on "
        "every mesh, faces that it cuts let gas through with their open part.",
        "m",
        None,
    )
    top: Literal["open", "closed"] = option(
        "Top of the box: open to gas at pressure 0, or a lid, under which no gas may come in. Particles leave by it "
        "only where an outlet of particles says so.",
        default="open",
    )
    walls: Literal["no-slip", "slip"] = option("Gas at the side walls and the closed nozzle.", default="no-slip")
    turbulence: Literal["none", "smagorinsky", "keqn", "dynamic-lagrangian", "localized-dynamic"] = option(
        "Sub-grid model of the gas (paper: localized-dynamic, here with C_s held within 0-0.23).", default="none"
    )
    max_courant: float = option("Courant limit of the fluid step (paper: 0.2).", default=0.2, **Positive)
    max_fourier: float = option("Fourier (diffusion) limit of the fluid step (paper: 0.15).", default=0.15, **Positive)
    max_step: float | None = option(
        "Longest fluid step; absent: the Courant and Fourier limits alone.", "s", None, **Positive
    )
    correctors: int = option("PISO pressure corrections a step.", default=2, ge=1, le=20)
    pressure_tolerance: float = option(
        "Normalised residual at which each pressure solve stops.", default=1e-6, gt=0.0, lt=0.1
    )
