"""Drag laws, and their registry."""
