"""The version of fbcouple: here alone."""

__version__ = "0.1.0"
