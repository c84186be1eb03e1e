"""A number with its standard error, written with the digits that the error leaves it."""

from __future__ import annotations

import math


def with_error(value: float, error: float) -> str:
    """A value and its standard error of the same unit, as "67 ± 10" or "0.0527 ± 0.0031".

    The error has two digits where its first three are 100 to 354 and one from 355 to 949; from 950 on it counts as
    1000. The value ends at the same place (rule of the Particle Data Group, Review of Particle Physics,
    Introduction, "Rounding"). An error that is not known is "?", beside a value of three digits.
    """
    if not (math.isfinite(value) and math.isfinite(error)):
        return f"{value:.3g} ± ?"
    if error == 0.0:
        return f"{value:.3g} ± 0"
    mantissa, _, power = f"{abs(error):.2e}".partition("e")
    place = int(power) - (1 if float(mantissa) <= 3.54 else 0)  # the power of ten of the last digit
    return f"{_round(value, place)} ± {_round(abs(error), place)}"


def _round(value: float, place: int) -> str:
    decimals = max(-place, 0)
    return f"{round(value, -place):.{decimals}f}"
