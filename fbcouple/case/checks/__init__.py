"""Checks of a case, as a registry."""
