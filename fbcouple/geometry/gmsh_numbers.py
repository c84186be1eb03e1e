"""The numbers of a section of a gmsh file, text or binary, one after the other."""

from __future__ import annotations

import numpy as np

from fbcouple.geometry.number_text import parse_numbers

AGAIN = "write it again with `gmsh -3 -format msh41`"
CUT_OFF = f"it ends early; copy it again, or {AGAIN}"


class Numbers:
    """The numbers of a section, taken from its start to its end."""

    def __init__(self, data: bytes, is_text: bool, size: int) -> None:
        """size: bytes of what the format calls size_t."""
        self._kinds = {"i": np.dtype("i4"), "s": np.dtype(f"u{size}"), "d": np.dtype("f8")}
        self._values = parse_numbers(data, float) if is_text else None
        self._data, self._at = data, 0

    def take(self, kind: str, count: int) -> np.ndarray:
        """The next `count` numbers of a kind: "i" int, "s" size_t, "d" double. Raises: ValueError if there are not."""
        if self._values is None:
            values = self.take_rows(self._kinds[kind], count)
        else:
            values = self._values[self._at : self._at + max(count, 0)]
            self._at += count
        if count < 0 or len(values) < count:
            raise ValueError(CUT_OFF)
        return values if kind == "d" else _require_whole(values)

    def take_rows(self, of: np.dtype, count: int) -> np.ndarray:
        """The next `count` values of the type `of` (binary). Raises: ValueError if there are not as many."""
        if not 0 <= count <= (len(self._data) - self._at) // of.itemsize:
            raise ValueError(CUT_OFF)
        start, self._at = self._at, self._at + count * of.itemsize
        return np.frombuffer(self._data[start : self._at], of)

    def one(self, kind: str) -> int:
        """The next whole number."""
        return int(self.take(kind, 1)[0])

    def count(self) -> int:
        """The number in the first line, which is text in a binary section of format 2, too."""
        if self._values is not None:
            return self.one("s")
        end = self._data.find(b"\n")
        self._at = end + 1
        return int(self._data[: max(end, 0)])

    def take_rest(self) -> np.ndarray:
        """All whole numbers that are left (text)."""
        assert self._values is not None
        return _require_whole(self._values[self._at :])


def _require_whole(values: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        whole = values.astype(np.int64)
    if values.dtype.kind == "f" and np.any(whole != values):
        raise ValueError(f"it has a number that is not whole where one is expected: {AGAIN}")
    return whole
