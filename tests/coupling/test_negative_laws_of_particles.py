"""Which particle a law pushes hardest against its slip, by any scheme; rounding is none."""

from __future__ import annotations

import numpy as np
import pytest
from test_momentum import DENSITY, DT, SCHEMES, VISCOSITY, Bed

from fbcouple.coupling.particles import Particles
from fbcouple.physics.drag.registry import DRAG_LAWS


def deposit(bed, velocities):
    own = bed.particles
    bed.particles = Particles(own.positions, velocities, own.radii, own.masses)
    bed.prepare()
    return bed.coupling.negative


@pytest.mark.parametrize("polydisperse", ["none", "beetstra"])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_worst_particle_is_named(rng, scheme, polydisperse):
    bed = Bed(rng, scheme=scheme, drag="tang", polydisperse=polydisperse, filter_passes=0)
    velocities = np.array(bed.particles.velocities)
    assert deposit(bed, velocities) is None
    velocities[17] = 0.0, 3e4, 0.0
    velocities[41] = 0.0, 0.0, -6e4
    found = deposit(bed, velocities)
    assert found is not None and (found.position == bed.particles.positions[41]).all()
    assert found.slip == pytest.approx(6e4, rel=1e-3) and 0.3 < found.voidage <= 1.0
    size = found.reynolds * VISCOSITY / (found.voidage * DENSITY * found.slip)
    beta = float(DRAG_LAWS["tang"](found.voidage, found.slip, size, DENSITY, VISCOSITY))
    if polydisperse == "none":
        assert size == pytest.approx(2.0 * bed.particles.radii[41], rel=1e-12)
    assert beta < 0.0 and found.what == f"a drag coefficient of {beta:.4g} kg/s"
    assert f"`tang` gives {found.what} at slip" in found.describe()
    assert f"voidage {found.voidage:.4g}, which is beyond" in found.describe()
    velocities[[17, 41]] = 0.0
    assert deposit(bed, velocities) is None


def test_rounding_of_a_drag_that_ends_is_none(rng):
    """Ergun's in creeping gas, of a sphere alone in large cells: 200 (1 - eps) of a voidage that passed 1."""
    bed = Bed(rng, drag="ergun", filter_passes=0)
    bed.velocity[:] = 0.0
    bed.coupling.map(bed.particles)
    bed.coupling.read_gas(np.hstack([bed.velocity, bed.pressure_gradient]))
    bed.coupling.voidage[:] = 1.0 + 4e-16
    own = bed.particles
    bed.coupling.deposit_drag(Particles(own.positions, 0.0 * own.velocities, own.radii, own.masses), DT)
    assert bed.coupling.beta.min() < 0.0 and bed.coupling.negative is None


def test_heat_transfer_has_its_own(rng, tmp_path, monkeypatch):
    from test_heat_exchange import HotBed  # noqa: PLC0415  (its fixtures are not for here)

    (tmp_path / "law.py").write_text("def nusselt(eps, re, pr):\n    return 2.0 - 1e-8 * max(re - 2e4, 0.0)**2\n")
    monkeypatch.chdir(tmp_path)
    bed = HotBed(rng, law="own", nusselt_file="law.py")
    bed.exchange(DT)
    assert bed.coupling.negative_heat is None
    bed.particles.velocities[5] = 0.0, 6e3, 0.0
    bed.exchange(DT)
    found = bed.coupling.negative_heat
    assert found is not None and (found.position == bed.particles.positions[5]).all() and found.reynolds > 2e4
    assert found.describe().startswith("`own` gives a Nusselt number of -") and "(heat.nusselt)" in found.describe()
