"""Numerics of runs that are not those of Hamidouche et al. 2019: the bed is the paper's, how it was computed is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fbcouple.postproc.papers.hamidouche2019.paper_beds import NUMERICS, SUB_GRID_MODELS, identify_case, look_up
from fbcouple.results.reader import Results

_SHORT = {
    "gas.max_courant": "CFL",
    "gas.max_fourier": "Fourier",
    "gas.correctors": "correctors",
    "gas.pressure_tolerance": "pressure tolerance",
    "gas.turbulence": "sub-grid model",
    "contact.steps_per_contact": "steps a contact",
    "contact.stiffness": "spring [N/m]",
    "output.task_file": "code of its own",
}


@dataclass(frozen=True)
class Other:
    """An option of a run, its value, and what the paper has, in words; nothing where it has no such thing."""

    key: str
    value: str
    papers: str

    def tell(self) -> str:
        """As a case file has it."""
        return f"{self.key} = {self.value}"

    def tell_briefly(self) -> str:
        """For a cell of a table."""
        return f"{_SHORT[self.key]} {self.value}"


def find_others(case: dict[str, Any]) -> list[Other]:
    """What of the numerics of a case is not the paper's."""
    found = []
    for key, (least, most) in NUMERICS.items():
        value = look_up(case, key)
        if value is not None and not least <= value <= most:
            found.append(Other(key, f"{value:g}", f"{least:g}" if least == most else f"{least:g} to {most:g}"))
    if own := look_up(case, "output.task_file"):  # code of its own may do anything
        found.append(Other("output.task_file", str(own), ""))
    model = look_up(case, "gas.turbulence")
    return [*found, Other("gas.turbulence", model, SUB_GRID_MODELS[0])] if model in SUB_GRID_MODELS[1:] else found


def list_numerics(case: dict[str, Any]) -> list[str]:
    """The same, each as a case file has it."""
    return [other.tell() for other in find_others(case)]


def tell_briefly(runs: Sequence[Results]) -> str:
    """What of the numerics of `runs` is not the paper's, for a cell of a table: "CFL 1.5, Fourier 1.5"; what not all of
    them have with how many do."""
    return ", ".join(
        f"{other.tell_briefly()} ({len(labels)} of {len(runs)})" if len(labels) < len(runs) else other.tell_briefly()
        for other, labels in _group(runs).items()
    )


def tell_numerics(runs: Sequence[Results]) -> str:
    """A sentence on those of `runs` that are of the paper's beds and do not have its numerics, and in what; nothing if
    all have them."""
    of_paper = [run for run in runs if identify_case(run.case)[1]]
    parts = []
    for other, labels in _group(of_paper).items():
        paper = f" ({other.papers} in the paper)" if other.papers else ""
        which = f"all {len(of_paper)} runs" if len(labels) == len(of_paper) > 1 else ", ".join(labels)
        parts.append(f"{other.tell()}{paper} in {which}")
    return f"Not the paper's numerics: {'; '.join(parts)}." if parts else ""


def _group(runs: Sequence[Results]) -> dict[Other, list[str]]:
    """Everything that is not the paper's -> the runs that have it."""
    found: dict[Other, list[str]] = {}
    for run in runs:
        for other in find_others(run.case):
            found.setdefault(other, []).append(run.label)
    return found
