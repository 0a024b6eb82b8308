"""Edges on the boundary of a mesh of tetrahedra."""

import numpy as np


def boundary_edges(mesh):
    """Return the number of boundary faces at each edge of the boundary: 2 at every edge if the boundary is closed and does
    not touch itself."""
    faces = mesh.faces[0][mesh.boundary]
    return np.unique(faces[:, [0, 1, 0, 2, 1, 2]].reshape(-1, 2), axis=0, return_counts=True)[1]
