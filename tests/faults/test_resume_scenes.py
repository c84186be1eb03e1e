"""What each option adds to the state of a run is in its checkpoints: resumed runs are the uninterrupted ones."""

from __future__ import annotations

import pytest
from small_bed import BED, compare_frames, find_differences, prepare, stop_at_next_moment

from fbcouple.launcher.launch import launch
from fbcouple.results.frames import read_frame
from fbcouple.results.reader import open_results

SHORT = ["end_time=3e-3", "averages.start=0.0", "output.record_every=5e-4"]
HERTZ = [
    "contact.model=hertz",
    "contact.youngs_modulus=5e6",
    "contact.poisson_ratio=0.3",
    "contact.impact_speed=1.0",
    "contact.tangential=history",
]
MIXTURE = ["particles.mixture=[[0.7e-3, 4000.0, 0.3]]", "contact.pairs=[[1, 2, 0.9, 0.3]]"]
SPREAD = ["particles.spread=normal", "particles.deviation=1e-4", "particles.smallest=8e-4", "particles.largest=1.2e-3"]
KERNEL = ["exchange.voidage=gaussian", "exchange.kernel_width=2.0"]
TRAFFIC = [
    "particles.feeds=[{low=[0.0,0.0,0.012],high=[0.01,0.006,0.016],rate=2e4,velocity=[0.0,0.0,-0.5]},"
    "{low=[0.0,0.0,0.012],high=[0.003,0.003,0.015],mass_flow=0.1,species=2,start=1e-3}]",
    "particles.outlets=[{low=[0.0,0.0,0.0],high=[0.003,0.006,0.001]},{face='top'}]",
]
PARCELS = [
    "particles.coarse_graining=1.2",
    TRAFFIC[1].replace("0.001]", "0.0015]"),
    "exchange.lift_force=true",
    "exchange.virtual_mass=true",
    "output.tracked=[7]",
]
ROUGH = ["particles.rotation=true", "contact.tangential=history", "contact.rolling_friction=0.01"]
FAST = ("together", "parcels", "stiff", "heat by inlets")
"""They have what each of the others adds to the state between them."""
OPENINGS = [
    "particles.feeds=[{low=[0.001,0.0,0.001],high=[0.004,0.006,0.005],rate=3e4,velocity=[-1.5,0.0,0.0]},"
    "{low=[0.003,0.001,0.0],high=[0.007,0.005,0.004],rate=3e4,velocity=[0.0,0.0,-1.5]}]",
    "particles.outlets=[{face='left',rectangle=[[0.001,0.0005],[0.005,0.006]]},"
    "{face='floor',circle=[0.005,0.003,0.0045],start=1.2e-3},{face='floor',rectangle=[[0.0,0.0],[0.0015,0.002]]}]",
    "start.region=[[0.0,0.01],[0.0,0.006],[0.006,0.02]]",
    "contact.tangential=history",
    "output.tracked=[7]",
]
RAMP = ["gas.inlet_ramp=[[0.0, 0.0], [1e-3, 1.2], [2e-3, 1.2], [2e-3, -0.3]]"]
INLETS = [
    "gas.inlets=[{rectangle=[[0.0, 0.0], [0.01, 0.006]], velocity=0.6}, {circle=[0.0047, 0.0032, 0.0037], "
    "ramp=[[0.0, 0.0], [1e-3, 3.0], [2e-3, 3.0], [2e-3, 1.0]]}, {rectangle=[[0.001, 0.003], [0.005, 0.007]], "
    "face='left', velocity=0.5, profile='parabolic'}]",
    "gas.outlets=[{rectangle=[[0.0, 0.0], [0.008, 0.006]]}, {rectangle=[[0.0, 0.01], [0.006, 0.016]], face='right'}]",
]
SHORT_FORM = "inlet_velocity = 1.2\n"
HEAT = [
    *("heat.gas_temperature=300.0", "heat.gas_specific_heat=1010.0", "heat.prandtl=0.8"),
    *("heat.particle_temperature=350.0", "heat.particle_specific_heat=840.0", "heat.particle_conductivity=1.4"),
    *("heat.contact_conduction=liggghts", "heat.wall_temperature=293.15", "output.particles_every=5e-4"),
    "heat.gas_density=ideal",
    "particles.feeds=[{low=[0.0,0.0,0.012],high=[0.01,0.006,0.016],rate=2e4,velocity=[0.0,0.0,-0.5],temperature=400.0}]",
    'output.probes=[{name="warm",every=2e-4,line=[[0.005,0.003,0.001],[0.005,0.003,0.019]],count=4,'
    'quantities=["gas_temperature","solids_temperature"]}]',
]
# Settings and ranks.
SCENES: dict[str, tuple[list[str], int]] = {
    "together": ([*HERTZ, *ROUGH, *MIXTURE, *KERNEL, *RAMP, "domain.periodic=['x']", "gas.turbulence=keqn"], 3),
    "heat": (HEAT, 2),
    "heat by inlets": ([*HEAT, INLETS[0].replace("ramp=", "temperature=450.0, ramp="), INLETS[1]], 2),
    "stiff": (["exchange.accelerated=true"], 2),
    "forces": (["exchange.lift_force=true", "exchange.virtual_mass=true"], 2),
    "rough": ([*ROUGH, "gas.turbulence=smagorinsky"], 2),
    "hertz": (HERTZ, 1),
    "traffic": ([*TRAFFIC, *MIXTURE, "contact.tangential=history", "output.tracked=[7, 251]"], 2),
    "traffic from nothing": ([TRAFFIC[0], *MIXTURE, "particles.count=0", "output.tracked=[]"], 1),
    "parcels": ([TRAFFIC[0], *MIXTURE, *PARCELS], 2),
    "openings": (OPENINGS, 2),
    "mixture": (MIXTURE, 1),
    "spread": (SPREAD, 1),
    "periodic": (["domain.periodic=['x', 'y']"], 1),
    "gaussian": (KERNEL, 1),
    "divided": (["exchange.voidage=divided"], 1),
    "centre": (["exchange.voidage=centre"], 1),
    "diffusion": (["exchange.diffusion_width=3.0"], 1),
    "ramp": (RAMP, 1),
    "inlets": ([*INLETS, "domain.periodic=['y']"], 2),
    "keqn": (["gas.turbulence=keqn"], 1),
    "dynamic-lagrangian": (["gas.turbulence=dynamic-lagrangian"], 1),
    "localized-dynamic": (["gas.turbulence=localized-dynamic"], 1),
    "explicit": (["exchange.scheme=explicit"], 1),
    "three ranks": ([], 3),
    "four ranks": (["gas.turbulence=dynamic-lagrangian", "contact.tangential=history"], 4),
}


