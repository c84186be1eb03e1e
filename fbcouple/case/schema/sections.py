"""A case file: its sections, with the options of its top and of [exchange].

Every option stands once, with type, default, range, unit and a sentence: those of the other sections in gas.py,
particles.py, heat.py and output.py beside this file, those of tables in lists in inlets.py and feeds.py.

A section that a case does not need is left out of the file: no `[gas]`, and OpenFOAM never starts; no
`[particles]`, and LIGGGHTS never starts; no `filter_passes`, no filter.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PrivateAttr, WithJsonSchema

from fbcouple.case.schema.gas import Domain, Gas
from fbcouple.case.schema.heat import Heat
from fbcouple.case.schema.option import NonNegative, Positive, Section, option
from fbcouple.case.schema.output import Averages, Checkpoint, Monitors, Output
from fbcouple.case.schema.particles import Contact, Particles, Start

LAWS = (
    *("huilin-gidaspow", "gidaspow", "ergun", "wen-yu", "di-felice", "beetstra", "tenneti", "tang", "koch-hill"),
    *("syamlal-obrien", "schiller-naumann", "stokes"),
)
"""Names of the drag laws, for lists and editors: to read the laws themselves takes a compiler."""
Law = Annotated[str, WithJsonSchema({"type": "string", "enum": [*LAWS, "own"]})]


class Exchange(Section):
    drag: Law = option('Drag law, by its name; "own" for the one in `drag_file`.', default="huilin-gidaspow")
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
    _inherited: frozenset[str] = PrivateAttr(frozenset())

    title: str = option("One line that says what this case is.", min_length=1, max_length=200)
    end_time: float = option(
        "Simulated time at which the run is complete; a run that is done goes on to a later one by --resume.",
        "s",
        **Positive,
    )
    gravity: float = option("Gravity, along -z.", "m s-2", 9.81, **NonNegative)
    accuracy: Literal["none", "draft", "standard", "reference"] = option(
        "Preset of fluid step, pressure solver, contact steps and overlap where the case leaves them out; none: the "
        "default of each. Measured on patil/c2 from its start to 0.12 s, core-seconds a simulated second and distance "
        "from Courant number 0.1 and overlap 0.01 over the range of bed height, pressure drop and mean solids "
        "fraction: draft 165, 0.015, 0.013, 0.006; standard 291, 0.009, 0.006, 0.004; reference 1602, 0.0004, 0.001, "
        "0.002.",
        default="none",
    )
    domain: Domain
    gas: Gas | None = None
    particles: Particles | None = None
    contact: Contact | None = None
    start: Start | None = None
    exchange: Exchange | None = None
    heat: Heat | None = None
    averages: Averages | None = None
    output: Output = Field(default_factory=Output)
    checkpoint: Checkpoint = Field(default_factory=Checkpoint)
    monitors: Monitors = Field(default_factory=Monitors)

    def remember_origin(self, name: str, sets: Sequence[str]) -> None:
        """Keep the name or path that the case was read by, and the `key=value` settings on top of it."""
        self._origin = name, tuple(sets)

    def remember_bases(self, folders: Sequence[Path], inherited: frozenset[str] = frozenset()) -> None:
        """Keep the folders of the case files that this case stands on, the nearest first, and the options, by dotted
        key, that these files say and its own does not."""
        self._base_folders, self._inherited = tuple(folders), inherited

    def find_folder(self, folder: Path, name: str | None) -> Path:
        """Where the file `name` of the case lies: in its own `folder`, or in that of the nearest base that has it."""
        base_folders = (folder, *self._base_folders) if name else ()
        return next((base_folder for base_folder in base_folders if (base_folder / str(name)).exists()), folder)

    def __eq__(self, other: object) -> bool:
        """Cases are the same by their values, wherever they were read from."""
        return isinstance(other, Case) and self.__dict__ == other.__dict__

    __hash__ = Section.__hash__

    @property
    def base_folders(self) -> tuple[Path, ...]:
        """Folders beside its own that files of the case may lie in, the nearest first."""
        return self._base_folders

    @property
    def inherited(self) -> frozenset[str]:
        """Options, by dotted key, that the case has from the files that it stands on."""
        return self._inherited

    @property
    def origin(self) -> tuple[str, tuple[str, ...]]:
        """Name or path that the case was read by, and settings on top of it; "" for one made otherwise."""
        return self._origin
