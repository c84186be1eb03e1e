"""The version, in this one place: the build of the package reads it here, and it needs no other module."""

__version__ = "0.1.0"
