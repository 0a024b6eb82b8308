"""Faces of the grid through which points come in, and at which a flow or pressure leads them out."""
