"""Nodes of a surface moved along it, so that its triangles stay well shaped, and the masses of their cells then."""
