"""Ranks for a job whose writer names none."""

from __future__ import annotations

from pathlib import Path

from fbcouple.batch.folders import find_runs
from fbcouple.case.cost.coefficients import load_coefficients
from fbcouple.case.cost.prediction import predict
from fbcouple.case.cost.ranks import Proposal, propose_ranks
from fbcouple.case.load import load_case
from fbcouple.errors import CaseError


def propose_for(target: Path) -> tuple[Path, Proposal]:
    """Ranks for the run in `target`, or for the dearest of the runs in it, and which of them that is.

    Raises: CaseError if the cost of a run cannot be predicted.
    """
    costs, found = load_coefficients(), []
    for run in find_runs(target):
        case = load_case(str(run))
        try:
            predicted = predict(case, 1, costs, run)
        except CaseError as error:
            text = f"--ranks: none is given, and the cost is not predicted ({error}); give the number of ranks."
            raise CaseError([f"{run}: {text}"]) from error
        found.append((predicted.wall, run, propose_ranks(case, costs, predicted)))
    _, run, proposal = max(found, key=lambda one: one[0])
    return run, proposal
