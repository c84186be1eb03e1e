"""Where the time goes, beside what the solvers alone take, and how it scales: `fbcouple bench`."""
