"""The drag laws. To add one: a loop under `@drag_law("name", most=...)`, with the Reynolds number up to which its paper
has it, and its published form in fbcouple/verify/published.py.

A law gives beta [kg/s] of one particle, F_D = beta (u - v), for model A: the gas keeps eps grad P and the particle
gets -V grad P besides. A fixed bed then loses n beta u/eps of pressure per length, n = (1 - eps)/V particles per
volume and u the gas velocity between them.

Papers differ in what their force is. Symbols: U = eps |u - v| superficial slip, Re = rho U d/mu, phi = 1 - eps,
F = force/(3 pi mu d U).
- Drag without the pressure gradient's force (Beetstra, Tang, Di Felice, Gidaspow's model A): beta = 3 pi mu d eps F.
- All of the gas' force on the particle, pressure gradient included (Wen and Yu, Koch and Hill, Tenneti), which is
  also the drag of model B: in a uniform bed the drag is eps times that, so beta = 3 pi mu d eps^2 F.

Every product of a drag coefficient and Re is formed whole, so that slip = 0 gives the creeping limit and no division
by zero.
"""

from __future__ import annotations

import math

import numpy as np

from fbcouple.physics.drag.registry import DRAG_LAWS, drag_law
from fbcouple.physics.elementary import arctangent, exponential, logarithm, power
from fbcouple.physics.jit import inlined

__all__ = ["DRAG_LAWS"]

_TINY = 1e-300
_LN10 = math.log(10.0)


@inlined
def sphere(reynolds):
    """C_D Re of a lone sphere: 24 (1 + 0.15 Re^0.687) below Re = 1000, 0.44 Re above (Schiller and Naumann 1933)."""
    return 24.0 * (1.0 + 0.15 * power(reynolds, 0.687)) if reynolds < 1000.0 else 0.44 * reynolds


@inlined
def solids(eps):
    """Solids fraction: voidages interpolated between cells without particles pass 1 by rounding, and roots follow."""
    return max(1.0 - eps, 0.0)


@drag_law("huilin-gidaspow")
def huilin_gidaspow(voidage, slip, diameter, density, viscosity, beta):
    """Ergun and Wen-Yu joined by Huilin and Gidaspow's switch; 0.4 < voidage <= 1, Re of any size.

    beta = (pi/8) d mu C_D Re with C_D = s C_WY + (1 - s) C_ER, s = atan(150 * 1.75 (0.2 - phi))/pi + 0.5,
    C_WY = C_sphere(Re) eps^-2.7, C_ER = (200 phi/Re + 7/3)/eps.

    Hamidouche et al. 2019, Fluids 4(1):51, eqs 20-25: drag of model A, as it stands.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        switch = arctangent(150.0 * 1.75 * (0.2 - (1.0 - eps))) / math.pi + 0.5
        wen_yu = sphere(reynolds) * power(eps, -2.7)
        ergun = (200.0 * (1.0 - eps) + 7.0 / 3.0 * reynolds) / eps
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * (switch * wen_yu + (1.0 - switch) * ergun)


@drag_law("gidaspow")
def gidaspow(voidage, slip, diameter, density, viscosity, beta):
    """Ergun at voidage <= 0.8, Wen-Yu above; the force jumps at 0.8.

    Per volume, n beta = 150 phi^2 mu/(eps d^2) + 1.75 rho phi |u - v|/d, or 3/4 C_sphere(Re) eps phi rho |u - v|/d
    eps^-2.65.

    Gidaspow 1994, Multiphase Flow and Fluidization, ch. 2 (Ding and Gidaspow 1990, AIChE J. 36:523): drag of model
    A, as it stands.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        ergun = (200.0 * (1.0 - eps) + 7.0 / 3.0 * reynolds) / eps
        product = ergun if eps <= 0.8 else sphere(reynolds) * power(eps, -2.65)
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * product


@drag_law("ergun", most=0.6 * 2500.0)
def ergun(voidage, slip, diameter, density, viscosity, beta):
    """Pressure loss of packed beds; voidage 0.35-0.6, Re/phi up to 2500. Its creeping drag ends at voidage 1.

    dP/L = 150 phi^2 mu U/(eps^3 d^2) + 1.75 phi rho U^2/(eps^3 d), and n beta = eps^2 dP/(L U).

    Ergun 1952, Chem. Eng. Prog. 48:89: a pressure loss, so the force with the pressure gradient; the drag is eps times
    that.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        product = (200.0 * (1.0 - eps) + 7.0 / 3.0 * reynolds) / eps
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * product


@drag_law("wen-yu")
def wen_yu(voidage, slip, diameter, density, viscosity, beta):
    """A sphere's drag times eps^-4.7 of the superficial slip; voidage above 0.6 or so, Re of any size.

    Force with the pressure gradient (pi/8) d^2 rho C_sphere(Re) U^2 eps^-4.7, so beta = (pi/8) d mu C_sphere Re
    eps^-2.7. Gidaspow's eps^-2.65 rounds the exponent.

    Wen and Yu 1966, Chem. Eng. Prog. Symp. Ser. 62:100: balanced with weight less the buoyancy of the fluid alone, so
    the drag is eps times it.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * sphere(reynolds) * power(eps, -2.7)


