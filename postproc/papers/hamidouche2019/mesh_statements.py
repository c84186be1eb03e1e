"""What Hamidouche et al. 2019 state of the mesh, the walls, the sub-grid model and the measurement (4.1, A)."""

from __future__ import annotations

from fbcouple.postproc import measures
from fbcouple.postproc.papers.hamidouche2019.judging import Finding, Runs, above, below, settle, within, word
from fbcouple.postproc.papers.hamidouche2019.registry import claim, measure_runs

COARSER = (("c1", "c2"),)
"""Of claims that compare C2 and C3: the pair of coarser meshes."""
VISIBLE = 0.05
"""Part of the range of a colour scale: half a step of one with ten, the least that is read off it."""
SAME_HEIGHT = 0.05
"""Part of the bed height: 3 mm, not quite a cell of the coarse mesh, 1 % of the height of the box in the figure."""
SEEN = "half a step of a colour scale of ten, the least that is read off it"


@claim(
    "double-loop",
    "Solids rise in the middle and sink at the side walls (C2; C1 and C3 in rows of their own, where they were run).",
    "4.1, figure 12",
    ("c2",),
    "flux over rho U_f at z/H = 0.092: middle above 0, walls below 0",
    also=(("c3",), ("c1",)),
)
def _double_loop(runs: Runs) -> Finding:
    middle, wall = measures.middle_flux(runs["c2"]), measures.wall_flux(runs["c2"])
    return settle(f"middle {word([middle])}, walls {word([wall])}", [above(middle), below(wall)])


@claim(
    "denser-walls",
    "A finer mesh makes the bed denser at the side walls.",
    "4.1, figure 12",
    ("c2", "c3"),
    "solids fraction within 5 mm of the side walls: that of the finer mesh above",
    also=COARSER,
)
def _denser_walls(runs: Runs) -> Finding:
    values = list(measure_runs(runs, ("c2", "c3"), measures.wall_solids).values())
    return settle(word(values), [above(values[1] - values[0])])


@claim(
    "flux-mesh",
    "A finer mesh makes the solids flux stronger.",
    "4.1, figure 12",
    ("c2", "c3"),
    "magnitude of the flux, mean below z/H = 0.375: that of the finer mesh above",
    also=COARSER,
)
def _flux_mesh(runs: Runs) -> Finding:
    values = list(measure_runs(runs, ("c2", "c3"), measures.flux_magnitude).values())
    return settle(word(values, 1.0, "kg m-2 s-1"), [above(values[1] - values[0])])


@claim(
    "mesh-height",
    "The mesh does not change the bed height.",
    "4.1, figure 12",
    ("c2", "c3"),
    "heights within 5 %",
    "3 mm of a picture of 250 mm, less than a cell of the coarse mesh",
    also=COARSER,
)
def _mesh_height(runs: Runs) -> Finding:
    values = list(measure_runs(runs, ("c2", "c3"), measures.bed_height).values())
    return settle(word(values, 1e3, "mm"), [within(values[1] - values[0], 0.0, SAME_HEIGHT * values[0].value)])


def _no_difference(runs: Runs, one: str, other: str) -> Finding:
    difference = measures.map_difference(runs[one], runs[other])
    return settle(word([difference], 100.0, "% beyond chance"), [below(difference, VISIBLE)])


_MAPS = "maps of the solids fraction within 5 % of their largest value, root mean square"


@claim(
    "turbulence",
    "The sub-grid model makes no visible difference (C6).",
    "A, figure A1",
    ("c6", "a1"),
    _MAPS,
    SEEN,
    also=(("c6-smagorinsky", "a1"), ("c6", "c6-smagorinsky")),
)
def _turbulence(runs: Runs) -> Finding:
    return _no_difference(runs, "c6", "a1")


@claim(
    "walls-fine",
    "Slip or no-slip walls for the gas make nearly no difference (C3).",
    "4.1",
    ("c3", "c3-slip"),
    _MAPS,
    SEEN,
)
def _walls_fine(runs: Runs) -> Finding:
    return _no_difference(runs, "c3", "c3-slip")


@claim(
    "walls-middle",
    "Slip or no-slip walls for the gas make nearly no difference on the intermediate mesh (C2), which the paper did "
    "not try.",
    "4.1",
    ("c2", "c2-slip"),
    _MAPS,
    SEEN,
    is_ours=True,
)
def _walls_middle(runs: Runs) -> Finding:
    return _no_difference(runs, "c2", "c2-slip")


@claim(
    "best-match",
    "mu_p = mu_w = 0.1 matches the experiment best.",
    "4.2, figure 18",
    (),
    "no measured numbers are published",
    "Patil's fields stand only as pictures",
)
def _best_match(runs: Runs) -> Finding:
    return Finding("", None, "Patil's fields stand only as pictures: compare with your own points (references)")
