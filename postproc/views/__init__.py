"""The bed in three dimensions."""
