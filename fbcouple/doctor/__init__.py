"""Whether a run can work here, and the archive for a bug report."""