@drag_law("di-felice", most=1e4)
def di_felice(voidage, slip, diameter, density, viscosity, beta):
    """A sphere's drag times eps^-chi with chi a function of Re; voidage 0.4-1, Re 0.01-10 000.

    F_D = (pi/8) d^2 rho C_D U^2 eps^-chi, C_D = (0.63 + 4.8/sqrt(Re))^2 (Dallavalle),
    chi = 3.7 - 0.65 exp(-(1.5 - log10 Re)^2/2).

    Di Felice 1994, Int. J. Multiphase Flow 20:153: the force that balances the weight less the buoyancy of the
    suspension, so without the pressure gradient, drag of model A as it stands. With U = eps |u - v|,
    beta = (pi/8) d mu C_D Re eps^(1 - chi); so has CFDEMcoupling's DiFeliceDrag, its model B over eps. Creeping limit
    of a lone sphere: 23.04/24 of Stokes (Dallavalle's).
    """
    for p in range(len(beta)):
        eps = voidage[p]
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        root = 0.63 * np.sqrt(reynolds) + 4.8
        off = 1.5 - logarithm(max(reynolds, _TINY)) / _LN10
        chi = 3.7 - 0.65 * exponential(-min(0.5 * off * off, 700.0))
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * root * root * power(eps, 1.0 - chi)


@drag_law("beetstra", most=1000.0)
def beetstra(voidage, slip, diameter, density, viscosity, beta):
    """Lattice-Boltzmann simulations of random arrays; solids fraction 0.1-0.6 (and 0), Re up to 1000.

    F = 10 phi/eps^2 + eps^2 (1 + 1.5 sqrt(phi))
        + 0.413 Re/(24 eps^2) (1/eps + 3 eps phi + 8.4 Re^-0.343)/(1 + 10^(3 phi) Re^-(1 + 4 phi)/2).

    Beetstra, van der Hoef and Kuipers 2007, AIChE J. 53:489, their final fit for monodisperse arrays: drag without the
    pressure gradient, so beta = 3 pi mu d eps F, as OpenFOAM's Beetstra has it (C_D Re = 24 eps F).
    """
    for p in range(len(beta)):
        eps = voidage[p]
        phi = solids(eps)
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        creeping = 10.0 * phi / (eps * eps) + eps * eps * (1.0 + 1.5 * np.sqrt(phi))
        rise = exponential(max((0.5 + 2.0 * phi) * logarithm(max(reynolds, _TINY)), -700.0))
        inertia = (1.0 / eps + 3.0 * eps * phi) * reynolds + 8.4 * power(reynolds, 0.657)
        inertia *= 0.413 / (24.0 * eps * eps) * rise / (rise + exponential(3.0 * _LN10 * phi))
        beta[p] = 3.0 * math.pi * viscosity * diameter[p] * eps * (creeping + inertia)


@drag_law("tenneti", most=300.0)
def tenneti(voidage, slip, diameter, density, viscosity, beta):
    """Particle-resolved simulations of random arrays; solids fraction 0.1-0.5 (and 0), Re 0.01-300.

    F = F_sphere(Re)/eps^3 + 5.81 phi/eps^3 + 0.48 phi^(1/3)/eps^4 + phi^3 Re (0.95 + 0.61 phi^3/eps^2), with
    F_sphere = 1 + 0.15 Re^0.687, continued by 0.44 Re/24 from Re = 1000.

    Tenneti, Garg and Subramaniam 2011, Int. J. Multiphase Flow 37:1072: the force with the mean
    pressure gradient, so beta = 3 pi mu d eps^2 F.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        phi = solids(eps)
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        cubed = eps * eps * eps
        force = sphere(reynolds) / (24.0 * cubed) + 5.81 * phi / cubed + 0.48 * power(phi, 1.0 / 3.0) / (cubed * eps)
        force += phi**3 * reynolds * (0.95 + 0.61 * phi**3 / (eps * eps))
        beta[p] = 3.0 * math.pi * viscosity * diameter[p] * eps * eps * force


@drag_law("tang", most=1000.0)
def tang(voidage, slip, diameter, density, viscosity, beta):
    """Immersed-boundary simulations of static random arrays; solids fraction 0.1-0.6 (and 0), Re up to 1000.

    F = 10 phi/eps^2 + eps^2 (1 + 1.5 sqrt(phi))
        + (0.11 phi (1 + phi) - 0.00456/eps^4 + (0.169 eps + 0.0644/eps^4) Re^-0.343) Re.

    Tang, Peters, Kuipers, Kriebitzsch and van der Hoef 2015, AIChE J. 61:688: drag without the pressure gradient, so
    beta = 3 pi mu d eps F, as pfmFOAM's Tang has it. Above Re = 9e4, far beyond its range, F of a lone sphere turns
    negative.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        phi = solids(eps)
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        fourth = eps**4
        creeping = 10.0 * phi / (eps * eps) + eps * eps * (1.0 + 1.5 * np.sqrt(phi))
        linear = (0.11 * phi * (1.0 + phi) - 0.00456 / fourth) * reynolds
        inertia = linear + (0.169 * eps + 0.0644 / fourth) * power(reynolds, 0.657)
        beta[p] = 3.0 * math.pi * viscosity * diameter[p] * eps * (creeping + inertia)


