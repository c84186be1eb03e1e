"""Every option of a validation.toml, once: what was measured of a bed, and what others computed of it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from fbcouple.case.schema.option import Positive, Section, Stretch, as_tuple, option

_PRINTABLE: dict[str, Any] = {"pattern": r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*$"}
"""A text of one line, as it goes to terminals."""
_FINITE: dict[str, Any] = {"allow_inf_nan": False}


class Measurement(Section):
    name: str = option(
        "What was measured, in a few words; no two have the same.", min_length=1, max_length=80, **_PRINTABLE
    )
    compare: str = option("How it is compared with a run: a comparison of fbcouple/validate/comparisons.py.")
    of: str = option("What of the run: a line quantity@height of output.references, or a history of results.nc.")
    file: str | None = option(
        "CSV file beside this one with the measured points: time or angle, value and, if known, error.", default=None
    )
    value: float | None = option("The measured number, in SI units.", default=None, **_FINITE)
    error: float | None = option("Error of `value`, in its unit.", default=None, **Positive)
    span: Stretch | None = option(
        "From where to where: places x [m] of a line, of which the points between count; times [s] of a history, by "
        "default the averaging window.",
        default=None,
    )
    origin: float = option("Time of the run at which that of the measurement begins.", "s", 0.0, **_FINITE)
    wanted: float | None = option(
        "Root mean square deviation, of a number its deviation, that a run should stay within, in SI units.",
        default=None,
        **Positive,
    )


class Peer(Section):
    of: str = option("Name of the measurement.")
    name: str = option("Which code.", min_length=1, max_length=80, **_PRINTABLE)
    source: str = option("Where its numbers are published.", min_length=1, max_length=300, **_PRINTABLE)
    file: str | None = option(
        "CSV file beside this one with what it computed, as that of the measurement.", default=None
    )
    value: float | None = option("What it computed, where the measurement is a number.", default=None, **_FINITE)
    rms: float | None = option("Its root mean square deviation, where no more is known.", default=None, **Positive)


class Validation(Section):
    """A validation.toml beside the case.toml of a measured bed."""

    source: str = option("Who measured it, and where that is published.", min_length=1, max_length=300, **_PRINTABLE)
    cost: str = option("What a run of the whole case takes, in words.", min_length=1, max_length=200, **_PRINTABLE)
    measurements: Annotated[tuple[Measurement, ...], BeforeValidator(as_tuple), Field(min_length=1)] = option(
        "What was measured, a table [[measurements]] each."
    )
    peers: Annotated[tuple[Peer, ...], BeforeValidator(as_tuple)] = option(
        "What others computed of it, a table [[peers]] each.", default=()
    )
