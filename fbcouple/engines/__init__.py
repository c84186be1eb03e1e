"""The two solvers, each behind a thin class: raw library, NumPy arrays, nothing of the coupling."""
