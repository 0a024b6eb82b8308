"""How faces on the boundary of a mesh of tetrahedra meet."""

import numpy as np


def boundary_edges(mesh):
    """For each edge of the boundary its number of faces there: 2 everywhere on one that is whole and touches itself nowhere."""
    faces = mesh.faces[0][mesh.boundary]
    return np.unique(faces[:, [0, 1, 0, 2, 1, 2]].reshape(-1, 2), axis=0, return_counts=True)[1]
