"""What the rows of a history cannot tell: those of a reduced file stand for several each, and some of a pool hold the
worst of all replicas."""

from __future__ import annotations

from fbcouple.results.histories import Join, find_rule
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.reduced import JOINED
from fbcouple.results.replicas import REDUCED

_MEND = "take the runs that are in it"


def tell_joined(results: Results) -> str:
    """How many rows of the run each row of a history stands for, in words; nothing where it is one."""
    if not results.data.attrs.get(REDUCED):
        return ""
    count = int(results.data.attrs.get(JOINED, 0))
    return "" if count == 1 else f"each row of its histories stands for {count or 'several'} of the run"


def require_every_row(results: Results, wants: str) -> None:
    """Raise NotDrawableError if rows are joined, as a rhythm in them is then another one; `wants`: what asks for it."""
    if joined := tell_joined(results):
        text = f"{results.path} is a reduced file: {joined}, too few for {wants}"
        raise NotDrawableError([f"{text}; {_MEND}."])


def find_lack(results: Results, name: str, is_of_spread: bool = False) -> str:
    """Why the rows of the history `name` have not the mean of the run that they are of or, `is_of_spread`, not the
    deviation; nothing where they have."""
    rule = find_rule(name, results.data)
    if results.replicas > 1 and rule.replicas is not None:
        return "its rows hold the worst of all replicas"
    allowed = (Join.LAST,) if is_of_spread else (Join.LAST, Join.MEAN)
    joined = tell_joined(results)
    return f"{joined}, and holds the {rule.rows} of them" if joined and rule.rows not in allowed else ""


def require_own_rows(results: Results, name: str, is_of_spread: bool = False) -> None:
    """Raise NotDrawableError if there is such a lack."""
    if lack := find_lack(results, name, is_of_spread):
        raise NotDrawableError([f"`{name}` in {results.path}: {lack}; {_MEND}."])
