"""The largest speed that particles of a case can have when they meet, and the overlap that it makes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fbcouple.case.bed.contact_coefficients import find_pair, find_wall
from fbcouple.case.bed.derived import find_spring, hertz_modulus, hertz_overlap, inlet_ramp
from fbcouple.case.bed.drag_balance import EXPANDED, find_balance, find_drag
from fbcouple.case.bed.falls import Fall, list_falls
from fbcouple.case.bed.gas_heat import speed_up_gas
from fbcouple.case.bed.jets import find_jet_range
from fbcouple.case.bed.number import Law, Number, judge
from fbcouple.case.bed.particle_types import Kind, list_kinds, particle_count, solids_volume
from fbcouple.case.bed.region import Region
from fbcouple.case.schema.particles import Contact
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import OWN
from fbcouple.physics.contact import normal_damping

SETTLED = 0.60
"""Solids fraction of the bed at rest."""

FIT_OVERLAP = 0.05
"""Overlap of a contact over the diameter up to which a bed hardly knows of its soft springs."""
LARGE = 0.1
"""Diameter [m] above which a length was most likely given in mm."""

Speed = tuple[float, str]
"""How fast [m/s], and in words what makes a particle so fast."""


def estimate_overlap(case: Case, region: Region, law: Law | None, folder: Path) -> Iterator[Number]:
    """The largest overlap of a contact, by the largest speed that particles can have; a lone one meets walls only."""
    assert case.particles is not None
    overlap, speed, why = find_largest_overlap(case, list_speeds(case, region, law, folder))
    if speed > 0.0:
        partner = "a contact with a wall" if _is_alone(case) else "a head-on contact"
        meaning = f"Overlap over diameter of {partner} at {speed:.3g} m s-1, from {why}; a stiffer spring lowers it."
        if (largest := max(kind.diameter for kind in list_kinds(case.particles))) > LARGE:
            meaning = f"{meaning} Particles of {largest:g} m: lengths are in m, 1 mm is 1e-3."
        verdict = judge(overlap <= FIT_OVERLAP, "warn" if overlap <= 0.2 else "unfit")
        yield Number("overlap", overlap, "d", f"at most {FIT_OVERLAP:g}", verdict, meaning)


def list_speeds(case: Case, region: Region, law: Law | None, folder: Path) -> list[tuple[Kind, float, str]]:
    """Each kind of particle with the largest speed [m/s] that one of it can have, and why (`_find_speed`)."""
    assert case.particles is not None
    bed = region.find_level(solids_volume(case.particles) / SETTLED)
    falls = list_falls(case, region, bed, folder)
    jets = find_jet_range(case, folder) if case.gas else (0.0, 0.0)
    return [(kind, *_find_speed(case, kind, region, bed, law, falls, jets)) for kind in list_kinds(case.particles)]


def find_largest_overlap(case: Case, speeds: list[tuple[Kind, float, str]]) -> tuple[float, float, str]:
    """The largest overlap, over the diameter, of contacts at `speeds`, and the speed [m/s] that makes it, and why."""
    assert case.contact is not None
    alone = _is_alone(case)
    return max((_find_overlap(case.contact, kind, speed, alone), speed, why) for kind, speed, why in speeds)


def _is_alone(case: Case) -> bool:
    assert case.particles is not None
    return particle_count(case.particles) == 1 and not case.particles.feeds


def _find_overlap(contact: Contact, kind: Kind, speed: float, alone: bool) -> float:
    """Overlap over diameter of a contact at relative speed `speed` [m/s], with one of its kind or, `alone`, with a wall
    (eqs 43-45; elastic for hertz)."""
    part = 1.0 if alone else 0.5
    mass = part * kind.mass
    if contact.model == "hertz":
        return hertz_overlap(hertz_modulus(contact), mass, part * kind.diameter / 2.0, speed) / kind.diameter
    restitution = (find_wall(contact, kind) if alone else find_pair(contact, kind, kind)).restitution
    spring = find_spring(contact, kind)
    damping = normal_damping(spring, mass, restitution)
    swing = math.sqrt(spring / mass - damping**2)
    reach = speed / math.sqrt(spring / mass) * math.exp(-damping / swing * math.atan2(swing, damping))
    return reach / kind.diameter


def _find_speed(
    case: Case,
    kind: Kind,
    region: Region,
    bed: float,
    law: Law | None,
    falls: Sequence[Fall],
    jets: tuple[float, float],
) -> Speed:
    """The largest speed of a particle of `kind`: as it starts or is fed, falls, or is carried by the gas, whose
    velocity in the streams of the inlet is within `jets` [m/s].

    Of a fall it is no faster than before or than the terminal velocity. The gas accelerates a lone particle in the
    stream of the inlet over the height `bed` [m] of the bed, and in the column over the height of the region; it lifts
    the bed as a whole over the height of the bed. Nothing gets faster than the gas around it.
    """
    speeds = [_fall(case, kind, fall, law) for fall in falls if fall.species in (None, kind.species)]
    if case.gas:
        speeds += _carry(case, kind, region, bed, law, jets)
    return max(speeds)


def _knows_drag(case: Case, law: Law | None) -> bool:
    return case.exchange is not None and (law is not None or case.exchange.drag != OWN)


def _weigh(case: Case, kind: Kind) -> float:
    """Weight less buoyancy over mass [m s-2], below 0 where the particle rises."""
    return case.gravity * (1.0 - (case.gas.density if case.gas else 0.0) / kind.density)


def _fall(case: Case, kind: Kind, fall: Fall, law: Law | None) -> Speed:
    """The fastest of those that fall at its end; drag that is known slows what is faster than its terminal velocity."""
    speeds = np.sqrt(fall.speeds**2 + 2.0 * abs(_weigh(case, kind)) * fall.heights)
    if case.gas and _knows_drag(case, law):
        speeds = np.minimum(speeds, np.maximum(fall.speeds, find_balance(case, 1.0, law, kind)))
    fastest = int(speeds.argmax())
    speed, before, height = (float(values[fastest]) for values in (speeds, fall.speeds, fall.heights))
    if before == 0.0:
        return speed, f"a fall over {height:.3g} m{f' from {fall.origin}' if fall.origin else ''}"
    return speed, fall.origin if speed == before else f"{fall.origin} and a fall over {height:.3g} m"


def _carry(
    case: Case, kind: Kind, region: Region, bed: float, law: Law | None, jets: tuple[float, float]
) -> Iterator[Speed]:
    """What the fastest gas upwards, and downwards, can do."""
    case = speed_up_gas(case)
    assert case.gas is not None
    velocities = [velocity for _, velocity in inlet_ramp(case.gas)]
    column = region.inlet / region.section
    slowest, jet = jets
    for way, fastest, stream in ((1.0, max(velocities), jet), (-1.0, -min(velocities), -slowest)):
        if stream <= 0.0:
            continue
        streams = [
            (stream, bed, 1.0, "the stream of the inlet over the height of the bed"),
            (column * fastest, region.height, 1.0, "the gas over the height of the region"),
        ]
        if bed > kind.diameter:
            streams.append((column * fastest, bed, EXPANDED, "the gas that lifts the bed"))
        for speed, path, voidage, why in streams:
            yield _accelerate(case, kind, speed, path, voidage, way, law), why


def _accelerate(
    case: Case, kind: Kind, speed: float, path: float, voidage: float, way: float, law: Law | None
) -> float:
    """Speed [m/s] from rest after `path` [m] in gas of the superficial `speed` [m/s], upwards (`way` 1) or down (-1).

    The drag at the start, over eps by model A, is the largest; where the drag is not known, the gas' speed."""
    if not _knows_drag(case, law):
        return speed
    slip = speed / voidage
    drag = find_drag(case, voidage, slip, law, kind) * slip / (voidage * kind.mass)
    net = drag - way * _weigh(case, kind)
    return min(speed, math.sqrt(2.0 * net * path)) if net > 0.0 else 0.0
