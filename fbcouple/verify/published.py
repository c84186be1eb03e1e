"""The drag laws once more, as their papers print them: what the coupled code and the compiled laws are held against.

Each is written apart from fbcouple/physics/drag/laws.py, in plain Python, with U the superficial slip, Re = rho U d/mu
and phi the solids fraction, and says what its paper's force is. From that alone follows the pressure that a fixed bed
loses per length, a number that knows no model A or B:
- a force on each particle with the pressure gradient's: dP/L = n force;
- a drag without it: dP/L = n drag/eps.

A law of the registry without an entry here fails the tests.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Bed:
    """A uniform bed of spheres, held, in gas of superficial slip `speed` [m/s]; SI units."""

    voidage: float
    speed: float
    diameter: float
    density: float
    viscosity: float

    @property
    def phi(self) -> float:
        """Solids fraction."""
        return 1 - self.voidage

    @property
    def per_volume(self) -> float:
        """Particles per volume [m-3]."""
        return self.phi / (math.pi / 6 * self.diameter**3)

    @property
    def reynolds(self) -> float:
        """Of the superficial slip."""
        return self.density * self.speed * self.diameter / self.viscosity

    @property
    def stokes(self) -> float:
        """3 pi mu d U [N]."""
        return 3 * math.pi * self.viscosity * self.diameter * self.speed

    @property
    def dynamic(self) -> float:
        """(pi/8) d^2 rho U^2 [N]."""
        return math.pi / 8 * self.diameter**2 * self.density * self.speed**2


Published = Callable[[Bed], float]
PUBLISHED: dict[str, Published] = {}


def published(name: str) -> Callable[[Published], Published]:
    """Register the pressure loss per length [Pa/m] of the law `name`."""

    def register(function: Published) -> Published:
        PUBLISHED[name] = function
        return function

    return register


def _sphere_coefficient(reynolds: float) -> float:
    """C_D of a lone sphere (Schiller and Naumann; Newton)."""
    return 24 / reynolds * (1 + 0.15 * reynolds**0.687) if reynolds < 1000 else 0.44


@published("huilin-gidaspow")
def _huilin_gidaspow(bed: Bed) -> float:
    """Drag: Hamidouche et al., eqs 20-25, m/tau = (pi/8) d mu C_D Re."""
    switch = math.atan(150 * 1.75 * (0.2 - bed.phi)) / math.pi + 0.5
    wen_yu = _sphere_coefficient(bed.reynolds) * bed.voidage**-2.7
    ergun = (200 * bed.phi / bed.reynolds + 7 / 3) / bed.voidage
    coefficient = switch * wen_yu + (1 - switch) * ergun
    beta = math.pi / 8 * bed.diameter * bed.viscosity * coefficient * bed.reynolds
    return bed.per_volume * beta * (bed.speed / bed.voidage) / bed.voidage


@published("gidaspow")
def _gidaspow(bed: Bed) -> float:
    """Interphase coefficient of model A: eps dP/L = beta u."""
    eps, u = bed.voidage, bed.speed / bed.voidage
    if eps <= 0.8:
        laminar = 150 * bed.phi**2 * bed.viscosity / (eps * bed.diameter**2)
        beta = laminar + 1.75 * bed.density * bed.phi * u / bed.diameter
    else:
        coefficient = _sphere_coefficient(bed.reynolds)
        beta = 0.75 * coefficient * eps * bed.phi * bed.density * u / bed.diameter * eps**-2.65
    return beta * u / eps


@published("ergun")
def _ergun(bed: Bed) -> float:
    """Ergun's equation itself."""
    laminar = 150 * bed.viscosity * bed.speed * bed.phi**2 / (bed.voidage**3 * bed.diameter**2)
    return laminar + 1.75 * bed.density * bed.speed**2 * bed.phi / (bed.voidage**3 * bed.diameter)


@published("wen-yu")
def _wen_yu(bed: Bed) -> float:
    """Force with the pressure gradient: a sphere's at the superficial slip, times eps^-4.7."""
    return bed.per_volume * bed.dynamic * _sphere_coefficient(bed.reynolds) * bed.voidage**-4.7


@published("di-felice")
def _di_felice(bed: Bed) -> float:
    """Drag without the pressure gradient: a sphere's at the superficial slip, times eps^-chi."""
    chi = 3.7 - 0.65 * math.exp(-((1.5 - math.log10(bed.reynolds)) ** 2) / 2)
    coefficient = (0.63 + 4.8 / math.sqrt(bed.reynolds)) ** 2
    return bed.per_volume * bed.dynamic * coefficient * bed.voidage**-chi / bed.voidage


