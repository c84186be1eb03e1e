"""Presets of accuracy: what each sets of the options that a case leaves out.

Chosen from the study `mueller` and from the start of `patil/c2`; what each costs and misses stands in the schema at
`accuracy`. The steps of a contact are what is wanted at least: a case whose packed bed needs more of them gets them.
"""

from __future__ import annotations

from typing import Any

from fbcouple.case.bed.adopt_parcels import resolve_parcels
from fbcouple.case.bed.adopt_spring import OVERLAP, SPRINGS, gives_spring, try_spring
from fbcouple.case.bed.derived import steps_per_contact
from fbcouple.case.checks.contact import is_hertz
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.case.schema.sections import Case

KEY = "accuracy"
NONE = "none"
PRESETS: dict[str, dict[str, Any]] = {
    "draft": {
        "contact.max_overlap": 0.1,
        "gas.max_courant": 2.0,
        "gas.max_fourier": 2.0,
        "gas.pressure_tolerance": 1e-4,
        "gas.correctors": 1,
        "contact.steps_per_contact": 6,
    },
    "standard": {
        "contact.max_overlap": 0.05,
        "gas.max_courant": 1.5,
        "gas.max_fourier": 1.5,
        "gas.pressure_tolerance": 1e-5,
        "gas.correctors": 2,
        "contact.steps_per_contact": 6,
    },
    "reference": {
        "contact.max_overlap": 0.02,
        "gas.max_courant": 0.2,
        "gas.max_fourier": 0.15,
        "gas.pressure_tolerance": 1e-6,
        "gas.correctors": 3,
        "contact.steps_per_contact": 12,
    },
}


_STEPS, _OVERLAP = "contact.steps_per_contact", f"contact.{OVERLAP}"


def apply_preset(raw: dict[str, Any]) -> None:
    """Fill the options that the preset named in `raw`, a case file's content, sets into the sections that it has; what
    stands there already stays. An unknown preset is for the schema to judge."""
    name = raw.get(KEY)
    for dotted, value in PRESETS.get(name, {}).items() if isinstance(name, str) else ():
        section, key = dotted.split(".")
        if dotted == _OVERLAP and gives_spring(raw):
            continue
        if isinstance(raw.get(section), dict) and key not in raw[section]:
            raw[section][key] = max(value, _find_steps(raw)) if dotted == _STEPS else value


def _find_steps(raw: dict[str, Any]) -> int:
    """DEM steps in a contact that the packed bed of a case file needs; 0 if they cannot be told from what is there."""
    try:
        contact = Contact.model_validate(try_spring(raw))
        particles, _ = resolve_parcels(Particles.model_validate(raw["particles"]))
        return steps_per_contact(contact, particles) if contact.model == "hooke" or is_hertz(contact) else 0
    except (KeyError, ValueError, ArithmeticError):  # of the schema, of a restitution that parcels cannot have
        return 0  # the schema and the checks say what is wrong


def _look_up_preset(case: Case, dotted: str) -> Any:
    """What the preset of a case sets an option to in it."""
    value = PRESETS[case.accuracy][dotted]
    if dotted != _STEPS or case.contact is None or case.particles is None:
        return value
    return max(value, steps_per_contact(case.contact.model_copy(update={"steps_per_contact": None}), case.particles))


def describe_preset(case: Case) -> str:
    """What the preset of a case sets in it, and what of it the case has its own value for."""
    if case.accuracy == NONE:
        return "accuracy = none: every option has its own value or default"
    set_by: list[str] = []
    own: list[str] = []
    for dotted, value in PRESETS[case.accuracy].items():
        section, key = dotted.split(".")
        if dotted == _OVERLAP and case.contact:
            spring = SPRINGS[case.contact.model][0]
            set_by.append(f"{spring} = {getattr(case.contact, spring):g}, by {dotted} = {value:g} unless given")
        elif table := getattr(case, section):
            found = getattr(table, key)
            (set_by if found == _look_up_preset(case, dotted) else own).append(f"{dotted} = {found:g}")
    text = f"accuracy = {case.accuracy}: {', '.join(set_by) or 'nothing'}"
    return f"{text}; of the case itself: {', '.join(own)}" if own else text
