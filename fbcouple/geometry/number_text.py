"""Numbers in text, read as data only and in time that grows with the length of the text."""

from __future__ import annotations

import warnings

import numpy as np

_ALLOWED = b"0123456789+-.eE \t\r\n\f\v"


def parse_numbers(text: bytes, kind: type) -> np.ndarray:
    """All numbers of `text`, which blanks part. Raises: ValueError saying what is no number."""
    foreign = text.translate(None, _ALLOWED)
    if foreign:
        first = text.find(foreign[:1])
        words = text[max(first - 20, 0) : first + 20].decode("ascii", "replace").split()
        raise ValueError(f"it has `{' '.join(words)}`")
    if not text.strip():
        return np.empty(0, kind)  # NumPy reads -1 from blanks alone
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except (ValueError, DeprecationWarning):
            what = "a whole number" if kind is not float else "a number"
            raise ValueError(f"it has a word that is not {what}") from None
