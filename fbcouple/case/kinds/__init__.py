"""Kinds of cases that `fbcouple init` writes."""