@pytest.mark.parametrize(
    "scene",
    [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in SCENES],
)
def test_resumed_run_is_the_uninterrupted_one(tmp_path, scene):
    sets, ranks = SCENES[scene]
    has_inflow = any(one.startswith(("gas.inlet_ramp", "gas.inlets")) for one in sets)
    text = BED.replace(SHORT_FORM, "") if has_inflow else BED
    one, other = (prepare(tmp_path / name, SHORT + sets, text) for name in ("one", "other"))
    rows: list[dict] = []
    resumed: list[dict] = []
    launch(one, ranks, rows.append)
    stop_at_next_moment(other, ranks, resumed)
    launch(other, ranks, resumed.append, resume=True)
    assert find_differences(one, other) == []
    assert [{**row, "wall": 0} for row in rows] == [{**row, "wall": 0} for row in resumed]
    assert len(list((other / "checkpoints").iterdir())) == 2, "where it stopped and where it ended"
    if PARCELS[0] in sets:
        ledger = [rows[-1][name] / 1.2**3 for name in ("particles", "particles_fed", "particles_removed")]
        assert ledger == pytest.approx([round(count) for count in ledger], rel=1e-12)
        assert round(ledger[0]) == round(rows[0]["particles"] / 1.2**3) + round(ledger[1]) - round(ledger[2])
    if HEAT[0] in sets:
        last = read_frame(max((one / "frames").iterdir())).temperatures
        assert compare_frames(one, other) == [] and last.max() > 399.0 and last.min() < 350.0
        assert rows[-1]["heat_fed"] > 0.0 == rows[-1]["heat_removed"]
    if TRAFFIC[0] in sets:
        assert rows[-1]["particles_fed"] > 50 and rows[-1]["particles_owed"] > 0
    if OPENINGS[0] in sets:
        exits = set(open_results(one).data["exit_outlet"].values.tolist())
        assert rows[-1]["particles_removed"] > 10 and exits >= {1.0, 2.0}
