"""CFD-DEM of fluidized beds: stock OpenFOAM (gas) and stock LIGGGHTS (particles) in one MPI job."""

import os

from fbcouple.version import __version__ as __version__

# Results are written beside their name and renamed, so nobody meets a file that is being written; HDF5's own locks only
# keep them from being read or written on file systems that have none.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
