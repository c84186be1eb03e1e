"""What is written for the solvers."""
