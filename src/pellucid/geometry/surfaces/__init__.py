"""Surfaces of membranes and films in a case, and their meshes."""
