"""Meshes as data: vertices, elements and their connectivity; computational geometry on them."""
