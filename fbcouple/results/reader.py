"""results.nc as the figures want it: opened and checked, averaged over the depth, in dimensionless axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote
from typing import Any

import numpy as np
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.input_files.toml_text import parse_toml
from fbcouple.paths import list_replicas
from fbcouple.results.inlet_speed import find_fastest, weigh_inlets
from fbcouple.results.pooling import WINDOW_MEAN, pool
from fbcouple.results.replicas import REDUCED, open_replicas, read_results
from fbcouple.results.told import list_told
from fbcouple.results.view import BED, View

RESULTS = "results.nc"
MESH_CELLS = "mesh_cells"
"""Attribute of data that were sampled on a regular grid: how many cells the mesh has."""
_ROUNDING = 1e-9


class NotDrawableError(CaseError):
    """The results lack what a figure needs; the text names it."""


class NotMeantError(NotDrawableError):
    """A figure of another kind of case: nothing is missing, and there is nothing to tell a user of."""


@dataclass(frozen=True)
class Results:
    """The contents of one results.nc: `data`, the effective `case`, the file's `path`, the run's `label`, and which
    `view` of it is asked for."""

    path: Path
    data: xr.Dataset
    case: dict[str, Any]
    label: str = ""
    view: View = BED

    @property
    def title(self) -> str:
        """The case's own line."""
        return str(self.case["title"])

    @property
    def size(self) -> tuple[float, float, float]:
        """Width L, depth D and height H [m] of the bed, of a mesh those of the box around it."""
        width, depth, height = (self._extent(axis)[1] for axis in "xyz")
        return width, depth, height

    @property
    def corner(self) -> tuple[float, float, float]:
        """Lower left front corner [m] of that box: zero, or wherever a mesh has it."""
        x, y, z = (self._extent(axis)[0] for axis in "xyz")
        return x, y, z

    def share(self, axis: str, coordinates: Any = None) -> np.ndarray:
        """x/L, y/D or z/H of `coordinates` [m], counted from the bed's corner; by default of the cell centres, (n,)."""
        start, length = self._extent(axis)
        values = self.data[axis].values if coordinates is None else coordinates
        return (np.asarray(values, dtype=float) - start) / length

    def level(self, share: float) -> float:
        """The coordinate z [m] at z/H = `share`."""
        start, length = self._extent("z")
        return start + share * length

    def _extent(self, axis: str) -> tuple[float, float]:
        """Where the cells of `axis` begin, and how long they are together [m].

        By their centres; the case's size and a corner at zero are taken for these where they differ by rounding only.
        """
        centres = self.data[axis].values.astype(float)
        length = float(self.case["domain"]["size"]["xyz".index(axis)])
        if centres.size > 1:
            seen = float(centres[-1] - centres[0]) * centres.size / (centres.size - 1)
            length = length if math.isclose(length, seen, rel_tol=_ROUNDING) else seen
        start = float(0.5 * (centres[0] + centres[-1])) - 0.5 * length
        return (0.0 if abs(start) < _ROUNDING * length else start), length

    @property
    def complete(self) -> bool:
        """Whether the run reached its end time."""
        return bool(self.data.attrs.get("complete", False))

    @property
    def window(self) -> tuple[float, float] | None:
        """Start and end of averaging [s], of replicas the least and the largest; None if nothing was averaged."""
        start, end = (float(self.data.attrs.get(f"averaging_{side}", math.nan)) for side in ("start", "end"))
        return (start, end) if math.isfinite(start) and math.isfinite(end) else None

    @property
    def windows(self) -> list[tuple[float, float]]:
        """Start and end of averaging [s] of each replica, or of the one run; none if nothing was averaged."""
        own = [(float(start), float(end)) for start, end in (one["window"] for one in list_told(self.data))]
        return own or ([self.window] if self.window else [])

    @property
    def first_window(self) -> tuple[float, float] | None:
        """That of what is of the first replica alone: histories, probes and snapshots."""
        return self.windows[0] if self.windows else None

    @property
    def averaged(self) -> float:
        """Averaged time [s] that the run got through, of all replicas together; 0 if it has not begun."""
        return sum(max(end - start, 0.0) for start, end in self.windows)

    @property
    def inlet_changes(self) -> list[float]:
        """When [s] the inlet was changed as the run went on from a checkpoint."""
        return [float(time) for time in np.atleast_1d(self.data.attrs.get("inlet_changed_at", []))]

    @property
    def cells(self) -> int:
        """Cells that the gas was solved on."""
        return int(self.data.attrs.get(MESH_CELLS, math.prod(self.case["domain"]["cells"])))

    @property
    def is_box(self) -> bool:
        """Whether the gas has the cells of a plain box, so that nothing of the grid is outside."""
        return "inside" not in self.data.coords

    @property
    def inlet_speed(self) -> float | None:
        """Superficial speed U_f [m s-1] of the gas at the inlet, without sign; None without an inlet flow.

        Of a ramp the largest in the averaging window, up or down; without one, in the whole record.
        """
        gas = self.case.get("gas")
        if gas is None:
            return None
        return self._find_fastest(gas) or None

    @property
    def replicas(self) -> int:
        """How many runs the means are of."""
        return int(self.data.attrs.get("replicas", 1))

    @property
    def simulated(self) -> float:
        """Simulated time [s], of all replicas together, the last row of the history or sample of the means, which may
        come after it; 0 before the first of them."""
        if told := list_told(self.data):
            return sum(max(float(one["simulated"]), float(one["window"][1])) for one in told)
        reached = float(self.data["time"].values[-1]) if self.data.sizes.get("time") else 0.0
        return max(reached, self.window[1]) if self.window else reached

    @property
    def span(self) -> tuple[float, float]:
        """The averaging window [s], or the whole record where nothing was averaged."""
        time = self.data["time"].values if self.data.sizes.get("time") else np.zeros(1)
        return self.window or (0.0, float(time[-1]))

    @property
    def gas_flux(self) -> float | None:
        """Mass flux of the gas at the inlet, rho U_f [kg m-2 s-1], the paper's unit of flux; None without one. Of an
        ideal gas each inlet has the density of its temperature."""
        gas = self.case.get("gas")
        if gas is None:
            return None
        return float(gas["density"]) * self._find_fastest(weigh_inlets(gas, self.case.get("heat"))) or None

    def _find_fastest(self, gas: Mapping[str, Any]) -> float:
        """Largest superficial speed [m s-1] at the inlet in the averaging window or, without one, the whole record."""
        return max(find_fastest(gas, *window) for window in self.windows or [self.span])

    @property
    def weight_per_area(self) -> float | None:
        """Weight of the bed less its buoyancy over its cross-section [Pa], the pressure drop of a fluidized bed; where
        particles come and go its mean over the averaging window or, without one, the whole record.

        None if the case has no gas or does not tell the mass, or there is no bed.
        """
        rows = self.weight_history
        if rows is None:
            return None
        if len(rows) > 1:
            (begin, end), time = self.span, self.data["time"].values
            rows = rows[(time >= begin) & (time <= end)]
        return float(rows.mean()) or None if len(rows) else None

    @property
    def weight_history(self) -> np.ndarray | None:
        """The same, (m - rho V) g over the mean horizontal cross-section of the bed at rest, in each row of the history
        where particles come and go, else once; None as above.

        Mass and volume are as the run wrote them down at its end, in older results as the case tells them.
        """
        gas, particles = self.case.get("gas"), self.case.get("particles")
        if gas is None or particles is None:
            return None
        width, depth, _ = self.size
        section = self.data.attrs.get("bed_section", width * depth)
        density, mass = particles["density"], particles.get("mass")
        if particles.get("count") is not None:
            mass = particles["count"] * density * math.pi / 6.0 * particles["diameter"] ** 3
        if "solids_mass" in self.data.attrs:
            mass, volume = float(self.data.attrs["solids_mass"]), float(self.data.attrs["solids_volume"])
            density = mass / volume if volume else density
        if mass is None:
            return None
        masses = np.array([mass])
        if {"mass_fed", "mass_removed"} <= set(self.data.data_vars):
            came = self.data["mass_fed"].values - self.data["mass_removed"].values
            masses = mass + came - came[-1] if len(came) else masses
        return np.asarray(masses * (self.case["gravity"] * (1.0 - gas["density"] / density) / section))

    def window_mean(self, name: str) -> tuple[float, float] | None:
        """Mean over the averaging windows of all replicas of the history `name`, and its standard error; None of a
        single run."""
        if WINDOW_MEAN not in self.data or name not in self.data["quantity"].values:
            return None
        found = self.data.sel(quantity=name)
        return float(found[WINDOW_MEAN]), float(found[f"{WINDOW_MEAN}_stderr"])

    def history(self, name: str) -> xr.DataArray:
        """Variable `name` over time in double precision; NotDrawableError if there is none or it holds no number."""
        values = self._variable(name)
        if not bool(np.isfinite(values).any()):
            raise NotDrawableError([f"`{name}` in {self.path} holds no finite number."])
        return values

    def mean(self, name: str) -> xr.DataArray:
        """Time mean `name` in double precision; NotDrawableError if there is none or a cell has no finite value."""
        self._require_averages()
        values = self._variable(name)
        finite = np.isfinite(values)
        missing = int((~finite & values["inside"]).sum() if "inside" in values.coords else (~finite).sum())
        if missing:
            raise NotDrawableError([f"`{name}` in {self.path}: {missing} of {values.size} values are not finite."])
        return values

    def particle_mean(self, name: str) -> xr.DataArray:
        """Time mean `name` of the particles, nan in cells that no particle ever came to, and only there."""
        self._require_averages()
        values, solids = self._variable(name), self.mean("solids_fraction")
        missing = int((~np.isfinite(values) & (solids > 0.0)).sum())
        if missing:
            text = f"`{name}` in {self.path}: {missing} values are not finite where there are solids."
            raise NotDrawableError([text])
        return values

    def error(self, name: str) -> xr.DataArray:
        """Standard error `name` of a time mean in double precision, nan where there is none yet."""
        return self._variable(name)

    def _variable(self, name: str) -> xr.DataArray:
        if name not in self.data:
            raise NotDrawableError([f"{self.path} has no `{name}` (a case records only what it has)."])
        return self.data[name].astype(float)

    def _require_averages(self) -> None:
        """Raise NotDrawableError if the case averages and averaging has not begun."""
        means = [name for name, field in self.data.data_vars.items() if {"z", "y", "x"} <= set(field.dims)]
        if "averages" not in self.case or any(bool(np.isfinite(self.data[name]).any()) for name in means):
            return
        times = self.data["time"].values if "time" in self.data else np.array([])
        reached = f"the last record is at t = {times[-1]:g} s" if times.size else "nothing is recorded yet"
        start = self.case["averages"]["start"]
        when = "with the first sample" if start == "auto" else f"at t = {start:g} s"
        text = f"{self.path} has no time means yet: averaging starts {when} ([averages] start), {reached}."
        raise NotDrawableError([f"{text} Let the run go on (`fbcouple run {quote(str(self.path.parent))} --resume`)."])


