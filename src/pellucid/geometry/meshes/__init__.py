"""Meshes as data: vertices, elements, and how these are linked."""
