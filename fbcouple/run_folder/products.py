"""What a run, and the commands after it, leave in a run folder beside logs, by name; of nothing else it is removed."""

from __future__ import annotations

import re
import shutil
from contextlib import suppress
from pathlib import Path

from fbcouple.paths import FRAMES, PROBES
from fbcouple.run_folder.manifest import read_manifest

PICTURES = (
    "bubbles",
    "cost",
    "solids_fraction",
    "solids_flux",
    "agitation",
    "slices",
    "moment_slices",
    "depth_profiles",
    "fluidization_curve",
    "history",
    "impact",
    "mixing",
    "probes",
    "flux_profile",
    "radial_profiles",
    "sections",
    "voidage_snapshots",
    "spectrum",
    "temperature",
    "throughput",
    "bed_views",
    "means_error",
    "measured_lines",
)
"""Figures of one run."""
_STEP = r"step-\d{12}"
_PRODUCTS = {
    "": r"results\.nc(\.part)?|report\.(html|json)|validation\.(html|json|csv|png)",
    FRAMES: r"frame-\d{6,}\.nc(\.part)?",
    PROBES: r"[a-z][a-z0-9_]*\.rows",
    "checkpoints": rf"{_STEP}(\.refused)?|\.unfinished-({_STEP}|\d+)",
    "figures": rf"({'|'.join(PICTURES)})\.(png|svg|pdf)|bed\.gif",
    "tables": r"(history|radial_profiles|probe_[a-z][a-z0-9_]*)\.csv",
    "vtk": r"means\.vt[iu]|particles-\d{6,}\.vtp|gas-\d{6,}\.vti|(particles|gas)\.pvd",
}
"""Folder in the run folder -> pattern of the names in it."""


def remove_products(run: Path) -> None:
    """Remove the results of a run and what was made of them; files of other names stay."""
    for folder, pattern in _PRODUCTS.items():
        for path in (run / folder).glob("*"):
            if re.fullmatch(pattern, path.name):
                _remove(path)
        if folder:
            with suppress(OSError):  # it is not there, or not empty
                (run / folder).rmdir()


def remove_run(run: Path) -> None:
    """Remove what a run left in the run folder `run`, if there is one, so that it can be set up anew.

    Raises: CaseError if there is a folder, and it is none of fbcouple's.
    """
    if run.is_dir() and any(run.iterdir()):
        read_manifest(run)
        remove_products(run)
        (run / "logs/run.jsonl").unlink(missing_ok=True)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()
