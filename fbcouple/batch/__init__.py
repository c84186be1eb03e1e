"""Job scripts of batch systems."""