def open_results(run: Path) -> Results:
    """Read RUN/results.nc, or the file `run` itself, into memory and check that there is something to draw.

    Of a folder of replicas those that have time means are pooled; what is not of all is that of the first of them.
    Raises: CaseError if the file is missing, is not NetCDF, or has no effective case.
    """
    run = Path(run)
    if list_replicas(run):
        replicas = open_replicas([run])
        data = pool(replicas)
        first = run / replicas[0].about["name"] / RESULTS
        return Results(first, sample(data), parse_toml(data.attrs["case"]), run.resolve().name)
    path = run if run.is_file() else run / RESULTS
    if not path.is_file():
        raise CaseError([_format_missing(run)])
    data, case = read_results(path)
    return Results(path, sample(data), case, run.stem if run.is_file() else path.resolve().parent.name)


def format_without(results: Results, name: str, option: str) -> str:
    """That there is no `name`, and by which option it is had, if the case can have it, or that a reduced file keeps
    none."""
    if results.data.attrs.get(REDUCED):
        return f"{results.path} has no `{name}`: a reduced file keeps none; take the runs that are in it."
    if not results.case.get("particles"):
        return f"{results.path} has no `{name}`: it is of gas alone."
    return f"{results.path} has no `{name}` (ask for them by {option})."


def _format_missing(run: Path) -> str:
    """Why there are no results: the folder is none of a run, its run was never started, or ended before a record."""
    path = run / "results.nc"
    if not (run / "manifest.json").is_file():
        case = quote(str(run)) if (run / "case.toml").is_file() else "CASE"
        text = f"{path} does not exist, and {run} is not a run folder. Set one up and run it"
        return f"{text} (`fbcouple setup {case} -o RUN`, `fbcouple run RUN`), and give that RUN."
    if (run / "logs").is_dir() and any((run / "logs").iterdir()):
        said = f"the run in {run} ended, or was ended, before it wrote any (its messages are in {run / 'logs'})"
        return f"{path} does not exist: {said}. Fix the case, and run it again."
    return f"{path} does not exist. Run it first (`fbcouple run {quote(str(run))}`)."


