"""CFD-DEM of fluidized beds: stock OpenFOAM (gas) and stock LIGGGHTS (particles) in one MPI job."""

__version__ = "0.1.0"
