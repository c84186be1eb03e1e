"""Small checks with the real solvers against analytic or published numbers: `fbcouple verify`."""
