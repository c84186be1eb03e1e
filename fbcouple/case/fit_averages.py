"""`--set end_time=...` of a case whose averages start later: a short try should not need a second setting."""

from __future__ import annotations

from typing import Any, TypeGuard

from fbcouple.case.schema.reference import list_options

SECTION = "averages"
PART = 0.5
"""Part of the run after which averages start where they are fitted."""


def fit_averages(raw: dict[str, Any], set_keys: set[str]) -> str | None:
    """Fit `averages.start` in `raw`, a case file's content, to an `end_time` that is set on top of it (`set_keys`).

    Where the averages do not fit into the run, they start after half of it; if that is too short for a sample in each
    block, the section is removed. What is set itself, and what is no number, is left for the checks to judge.

    Returns: what was changed, a sentence; None if nothing was.
    """
    averages = raw.get(SECTION)
    if "end_time" not in set_keys or f"{SECTION}.start" in set_keys or not isinstance(averages, dict):
        return None
    end, start = raw["end_time"], averages.get("start")
    every, blocks = (averages.get(key, list_options()[f"{SECTION}.{key}"].default) for key in ("every", "blocks"))
    if not (_is_number(end) and _is_number(start) and _is_number(every) and _is_number(blocks)) or end <= 0.0:
        return None
    needed = every * blocks * (1.0 - 1e-9)
    if end - start >= needed and end > start:
        return None
    why = f"end_time = {end:g} of --set is too early for averages.start = {start:g}"
    if (1.0 - PART) * end >= needed:
        averages["start"] = PART * end
        return f"averages.start = {averages['start']:g}: {why}"
    if any(key.startswith(f"{SECTION}.") for key in set_keys):
        return None
    del raw[SECTION]
    return f"no averages are taken: {why}, and half of the run is shorter than {blocks} samples"


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)
