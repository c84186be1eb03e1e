"""Laws of heat transfer: closed formulas."""
