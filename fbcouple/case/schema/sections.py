"""Every option of a case file, once: type, default, range, unit and a sentence.

A section that a case does not need is left out of the file: no `[gas]`, and OpenFOAM never starts; no
`[particles]`, and LIGGGHTS never starts; no `filter_passes`, no filter.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field, PrivateAttr

from fbcouple.case.schema.feeds import Feeds, ParticleOutlets
from fbcouple.case.schema.inlets import Inlets, Outlets
from fbcouple.case.schema.option import (
    Cells,
    Faces,
    Lengths,
    Mixture,
    NonNegative,
    Pairs,
    Positive,
    Ramp,
    Region,
    Section,
    Sides,
    Sizes,
    SizesOfParticles,
    Walls,
    option,
)
from fbcouple.case.schema.output import Averages, Checkpoint, Monitors, Output

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
        "only where an outlet of particles has face = top.",
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


class Particles(Section):
    diameter: float = option("Diameter.", "m", **Positive)
    density: float = option("Material density.", "kg m-3", **Positive)
    mixture: Mixture = option(
        "Further species, numbered from 2: rows of diameter [m], density [kg m-3] and fraction of the bed; the rest of "
        "it, species 1, is what `diameter` and `density` say.",
        default=(),
    )
    fractions: Literal["mass", "number"] = option("What `mixture` and `spread` are parts of.", default="mass")
    spread: Literal["normal", "lognormal"] | None = option(
        "Distribution of the diameter of species 1 about `diameter` (its mean, or median if lognormal), with "
        "`deviation`, between `smallest` and `largest`; absent: all are of one size.",
        default=None,
    )
    deviation: float | None = option(
        "Standard deviation of the diameter; for lognormal that of ln(d) is ln(1 + deviation/diameter).",
        "m",
        None,
        **Positive,
    )
    smallest: float | None = option("Diameter at which the distribution is cut off below.", "m", None, **Positive)
    largest: float | None = option("Diameter at which the distribution is cut off above.", "m", None, **Positive)
    classes: int = option(
        "Diameters that stand for the distribution, with equal parts of it; each pair of them has its own damping.",
        default=8,
        ge=2,
        le=50,
    )
    mass: float | None = option("Mass of the bed; the count is rounded. Give this or `count`.", "kg", None, **Positive)
    count: int | None = option(
        "Number of particles; 0 where they come by `feeds` alone. Give this or `mass`.", default=None, ge=0, le=10**15
    )
    positions: str | None = option(
        "File of start positions beside the case: a table (CSV: x, y, z in m; where they start moving also vx, vy, vz "
        "in m/s and omegax, omegay, omegaz in rad/s; of each particle also radius or diameter in m, density in kg/m3, "
        "kind), a text dump or a data file of LIGGGHTS or LAMMPS in SI units; absent: as [start] says.",
        default=None,
    )
    positions_step: int | None = option(
        "Time step that is taken of a dump with several; absent: the last one.", default=None, ge=0, le=2**63 - 1
    )
    sizes: SizesOfParticles = option(
        "Rows of diameter [m], density [kg m-3] and number of particles, in place of `diameter` and `density`, where "
        "the file `positions` gives each particle its own; filled in from it, `diameter` then counts for kernels only.",
        default=(),
    )
    rotation: bool = option("Integrate rotation (the paper does not).", default=False)
    feeds: Feeds = option("Where particles come in while the run goes on: tables [[particles.feeds]].", default=())
    outlets: ParticleOutlets = option(
        "Where particles are taken out while the run goes on: tables [[particles.outlets]]; absent: all walls, and the "
        "top, are closed to them.",
        default=(),
    )


class Contact(Section):
    stiffness: float = option(
        "Normal spring k_n (not printed in the paper, 300-1500 fits it).", "N m-1", 1000.0, **Positive
    )
    restitution: float = option("Normal restitution between particles, e_n.", gt=0.0, le=1.0)
    wall_restitution: float = option("Normal restitution against walls, e_w.", gt=0.0, le=1.0)
    friction: float = option("Coulomb friction between particles, mu_p.", ge=0.0, le=10.0)
    wall_friction: float = option("Coulomb friction against walls, mu_w.", ge=0.0, le=10.0)
    pairs: Pairs = option(
        "Rows of two species, their restitution and their friction, in place of `restitution` and `friction`.",
        default=(),
    )
    walls: Walls = option(
        "Rows of a species, its restitution and its friction against walls, in place of the common ones.", default=()
    )
    steps_per_contact: int | None = option(
        "DEM steps in one contact time T_C (paper: 6); absent: as many as a packed bed of this restitution, contact "
        "model and friction needs to come to rest, at least 6 (hooke with history and rotation: 6 from e = 0.5 on, 9 "
        "at 0.3, 16 at 0.1; hertz 6 from 0.7 on, 11 at 0.3).",
        default=None,
        ge=3,
        le=1000,
    )
    skin: float | None = option(
        "Skin of the neighbour lists in diameters of the smallest particle, for speed alone (`fbcouple bench skin`); "
        "absent: 0.3, with a tangential spring 0.4.",
        default=None,
        ge=0.05,
        le=10.0,
    )
    tangential: Literal["no-history", "history"] | None = option(
        "Friction: Coulomb sliding with a viscous limit (no-history, the paper's), or a tangential spring that "
        "remembers the contact (history). Without history nothing sticks: loaded contacts slide slowly, a bed at rest "
        "flows and packs, a heap spreads; it is for beds that move all over. Absent: history where there is friction.",
        default=None,
    )
    tangential_stiffness: float | None = option(
        "k_t/k_n of the tangential spring (hooke with history; hertz has it from its moduli); absent: 2/7.",
        default=None,
        gt=0.0,
        le=2.0,
    )
    tangential_damping: float | None = option(
        "Damping along the tangential spring over that along the normal (hooke with history); absent: 1/2.",
        default=None,
        ge=0.0,
        le=20.0,
    )
    rolling_friction: float = option(
        "Rolling resistance mu_r: torque mu_r F_n R against the rolling (constant directional torque); 0: none.",
        default=0.0,
        ge=0.0,
        le=10.0,
    )
    model: Literal["hooke", "hertz"] = option(
        "Normal force: linear spring of `stiffness` (paper), or Hertz from the moduli below.", default="hooke"
    )
    youngs_modulus: float | None = option(
        "Young's modulus of particles and walls (hertz only).", "Pa", None, ge=1e3, le=1e13
    )
    poisson_ratio: float | None = option(
        "Poisson's ratio of particles and walls (hertz only).", default=None, ge=0.0, le=0.5
    )
    impact_speed: float | None = option(
        "Relative speed whose contact time T_C sets the DEM step (hertz only): the fastest that the bed will see.",
        "m s-1",
        None,
        **Positive,
    )


class Start(Section):
    method: Literal["lattice", "pour"] = option(
        "Particles start on a lattice, or poured: they rain in at random places and settle under gravity, without gas "
        "and by the contacts of the case, until they are at rest.",
        default="lattice",
    )
    spacing: float = option("Distance of the simple cubic start lattice in diameters.", default=1.03, gt=1.0, le=10.0)
    jitter: float = option(
        "Random shift of each particle, as a part of the free gap of the lattice.", default=0.5, ge=0.0, lt=1.0
    )
    seed: int = option("Seed of the random shift, and of what is poured.", default=1, ge=0, le=2**63 - 1)
    region: Region | None = option(
        "Part of the bed that the lattice fills from below: rows of lowest and highest x, y and z, as the mesh has "
        "them; absent: all of it.",
        "m",
        None,
    )
    rest_speed: float | None = option(
        "Root mean square of the speeds below which a poured bed is at rest, with the fastest particle below ten times "
        "that; absent: 1 % of sqrt(g d) of the smallest.",
        "m s-1",
        None,
        **Positive,
    )
    settle_limit: float = option(
        "Simulated time that a poured bed, or each part of it that is poured at once, has to come to rest.",
        "s",
        5.0,
        le=1e4,
        **Positive,
    )
    run: str | None = option(
        "Run folder of another case whose particles this one starts with: those of its newest checkpoint, or last "
        "frame, or of `time`. From the folder of the case file; with --set from the current one.",
        default=None,
    )
    time: float | None = option(
        "Time in that run that the particles are taken of: the nearest checkpoint or frame, at most an interval of "
        "frames away.",
        "s",
        None,
        **NonNegative,
    )

    @property
    def is_made(self) -> bool:
        """Have positions to be made first, by another run or by pouring?"""
        return self.run is not None or self.method == "pour"


class Exchange(Section):
    drag: str = option(
        'Drag law, a name of the registry in fbcouple/physics/drag/laws.py, or "own".', default="huilin-gidaspow"
    )
    drag_file: str | None = option(
        'Python file beside the case with the case\'s own law, for drag = "own"; it runs only with --trust.',
        default=None,
    )
    polydisperse: Literal["none", "beetstra"] = option(
        "Drag of particles of several sizes: the law at a particle's own diameter, or at the mean diameter of its cell "
        "times the factor eps y + (1 - eps) y^2 + 0.064 eps y^3 of Beetstra et al., y its diameter over that mean.",
        default="none",
    )
    scheme: Literal["exponential", "semi-implicit", "explicit"] = option(
        "Drag over a fluid step: averaged exactly, backward Euler, or the value at the start (paper).",
        default="exponential",
    )
    accelerated: bool | None = option(
        "The drag of a step knows what velocity the other forces gave the particle in the last one, and is exact for "
        "constant ones (exponential only); absent: where the fluid step is over 0.2 % of the particles' response time.",
        default=None,
    )
    voidage: Literal["trilinear", "centre", "divided", "gaussian"] = option(
        "How a particle is shared among cells and reads them: trilinear weights (paper), the cell of its centre, 29 "
        "equal parts, or a Gaussian kernel of `kernel_width`.",
        default="trilinear",
    )
    kernel_width: float | None = option(
        "Bandwidth b of the Gaussian kernel exp(-r^2/b^2), in particle diameters: variance b^2/2 along each axis.",
        default=None,
        ge=0.5,
        le=1000.0,
    )
    diffusion_width: float | None = option(
        "Bandwidth b, in particle diameters, of a diffusion of all that is exchanged (implicit, conservative), close "
        "to the kernel exp(-r^2/b^2): variance b^2/2 along each axis; absent: none.",
        default=None,
        ge=0.1,
        le=1000.0,
    )
    filter_passes: int = option("Passes of the (1/4, 1/2, 1/4) filter (paper: 1).", default=0, ge=0, le=20)
    pressure_gradient: bool = option("Pressure-gradient force on the particles.", default=True)
    viscous_force: bool = option("Viscous force V div(tau) of the gas on the particles.", default=False)
    lift_force: bool = option("Lift of particles in shear (Saffman, Mei).", default=False)
    virtual_mass: bool = option(
        "Virtual mass of the particles, half the gas that they displace; contacts have it too.", default=False
    )


class Case(Section):
    """A whole case file."""

    _origin: tuple[str, tuple[str, ...]] = PrivateAttr(("", ()))
    _base_folders: tuple[Path, ...] = PrivateAttr(())

    title: str = option("One line that says what this case is.", min_length=1, max_length=200)
    end_time: float = option(
        "Simulated time at which the run is complete; a run that is done goes on to a later one by --resume.",
        "s",
        **Positive,
    )
    gravity: float = option("Gravity, along -z.", "m s-2", 9.81, **NonNegative)
    accuracy: Literal["none", "draft", "standard", "reference"] = option(
        "Preset of fluid step, pressure solver and contact steps where the case leaves them out; none: the default of "
        "each. Measured on patil/c2 from its start to 0.12 s, core-seconds a simulated second and distance from "
        "Courant number 0.1 over the range of bed height, pressure drop and mean solids fraction: draft 257, 0.008, "
        "0.015, 0.006; standard 267, 0.004, 0.007, 0.004; reference 748, 0.0005, 0.002, 0.002.",
        default="none",
    )
    domain: Domain
    gas: Gas | None = None
    particles: Particles | None = None
    contact: Contact | None = None
    start: Start | None = None
    exchange: Exchange | None = None
    averages: Averages | None = None
    output: Output = Field(default_factory=Output)
    checkpoint: Checkpoint = Field(default_factory=Checkpoint)
    monitors: Monitors = Field(default_factory=Monitors)

    def remember_origin(self, name: str, sets: Sequence[str]) -> None:
        """Keep the name or path that the case was read by, and the `key=value` settings on top of it."""
        self._origin = name, tuple(sets)

    def remember_bases(self, folders: Sequence[Path]) -> None:
        """Keep the folders of the case files that this case stands on, the nearest first."""
        self._base_folders = tuple(folders)

    def find_folder(self, folder: Path, name: str | None) -> Path:
        """Where the file `name` of the case lies: in its own `folder`, or in that of the nearest base that has it."""
        places = (folder, *self._base_folders) if name else ()
        return next((place for place in places if (place / str(name)).exists()), folder)

    def __eq__(self, other: object) -> bool:
        """Cases are the same by their values, wherever they were read from."""
        return isinstance(other, Case) and self.__dict__ == other.__dict__

    __hash__ = Section.__hash__

    @property
    def base_folders(self) -> tuple[Path, ...]:
        """Folders beside its own that files of the case may lie in, the nearest first."""
        return self._base_folders

    @property
    def origin(self) -> tuple[str, tuple[str, ...]]:
        """Name or path that the case was read by, and settings on top of it; "" for one made otherwise."""
        return self._origin
