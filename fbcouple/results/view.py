"""What of a bed its figures show, where a user or the case asks for something else than the bed itself gives."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class View:
    """`heights` [m] of profiles above the floor; empty: those of the case, else that of the bed's centre of mass.

    `full_height`: maps go up to the top of the box, and not only to a little above the bed.
    """

    heights: tuple[float, ...] = ()
    full_height: bool = False


BED = View()
"""What the bed itself and its case give."""
