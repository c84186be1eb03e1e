"""The bed at single moments: voidage averaged over the depth (figure 15 of Hamidouche et al. 2019)."""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fbcouple.postproc.figures.bubbles import EDGE
from fbcouple.postproc.figures.layout import MOST_ACROSS, Line, Panel, draw_panels
from fbcouple.postproc.figures.registry import figure
from fbcouple.results.reader import NotDrawableError, Results, format_without

LOWEST = 0.35
"""Lower colour limit; a random packing has 0.4."""


@figure
def voidage_snapshots(results: Results) -> Figure:
    """Depth-averaged voidage at five moments over the second half of the run; the line is the edge of bubbles."""
    x, z = results.share("x"), results.share("z")
    panels = []
    for snapshot in choose_snapshots(results):
        field = snapshot.drop_vars("snapshot_time").transpose("z", "x")
        outline = partial(_outline, x=x, z=z, values=field.values)
        panels.append(Panel(results, field, f"t = {float(snapshot['snapshot_time']):.3f} s", outline))
    label = r"Voidage $\langle \varepsilon \rangle_{xz}$ [–]"
    line = Line("-", f"edge of bubbles, voidage {EDGE:g}")
    return draw_panels(panels, results.title, "", label, (LOWEST, 1.0), EDGE, line, cmap="cividis")


def choose_snapshots(results: Results) -> list[xr.DataArray]:
    """Voidage (z, x) at `MOST_ACROSS` moments over the second half of the run, each with its `snapshot_time` [s].

    Raises: NotDrawableError if there are none.
    """
    if not results.data.sizes.get("snapshot_time"):
        raise NotDrawableError([format_without(results, "voidage_snapshots", "output.snapshots_every")])
    snapshots = results.data["voidage_snapshots"].astype(float)
    times = snapshots["snapshot_time"].values
    wanted = np.linspace(0.5 * (times[0] + times[-1]), times[-1], min(MOST_ACROSS, len(times)))
    indices = sorted({int(np.argmin(np.abs(times - time))) for time in wanted})
    return [snapshots.isel(snapshot_time=index) for index in indices]


def _outline(axes: Axes, x: np.ndarray, z: np.ndarray, values: np.ndarray) -> None:
    """Line around the bubbles."""
    if min(values.shape) > 1 and np.nanmin(values) < EDGE < np.nanmax(values):
        axes.contour(x, z, values, levels=[EDGE], colors="black", linewidths=0.7)
