"""What of its measurements the case of a bed cannot give: told before it is run."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from fbcouple.case.bed.derived import has_ramp
from fbcouple.case.bed.feeds import has_traffic
from fbcouple.case.schema.output import AUTO, find_first_sample
from fbcouple.case.schema.sections import Case
from fbcouple.results.steady_part import FEWEST
from fbcouple.validate.comparisons import COMPARISONS, SECTION, Task
from fbcouple.validate.source import Bed

_PARTICLES, _GAS, _BOTH = "[particles]", "[gas]", "[gas] and [particles]"
_HAS: dict[str, Callable[[Case], bool]] = {
    _PARTICLES: lambda case: case.particles is not None,
    _GAS: lambda case: case.gas is not None,
    _BOTH: lambda case: case.gas is not None and case.particles is not None,
    "a ramp of the inlet": lambda case: case.gas is not None and has_ramp(case.gas),
    "an open top": lambda case: case.gas is not None and case.gas.top == "open",
    "particles.feeds or particles.outlets": has_traffic,
    "a mixture of two species": lambda case: case.particles is not None and len(case.particles.mixture) == 1,
    'averages.start = "auto"': lambda case: case.averages is not None and case.averages.start == AUTO,
    "averages.until_error": lambda case: case.averages is not None and case.averages.until_error is not None,
    "[heat]": lambda case: case.heat is not None,
    "[heat] and [gas]": lambda case: case.heat is not None and case.gas is not None,
    "[heat] and [particles]": lambda case: case.heat is not None and case.particles is not None,
    "[heat] and particles.feeds or particles.outlets": lambda case: case.heat is not None and has_traffic(case),
    "output.tracked": lambda case: case.particles is not None and bool(case.output.tracked),
}
"""What a case may have."""
_OF: dict[str, tuple[str, ...]] = {
    _PARTICLES: (
        *("bed_height", "solids_centre_z", "particles", "kinetic_energy", "particles_at_outlet", "max_overlap"),
        *("substeps", "solids_fraction", "solids_flux", "solids_velocity", "agitation", "granular_temperature"),
    ),
    _GAS: (
        *("pressure_drop", "gas_mass_error", "gas_inflow_error", "gas_flux_error", "max_courant"),
        *("voidage", "gas_velocity", "gas_flux", "pressure"),
    ),
    _BOTH: (
        *("gas_support", "solids_volume", "momentum_error", "displaced_gas_error", "min_voidage"),
        "cells_over_packed",
    ),
    "a ramp of the inlet": ("inlet_velocity",),
    "an open top": ("gas_backflow",),
    "particles.feeds or particles.outlets": (
        *("particles_fed", "particles_removed", "particles_owed", "mass_fed", "mass_removed", "ledger_error"),
    ),
    "a mixture of two species": ("species_centre_z",),
    'averages.start = "auto"': ("averages_start",),
    "averages.until_error": ("averages_error", "expected_end"),
    "[heat]": (
        *("heat_error", "heat_given", "heat_by_walls", "heat_by_inlets", "heat_by_outlets", "heat_by_contacts"),
        *("heat_by_continuity", "min_temperature", "max_temperature"),
    ),
    "[heat] and [gas]": ("mean_gas_temperature", "gas_temperature"),
    "[heat] and [particles]": ("mean_particle_temperature", "solids_temperature"),
    "[heat] and particles.feeds or particles.outlets": ("heat_fed", "heat_removed"),
    "output.tracked": ("rebound_angle", "tangential_restitution"),
}
NEEDED: dict[str, str] = {name: need for need, names in _OF.items() for name in names}
"""History, time mean or what is made of tracked particles -> what a case must have for its run to have it."""
_SINGLE = ("rate", "curve")
"""Comparisons at moments of a history, which need no averaging window."""


def find_lacks(bed: Bed, case: Case) -> dict[str, str]:
    """Name of each measurement of `bed` that a whole run of `case` cannot give -> why, and what to do."""
    found = {}
    for task in bed.tasks:
        if lack := next(_look(case, task), None):
            found[task.measurement.name] = lack
    return found


def _look(case: Case, task: Task) -> Iterator[str]:
    wanted = task.measurement
    if COMPARISONS[wanted.compare].of == SECTION:
        yield from _look_at_section(case, task)
        return
    name = wanted.of if task.line is None else task.line.quantity
    if (need := NEEDED.get(name)) and not _HAS[need](case):
        yield f"{name} is compared, and the case has not {need}; give it that"
    if task.line is not None:
        yield from _look_at_window(case, f"{wanted.of} is a time mean")
    elif wanted.compare in _SINGLE:
        moments = task.points.x if wanted.span is None else np.array(wanted.span)
        yield from _look_at_times(case, wanted.origin + moments)
    elif COMPARISONS[wanted.compare].axis == "":
        yield from _look_at_span(case, task)


def _look_at_section(case: Case, task: Task) -> Iterator[str]:
    wanted = task.measurement
    sections = [one for one in case.output.probes if one.height is not None and "voidage" in one.quantities]
    if wanted.of not in [one.name for one in sections]:
        yield f"{wanted.of} is no set of output.probes with a height and the voidage; give the case such a set"
    if wanted.span is not None:
        yield from _look_at_times(case, np.array(wanted.span))


def _look_at_window(case: Case, what: str) -> Iterator[str]:
    if case.averages is None:
        yield f"{what}, and the case has no [averages]; give it some"
    elif (begin := find_first_sample(case.averages)) >= case.end_time:
        given = f"averages.start = {begin:g} s, end_time = {case.end_time:g} s"
        yield f"{what}, and the run ends before these begin ({given}); let it run longer"


def _look_at_times(case: Case, moments: np.ndarray) -> Iterator[str]:
    if moments.min() < 0.0 or moments.max() > case.end_time:
        text = f"it is of the times {moments.min():g} to {moments.max():g} s of the run"
        yield f"{text}, which ends at {case.end_time:g} s; let it run longer, or give another span or origin"


def _look_at_span(case: Case, task: Task) -> Iterator[str]:
    """There are rows enough of the history within the span, by default the averaging window."""
    span = task.measurement.span
    if span is None:
        yield from _look_at_window(case, "it is of the averaging window")
    else:
        yield from _look_at_times(case, np.array(span))
    begin, end = span or (find_first_sample(case.averages) if case.averages else 0.0, case.end_time)
    rows = int((end - begin) / case.output.record_every + 1e-9)
    if rows < FEWEST:
        text = f"output.record_every = {case.output.record_every:g} s gives {rows} rows in {begin:g} to {end:g} s"
        yield f"{text}, and {FEWEST} are needed; record more often"
