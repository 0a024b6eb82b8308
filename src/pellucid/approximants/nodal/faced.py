"""Nodal approximants whose nodal weights can vanish on faces."""

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, NodalApproximant
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


class FacedApproximant(NodalApproximant):
    """Base class of approximants whose shape functions can be made zero on given faces: the parameters of the functions
    include `distances` from faces."""

    def vanishing(self, evaluator: Evaluator, mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> Evaluator:
        from pellucid.approximants.nodal.rings import with_faces  # scipy is slow to import

        return with_faces(evaluator, mesh, nodes, faces)
