"""Heat that contacts of spheres conduct: two laws of one radius, and the radius that a force makes.

The radius of a contact is that of the circle in which the spheres overlap, or Hertz's. They are not the same: with the
effective radius R = R_1 R_2/(R_1 + R_2) and a small overlap d the circle has the radius (2 R d)^(1/2), Hertz's contact
(R d)^(1/2), because elastic spheres give way beside the contact.
"""

from __future__ import annotations

import math

CONDUCTION_LAWS = {"batchelor-obrien": 1.0, "liggghts": math.sqrt(math.pi)}
"""Law -> its conductance over 2 k a.

Batchelor and O'Brien 1977, Proc. R. Soc. A 355:313: 2 k a for two spheres of one conductivity k with a contact that is
small beside them; k is the harmonic mean for two. LIGGGHTS' fix heat/gran/conduction: 2 k A^(1/2), A = pi a^2 (after
Chaudhuri, Muzzio and Tomassone 2006, Chem. Eng. Sci. 61:6348)."""


def find_conductance(law: str, one: float, other: float, radius: float) -> float:
    """Conductance [W/K] of a contact of `radius` [m] between materials of conductivity `one` and `other` [W/(m K)]."""
    return CONDUCTION_LAWS[law] * 4.0 * one * other / (one + other) * radius


def find_overlap_radius(radius: float, overlap: float) -> float:
    """Radius [m] of the circle in which two spheres overlap; `radius` [m] is the effective one, `overlap` [m] small."""
    return math.sqrt(2.0 * radius * overlap)


def find_hertz_radius(force: float, radius: float, modulus: float) -> float:
    """Radius [m] of a Hertz contact: (3 F R/(4 E*))^(1/3) (Johnson 1985, eq. 4.22).

    force: F [N]; radius: the effective R [m]; modulus: E* [Pa] of both bodies.
    """
    return (0.75 * force * radius / modulus) ** (1.0 / 3.0)
