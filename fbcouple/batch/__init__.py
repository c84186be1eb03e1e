"""Runs under a batch system: a job script and how to hand it in."""
