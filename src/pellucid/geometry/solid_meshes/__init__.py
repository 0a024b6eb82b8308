"""Tetrahedral meshes of a case, and their generation."""
