"""Geometries of a film: curves, triangles with radial functions, Loop subdivision."""
