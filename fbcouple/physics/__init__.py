"""Closed formulas: arrays in, arrays out."""
