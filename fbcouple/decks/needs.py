"""What a case needs, and why the rest is left out: the one place that decides what appears in the decks."""

from __future__ import annotations

from fbcouple.case.schema.sections import Case
from fbcouple.decks.exchange_parts import EXCHANGE
from fbcouple.decks.gas_parts import GAS
from fbcouple.decks.output_parts import OUTPUT
from fbcouple.decks.particle_parts import PARTICLES
from fbcouple.decks.parts import Decision, Part

_DECISIONS: dict[str, Decision] = {**GAS, **PARTICLES, **EXCHANGE, **OUTPUT}


def explain(case: Case) -> list[Part]:
    """Every part a case can have, whether this one has it, and why."""
    return [Part(name, *decide(case)) for name, decide in _DECISIONS.items()]


def tell_parts(case: Case) -> dict[str, dict[str, str]]:
    """What a manifest says of it: the parts that are in and those that are left out, each with why."""
    parts = explain(case)
    return {
        "in": {part.name: part.why for part in parts if part.is_in},
        "left_out": {part.name: part.why for part in parts if not part.is_in},
    }


def find_needs(case: Case) -> dict[str, bool]:
    """Part name -> is it in, for the templates and the time loop."""
    return {part.name: part.is_in for part in explain(case)}
