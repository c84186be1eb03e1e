"""The coupling on polyhedral cells."""
