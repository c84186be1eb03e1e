"""Parts of a case: contacts, kinds of particles, and how particles come and go."""

from __future__ import annotations

from fbcouple.case.bed.contact_coefficients import list_coefficients
from fbcouple.case.bed.derived import tangential_law
from fbcouple.case.bed.feeds import has_traffic
from fbcouple.case.bed.outlets import list_openings
from fbcouple.case.bed.particle_types import count_kinds, grains_per_parcel, list_kinds, particle_count
from fbcouple.case.schema.sections import Case
from fbcouple.decks.parts import Decision, register

PARTICLES: dict[str, Decision] = {}
_part = register(PARTICLES)


@_part
def _pair_friction(case: Case) -> tuple[bool, str]:
    friction = max(pair.friction for pair in list_coefficients(case.contact)[0]) if case.contact else 0.0
    return friction > 0, f"contact.friction = {friction}"


@_part
def _wall_friction(case: Case) -> tuple[bool, str]:
    friction = max(wall.friction for wall in list_coefficients(case.contact)[1]) if case.contact else 0.0
    return friction > 0, f"contact.wall_friction = {friction}"


@_part
def _tangential_history(case: Case) -> tuple[bool, str]:
    tangential = tangential_law(case.contact) if case.contact else "no-history"
    return tangential == "history", f"contact.tangential = {tangential}"


@_part
def _rolling_friction(case: Case) -> tuple[bool, str]:
    friction = case.contact.rolling_friction if case.contact else 0.0
    return friction > 0, f"contact.rolling_friction = {friction}"


@_part
def _hertz(case: Case) -> tuple[bool, str]:
    model = case.contact.model if case.contact else "hooke"
    return model == "hertz", f"contact.model = {model}"


@_part
def _damping(case: Case) -> tuple[bool, str]:
    if case.contact is None:
        return False, "no contacts"
    pairs, walls = list_coefficients(case.contact)
    damped = min(contact.restitution for contact in pairs + walls) < 1.0
    return damped, "a restitution below 1" if damped else "both restitutions are 1: LIGGGHTS gets zero damping"


@_part
def _rotation(case: Case) -> tuple[bool, str]:
    rotates = case.particles is not None and case.particles.rotation
    return rotates, "particles.rotation" if rotates else "positions and velocities only (fix nve)"


@_part
def _mixture(case: Case) -> tuple[bool, str]:
    kinds = list_kinds(case.particles) if case.particles else []
    if len(kinds) < 2:
        return False, "all particles are alike"
    assert case.particles is not None
    counted = zip(count_kinds(case.particles), kinds, strict=True)
    return True, "; ".join(f"{count} of {kind.diameter:.4g} m, {kind.density:g} kg m-3" for count, kind in counted)


@_part
def _coarse_graining(case: Case) -> tuple[bool, str]:
    if case.particles is None or case.particles.coarse_graining is None:
        return False, "each particle is one of LIGGGHTS"
    grains, count = grains_per_parcel(case.particles), particle_count(case.particles)
    return True, f"{count} parcels of {grains:.6g} particles each, {case.particles.coarse_graining:.6g} times as wide"


@_part
def _feeds_and_outlets(case: Case) -> tuple[bool, str]:
    if not has_traffic(case):
        return False, "no particles come or go"
    assert case.particles is not None
    return True, f"{len(case.particles.feeds)} feeds, {len(case.particles.outlets)} outlets of particles"


@_part
def _empty_start(case: Case) -> tuple[bool, str]:
    if case.particles is None or particle_count(case.particles):
        return False, "particles at the start, or none at all"
    key = "mass" if case.particles.count is None else "count"
    return True, f"particles.{key} = {getattr(case.particles, key):g}: no particle, or parcel, at the start"


@_part
def _open_walls(case: Case) -> tuple[bool, str]:
    openings = list_openings(case)
    where = " and ".join(sorted({one.face or "patches of the mesh" for one in openings}))
    return bool(openings), f"particles leave by {where}" if openings else "particles leave by no wall"


@_part
def _gravity(case: Case) -> tuple[bool, str]:
    return case.gravity > 0, f"gravity = {case.gravity}"
