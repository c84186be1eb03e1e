"""Parcels in the exchange: the drag and forces of their grains, the volume and place of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_forces import derive, prepare
from test_momentum import DT, Bed, every_method

from fbcouple.coupling.forces import FORCES
from fbcouple.coupling.kernels import Drag

RATIO = 1.7
WEIGHT = RATIO**3


def make_parcels(bed, ratio=RATIO):
    """The bed as one of parcels: the same spheres stand for grains that are smaller."""
    coupling = bed.coupling
    coupling._drag = coupling._drag._replace(ratio=ratio, grains=ratio**3)
    if coupling.forces:
        coupling.forces._ratio, coupling.forces._grains = ratio, ratio**3
    return bed


def shrink(bed):
    """The particles of the bed with the size of the grains of its parcels."""
    return replace(bed.particles, radii=bed.particles.radii / RATIO)


def test_beta_is_that_of_all_grains_at_the_voidage_of_the_parcels(rng):
    """The law at the diameter of the grains, l^3 times; of the step's start."""
    bed = Bed(rng, scheme="explicit")
    bed.prepare()
    of_spheres = bed.coupling.beta.copy()
    bed.coupling.deposit_drag(shrink(bed), DT)
    of_grains = bed.coupling.beta.copy()
    make_parcels(bed).prepare()
    assert bed.coupling.beta == pytest.approx(WEIGHT * of_grains, rel=1e-13)
    assert (bed.coupling.beta > 1.5 * of_spheres).all()


@pytest.mark.parametrize("polydisperse", ["none", "beetstra"])
def test_of_several_sizes_all_are_scaled(rng, polydisperse):
    """Stokes' drag goes by d, a parcel's by l^3 d/l; what is over the mean diameter is as it was."""
    bed = Bed(rng, scheme="explicit", drag="stokes", polydisperse=polydisperse)
    bed.prepare()
    of_spheres = bed.coupling.beta.copy()
    make_parcels(bed).prepare()
    assert bed.coupling.beta == pytest.approx(RATIO**2 * of_spheres, rel=1e-13)


@pytest.mark.parametrize("scheme", ["exponential", "semi-implicit", "explicit"])
@every_method
def test_parcels_and_gas_share_the_momentum_and_the_volume(rng, method, scheme):
    bed = make_parcels(Bed(rng, scheme=scheme, filter_passes=1, **method, **dict.fromkeys(FORCES, True)))
    last = bed.particles.velocities + 1e-3 * rng.standard_normal(bed.particles.velocities.shape)
    bed.particles = replace(bed.particles, last_velocities=last)
    prepare(bed, derive(bed, rng))
    solids = np.sum(1.0 - bed.coupling.voidage) * bed.grid.cell_volume
    assert solids == pytest.approx(bed.volumes.sum(), rel=1e-12)
    after = rng.standard_normal(bed.velocity.shape)
    forces, magnitude = bed.react(after, bed.pressure_gradient)
    loss = bed.find_loss(after, bed.pressure_gradient)
    assert loss == pytest.approx(forces.sum(axis=0), abs=1e-13 * magnitude)


@pytest.mark.parametrize("name", FORCES)
def test_a_force_is_that_on_all_grains(rng, name):
    """Those by volume are the same on a parcel and on a sphere as large; lift is that of l^3 small ones."""
    bed = Bed(rng, **{name: True})
    fields = derive(bed, rng)
    prepare(bed, fields)
    whole = bed.coupling.forces._force.copy()
    bed.coupling.deposit_drag(shrink(bed), DT, DT)
    of_grains = bed.coupling.forces._force.copy()
    make_parcels(bed)
    prepare(bed, fields)
    found = bed.coupling.forces._force
    assert found == pytest.approx(WEIGHT * of_grains, rel=1e-12)
    if name != "lift_force":
        assert found == pytest.approx(whole, rel=1e-12)
    else:
        assert not np.allclose(found, whole, rtol=1e-2, atol=0.0)


def test_without_parcels_the_drag_is_as_it_was():
    assert Drag(0, 0, False, False, False, 1.0, 1.0)[-2:] == (1.0, 1.0)
