"""Whether the voidage options of a case fit together and into its box."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.bed.particle_types import find_ratio
from fbcouple.case.checks.registry import check
from fbcouple.case.problems import Problem
from fbcouple.case.schema.sections import Case


@check("exchange.voidage", "exchange.kernel_width")
def check_kernel_width(case: Case, folder: Path) -> Iterator[Problem]:
    """The Gaussian kernel has a width, and only it has."""
    key = "exchange.kernel_width"
    if case.exchange is None:
        return
    method, width = case.exchange.voidage, case.exchange.kernel_width
    if method == "gaussian" and width is None:
        text = 'nothing is given and voidage = "gaussian" needs it'
        yield Problem(key, f"{text}; give the bandwidth of the kernel in particle diameters (3 to 6 is usual).")
    elif method != "gaussian" and width is not None:
        text = f'{width:g} is given and voidage = "{method}" does not look at it'
        yield Problem(key, f'{text}; remove it or take voidage = "gaussian".')


@check("exchange.voidage", "exchange.diffusion_width")
def check_diffusion(case: Case, folder: Path) -> Iterator[Problem]:
    """A Gaussian kernel is not widened by diffusion: its own width says it."""
    if case.exchange and case.exchange.voidage == "gaussian" and case.exchange.diffusion_width is not None:
        text = f'{case.exchange.diffusion_width:g} is given and voidage = "gaussian" has a width already'
        yield Problem("exchange.diffusion_width", f"{text}; remove it or take another voidage.")


@check("exchange.kernel_width", "exchange.diffusion_width", "particles.diameter", "domain.size")
def check_spread(case: Case, folder: Path) -> Iterator[Problem]:
    """What spreads a particle is not wider than the box."""
    if case.exchange is None or case.particles is None:
        return
    longest, diameter = max(case.domain.size), find_ratio(case.particles) * case.particles.diameter
    for key in ("kernel_width", "diffusion_width"):
        width = getattr(case.exchange, key)
        if width is not None and width * diameter > longest:
            text = f"{width:g} diameters are {width * diameter:g} m and the box is {longest:g} m at most"
            most = longest / diameter
            yield Problem(f"exchange.{key}", f"{text}: each particle would fill it; give at most {most:.4g}.")
