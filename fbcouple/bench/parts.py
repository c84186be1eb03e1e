"""What a scene saves by leaving out what it does not need: the same case with and without each of its parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

Content = dict[str, Any]
Edit = Callable[[Content], None]
LEFT_OUT: dict[str, Edit] = {}


def leaves_out(name: str) -> Callable[[Edit], Edit]:
    """Register how a part is taken out of a case's content."""

    def register(edit: Edit) -> Edit:
        LEFT_OUT[name] = edit
        return edit

    return register


@leaves_out("friction")
def drop_friction(content: Content) -> None:
    """Spheres that slide freely: no tangential model."""
    content["contact"] |= {"friction": 0.0, "wall_friction": 0.0, "rolling_friction": 0.0, "tangential": "no-history"}


@leaves_out("damping")
def drop_damping(content: Content) -> None:
    """Elastic contacts."""
    content["contact"] |= {"restitution": 1.0, "wall_restitution": 1.0}


@leaves_out("rotation")
def drop_rotation(content: Content) -> None:
    """Positions and velocities only."""
    content["particles"] |= {"rotation": False}


@leaves_out("turbulence")
def drop_turbulence(content: Content) -> None:
    """No sub-grid model of the gas."""
    content["gas"] |= {"turbulence": "none"}


@leaves_out("closed nozzle")
def drop_nozzle(content: Content) -> None:
    """Gas through the whole floor."""
    content["gas"] |= {"closed_nozzle": None}


@leaves_out("pressure-gradient force")
def drop_gradient(content: Content) -> None:
    """No pressure-gradient force on the particles."""
    content["exchange"] |= {"pressure_gradient": False}


@leaves_out("extra forces")
def drop_forces(content: Content) -> None:
    """No lift, viscous force and virtual mass."""
    content["exchange"] |= {"lift_force": False, "viscous_force": False, "virtual_mass": False}


@leaves_out("filter")
def drop_filter(content: Content) -> None:
    """What is exchanged goes to the cells as it is."""
    content["exchange"] |= {"filter_passes": 0}


@leaves_out("averages")
def drop_averages(content: Content) -> None:
    """No time means."""
    content["averages"] = None


@leaves_out("all of these")
def drop_all(content: Content) -> None:
    """Gas and particles, and their drag: nothing else."""
    for name, edit in list(LEFT_OUT.items()):
        if name not in ("gas", "particles", "all of these"):
            edit(content)


@leaves_out("gas")
def drop_gas(content: Content) -> None:
    """Particles alone: OpenFOAM never starts."""
    content["gas"] = content["exchange"] = None
    content["output"] |= {"snapshots_every": None}


@leaves_out("particles")
def drop_particles(content: Content) -> None:
    """Gas alone: LIGGGHTS never starts."""
    for section in ("particles", "contact", "start", "exchange"):
        content[section] = None
    content["output"] |= {"snapshots_every": None, "particles_every": None, "tracked": ()}


def make_variants(case: Case) -> dict[str, Case]:
    """The whole case, and the case without each part that it has.

    Raises: CaseError if the case lacks one of the two phases or starts from a file.
    """
    if not (case.gas and case.particles and case.contact and case.exchange and case.start):
        raise CaseError(["bench parts: the case needs gas and particles, on the lattice of [start]."])
    variants = {"nothing": case}
    for name, edit in LEFT_OUT.items():
        content = case.model_dump()
        edit(content)
        variant = Case.model_validate(content)
        if variant != case:
            variants[name] = variant
    return variants
