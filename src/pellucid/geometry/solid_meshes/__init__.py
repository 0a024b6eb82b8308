"""Meshes of tetrahedra, as cases describe them, and how each is made."""
