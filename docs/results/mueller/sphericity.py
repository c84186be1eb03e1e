"""Drag law of the runs with grains of sphericity 0.8, for `exchange.drag_file`: the case's at Ergun's diameter."""

import math

SPHERICITY = 0.8


def beta(voidage, slip, diameter, density, viscosity):
    """Ergun and Wen-Yu with Huilin's switch at 0.8 d, on the volume of a grain of d: model A, force over slip."""
    d = SPHERICITY * diameter
    reynolds = voidage * density * slip * d / viscosity
    switch = math.atan(150.0 * 1.75 * (0.2 - (1.0 - voidage))) / math.pi + 0.5
    lone = 24.0 * (1.0 + 0.15 * reynolds**0.687) if reynolds < 1000.0 else 0.44 * reynolds
    ergun = (200.0 * (1.0 - voidage) + 7.0 / 3.0 * reynolds) / voidage
    mixed = switch * lone * voidage**-2.7 + (1.0 - switch) * ergun
    return math.pi / 8.0 * d * viscosity * mixed / SPHERICITY**3
