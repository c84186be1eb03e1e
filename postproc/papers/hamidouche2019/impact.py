"""A tracked sphere that falls onto the floor, beside the exact contact (figures 3 and 4 of Hamidouche et al. 2019)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fbcouple.physics.contact import Impact, contact_time
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import BLUE, GREEN, INK, PAGE, VERMILION, inset_axes, new_figure
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

SCHEMES = (("Euler", 80, GREEN, "^", 4), ("RK2", 6, VERMILION, "s", 1))
"""Name, steps in T_C, colour, mark and the steps between marks of what the paper shows in figure 4."""


@dataclass(frozen=True)
class Contact:
    """The first contact of a sphere with the floor: times over T_C, overlap over the largest of the exact contact, and
    velocity over that of the impact, (rows,) each; `restitution` as it was and `duration` T_C [s] as it should be."""

    times: np.ndarray
    overlaps: np.ndarray
    velocities: np.ndarray
    restitution: float
    duration: float
    speed: float
    """Speed of the impact [m/s]."""


def find_contact(results: Results) -> Contact:
    """Follow the first tracked particle from the moment at which it touches the floor to the one at which it leaves.

    Raises: NotMeantError if none is tracked, or if more than a linear spring acts; NotDrawableError if it does not
    leave the floor.
    """
    if "tracked_position" not in results.data or "tracked_velocity" not in results.data:
        raise NotMeantError([f"{results.path} has no `tracked_position` (ask for it by output.tracked)."])
    contact = _require_spring(results)
    particles = results.case["particles"]
    height = results.history("tracked_position").isel(tracked=0).sel(component="z").values - results.corner[2]
    upward = results.history("tracked_velocity").isel(tracked=0).sel(component="z").values
    time, overlap = results.data["time"].values, particles["diameter"] / 2.0 - height
    touches = np.flatnonzero(overlap > 0.0)
    first = int(touches[0]) if touches.size else 0
    leaves = np.flatnonzero(overlap[first:] <= 0.0)
    if not (touches.size and first and leaves.size and upward[first - 1] < 0.0):
        raise NotDrawableError([f"the tracked particle of {results.path} does not meet the floor and leave it."])
    last, speed = first + int(leaves[0]), -float(upward[first - 1])
    mass = particles["density"] * math.pi / 6.0 * particles["diameter"] ** 3
    duration = contact_time(contact["stiffness"], mass, contact["wall_restitution"])
    exact = Impact(contact["wall_restitution"])
    largest = exact.largest * speed * math.sqrt(mass / contact["stiffness"])
    rows = slice(first - 1, last + 1)
    begin = time[first - 1] - overlap[first - 1] / speed
    return Contact(
        (time[rows] - begin) / duration,
        overlap[rows] / largest,
        -upward[rows] / speed,
        float(upward[last]) / speed,
        duration,
        speed,
    )


def _require_spring(results: Results) -> dict[str, Any]:
    """The contact options, if the collision force is all that acts, along the normal, by a linear spring."""
    case = results.case
    others = [name for name in ("gas", "exchange") if name in case] + (["gravity"] if case["gravity"] else [])
    contact: dict[str, Any] = case.get("contact") or {}
    others += [f"contact.model = {contact['model']}"] if contact.get("model", "hooke") != "hooke" else []
    others += [f"no contact.{key}" for key in ("stiffness", "wall_restitution") if contact.get(key) is None]
    others += [] if "particles" in case else ["no particles"]
    if others:
        raise NotMeantError([f"{', '.join(others)}: the exact contact is that of a linear spring alone."])
    return contact


@figure
def impact(results: Results) -> Figure:
    """Overlap and velocity of a sphere against the floor over the contact time: the run, exact, and as in the paper."""
    found = find_contact(results)
    contact, particles = results.case["contact"], results.case["particles"]
    note = (
        f"d = {1e3 * particles['diameter']:g} mm, {found.speed:g} m/s, e = {contact['wall_restitution']:g}, "
        f"k = {contact['stiffness']:g} N/m, $T_C$ = {1e6 * found.duration:.1f} µs; the contact starts at t = 0"
    )
    return draw_contact(results.title, note, contact["wall_restitution"], found)


def draw_contact(heading: str, note: str, restitution: float, found: Contact | None) -> Figure:
    """The exact contact and those that the paper's schemes work out, with that of a run where there is one."""
    exact, fine = Impact(restitution), np.linspace(0.0, 1.0, 201)
    picture = new_figure(heading, PAGE, 3.05, note)
    panels = [inset_axes(picture, left, 0.42, 2.8, 2.5) for left in (0.56, 4.08)]
    lines: list[tuple[str, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]]
    lines = [("exact, eqs 43–44", fine, *exact.solve(fine), {"color": INK})]
    for name, count, colour, mark, every in SCHEMES:
        overlap, velocity = exact.integrate(getattr(exact, name.lower()), count, count, np.zeros(1))
        look: dict[str, Any] = {"color": colour, "marker": mark, "linestyle": "none", "markevery": every}
        times = np.arange(count + 1) / count
        lines.append((f"{name}, $T_C/{count}$ (worked out)", times, overlap[:, 0], velocity[:, 0], look))
    if found is not None:
        look = {"color": BLUE, "marker": "o", "linestyle": "none"}
        steps = 1.0 / float(np.median(np.diff(found.times)))
        name = f"LIGGGHTS, $T_C/{steps:.3g}$ (this run, e = {found.restitution:.4f})"
        lines.append((name, found.times, found.overlaps, found.velocities, look))
    for label, times, *values, look in lines:
        for axes, value in zip(panels, values, strict=True):
            axes.plot(times, value, markersize=3.5, label=label, **look)
    names = r"$\delta^*$ = overlap / largest overlap [–]", "$u^*$ = velocity / impact velocity [–]"
    for axes, label in zip(panels, names, strict=True):
        axes.set(xlabel="$t/T_C$ [–]", ylabel=label)
        axes.axhline(0.0, color=INK, linewidth=0.5)
    panels[0].set_ylim(-0.12, 1.42)
    panels[0].legend(loc="upper left", handlelength=1.4, labelspacing=0.3)
    return picture
