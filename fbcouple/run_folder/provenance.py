"""With what a run is made, as its parent wrote it into the manifest for the ranks: for results.nc and checkpoints."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fbcouple.run_folder.manifest import read_manifest

Versions = dict[str, str]
"""Program or library -> its version, in words."""
_PROGRAMS = ("fbcouple", "OpenFOAM", "LIGGGHTS")
_NO_PART = ("commit", "python", "machine", "MPI")
"""Versions that a run's numbers do not depend on."""


@dataclass(frozen=True)
class Making:
    """What a run is made with."""

    versions: Versions
    changed: list[str]
    """Files of the run folder that were changed since set-up, and trusted."""
    updates: list[str]
    """With what else than before it went on from a checkpoint, a line each time."""

    inlet_changes: list[dict[str, Any]] = field(default_factory=list)
    """At which `time` [s] which `inlet` was changed in the run."""
    predicted: dict[str, Any] | None = None
    """What the run was predicted to cost when it was started last; None where that could not be told."""

    def list_attributes(self) -> dict[str, Any]:
        """What results.nc says of it; `source` is the sentence that the CF conventions ask for."""
        programs = [f"{name} {self.versions[name]}" for name in _PROGRAMS if name in self.versions]
        lines = {"source": "; ".join(programs), "changed_since_set_up": ", ".join(self.changed)}
        lines["updates"] = "\n".join(self.updates)
        told = [f"from t = {change['time']:.6g} s on: {change['inlet']}" for change in self.inlet_changes]
        lines["inlet_changes"] = "\n".join(told)
        attributes: dict[str, Any] = self.versions | {name: text for name, text in lines.items() if text}
        if told:
            attributes["inlet_changed_at"] = sorted({float(change["time"]) for change in self.inlet_changes})
        return attributes | self._list_predicted()

    def _list_predicted(self) -> dict[str, float]:
        """Wall time of all coupling steps, up to when, the error of the means, and the factors of both."""
        if not self.predicted:
            return {}
        told, stages = self.predicted, self.predicted["stages"]
        names = {"predicted_end": "simulated_seconds", "predicted_factor": "wall_factor"}
        names |= {"predicted_error": "means_error", "predicted_error_factor": "means_factor"}
        found = {name: float(told[key]) for name, key in names.items() if told[key] is not None}
        return found | {"predicted_seconds": sum(seconds for stage, seconds in stages.items() if stage != "start-up")}


def read_making(run: Path) -> Making:
    """What the parent wrote into the manifest of `run`."""
    manifest = read_manifest(run)
    about = manifest["run"]
    changes, predicted = manifest.get("inlet_changes", []), about.get("predicted")
    return Making(manifest["run_with"], about["changed"], about["updates"], changes, predicted)


def list_makers(versions: Versions) -> Versions:
    """Those of `versions` that a run's numbers depend on: another one of them is another run."""
    return {name: text for name, text in versions.items() if name not in _NO_PART}
