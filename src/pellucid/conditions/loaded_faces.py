"""Faces of a body in a region, on which tractions and pressures act, and the resulting forces on nodes or points of the
body."""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.conditions.enclosed.volume import failed_points
from pellucid.findings import Finding, Path, refuse
from pellucid.geometry.meshes.cells import FaceShares, vector_areas
from pellucid.geometry.region import Where, chosen_faces, faults
from pellucid.parts.annotations import AssembledBody
from pellucid.parts.body_model import BodyModel, is_alone, selectable_of
from pellucid.parts.capabilities import HasMesh
from pellucid.parts.part import Parts


class LoadedFaces:
    """Faces of a body in a region: triangles, or quadrilaterals split in two. They are selected at the start, or in each
    step by their centres.

    A traction t, i.e. a force per unit reference area, gives the nodal forces ∫ p_a t dA, with the mean of the shape
    functions p_a over each face. A pressure p acts on the vector areas a_f of the deformed faces, computed from the current
    positions of the corners: the force on node a is -p Σ_f a_f ∫_f p_a dA / A_f. The resultant is exact. The moment is
    exact for affine deformations; otherwise its error depends on the mesh.
    """

    def __init__(
        self, member: AssembledBody, where: Where, path: Path, by_centre: bool = False, each_step: bool = False
    ) -> None:
        """member: the body; where: region that selects the faces; path: path of the region in the case; by_centre: True to
        select the faces whose centres lie in the region, False to select those with all corners in the region; each_step:
        select the faces in each step. Raises CaseError, with the path, if the region contains no face at the start."""
        self.body, start = member.body, member.selectable_by_number()
        refuse(faults(where, start, path, self.body.name, member.active_axes, True, by_centre))
        self._now = (where, start, member.active_axes) if each_step else None
        self.faces = start.faces if each_step else start.faces[chosen_faces(where, start, member.active_axes, by_centre)]
        self._start = start.position.copy()
        self._shares: FaceShares | None = None
        self.is_left = False
        """True if faces are selected in each step and, in this step, the region contains no face."""

    def shares(self) -> FaceShares:
        """Return the weights that distribute loads on the faces to nodes of the body; they are computed at the first call,
        which must come after all conditions have been built."""
        if self._shares is None:
            body = self.body
            self._shares = body.face_shares(self.faces) if isinstance(body, HasMesh) else FaceShares.linear(self.faces)
        return self._shares

    def traction(self, traction: np.ndarray) -> np.ndarray:
        """Return the forces [N], shape (n, 3), in storage order, of a traction per unit reference area [Pa], shape (3,), on
        faces that were selected at the start."""
        areas = np.linalg.norm(vector_areas(self._start, self.faces), axis=1)
        return self._stored(self.shares(), areas[:, None] * traction)

    def pressure(self, pressure: float) -> np.ndarray:
        """Return the forces [N], shape (n, 3), in storage order, of a pressure [Pa] against the current outward normals; 0
        on failed points."""
        places, faces, shares = self.body.places(), self.faces, self.shares()
        if self._now is not None:
            where, start, active = self._now
            chosen = chosen_faces(where, start._replace(position=places), active, by_centre=True)
            faces, shares = faces[chosen], shares.of(chosen)
            self.is_left = not len(faces)
        return self._stored(shares, -pressure * vector_areas(places, faces), failed_points(self.body))

    def _stored(self, shares: FaceShares, on_faces: np.ndarray, without: Sequence[int] | np.ndarray = ()) -> np.ndarray:
        """Return the nodal forces [N], shape (n, 3), in storage order, of forces on the faces (`on_faces` [N], shape (m,
        3)); shares: weights that distribute the forces to nodes; without: numbers of points that get no force."""
        forces = shares.at_nodes(on_faces, self.body.n_points)
        if len(without):
            forces[without] = 0.0
        return forces[self.body.stored_array("id")]


def face_problems(where: Where, path: Path, name: str, parts: Parts, by_centre: bool = False) -> Iterator[Finding]:
    """Yield findings if loads cannot act on the faces of a body (`name`) in a region (`where`), since the body has no
    persistent faces, or none in the region. path: path of the region in the case; by_centre: True if faces belong to the
    region by their centres, False if by all corners."""
    body = parts.named(BodyModel, name)
    if body is None:
        return
    start = selectable_of(body, parts)
    if start is None or not body.owns_nodes(is_alone(body, parts)):
        text = f"body {name} has no faces with its own nodes"
        yield Finding(path, text, "use a meshless-solid, or membrane-elements in their own velocity field")
    elif body.is_surface and not all(parts.active_axes):
        yield in_plane_problem(path, name)
    else:
        yield from faults(where, start, path, name, parts.active_axes, True, by_centre)


def in_plane_problem(path: Path, name: str) -> Finding:
    """Return the finding that faces of a membrane cannot be selected in a plane problem; path: key for the finding; name:
    name of the body."""
    text = f"body {name} is a membrane in a plane problem: its faces extend through the slice and cannot be selected"
    return Finding(path, text, "use a grid that is more than one cell thick along every axis")
