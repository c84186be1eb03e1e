"""Drag laws: every law of the registry obeys dimensions and limits; each has numbers of its own to meet."""

import math

import numpy as np
import pytest

from fbcouple.exchange.drag import DRAG_LAWS

NITROGEN = {"density": 1.165, "viscosity": 2e-5}
DIAMETER, GLASS, GRAVITY = 1e-3, 2500.0, 9.81
VOLUME = math.pi / 6.0 * DIAMETER**3
PAPER = DRAG_LAWS["huilin-gidaspow"]
VOIDAGES = np.linspace(0.36, 1.0, 65)

every_law = pytest.mark.parametrize("law", DRAG_LAWS.values(), ids=DRAG_LAWS.keys())


def drag(law, voidage, slip, diameter=DIAMETER, density=1.165, viscosity=2e-5):
    return law(voidage, slip, diameter, density, viscosity)


def pressure_loss(law, voidage, superficial):
    """Pressure per length [Pa/m] of a fixed bed: n beta u/eps."""
    u = superficial / voidage
    return (1.0 - voidage) / VOLUME * drag(law, voidage, u) * u / voidage


@every_law
def test_positive_and_finite_without_slip_too(law):
    slips = np.array([0.0, 1e-300, 1e-9, 1e-3, 1.0, 100.0])
    beta = drag(law, VOIDAGES[:, None], slips)
    assert np.isfinite(beta).all() and beta.min() > 0.0


@every_law
def test_creeping_flow_is_linear_in_viscosity_and_knows_no_gas_density(law):
    still = drag(law, VOIDAGES, 0.0)
    assert drag(law, VOIDAGES, 0.0, density=1165.0) == pytest.approx(still, rel=1e-14)
    assert drag(law, VOIDAGES, 0.0, viscosity=6e-5) == pytest.approx(3.0 * still, rel=1e-14)
    assert drag(law, VOIDAGES, 1e-12) == pytest.approx(still, rel=1e-6)


@every_law
def test_units_cancel(law):
    """In units L, T and M times as small beta [kg/s] is M/T times as large."""
    length, time, mass = 3.0, 0.7, 11.0
    slips = np.array([[1e-4], [0.1], [1.0], [60.0]])
    scaled = law(
        VOIDAGES,
        slips * length / time,
        DIAMETER * length,
        1.165 * mass / length**3,
        2e-5 * mass / (length * time),
    )
    assert scaled == pytest.approx(drag(law, VOIDAGES, slips) * mass / time, rel=1e-12)


@every_law
def test_continuous_in_slip_and_voidage(law):
    """No jump above half a percent (Wen-Yu's own, at Re_p = 1000, is 0.4 %)."""
    slips = np.geomspace(1e-6, 200.0, 20_001)
    for voidage in VOIDAGES[::8]:
        assert np.abs(np.diff(np.log(drag(law, voidage, slips)))).max() < 5e-3
    voidages = np.linspace(0.36, 1.0, 20_001)
    for slip in (0.0, 0.1, 1.0, 30.0):
        assert np.abs(np.diff(np.log(drag(law, voidages, slip)))).max() < 5e-3


@every_law
def test_more_solids_or_more_slip_give_more_force(law):
    slips = np.geomspace(1e-6, 200.0, 100)
    for voidage in VOIDAGES[::8]:
        assert (np.diff(drag(law, voidage, slips) * slips) > 0.0).all()
    for slip in (0.01, 1.0, 10.0):
        assert (np.diff(drag(law, VOIDAGES, slip)) < 0.0).all()


def paper_beta(voidage, slip, diameter, density, viscosity):
    """Eqs 20-25 as they are printed (with the outer voidage of eq. 25 and in Re_p), C_D and Re_p apart."""
    reynolds = voidage * density * slip * diameter / viscosity
    phi = math.atan(150 * 1.75 * (0.2 - (1 - voidage))) / math.pi + 0.5
    sphere = 24 / reynolds * (1 + 0.15 * reynolds**0.687) if reynolds < 1000 else 0.44
    wen_yu = sphere * voidage**-2.7
    ergun = (200 * (1 - voidage) / reynolds + 7 / 3) / voidage
    return math.pi / 8 * diameter * viscosity * (phi * wen_yu + (1 - phi) * ergun) * reynolds


@pytest.mark.parametrize("voidage", [0.4, 0.57, 0.795, 0.8, 0.81, 0.95, 1.0])
@pytest.mark.parametrize("slip", [1e-4, 0.3, 2.0, 40.0])
def test_paper_law_as_printed(voidage, slip):
    expected = paper_beta(voidage, slip, DIAMETER, **NITROGEN)
    assert drag(PAPER, voidage, slip) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("voidage", "phi"), [(0.4, 0.00303), (0.8, 0.5), (1.0, 0.99394)])
def test_paper_law_switch(voidage, phi):
    """Without slip C_D Re_p is 24 eps^-2.7 (Wen and Yu) and 200 (1 - eps)/eps (Ergun): the switch shows alone."""
    product = drag(PAPER, voidage, 0.0) / (math.pi / 8 * DIAMETER * 2e-5)
    wen_yu, ergun = 24 * voidage**-2.7, 200 * (1 - voidage) / voidage
    assert (product - ergun) / (wen_yu - ergun) == pytest.approx(phi, abs=6e-6)


def test_paper_law_in_a_packed_bed():
    """eps = 0.42, U = 0.5 m/s: Ergun's equation itself gives 10800.92 Pa/m, the switch adds 0.14 %."""
    ergun = 150 * 0.58**2 * 2e-5 * 0.5 / (0.42**3 * DIAMETER**2) + 1.75 * 0.58 * 1.165 * 0.25 / (0.42**3 * DIAMETER)
    assert ergun == pytest.approx(10800.92, abs=0.01)
    assert pressure_loss(PAPER, 0.42, 0.5) == pytest.approx(10815.99, abs=0.01)


def test_paper_law_of_a_lone_particle():
    """It falls where drag balances its weight less that of the gas: 6.680 m/s (Schiller and Naumann alone: 6.749)."""
    weight = VOLUME * (GLASS - 1.165) * GRAVITY

    def residual(speed):
        return drag(PAPER, 1.0, speed) * speed - weight

    assert residual(6.6795) < 0.0 < residual(6.6805)


# Rows of a homogeneous bed solved from eqs 20-27 apart from this code, 1 mm glass in nitrogen, each to five decimals:
# voidage, superficial velocity [m/s] with the switch. Minimum fluidization at 0.40 is the second.
HOMOGENEOUS = [
    (0.36, 0.41320),
    (0.40, 0.53996),
    (0.45, 0.71703),
    (0.55, 1.12153),
    (0.65, 1.57952),
    (0.75, 2.08692),
    (0.79, 2.35334),
    (0.80, 2.71933),
    (0.81, 3.35925),
    (0.90, 4.89478),
    (0.99, 6.48656),
]


@pytest.mark.parametrize(("voidage", "superficial"), HOMOGENEOUS)
def test_paper_law_carries_a_homogeneous_bed(voidage, superficial):
    """n beta u/eps = (1 - eps)(rho_p - rho) g: the velocity at which the drag carries the bed, to the last decimal."""
    weight = (1.0 - voidage) * (GLASS - 1.165) * GRAVITY
    below, above = (pressure_loss(PAPER, voidage, superficial + shift) - weight for shift in (-6e-6, 6e-6))
    assert below < 0.0 < above
