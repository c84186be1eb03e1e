"""The figures of Hamidouche et al. 2019: what each shows and says, which beds it needs, and how ours are drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from matplotlib.figure import Figure

from fbcouple.postproc.figures import depth, maps, profiles, snapshots
from fbcouple.postproc.papers.hamidouche2019 import figure_data, page_tables
from fbcouple.postproc.papers.hamidouche2019.figure_data import Data
from fbcouple.postproc.papers.hamidouche2019.friction_statements import C4, C5
from fbcouple.postproc.papers.hamidouche2019.page_tables import Rows
from fbcouple.results.reader import Results
from fbcouple.results.view import View

MESHES = ("c1", "c2", "c3")
PROFILE_HEIGHT = 0.023
"""z/H = 0.092 of figures 13, 18 and 20 [m]."""
DEPTH_HEIGHT = 0.04
"""z/H = 0.16 of figure 11 [m]."""


@dataclass(frozen=True)
class Picture:
    """One of our pictures: a name for its file, the beds that it shows, how it is drawn of those that have runs beside
    the others of its figure, which may share its scale, and the data behind it."""

    name: str
    beds: tuple[str, ...]
    draw: Callable[[Sequence[Results], Sequence[Results]], Figure]
    collect: Callable[[Sequence[Results]], Data]


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: its number, what it shows, what the paper says of it, our pictures of the same, the claims
    that are judged on it, and numbers beside it, of the runs of its beds that there are."""

    number: str
    shows: str
    said: str
    pictures: tuple[Picture, ...] = ()
    claims: tuple[str, ...] = ()
    tell: Callable[[Sequence[Results]], Rows] | None = field(default=None)

    @property
    def beds(self) -> tuple[str, ...]:
        """All beds that the pictures show."""
        return tuple(dict.fromkeys(bed for picture in self.pictures for bed in picture.beds))


def _at(
    height: float, draw: Callable[[Sequence[Results]], Figure]
) -> Callable[[Sequence[Results], Sequence[Results]], Figure]:
    """Draw with profiles at one height [m]."""
    return lambda runs, others: draw([replace(run, view=View((height,))) for run in runs])


def _fractions(name: str, beds: tuple[str, ...]) -> Picture:
    return Picture(name, beds, lambda runs, others: maps.solids_fractions(runs), figure_data.collect_fractions)


def _fluxes(name: str, beds: tuple[str, ...]) -> Picture:
    return Picture(name, beds, maps.solids_fluxes, figure_data.collect_fluxes)


def _agitations(name: str, beds: tuple[str, ...]) -> Picture:
    return Picture(name, beds, maps.agitations, figure_data.collect_agitations)


def _profiles(name: str, beds: tuple[str, ...]) -> Picture:
    draw = _at(PROFILE_HEIGHT, profiles.flux_profiles)
    return Picture(name, beds, draw, lambda runs: figure_data.collect_profiles(runs, PROFILE_HEIGHT))


def _snapshots(name: str, bed: str) -> Picture:
    return Picture(
        name, (bed,), lambda runs, others: snapshots.voidage_snapshots(runs[0]), figure_data.collect_snapshots
    )


