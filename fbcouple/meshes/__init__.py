"""Meshes of polyhedra: read, made, cut into tetrahedra for the search of particles, and their walls as triangles."""
