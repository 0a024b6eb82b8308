"""Mesh smoothing on closed surfaces: moves nodes along the surface so that triangles stay well shaped, and computes the new
masses of the areas around the nodes.
"""
