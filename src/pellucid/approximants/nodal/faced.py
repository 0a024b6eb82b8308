"""Nodal approximants whose nodal weights can vanish on faces."""

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, NodalApproximant
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


class FacedApproximant(NodalApproximant):
    """An approximant whose parameters include `distances` from faces, on which the shape functions of nodes can be made
    zero."""

    def vanishing(self, evaluator: Evaluator, mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> Evaluator:
        from pellucid.approximants.nodal.rings import with_faces  # scipy is slow to import

        return with_faces(evaluator, mesh, nodes, faces)
