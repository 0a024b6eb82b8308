"""Geometries of a film: the interpolation between its nodes on curves, on triangles by radial functions, and by Loop
subdivision.
"""
