"""Mesh data structures: vertices, elements and their connectivity."""
