"""OpenFOAM behind a C interface."""