@published("beetstra")
def _beetstra(bed: Bed) -> float:
    """Drag without the pressure gradient over 3 pi mu d U."""
    phi, re = bed.phi, bed.reynolds
    still = 10 * phi / (1 - phi) ** 2 + (1 - phi) ** 2 * (1 + 1.5 * math.sqrt(phi))
    top = 1 / (1 - phi) + 3 * phi * (1 - phi) + 8.4 * re**-0.343
    moving = 0.413 * re / (24 * (1 - phi) ** 2) * top / (1 + 10 ** (3 * phi) * re ** (-(1 + 4 * phi) / 2))
    return bed.per_volume * bed.stokes * (still + moving) / bed.voidage


@published("tenneti")
def _tenneti(bed: Bed) -> float:
    """Force with the mean pressure gradient over 3 pi mu d U."""
    phi, re = bed.phi, bed.reynolds
    isolated = re / 24 * _sphere_coefficient(re)
    crowd = 5.81 * phi / (1 - phi) ** 3 + 0.48 * phi ** (1 / 3) / (1 - phi) ** 4
    moving = phi**3 * re * (0.95 + 0.61 * phi**3 / (1 - phi) ** 2)
    return bed.per_volume * bed.stokes * (isolated / (1 - phi) ** 3 + crowd + moving)


@published("tang")
def _tang(bed: Bed) -> float:
    """Drag without the pressure gradient over 3 pi mu d U."""
    phi, re = bed.phi, bed.reynolds
    still = 10 * phi / (1 - phi) ** 2 + (1 - phi) ** 2 * (1 + 1.5 * math.sqrt(phi))
    slope = 0.11 * phi * (1 + phi) - 0.00456 / (1 - phi) ** 4
    slope += (0.169 * (1 - phi) + 0.0644 / (1 - phi) ** 4) * re**-0.343
    return bed.per_volume * bed.stokes * (still + slope * re) / bed.voidage


@published("koch-hill")
def _koch_hill(bed: Bed) -> float:
    """Force with the pressure gradient over 3 pi mu d U: F_0 + F_3 Re_a, Re_a with the radius."""
    phi = bed.phi
    top = 1 + 3 * (phi / 2) ** 0.5 + 135 / 64 * phi * math.log(phi) + 16.14 * phi
    dilute = top / (1 + 0.681 * phi - 8.48 * phi**2 + 8.16 * phi**3)
    still = dilute if phi < 0.4 else 10 * phi / (1 - phi) ** 3
    moving = (0.0673 + 0.212 * phi + 0.0232 / (1 - phi) ** 5) * bed.reynolds / 2
    return bed.per_volume * bed.stokes * (still + moving)


@published("syamlal-obrien")
def _syamlal_obrien(bed: Bed) -> float:
    """Interphase coefficient of model A: eps dP/L = F_gs u; Re of the interstitial slip."""
    eps, u = bed.voidage, bed.speed / bed.voidage
    re = bed.density * u * bed.diameter / bed.viscosity
    a = eps**4.14
    b = 0.8 * eps**1.28 if eps <= 0.85 else eps**2.65
    ratio = 0.5 * (a - 0.06 * re + math.sqrt((0.06 * re) ** 2 + 0.12 * re * (2 * b - a) + a**2))
    coefficient = (0.63 + 4.8 * math.sqrt(ratio / re)) ** 2
    return 0.75 * bed.phi * eps * bed.density / (ratio**2 * bed.diameter) * coefficient * u * u / eps


@published("schiller-naumann")
def _schiller_naumann(bed: Bed) -> float:
    """Drag of a lone sphere at the slip u: no effect of voidage."""
    u = bed.speed / bed.voidage
    coefficient = _sphere_coefficient(bed.reynolds / bed.voidage)
    return bed.per_volume * math.pi / 8 * bed.diameter**2 * bed.density * u**2 * coefficient / bed.voidage


@published("stokes")
def _stokes(bed: Bed) -> float:
    """Drag of a lone sphere in creeping flow at the slip u."""
    return bed.per_volume * 3 * math.pi * bed.viscosity * bed.diameter * bed.speed / bed.voidage / bed.voidage
