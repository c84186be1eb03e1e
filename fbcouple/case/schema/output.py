"""The sections of a case file that say what a run keeps, when, and what it is held to: no physics."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import PlainValidator, WithJsonSchema

from fbcouple.case.schema.option import Amounts, Numbers, Positive, Section, Sides, Texts, option
from fbcouple.case.schema.probes import Probes

MeanMap = Literal[
    "solids_fraction",
    "solids_flux",
    "agitation",
    "granular_temperature",
    "voidage",
    "gas_velocity",
    "gas_flux",
    "pressure",
]


MeanHistory = Literal["bed_height", "solids_centre_z", "kinetic_energy", "pressure_drop", "gas_support"]

OF_SOLIDS = (
    *("solids_fraction", "solids_flux", "agitation", "granular_temperature"),
    *("bed_height", "solids_centre_z", "kinetic_energy", "gas_support"),
)
"""Maps and histories whose error may end a run and that only particles make."""
OF_GAS = ("voidage", "gas_velocity", "gas_flux", "pressure", "pressure_drop", "gas_support")
"""The same of gas."""


AUTO = "auto"
"""What `averages.start` is where the run finds the end of its start-up itself."""


def _read_start(value: Any) -> float | str:
    """A time or `AUTO`. Raises: ValueError."""
    is_time = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < math.inf
    if value != AUTO and not is_time:
        raise ValueError("neither a time nor a word that is known")
    return AUTO if value == AUTO else float(value)


Start = Annotated[
    float | Literal["auto"],
    PlainValidator(_read_start),
    WithJsonSchema({"anyOf": [{"type": "number", "minimum": 0.0}, {"enum": [AUTO]}]}),
]


class Averages(Section):
    start: Start = option(
        'Time at which averaging starts; "auto": where the start-up ends, which the run finds itself.', "s"
    )
    every: float = option("Time between samples.", "s", 2e-3, **Positive)
    blocks: int = option(
        "Blocks of the window, for the standard errors; with `until_error` there are once to twice as many.",
        default=10,
        ge=2,
        le=1000,
    )
    until_error: float | None = option(
        "Standard error of the map `error_of` over the map, root mean square, or of the mean of a history over the "
        "mean, at which the run is complete, if that is before end_time; absent: it runs to end_time.",
        default=None,
        gt=0.0,
        lt=1.0,
    )
    earliest_end: float | None = option(
        "Simulated time before which `until_error` ends no run; absent: none.", "s", None, **Positive
    )
    error_of: Literal[MeanMap, MeanHistory] | None = option(
        "Mean map whose error ends the run, of a vector its component along z, or history; absent: solids_flux, "
        "without particles gas_velocity.",
        default=None,
    )
    mirror: Sides = option(
        'Axes in whose middle plane the bed is its own mirror image, as ["x"]: samples are averaged with their images.',
        default=(),
    )


def find_first_sample(averages: Averages) -> float:
    """Time [s] of the first sample; with `AUTO` samples are taken from the start of the run on."""
    return 0.0 if averages.start == AUTO else float(averages.start)


def name_map(averages: Averages, has_particles: bool) -> str:
    """The mean map, or history, whose error ends a run."""
    return averages.error_of or ("solids_flux" if has_particles else "gas_velocity")


class Output(Section):
    record_every: float = option("Time between rows of the history.", "s", 1e-2, **Positive)
    save_every: float = option("Wall time between rewrites of results.nc.", "s", 60.0, **Positive)
    snapshots_every: float | None = option(
        "Time between snapshots of the depth-mean voidage, for bubbles; absent: none are taken.", "s", None, **Positive
    )
    particles_every: float | None = option(
        "Time between frames of all particles and of the gas in every cell, for 3-D views, in the folder frames of the "
        "run; absent: none are taken.",
        "s",
        None,
        **Positive,
    )
    tracked: Numbers = option(
        "Particles, numbered from 1 as they start, whose position and velocity the history has.", default=()
    )
    probes: Probes = option(
        "Points and lines at which fields are followed in time: tables [[output.probes]].", default=()
    )
    task_file: str | None = option(
        "Python file beside the case with tasks of your own, classes of fbcouple.Task: their methods are called after "
        "every step. It is code, and runs with --trust only.",
        default=None,
        max_length=255,
    )
    references: Texts = option(
        "Measured lines for the report: quantity@height=file, height in m, CSV beside the case (x in m, value, error); "
        "quantity@height,front:back=file is compared from y = front to back alone, quantity@height,r=file over the "
        "radius of a column (r in m).",
        default=(),
    )
    profile_heights: Amounts = option(
        "Heights above the floor of the profiles in figures and reports; absent: that of the bed's centre of mass.",
        "m",
        default=(),
    )
    radial_heights: Amounts = option(
        "Heights above the floor of profiles over the radius of a column, about its middle: a cylinder, or a mesh that "
        "is one; absent: of a cylinder those of `profile_heights`, of a mesh none.",
        "m",
        default=(),
    )


class Checkpoint(Section):
    wall_every: float = option("Wall time between checkpoints.", "s", 600.0, **Positive)
    every: float | None = option(
        "Simulated time between checkpoints; absent: by wall time only.", "s", None, **Positive
    )
    moment_steps: int = option(
        "Coupling steps between the moments at which a checkpoint can be written; at each the particles' solver is set "
        "up anew, so that a resumed run equals the uninterrupted one.",
        default=100,
        ge=1,
        le=1_000_000,
    )


class Monitors(Section):
    """What ends a run with exit code 4; cells over the closest packing (0.74) are counted and end nothing."""

    momentum: float = option("Imbalance of a step's momentum exchange over its impulse.", default=1e-9, **Positive)
    solids_volume: float = option("Relative error of the solids volume that the gas sees.", default=1e-9, **Positive)
    ledger: float = option(
        "Mass, or momentum, of particles that came and went against what there is, over all of it; their number has to "
        "be exact.",
        default=1e-9,
        **Positive,
    )
    heat: float = option(
        "Heat of gas and particles after a step against that before it and what came in, over what they hold.",
        default=1e-9,
        **Positive,
    )
    gas_flux: float = option(
        "Error of the gas flux at a height against continuity, over the fastest inflow.", default=1e-2, **Positive
    )
    inflow: float = option(
        "Error of the gas that comes in by the inlet in a step, over the fastest inflow of the run; of inlets that let "
        "gas in and out over what passes all of them.",
        default=1e-6,
        **Positive,
    )
    courant: float = option("Courant number of a fluid step over gas.max_courant.", default=50.0, gt=1.0, le=1e9)
    substeps: int = option("DEM steps in a fluid step.", default=10_000, ge=1)
    voidage: float = option(
        "Voidage that each cell must be above: at 0.1 others clamp it, and drag no longer means a thing.",
        default=0.1,
        ge=0.0,
        lt=1.0,
    )
    voidage_excess: float = option("Voidage above 1, by rounding.", default=1e-9, **Positive)
    overlap: float = option(
        "Overlap of two particles over their mean diameter; 0.05 is usual in a violent bed.",
        default=0.3,
        gt=0.0,
        le=1.0,
    )
