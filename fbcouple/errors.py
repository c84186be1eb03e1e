"""One class of error, one exit code each: where, what was given, what is allowed, how to fix it."""


class FbcoupleError(Exception):
    """Base of every error that fbcouple raises on purpose; `exit_code` is what the command line returns."""

    exit_code = 1


class CaseError(FbcoupleError):
    """The case or another input is wrong (exit 1); `problems` lists every mistake found, one text each."""

    exit_code = 1

    def __init__(self, problems: list[str]) -> None:
        self.problems = problems
        super().__init__(problems)

    def __str__(self) -> str:
        return "\n".join(self.problems)


class BusyError(CaseError):
    """Another run is under way in the run folder (exit 69)."""

    exit_code = 69


class SolverError(FbcoupleError):
    """A solver, MPI or the machine failed (exit 3)."""

    exit_code = 3


class DivergedError(FbcoupleError):
    """The simulation diverged or broke a conservation check (exit 4)."""

    exit_code = 4


class StoppedError(FbcoupleError):
    """The run stopped early with a checkpoint; it can be resumed (exit 75)."""

    exit_code = 75


class LeftOutWarning(UserWarning):
    """Something that was given is left out, and the rest is done; the command line prints it as a line."""
