"""What a member's error is measured by: a registry, and the modules that fill it."""

from fbcouple.study.measures import against_experiment, against_finest, against_theory, of_motion  # noqa: F401
from fbcouple.study.measures.registry import MEASURES, Error, Finished, check_measures, check_needs, find_error

__all__ = ["MEASURES", "Error", "Finished", "check_measures", "check_needs", "find_error"]