@drag_law("koch-hill", most=200.0)
def koch_hill(voidage, slip, diameter, density, viscosity, beta):
    """Lattice-Boltzmann simulations of Hill, Koch and Ladd; solids fraction up to 0.64, Re up to 200 or so.

    n beta = 18 mu eps^2 phi/d^2 (F_0 + F_3 Re/2), F_3 = 0.0673 + 0.212 phi + 0.0232/eps^5,
    F_0 = (1 + 3 sqrt(phi/2) + (135/64) phi ln(phi) + 16.14 phi)/(1 + 0.681 phi - 8.48 phi^2 + 8.16 phi^3) below
    phi = 0.4 and 10 phi/eps^3 from there on; the force jumps by 1 % at 0.4.

    Koch and Hill 2001, Annu. Rev. Fluid Mech. 33:619 (F_0 + F_3 Re_a, Re_a with the radius), as van Buijtenen et al.
    2011, Chem. Eng. Sci. 66:2368 use it: force with the pressure gradient, so beta = 3 pi mu d eps^2 F.
    """
    for p in range(len(beta)):
        eps = voidage[p]
        phi = solids(eps)
        reynolds = eps * density * slip[p] * diameter[p] / viscosity
        dilute = 1.0 + 3.0 * np.sqrt(0.5 * phi) + 135.0 / 64.0 * phi * logarithm(max(phi, _TINY)) + 16.14 * phi
        dilute /= 1.0 + 0.681 * phi - 8.48 * phi * phi + 8.16 * phi**3
        still = dilute if phi < 0.4 else 10.0 * phi / eps**3
        moving = 0.0673 + 0.212 * phi + 0.0232 / eps**5
        beta[p] = 3.0 * math.pi * viscosity * diameter[p] * eps * eps * (still + 0.5 * moving * reynolds)


@drag_law("syamlal-obrien")
def syamlal_obrien(voidage, slip, diameter, density, viscosity, beta):
    """From terminal velocities of settling suspensions (Richardson-Zaki); Re of any size.

    n beta = (3/4) C_D eps phi rho |u - v|/(V_r^2 d), C_D = (0.63 + 4.8 sqrt(V_r/R))^2 with R = rho |u - v| d/mu, no
    voidage in it; V_r = (A - 0.06 R + sqrt((0.06 R)^2 + 0.12 R (2 B - A) + A^2))/2, A = eps^4.14,
    B = 0.8 eps^1.28 up to eps = 0.85 and eps^2.65 above.

    Syamlal and O'Brien 1988, Int. J. Multiphase Flow 14:473; Syamlal, Rogers and O'Brien 1993, MFIX Theory Guide: drag
    of model A, as it stands and as OpenFOAM's SyamlalOBrien has it. Slip over lone fall of a settling suspension is
    then Garside and Al-Dibouni's V_r. Creeping limit of a lone sphere: 23.04/24 of Stokes (Dallavalle's).
    """
    for p in range(len(beta)):
        eps = voidage[p]
        slow = 0.06 * density * slip[p] * diameter[p] / viscosity
        a = power(eps, 4.14)
        b = 0.8 * power(eps, 1.28) if eps <= 0.85 else power(eps, 2.65)
        ratio = 0.5 * (a - slow + np.sqrt(slow * slow + 2.0 * slow * (2.0 * b - a) + a * a))
        root = 0.63 * np.sqrt(slow / 0.06) + 4.8 * np.sqrt(ratio)
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * eps * root * root / (ratio * ratio)


@drag_law("schiller-naumann")
def schiller_naumann(voidage, slip, diameter, density, viscosity, beta):
    """A lone sphere, no effect of the neighbours; Re of any size below the drag crisis.

    beta = (pi/8) d mu C_sphere R with R = rho |u - v| d/mu, no voidage in it.

    Schiller and Naumann 1933, Z. Ver. Dtsch. Ing. 77:318, with 0.44 (Newton) from R = 1000.
    """
    for p in range(len(beta)):
        reynolds = density * slip[p] * diameter[p] / viscosity
        beta[p] = math.pi / 8.0 * diameter[p] * viscosity * sphere(reynolds)


@drag_law("stokes", most=0.1)
def stokes(voidage, slip, diameter, density, viscosity, beta):
    """A lone sphere in creeping flow, beta = 3 pi mu d; R = rho |u - v| d/mu below 0.1 (Stokes 1851)."""
    for p in range(len(beta)):
        beta[p] = 3.0 * math.pi * viscosity * diameter[p]
