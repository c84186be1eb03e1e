"""Both solvers in this process."""
