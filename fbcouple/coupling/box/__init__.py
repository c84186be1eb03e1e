"""The coupling on the equal cells of a box."""
