"""Units that files of other programs give numbers in, and what coordinates without one may be measured in."""

from __future__ import annotations

from collections.abc import Sequence

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6}
TIMES = {"s": 1.0, "ms": 1e-3}
SPEEDS = {"m/s": 1.0, "m s-1": 1.0, "m s^-1": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
DENSITIES = {"kg/m3": 1.0, "kg/m^3": 1.0, "kg/m³": 1.0, "kg m-3": 1.0, "g/cm3": 1e3, "g/cm^3": 1e3, "g/cm³": 1e3}
"""Units that a head may name, and their size in SI units."""

_LIKELY = 0.1
"""Part of a bed's edge that the coordinates of a file reach at least."""
_PLAIN = str.maketrans({"⁻": "-", "−": "-", "¹": "1", "²": "2", "³": "3", "·": " ", "⋅": " ", "*": " ", "^": None})
"""How programs write powers and products, and how they stand in the tables of units."""


def find_size(unit: str, units: dict[str, float]) -> float | None:
    """Size in SI units of `unit`, one of `units` however a program spells it (`m·s⁻¹`, `M/S`); None: it is none."""
    if unit in units:
        return units[unit]
    spelt = " ".join(unit.translate(_PLAIN).split())
    if spelt in units:
        return units[spelt]
    alike = {size for name, size in units.items() if name.lower() == spelt.lower()}
    return alike.pop() if len(alike) == 1 else None


def guess_frame(low: Sequence[float], high: Sequence[float], size: Sequence[float]) -> str:
    """What coordinates from `low` to `high` along each axis may be measured in that are not within 0 to `size` [m]; ""
    if no guess."""
    reaches, middle = list(high), ""
    if min(low) < 0.0:
        reaches, middle = [2.0 * max(-a, b) for a, b in zip(low, high, strict=True)], " from the middle"
    scales = {"mm": LENGTHS["mm"], "cm": LENGTHS["cm"]} | ({"": 1.0} if middle else {})
    found = []
    for unit, scale in scales.items():
        shares = [reach * scale / width for reach, width in zip(reaches, size, strict=True)]
        if max(shares) <= 1.0 and any(share >= _LIKELY for share in shares):
            found.append(f"{unit}{middle}".strip())
    return f" (they look like {' or '.join(found)})" if found else ""
