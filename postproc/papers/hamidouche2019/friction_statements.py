"""What Hamidouche et al. 2019 state of the bed and of friction, sets C4 and C5 (section 4.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from fbcouple.postproc import measures
from fbcouple.postproc.measures import Measured
from fbcouple.postproc.papers.hamidouche2019.judging import (
    Finding,
    Runs,
    above,
    below,
    fall,
    is_largest,
    rise,
    settle,
    within,
    word,
)
from fbcouple.postproc.papers.hamidouche2019.registry import claim, measure_runs
from fbcouple.results.reader import Results

C4 = ("c4-0.0", "c4-0.1", "c4-0.2", "c4-0.4")
C5 = ("c5-0.0", "c5-0.1", "c5-0.2", "c5-0.4")
DENSE_HEIGHT = 0.0625
"""z/H = 0.25 [m]."""
NEARLY_NONE = 0.02
"""Solids fraction that a map up to 0.6 shows as nothing: a third of the first of ten colours."""
BUBBLES = 0.02
"""Movement of the centre of mass over its height: beds that bubble have 0.05 to 0.1."""
DOWNWARD = "flux over rho U_f, downward, in the cells at the side walls at z/H = 0.092: largest at 0.2"
MAGNITUDE = "magnitude of the flux, mean below z/H = 0.375: largest at 0.2"


@claim(
    "bed-height",
    "The dense bed (solids fraction above 0.2) is 62.5 mm high in C4.",
    "4.2, figure 16",
    C4,
    "mean of the four 62.5 mm within a cell and the 1.3 mm of its two digits",
    "the paper gives one height for the set, z/H = 0.25",
)
def _bed_height(runs: Runs) -> Finding:
    heights = list(measure_runs(runs, C4, measures.bed_height).values())
    z, height = runs[C4[0]].data["z"].values, runs[C4[0]].size[2]
    answer = within(measures.average(heights), DENSE_HEIGHT, float(z[1] - z[0]) + 0.005 * height)
    return settle(f"mean {word([measures.average(heights)], 1e3)} of {word(heights, 1e3, 'mm')}", [answer])


@claim(
    "freeboard",
    "Nearly no solids above z = 93.75 mm (C4, C5).",
    "4.2, on figure 16",
    (*C4, *C5),
    "solids fraction below 0.02 in every layer there",
    "a map up to 0.6 in ten colours shows a third of its first colour as nothing",
)
def _freeboard(runs: Runs) -> Finding:
    values = measure_runs(runs, (*C4, *C5), measures.freeboard_solids)
    most = max(values, key=lambda name: values[name].value)
    answers = [replace(below(value, NEARLY_NONE), of=name) for name, value in values.items()]
    return settle(f"at most {word([values[most]])} ({most})", answers)


@claim(
    "agitation-peak",
    "Agitation is largest at z/H = 0.25 in C4.",
    "4.2, figure 16",
    C4,
    "z/H = 0.25 ± 0.05 in all four",
    '"approximate": half of the 0.1 between two numbers of the axis',
)
def _agitation_peak(runs: Runs) -> Finding:
    peaks = {name: measures.agitation_peak(runs[name], 0.25, 0.05) for name in C4}
    heights = ", ".join(f"{height:.3f}" for height, _ in peaks.values())
    return settle(f"z/H = {heights}", [replace(above(lead), of=name) for name, (_, lead) in peaks.items()])


@claim(
    "height-wall-friction",
    "The bed height falls as friction at walls grows (C4).",
    "4.2, figure 14",
    C4,
    "falls from mu_w = 0 to 0.4, rises nowhere between",
)
def _height_wall_friction(runs: Runs) -> Finding:
    heights = list(measure_runs(runs, C4, measures.bed_height).values())
    return settle(word(heights, 1e3, "mm"), fall(heights))


@claim(
    "height-friction",
    "The bed height falls as friction between particles grows (C5).",
    "4.2, figure 14",
    C5,
    "falls from mu_p = 0 to 0.4, rises nowhere between",
)
def _height_friction(runs: Runs) -> Finding:
    heights = list(measure_runs(runs, C5, measures.bed_height).values())
    return settle(word(heights, 1e3, "mm"), fall(heights))


@claim(
    "homogeneous",
    "Without friction between particles (mu_w = 0.1) the bed is homogeneous, without bubbles.",
    "4.2, figures 14 and 15",
    ("c5-0.0",),
    "the centre of mass moves by less than 2 %",
    "beds that bubble move it by 5 to 10 %",
)
def _homogeneous(runs: Runs) -> Finding:
    value = measures.centre_fluctuation(runs["c5-0.0"])
    return settle(word([value], 100.0, "%"), [below(value, BUBBLES)])


@claim(
    "not-homogeneous",
    "Without friction at walls (mu_p = 0.1) the bed is not homogeneous.",
    "4.2, figure 14",
    ("c4-0.0",),
    "the centre of mass moves by more than 2 %",
    "beds that bubble move it by 5 to 10 %",
)
def _not_homogeneous(runs: Runs) -> Finding:
    value = measures.centre_fluctuation(runs["c4-0.0"])
    return settle(word([value], 100.0, "%"), [above(value, BUBBLES)])


def _judge_largest(
    runs: Runs, names: tuple[str, ...], measure: Callable[[Results], Measured], unit: str = ""
) -> Finding:
    """Whether the third of the runs, friction 0.2, has most."""
    values = measure_runs(runs, names, measure)
    return settle(word(values.values(), 1.0, unit), is_largest(values, names[2]))


def _downward_flux(run: Results) -> Measured:
    flux = measures.wall_flux(run)
    return Measured(-flux.value, flux.error)


@claim("wall-flux-c4", "The downward flux at the walls is largest at mu_w = 0.2 (C4).", "4.2, figure 18", C4, DOWNWARD)
def _wall_flux_c4(runs: Runs) -> Finding:
    return _judge_largest(runs, C4, _downward_flux, "over rho U_f")


@claim("wall-flux-c5", "The downward flux at the walls is largest at mu_p = 0.2 (C5).", "4.2, figure 18", C5, DOWNWARD)
def _wall_flux_c5(runs: Runs) -> Finding:
    return _judge_largest(runs, C5, _downward_flux, "over rho U_f")


@claim("flux-c5", "The magnitude of the solids flux is largest at mu_p = 0.2 (C5).", "4.2, figure 17", C5, MAGNITUDE)
def _flux_c5(runs: Runs) -> Finding:
    return _judge_largest(runs, C5, measures.flux_magnitude, "kg m-2 s-1")


@claim("flux-c4", "The magnitude of the solids flux is largest at mu_w = 0.2 (C4).", "4.2, figure 17", C4, MAGNITUDE)
def _flux_c4(runs: Runs) -> Finding:
    return _judge_largest(runs, C4, measures.flux_magnitude, "kg m-2 s-1")


@claim(
    "agitation-friction",
    "Agitation falls as friction between particles grows (C5).",
    "4.2, figure 16",
    C5,
    "mean of the dense bed falls from mu_p = 0 to 0.4, rises nowhere between",
)
def _agitation_friction(runs: Runs) -> Finding:
    values = list(measure_runs(runs, C5, measures.bed_agitation).values())
    return settle(word(values, 1.0, "m2 s-2"), fall(values))


@claim(
    "agitation-wall-friction",
    "Agitation grows as friction at walls grows (C4).",
    "4.2, figure 16",
    C4,
    "mean of the dense bed grows from mu_w = 0 to 0.4, falls nowhere between",
)
def _agitation_wall_friction(runs: Runs) -> Finding:
    values = list(measure_runs(runs, C4, measures.bed_agitation).values())
    return settle(word(values, 1.0, "m2 s-2"), rise(values))