def sample(data: xr.Dataset) -> xr.Dataset:
    """Means over the cells of a mesh as the cells at the places of the regular grid have them: (cell,) -> (z, y, x).

    Places outside of the mesh are nan, and the coordinate `inside` says which are not. Of a box: `data` as it is.
    """
    if "sampled_cell" not in data:
        return data
    cells = data["sampled_cell"]
    inside = cells >= 0
    names = [name for name, field in data.data_vars.items() if "cell" in field.dims]
    kept = data.drop_dims("cell").drop_vars("sampled_cell")
    sampled = {}
    for name in names:
        values = data[name].reset_coords(drop=True).isel(cell=cells.clip(min=0))
        sampled[name] = values.where(inside).transpose(..., "z", "y", "x")
    return kept.assign(sampled).assign_coords(inside=inside).assign_attrs({MESH_CELLS: data.sizes["cell"]})


def open_runs(folders: Sequence[Path]) -> list[Results]:
    """Open several runs; runs of one name get their place in the list added to their label.

    Raises: CaseError with every run that cannot be opened, or is given twice.
    """
    runs, problems, places = [], [], [folder.resolve() for folder in folders]
    for number, folder in enumerate(folders):
        if places[number] in places[:number]:
            problems.append(f"{folder} is given twice, and a run is compared with others; leave one out.")
            continue
        try:
            runs.append(open_results(folder))
        except CaseError as error:
            problems += error.problems
    if problems:
        raise CaseError(problems)
    names = [run.label for run in runs]
    return [
        replace(run, label=f"{run.label} ({number})" if names.count(run.label) > 1 else run.label)
        for number, run in enumerate(runs, start=1)
    ]
