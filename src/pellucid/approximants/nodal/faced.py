"""Nodal approximants whose weights of nodes fall to nothing towards faces."""

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, NodalApproximant
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


class FacedApproximant(NodalApproximant):
    """An approximant whose functions have `distances` from faces, towards which the weights of nodes can fall to nothing."""

    def vanishing(self, evaluator: Evaluator, mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> Evaluator:
        """With distances of these nodes from these faces too."""
        from pellucid.approximants.nodal.rings import with_faces  # scipy is heavy

        return with_faces(evaluator, mesh, nodes, faces)
