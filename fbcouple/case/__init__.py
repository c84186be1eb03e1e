"""The case file: read, checked and completed."""
