"""Meshes and grids: made, read, cut and searched."""
