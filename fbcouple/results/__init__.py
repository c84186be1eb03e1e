"""results.nc: written, read and checked."""
