"""Figures of one run or of several, as registries."""
