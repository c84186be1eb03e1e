"""Cadences that a run does not keep: longer than it, or shorter than its steps."""

from __future__ import annotations

from collections.abc import Iterator

from fbcouple.case.bed.fluid_step import gas_step
from fbcouple.case.bed.number import Number
from fbcouple.case.bed.step_limits import Limits
from fbcouple.case.schema.sections import Case


def watch_cadences(case: Case, limits: Limits | None = None) -> Iterator[Number]:
    """Tell of each option that takes something every so often where it takes it once or never, or at every step and
    more seldom than asked; limits: of its fluid step, as `gas_step` has them."""
    step = gas_step(case, limits=limits) if case.gas else 0.0
    for key, every, start in _list_cadences(case):
        left = max(case.end_time - start, 0.0)
        if every > left:
            limit = f"at most what is left of the run, {left:.4g}"
            meaning = (
                "Longer than what the run has for it: what is taken is that of its first moment alone, or nothing."
            )
        elif every < step:
            limit = f"at least a fluid step, {step:.4g}"
            meaning = "Shorter than the fluid step: it is taken once a step, so more seldom than asked."
        else:
            continue
        yield Number(key, every, "s", limit, "warn", meaning)


def _list_cadences(case: Case) -> Iterator[tuple[str, float, float]]:
    """Option, its cadence [s] and the time [s] from which on it counts. Samples of means may be taken at every step."""
    for name in ("snapshots_every", "particles_every"):
        if every := getattr(case.output, name):
            yield f"output.{name}", every, 0.0
    for number, probe in enumerate(case.output.probes, start=1):
        yield f"output.probes.{number}.every", probe.every, probe.start
