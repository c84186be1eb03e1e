"""What the LIGGGHTS library here can do, as `fbcouple doctor` shows it."""

from __future__ import annotations

from fbcouple.decks.abilities import PROBED, format_lacking, probe
from fbcouple.doctor.row import Row
from fbcouple.errors import SolverError
from fbcouple.solvers.site_files import LIGGGHTS

NEEDED = ("particles", "coupling")
"""Parts of a case without which no run with particles works."""


def rate_abilities() -> Row:
    """A run can work where the parts NEEDED can be done; cases that need others which are not are refused."""
    name, wanted = "LIGGGHTS' models", f"those of decks: at least {' and '.join(NEEDED)}"
    mend = f"name another library of LIGGGHTS in {LIGGGHTS}"
    try:
        answers = probe()
    except SolverError as error:
        return Row(name, str(error), wanted, False, mend)
    lacking = {part: words for part, words in answers.items() if words}
    if not lacking:
        return Row(name, f"all {len(PROBED)} that decks use", wanted, True, mend)
    found = f"{len(PROBED) - len(lacking)} of {len(PROBED)} that decks use; no {format_lacking(lacking)}"
    return Row(name, found, wanted, not any(part in lacking for part in NEEDED), mend)
