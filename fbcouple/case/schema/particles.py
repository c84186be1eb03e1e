"""Options of the particles, [particles], of their contacts, [contact], and of how they start, [start]."""

from __future__ import annotations

from typing import Literal

from fbcouple.case.schema.feeds import Feeds, ParticleOutlets
from fbcouple.case.schema.option import (
    Mixture,
    NonNegative,
    Pairs,
    Positive,
    Region,
    Section,
    SizesOfParticles,
    Walls,
    option,
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
    positions_seed: int | None = option(
        "Seed of a random shift of every particle of `positions`, or of a start that is poured or taken over, by up to "
        "a thousandth of its diameter along each axis: the same bed, and soon another motion. Absent: none. A lattice "
        "has `start.seed`.",
        default=None,
        ge=0,
        le=2**63 - 1,
    )
    coarse_graining: float | None = option(
        "Length ratio l of parcels, l^3 particles each: LIGGGHTS has spheres of l times the diameter and the same "
        "density, with the drag of the particles that they stand for. What a case says, and what results tell, is of "
        "particles; absent: every particle is one of LIGGGHTS.",
        default=None,
        ge=1.0,
        le=1000.0,
    )
    parcels: int | None = option(
        "Number of parcels of the bed, in place of `coarse_graining`: the ratio that makes it is chosen, and stands in "
        "the effective case.",
        default=None,
        ge=1,
        le=2_000_000_000,
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
        "Normal spring k_n (not printed in the paper, 300-1500 fits it), of parcels times `particles.coarse_graining`; "
        "absent with `max_overlap`: the one that makes it.",
        "N m-1",
        1000.0,
        **Positive,
    )
    max_overlap: float | None = option(
        "Largest overlap of two particles over their diameter, at the fastest speed that they can have or under the "
        "bed at rest (`fbcouple check`), in place of `stiffness` or `youngs_modulus`: the spring that makes it is "
        "chosen, and stands in the effective case. The DEM step is proportional to it.",
        default=None,
        ge=1e-4,
        le=0.2,
    )
    restitution: float = option("Normal restitution between particles, e_n.", gt=0.0, le=1.0)
    wall_restitution: float = option("Normal restitution against walls, e_w.", gt=0.0, le=1.0)
    friction: float = option("Coulomb friction between particles, mu_p.", ge=0.0, le=10.0)
    wall_friction: float = option("Coulomb friction against walls, mu_w.", ge=0.0, le=10.0)
    pairs: Pairs = option(
        "Rows of two species, their restitution and their friction, in place of `restitution` and `friction`.",
        default=(),
    )
    scale_restitution: bool = option(
        "Restitution e_l of parcels of `particles.coarse_graining`, e_l^2 = 1 - l (1 - e^2), between them and against "
        "walls, so that they lose as much in a volume and a time as the particles do; false: e as it is given.",
        default=True,
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
        "Root mean square of the speeds below which a poured bed is at rest, with the fastest below a hundred times "
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
    restart: str | None = option(
        "Restart file of LIGGGHTS (`write_restart`) beside the case whose particles this one starts with. Nothing can "
        "check it, so it is read with --trust only.",
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
        """Have positions to be made first, by another run, a restart file or pouring?"""
        return self.run is not None or self.restart is not None or self.method == "pour"