FIGURES = (
    PaperFigure(
        "10",
        "solids fraction of C2 at t U_f/d_p = 12 000 on slices along the depth",
        "The slices at y/D = 0.2, 0.5 and 0.8 differ so little that the bed counts as two-dimensional.",
        (Picture("slices", ("c2",), lambda runs, others: depth.moment_slices(runs[0]), figure_data.collect_slices),),
        tell=page_tables.tell_slices,
    ),
    PaperFigure(
        "11",
        "mean vertical velocity of the solids of C2 along the depth, z/H = 0.16",
        "Variations along the depth are not strong.",
        (
            Picture(
                "depth",
                ("c2",),
                _at(DEPTH_HEIGHT, lambda runs: depth.depth_profiles(runs[0])),
                lambda runs: figure_data.collect_depth(runs, DEPTH_HEIGHT),
            ),
        ),
        tell=lambda runs: page_tables.tell_depth(runs, DEPTH_HEIGHT),
    ),
    PaperFigure(
        "12",
        "mean solids fraction and solids flux on the three meshes",
        "Dense at the side walls and on the floor, dilute in the middle; two loops, up in the middle and down at the "
        "walls. A finer mesh has denser walls and stronger fluxes; bed height and place of the loops stay. The bed is "
        "slightly higher, and the loops lie slightly higher, than measured.",
        (_fractions("fraction", MESHES), _fluxes("flux", MESHES)),
        ("double-loop", "denser-walls", "flux-mesh", "mesh-height"),
    ),
    PaperFigure(
        "13",
        "vertical solids flux across the bed at z/H = 0.092 on the three meshes",
        "The finest mesh is nearest to the measurement, above all at the side walls; in the middle the effect of the "
        "closed nozzle is met poorly on all. Slip or no-slip walls for the gas make hardly any difference.",
        (_profiles("profile", MESHES),),
        ("walls-fine", "walls-middle"),
    ),
    PaperFigure(
        "14",
        "mean solids fraction with friction at walls (C4) and between particles (C5)",
        "More friction lowers the bed. Without friction between particles the bed is homogeneous, without friction at "
        "walls it is not.",
        (_fractions("c4", C4), _fractions("c5", C5)),
        ("height-wall-friction", "height-friction", "homogeneous", "not-homogeneous"),
    ),
    PaperFigure(
        "15",
        "voidage at single moments, friction between particles 0 and 0.2",
        "No bubbles form without friction between particles; with 0.2 they grow as bubbles do.",
        (_snapshots("c5-0.0", "c5-0.0"), _snapshots("c5-0.2", "c5-0.2")),
        ("homogeneous",),
        page_tables.tell_movement,
    ),
    PaperFigure(
        "16",
        "mean particle agitation over U_f^2, C4 and C5",
        "Most agitation is at z/H = 0.25, the height of the dense bed. It grows with friction at walls and falls with "
        "friction between particles. Above z/H = 0.375 it says little, as nearly no particles are there.",
        (_agitations("c4", C4), _agitations("c5", C5)),
        ("bed-height", "agitation-peak", "agitation-friction", "agitation-wall-friction", "freeboard"),
    ),
    PaperFigure(
        "17",
        "mean solids flux, C4 and C5",
        "The magnitude is largest at a friction of 0.2 in both sets.",
        (_fluxes("c4", C4), _fluxes("c5", C5)),
        ("flux-c4", "flux-c5"),
    ),
    PaperFigure(
        "18",
        "vertical solids flux across the bed at z/H = 0.092, C4 and C5",
        "Flat in the middle, sloped at the walls. Up to a friction of 0.2 the downward flux grows and the upward one "
        "in the middle falls; beyond it both fall. 0.1 and 0.1 match the measurement best.",
        (_profiles("c4", C4), _profiles("c5", C5)),
        ("wall-flux-c4", "wall-flux-c5", "best-match"),
    ),
    PaperFigure(
        "19",
        "mean solids fraction and solids flux of C6, 1.71 m/s",
        "Very well reproduced, with a slight mismatch of the bed height and of the place of the loops.",
        (_fractions("fraction", ("c6",)), _fluxes("flux", ("c6",))),
        tell=page_tables.tell_beds,
    ),
    PaperFigure(
        "20",
        "vertical solids flux across the bed at z/H = 0.092, C6",
        "Conveniently reproduced by mu_p = mu_w = 0.1.",
        (_profiles("profile", ("c6",)),),
    ),
    PaperFigure(
        "21",
        "mean solids fraction and solids flux of C7, 125 g, 1.54 m/s",
        "The general pattern is well reproduced; the bed is too high and the loops too elongated.",
        (_fractions("fraction", ("c7",)), _fluxes("flux", ("c7",))),
        tell=page_tables.tell_beds,
    ),
    PaperFigure(
        "A1",
        "mean solids fraction of C6 with and without a sub-grid model",
        "Almost no difference.",
        (_fractions("fraction", ("c6", "c6-smagorinsky", "a1")),),
        ("turbulence",),
    ),
)
"""Those that are drawn of the runs of a set; figures 4 and 7 are worked out and measured otherwise."""
