"""Measured beds: each run, and scored against its data and against what others reached: `fbcouple validate`."""
