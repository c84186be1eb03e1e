"""What Hamidouche et al. 2019 state and a number can decide: each claim with the runs it speaks of and its judge."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

from fbcouple.postproc import measures
from fbcouple.postproc.measures import Measured
from fbcouple.results.reader import Results

Runs = Mapping[str, Results]


@dataclass(frozen=True)
class Finding:
    """What was measured, in words, and whether the claim holds; None if the numbers do not decide it, and why."""

    measured: str
    holds: bool | None
    why: str = ""


Judge = Callable[[Runs], Finding]


@dataclass(frozen=True)
class Claim:
    """A statement, where the paper makes it, the runs it speaks of, what is wanted of the number, and the judge."""

    statement: str
    place: str
    needs: tuple[str, ...]
    wanted: str
    judge: Judge


CLAIMS: dict[str, Claim] = {}
C4 = ("c4-0.0", "c4-0.1", "c4-0.2", "c4-0.4")
C5 = ("c5-0.0", "c5-0.1", "c5-0.2", "c5-0.4")


def claim(name: str, statement: str, place: str, needs: tuple[str, ...], wanted: str) -> Callable[[Judge], Judge]:
    """Register `judge(runs) -> Finding` under `name`; it is called only if every run of `needs` is there."""

    def register(judge: Judge) -> Judge:
        CLAIMS[name] = Claim(statement, place, needs, wanted, judge)
        return judge

    return register


def _settle(measured: str, answers: Iterable[bool | None]) -> Finding:
    """Every answer must be yes; one clear no is enough for no; otherwise the numbers lie within their errors."""
    found = list(answers)
    if any(answer is False for answer in found):
        return Finding(measured, False)
    if any(answer is None for answer in found):
        return Finding(measured, None, "within two standard errors")
    return Finding(measured, True)


def _word(values: Iterable[Measured], factor: float = 1.0, unit: str = "") -> str:
    text = ", ".join(f"{factor * value.value:.3g} ± {factor * value.error:.1g}" for value in values)
    return f"{text} {unit}".strip()


def _falls(runs: Runs, names: tuple[str, ...], measure: Callable[[Results], Measured]) -> list[bool | None]:
    """Whether the measure falls from the first run to the last, and rises nowhere between neighbours."""
    values = [measure(runs[name]) for name in names]
    rises = [(after - before).is_above(0.0) for before, after in pairwise(values)]
    return [(values[0] - values[-1]).is_above(0.0), *(False for rise in rises if rise)]


def _is_largest(values: dict[str, Measured], name: str) -> list[bool | None]:
    return [(values[name] - value).is_above(0.0) for other, value in values.items() if other != name]


@claim(
    "bed-height",
    "The dense bed (solids fraction above 0.2) is 62.5 mm high in C4.",
    "4.2",
    ("c4-0.1",),
    "62.5 mm within a cell and the 1.3 mm of its two digits",
)
def _bed_height(runs: Runs) -> Finding:
    run = runs["c4-0.1"]
    z = run.data["z"].values
    height, allowed = measures.bed_height(run), float(z[1] - z[0]) + 0.005 * run.size[2]
    off = Measured(abs(height.value - 0.0625), height.error).is_above(allowed)
    return _settle(_word([height], 1e3, "mm"), [None if off is None else not off])


@claim(
    "freeboard",
    "Nearly no solids above z = 93.75 mm (C4, C5).",
    "4.2",
    (*C4, *C5),
    "solids fraction below 0.02 in every layer there",
)
def _freeboard(runs: Runs) -> Finding:
    values = [measures.freeboard_solids(runs[name]) for name in (*C4, *C5)]
    most = max(values, key=lambda value: value.value)
    above = most.is_above(0.02)
    return _settle(f"at most {_word([most])}", [None if above is None else not above])


@claim("agitation-peak", "Agitation is largest at z/H = 0.25 in C4.", "4.2, figure 16", C4, "0.25 ± 0.05 in all four")
def _agitation_peak(runs: Runs) -> Finding:
    peaks = [measures.agitation_peak(runs[name], 0.25, 0.05) for name in C4]
    return _settle(", ".join(f"{height:.3f}" for height, _ in peaks), [lead.is_above(0.0) for _, lead in peaks])


@claim(
    "double-loop",
    "Solids rise in the middle and sink at the side walls (C2).",
    "4.1, figure 12",
    ("c2",),
    "flux over rho U_f at z/H = 0.092: middle above 0, walls below 0",
)
def _double_loop(runs: Runs) -> Finding:
    middle, wall = measures.middle_flux(runs["c2"]), measures.wall_flux(runs["c2"])
    sinks = wall.is_above(0.0)
    return _settle(
        f"middle {_word([middle])}, walls {_word([wall])}",
        [middle.is_above(0.0), None if sinks is None else not sinks],
    )


@claim(
    "denser-walls",
    "A finer mesh makes the bed denser at the side walls.",
    "4.1, figure 12",
    ("c2", "c3"),
    "solids fraction within 5 mm of the side walls: C3 above C2",
)
def _denser_walls(runs: Runs) -> Finding:
    values = [measures.wall_solids(runs[name]) for name in ("c2", "c3")]
    return _settle(_word(values), [(values[1] - values[0]).is_above(0.0)])


@claim("mesh-height", "The mesh does not change the bed height.", "4.1", ("c2", "c3"), "C2 and C3 within 5 %")
def _mesh_height(runs: Runs) -> Finding:
    values = [measures.bed_height(runs[name]) for name in ("c2", "c3")]
    difference = values[1] - values[0]
    off = Measured(abs(difference.value), difference.error).is_above(0.05 * values[0].value)
    return _settle(_word(values, 1e3, "mm"), [None if off is None else not off])


@claim(
    "height-wall-friction",
    "The bed height falls as friction at walls grows (C4).",
    "4.2, figure 14",
    C4,
    "falls from mu_w = 0 to 0.4, rises nowhere between",
)
def _height_wall_friction(runs: Runs) -> Finding:
    heights = [measures.bed_height(runs[name]) for name in C4]
    return _settle(_word(heights, 1e3, "mm"), _falls(runs, C4, measures.bed_height))


@claim(
    "height-friction",
    "The bed height falls as friction between particles grows (C5).",
    "4.2, figure 14",
    C5,
    "falls from mu_p = 0 to 0.4, rises nowhere between",
)
def _height_friction(runs: Runs) -> Finding:
    heights = [measures.bed_height(runs[name]) for name in C5]
    return _settle(_word(heights, 1e3, "mm"), _falls(runs, C5, measures.bed_height))


@claim(
    "homogeneous",
    "Without friction between particles (mu_w = 0.1) the bed is homogeneous, without bubbles.",
    "4.2, figure 15",
    ("c5-0.0",),
    "the centre of mass moves by less than 2 % (a bubbling bed: 5-10 %)",
)
def _homogeneous(runs: Runs) -> Finding:
    value = measures.centre_fluctuation(runs["c5-0.0"])
    moves = value.is_above(0.02)
    return _settle(_word([value], 100.0, "%"), [None if moves is None else not moves])


@claim(
    "not-homogeneous",
    "Without friction at walls (mu_p = 0.1) the bed is not homogeneous.",
    "4.2",
    ("c4-0.0",),
    "the centre of mass moves by more than 2 %",
)
def _not_homogeneous(runs: Runs) -> Finding:
    value = measures.centre_fluctuation(runs["c4-0.0"])
    return _settle(_word([value], 100.0, "%"), [value.is_above(0.02)])


def _downward(runs: Runs, names: tuple[str, ...], largest: str) -> Finding:
    down = {name: Measured(-flux.value, flux.error) for name in names for flux in [measures.wall_flux(runs[name])]}
    return _settle(_word(down.values()), _is_largest(down, largest))


@claim("wall-flux-c4", "The downward flux at the walls is largest at mu_w = 0.2 (C4).", "4.2, figure 18", C4, "at 0.2")
def _wall_flux_c4(runs: Runs) -> Finding:
    return _downward(runs, C4, "c4-0.2")


@claim("wall-flux-c5", "The downward flux at the walls is largest at mu_p = 0.2 (C5).", "4.2, figure 18", C5, "at 0.2")
def _wall_flux_c5(runs: Runs) -> Finding:
    return _downward(runs, C5, "c5-0.2")


@claim("flux-c5", "The magnitude of the solids flux is largest at mu_p = 0.2 (C5).", "4.2, figure 17", C5, "at 0.2")
def _flux_c5(runs: Runs) -> Finding:
    sizes = {name: measures.flux_magnitude(runs[name]) for name in C5}
    return _settle(_word(sizes.values(), 1.0, "kg m-2 s-1"), _is_largest(sizes, "c5-0.2"))


@claim("flux-c4", "The magnitude of the solids flux is largest at mu_w = 0.2 (C4).", "4.2, figure 17", C4, "at 0.2")
def _flux_c4(runs: Runs) -> Finding:
    sizes = {name: measures.flux_magnitude(runs[name]) for name in C4}
    return _settle(_word(sizes.values(), 1.0, "kg m-2 s-1"), _is_largest(sizes, "c4-0.2"))


@claim(
    "agitation-friction",
    "Agitation falls as friction between particles grows (C5).",
    "4.2, figure 16",
    C5,
    "mean of the dense bed falls from mu_p = 0 to 0.4, rises nowhere between",
)
def _agitation_friction(runs: Runs) -> Finding:
    values = [measures.bed_agitation(runs[name]) for name in C5]
    return _settle(_word(values, 1.0, "m2 s-2"), _falls(runs, C5, measures.bed_agitation))


def _no_difference(runs: Runs, one: str, other: str) -> Finding:
    difference = measures.map_difference(runs[one], runs[other])
    return _settle(_word([difference], 100.0, "%"), [difference.value <= 0.05 or _or_noise(difference)])


def _or_noise(difference: Measured) -> bool | None:
    """Two samples of one flow differ by their errors: only what is well beyond them is a difference."""
    return None if difference.value <= 2.0 * difference.error else False


@claim(
    "turbulence",
    "The sub-grid model makes no visible difference (C6).",
    "A, figure A1",
    ("c6", "a1"),
    "maps within 5 %",
)
def _turbulence(runs: Runs) -> Finding:
    return _no_difference(runs, "c6", "a1")


@claim(
    "walls-fine",
    "Slip or no-slip walls for the gas make nearly no difference (C3).",
    "4.1",
    ("c3", "c3-slip"),
    "maps within 5 %",
)
def _walls_fine(runs: Runs) -> Finding:
    return _no_difference(runs, "c3", "c3-slip")


@claim(
    "walls-middle",
    "The same on the intermediate mesh, which the paper did not try.",
    "4.1",
    ("c2", "c2-slip"),
    "maps within 5 %",
)
def _walls_middle(runs: Runs) -> Finding:
    return _no_difference(runs, "c2", "c2-slip")


@claim(
    "best-match",
    "mu_p = mu_w = 0.1 matches the experiment best.",
    "4.2, figure 18",
    (),
    "no measured numbers are published",
)
def _best_match(runs: Runs) -> Finding:
    return Finding("", None, "Patil's fields stand only as pictures: compare with your own points (references)")
