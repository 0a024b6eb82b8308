"""Faces of a body with its own nodes on which tractions and pressures act, and the forces at its nodes."""

from collections.abc import Iterator

import numpy as np

from pellucid.findings import Finding, Path, refuse
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.face_shares import FaceShares
from pellucid.geometry.region import Where, chosen_faces, faults
from pellucid.parts.annotations import AssembledBody
from pellucid.parts.body_model import BodyModel, is_alone, selectable_of
from pellucid.parts.capabilities import HasMesh
from pellucid.parts.part import Parts


class LoadedFaces:
    """The faces of a body in a region, chosen at the start.

    A force t on unit area of the reference goes to the nodes as ∫ p_a t dA, with the means of the shape functions p_a over each
    face. A pressure takes the vector areas a_f of the deformed faces, between the present places of their corners: node a has
    -p Σ_f a_f ∫_f p_a dA / A_f. So the resultant is exact; the moment is where the deformation is affine, else it errs with the
    mesh.
    """

    def __init__(self, member: AssembledBody, where: Where, path: Path) -> None:
        """Raises CaseError, with the path of the region, where no face is in it."""
        self.body, start = member.body, member.selectable()
        refuse(faults(where, start, path, self.body.name, member.active_axes, faces=True))
        self.faces = start.faces[chosen_faces(where, start, member.active_axes)]
        self._start = start.position.copy()
        self._shares: FaceShares | None = None

    def shares(self) -> FaceShares:
        """How what acts on them goes to the nodes: known when all conditions are."""
        if self._shares is None:
            body = self.body
            self._shares = body.face_shares(self.faces) if isinstance(body, HasMesh) else FaceShares.linear(self.faces)
        return self._shares

    def traction(self, traction: np.ndarray) -> np.ndarray:
        """Forces at the nodes [N], shape (n, 3), of a force on unit area of the reference [Pa], shape (3,)."""
        areas = np.linalg.norm(vector_areas(self._start, self.faces), axis=1)
        return self.shares().at_nodes(areas[:, None] * traction, self.body.n_points)

    def pressure(self, pressure: float) -> np.ndarray:
        """Forces at the nodes [N], shape (n, 3), of a pressure [Pa] against the outward normals as they are now."""
        return self.shares().at_nodes(-pressure * vector_areas(self.body.places(), self.faces), self.body.n_points)


def face_problems(where: Where, path: Path, name: str, parts: Parts) -> Iterator[Finding]:
    """Why nothing can act on faces of a body in a region at a path: it has none that keep their nodes, or none there."""
    body = parts.named(BodyModel, name)
    if body is None:
        return
    start = selectable_of(body, parts)
    if start is None or not body.owns_nodes(is_alone(body, parts)):
        text = f"body {name} has no faces between nodes of its own"
        yield Finding(path, text, "use a meshless-solid, or membrane-elements in a velocity field of their own")
    elif body.is_surface and not all(parts.active_axes):
        text = f"body {name} is a membrane in a plane problem, whose faces are as deep as the slice"
        yield Finding(path, text, "use a grid that is more than one cell thick along every axis")
    else:
        yield from faults(where, start, path, name, parts.active_axes, faces=True)
