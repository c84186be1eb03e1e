"""Every option of a study file, once: `Study` for error against run time, `Stability` for stiff and extreme scenes."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from fbcouple.case.schema.option import NonNegative, Positive, Section, Texts, option

Forms = Annotated[Texts, Field(min_length=1)]


class Study(Section):
    """A study of error against run time."""

    title: str = option("One line that says what this study is.", min_length=1, max_length=200)
    base: str = option("The case that every member is made from: a shipped name, or a file beside the study.")
    set: dict[str, Any] = option("Case keys and values that all members have on top of the base.", default={})
    knobs: dict[str, Any] = option("Case keys, or `ranks`, with the list of values that each takes.")
    design: Literal["each", "grid"] = option(
        "One knob at a time off the base, or every combination of the knobs' values.", default="each"
    )
    reference: dict[str, Any] = option(
        "Case keys and values of the finest member, which is no member itself.", default={}
    )
    measures: Texts = option("What is measured: name, or name:argument, of the registry in fbcouple/study/measures/.")
    cost: Literal["wall", "cpu"] = option(
        "Cost of a member: wall time of its ranks, or their processor time, on a machine that others use too.",
        default="wall",
    )
    wall_limit: float = option("Wall time of one member after which it is ended.", "s", 600.0, **Positive)


class Stability(Section):
    """A study of stiff and extreme scenes."""

    title: str = option("One line that says what this study is.", min_length=1, max_length=200)
    base: str = option("The case that every scene is made from: a shipped name, or a file beside the study.")
    set: dict[str, Any] = option("Case keys and values that all scenes have on top of their base.", default={})
    forms: Forms = option(
        "The exchange forms that each scene is run with.", default=("explicit", "semi-implicit", "exponential")
    )
    scenes: dict[str, Any] = option(
        "Tables of scenes: case keys with a value or a list of values (each combination is a scene); `base` and `span` "
        "of their own if they differ."
    )
    span: Literal["gas", "particles", "contact", "fall", "passage"] = option(
        "Characteristic time: response of gas or particles, contact, free fall over the box, gas through it.",
        default="gas",
    )
    times: float = option("Characteristic times that each scene is run for.", default=100.0, **Positive)
    steps: int = option("Fluid steps that each scene takes at least.", default=200, ge=1, le=1_000_000)
    longest: float = option("Simulated time of a scene at most; 0: no limit.", "s", 0.0, **NonNegative)
    wall_limit: float = option("Wall time of one scene after which it is ended.", "s", 120.0, **Positive)
    ranks: int = option("MPI ranks of every scene.", default=1, ge=1, le=64)
    restart: bool = option(
        "Run the second half of each scene once more, from a checkpoint in its middle: its verdict stands beside the "
        "scene's own.",
        default=False,
    )
