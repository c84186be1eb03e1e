"""Values with their standard errors, as tables and figures write them."""

import math

import pytest

from fbcouple.postproc.value_text import with_error


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (66.83, 12.6, "67 ± 13"),
        (168.2, 26.4, "168 ± 26"),
        (47.9, 9.7, "48 ± 10"),
        (62.94, 0.52, "62.9 ± 0.5"),
        (0.05274, 0.0031, "0.0527 ± 0.0031"),
        (2.47, 0.34, "2.47 ± 0.34"),
        (2.47, 0.36, "2.5 ± 0.4"),
        (-121.7, 3.95, "-122 ± 4"),
        (12345.0, 678.0, "12300 ± 700"),
        (12345.0, 123.0, "12340 ± 120"),
        (5.0, 0.0, "5 ± 0"),
        (5.0004, math.nan, "5 ± ?"),
    ],
)
def test_error_decides_the_digits(value: float, error: float, text: str) -> None:
    assert with_error(value, error) == text
