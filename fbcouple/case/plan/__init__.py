"""Which numerics, length of the means and ranks reach an error at least cost, told before a run."""
