"""Voidage options that do not fit together or into the box, each with its text."""

from __future__ import annotations

import pytest

from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError

GAUSSIAN = "exchange.voidage=gaussian"


@pytest.mark.parametrize(
    "sets", [["exchange.voidage=divided"], [GAUSSIAN, "exchange.kernel_width=6"], ["exchange.diffusion_width=6"]]
)
def test_options_that_fit_together(sets):
    load_case("patil/c2", sets)


@pytest.mark.parametrize(
    ("sets", "verdict"),
    [
        ([GAUSSIAN, "exchange.kernel_width=6"], "fit"),
        (["exchange.diffusion_width=6"], "fit"),
        (["exchange.diffusion_width=1"], "warn"),
    ],
)
def test_the_width_stands_before_the_run_in_place_of_the_cell_size(sets, verdict):
    numbers = {number.name: number for number in estimate(load_case("patil/c2", sets))}
    assert numbers["width z"].verdict == verdict
    assert numbers["width z"].value == pytest.approx(float(sets[-1].split("=")[1]) * 1e-3 / (0.25 / 110))
    assert "cell size z" not in numbers


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        ([GAUSSIAN], 'exchange.kernel_width: nothing is given and voidage = "gaussian" needs it; give the bandwidth'),
        (
            ["exchange.kernel_width=3"],
            'exchange.kernel_width: 3 is given and voidage = "trilinear" does not look at it',
        ),
        ([GAUSSIAN, "exchange.kernel_width=0"], "exchange.kernel_width: 0 is given, a number at least 0.5"),
        ([GAUSSIAN, "exchange.kernel_width=nan"], "exchange.kernel_width: nan is given, a number at least 0.5"),
        (
            [GAUSSIAN, "exchange.kernel_width=300"],
            "exchange.kernel_width: 300 diameters are 0.3 m and the box is 0.25 m at most: each particle would fill "
            "it; give at most 250.",
        ),
        (
            [GAUSSIAN, "exchange.kernel_width=3", "exchange.diffusion_width=3"],
            'exchange.diffusion_width: 3 is given and voidage = "gaussian" has a width already; remove it',
        ),
        (["exchange.diffusion_width=-1"], "exchange.diffusion_width: -1 is given, a number at least 0.1"),
        (["exchange.diffusion_width=900"], "exchange.diffusion_width: 900 diameters are 0.9 m and the box is 0.25 m"),
        (["exchange.voidage=center"], 'exchange.voidage: "center" is given, "trilinear" or "centre" or "divided"'),
    ],
)
def test_options_that_do_not_fit_together(sets, words):
    with pytest.raises(CaseError) as caught:
        load_case("patil/c2", sets)
    assert any(words in problem for problem in caught.value.problems), caught.value.problems
