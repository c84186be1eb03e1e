"""Draw figure 4 of the paper beside this file: `python docs/results/single-impact/draw.py`."""

from __future__ import annotations

import csv
import tempfile
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.verify.single_impact import collide, euler, find_exact, integrate, rk2
from postproc.style import BLUE, GREEN, INK, PAGE, VERMILION, journal_style, new_figure, save

HERE = Path(__file__).resolve().parent
LIGGGHTS_STEPS = 20

Curve = tuple[str, np.ndarray, np.ndarray, np.ndarray]


def list_curves(place: Path) -> list[Curve]:
    """Name, time over T_C, overlap over its largest, velocity over that of the impact."""
    fine, meets = np.linspace(0.0, 1.0, 201), np.zeros(1)
    curves: list[Curve] = [("analytic, eqs 43-44", fine, *find_exact(fine))]
    for name, step, count in (("Euler, $T_C/80$", euler, 80), ("RK2, $T_C/6$", rk2, 6)):
        overlap, velocity = integrate(step, count, count, meets)
        curves.append((name, np.arange(count + 1) / count, overlap[:, 0], velocity[:, 0]))
    times = np.arange(LIGGGHTS_STEPS + 1) / LIGGGHTS_STEPS
    curves.append((f"LIGGGHTS, $T_C/{LIGGGHTS_STEPS}$", times, *collide(place, MPI.COMM_WORLD, LIGGGHTS_STEPS)))
    return curves


def draw(curves: list[Curve]) -> None:
    """figure-4.png and figure-4.csv."""
    looks = [{"color": INK}, {"color": GREEN, "marker": "^"}, {"color": VERMILION, "marker": "s"}]
    looks.append({"color": BLUE, "marker": "o"})
    note = "1 mm glass, 1 m/s, e = 0.97, k = 1000 N/m; the contact starts at t = 0"
    with journal_style():
        picture = new_figure("Normal impact on a wall", PAGE, 2.8, note)
        panels = picture.subplots(1, 2)
        picture.subplots_adjust(left=0.09, right=0.98, bottom=0.14, wspace=0.28)
        for (name, times, *values), look in zip(curves, looks, strict=True):
            for axes, value in zip(panels, values, strict=True):
                every = max(1, len(times) // 20) if "marker" in look else 1
                line = "-" if "marker" not in look else "none"
                axes.plot(times[::every], value[::every], linestyle=line, markersize=3.5, label=name, **look)
        for axes, label in zip(panels, ("overlap / largest overlap", "velocity / impact velocity"), strict=True):
            axes.set(xlabel="$t/T_C$", ylabel=label)
        panels[0].legend()
        save(picture, HERE / "figure-4.png", "Normal impact on a wall")
    with (HERE / "figure-4.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["scheme", "time_over_contact_time", "overlap_over_largest", "velocity_over_impact"])
        for name, *columns in curves:
            table.writerows([name.replace("$", ""), *map(repr, row)] for row in np.column_stack(columns).tolist())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        draw(list_curves(Path(folder)))
