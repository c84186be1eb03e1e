"""Commas and points in the numbers of one table: whether they are decimal signs, or may stand between thousands."""

from __future__ import annotations

import re

from fbcouple.errors import CaseError

_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")


class DecimalSigns:
    """What the numbers of the table `file`, with `separator` between its columns, have had so far.

    A comma is a decimal one for sure where one number of the file cannot have it between thousands: a program writes
    all numbers of a file one way.
    """

    def __init__(self, file: str, separator: str | None) -> None:
        self._file, self._separates = file, separator == ","
        self._comma, self._is_clear, self._unclear = 0, False, ""
        self.point = 0
        """Line of the first number with a decimal point; 0: none yet."""

    def see_point(self, line: int) -> None:
        """A number in `line` has a decimal point. Raises: CaseError if one before has a comma."""
        self.point = line
        self._require_one_way()

    def see_comma(self, line: int, entry: str, column: str) -> None:
        """The number `entry` for `column` in `line` has a comma. Raises: CaseError if that cannot be a decimal one."""
        self._comma = self._comma or line
        self._require_one_way()
        number = entry.strip()
        if not _THOUSANDS.fullmatch(number):
            self._is_clear = True
            return
        mend = f"write it with a decimal point, or as {number.replace(',', '')}"
        text = (
            f"{self._file}: line {line} has `{number}` for {column}, which may be thousands or a decimal comma; {mend}"
        )
        if self._separates:
            raise CaseError([f"{text}."])
        self._unclear = self._unclear or text

    def require_clear(self) -> None:
        """At the end of the file. Raises: CaseError if no number tells what its commas are."""
        if self._unclear and not self._is_clear:
            raise CaseError([f"{self._unclear} (no number of the file tells: each comma stands before three digits)."])

    def _require_one_way(self) -> None:
        if self._comma and self.point:
            text = f"{self._file}: line {self._comma} has a decimal comma and line {self.point} a decimal point"
            raise CaseError([f"{text}; write all numbers one way, and none with a sign between thousands."])
