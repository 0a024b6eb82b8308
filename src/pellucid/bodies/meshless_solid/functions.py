"""The shape functions of a meshless solid; they are built when the conditions that prescribe the field are known."""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, NoFunctions
from pellucid.approximants.nodal.faces import face_shares
from pellucid.bodies.meshless_solid.force_correction import ForceCorrection
from pellucid.bodies.meshless_solid.prescribed import PrescribedField, values_at_nodes
from pellucid.bodies.meshless_solid.skin.points import SkinPoints, skin_points
from pellucid.bodies.meshless_solid.tables import Tables, at_quadrature_points, make_tables
from pellucid.errors import CaseError, Problem
from pellucid.findings import Refusal
from pellucid.geometry.meshes.cells import FaceShares, cells_of_faces
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.materials.law import Law
from pellucid.parts.body import in_metres

if TYPE_CHECKING:
    from pellucid.bodies.meshless_solid.model import MeshlessSolidCase

MISSED = 0.01  # weight of other nodes at a prescribed node from which a warning is issued


@contextmanager
def refused(case: "MeshlessSolidCase", key: str | None = None) -> Iterator[None]:
    """Convert errors about shape functions or settings that are raised inside the `with` statement to CaseError at `key`
    (default: the mesh)."""
    approximant, body = case.approximant, f"body.{case.name}"
    try:
        yield
    except NoFunctions as error:
        reach = approximant.reach
        where = f"{body}.approximant.{reach}" if reach else f"{body}.{case.place}"
        value = getattr(approximant, reach) if reach else None
        raise CaseError(Problem(str(error), where, value, approximant.remedy or "")) from None
    except Refusal as error:
        text, remedy = error.reason
        raise CaseError(Problem(text, f"{body}.{key or case.place}", remedy=remedy)) from None


def check_functions(case: "MeshlessSolidCase", mesh: SimplexMesh) -> None:
    """Raise CaseError if the approximant has no functions at a quadrature point or a node."""
    with refused(case):
        evaluator = case.approximant.evaluator(mesh)
        at_quadrature_points(mesh, evaluator, case.points_per_cell)
        values_at_nodes(mesh, evaluator)


class SolidFunctions:
    """Shape functions of a solid over its mesh. If nodal values are prescribed directly, functions of nodes with another
    prescribed displacement, or none, are made zero on prescribed faces, provided that the approximant supports this.

    Attributes: tables: gradients of the functions and weights at the quadrature points; at_nodes: values of the functions
    at the nodes, shape (n, n); residuals: evaluator of the difference between the displacement field and its prescribed
    values. law: hyperelastic law; prescribed: prescribed displacements. Raises CaseError if the approximant has no
    functions.
    """

    def __init__(self, case: "MeshlessSolidCase", mesh: SimplexMesh, law: Law, prescribed: PrescribedField) -> None:
        self._case, self._mesh, self._prescribed, approximant = case, mesh, prescribed, case.approximant
        with refused(case):
            self.evaluator: Evaluator = approximant.evaluator(mesh)
            if self.prescribes_nodes and len((disturbing := prescribed.disturbing(self.evaluator))[0]):
                self.evaluator = approximant.vanishing(self.evaluator, mesh, *disturbing)
            how = case.points_per_cell, case.consistent, case.averages_volume
            self.tables: Tables = make_tables(mesh, self.evaluator, law, *how)
            self.at_nodes = values_at_nodes(mesh, self.evaluator)
            self.residuals = prescribed.residuals(self.at_nodes, self.evaluator)
        if self.prescribes_nodes:
            self._warn_of_lone_nodes()

    def _warn_of_lone_nodes(self) -> None:
        nodes, missed = self._prescribed.lone(self.at_nodes)
        if not len(nodes) or missed.max() < MISSED:
            return
        count, node = int((missed >= MISSED).sum()), int(nodes[missed.argmax()])
        text = (
            f"body {self._case.name}: supports or motions select {count} of its nodes that do not form a whole "
            f"face, such as {node} at "
            f"{in_metres(self._mesh.nodes[node])}; other nodes have a weight of up to {missed.max():.2g} there: "
            'extend the regions to whole faces, or, in a case without a grid, set `essential = "sebciem"`'
        )
        warnings.warn(text, stacklevel=2)

    def follow(self, prescribed: PrescribedField) -> None:
        """Use a new set of prescribed nodes, for example after supports were released. The shape functions do not change."""
        self._prescribed, self.residuals = prescribed, prescribed.residuals(self.at_nodes, self.evaluator)

    @property
    def prescribes_nodes(self) -> bool:
        """True if nodal coefficients are prescribed directly; False if forces enforce the prescribed values of the field."""
        return self._case.essential == "direct"

    def correction(self, position: np.ndarray, inertia: np.ndarray, motions: tuple[int, int]) -> ForceCorrection | None:
        """Return the object that computes constraint forces for the prescribed displacement field; None if nodal coefficients
        are prescribed directly, or no node is prescribed.

        position: nodal positions of the body [m], shape (n, 3); inertia: nodal masses [kg], shape (n,); motions: first row of
        the prescribed values that belongs to a motion, and the row after the last.
        """
        if self.prescribes_nodes or not len(self._prescribed.nodes):
            return None
        how = position, inertia, motions, self._case.essential == "ebciem"
        with refused(self._case, "essential"):
            return ForceCorrection(self._prescribed, self.at_nodes, self.evaluator, *how)

    def face_shares(self, faces: np.ndarray) -> FaceShares:
        """Return the means of the shape functions over outer faces of the mesh with corners `faces`, shape (f, 3)."""
        with refused(self._case):
            return face_shares(self.evaluator, self._mesh.nodes, faces, cells_of_faces(self._mesh.cells, faces))

    def skin_points(self, mass: np.ndarray, longest: float, closed: Sequence[np.ndarray] = ()) -> SkinPoints:
        """Build the contact points on the outer faces of the solid, at most `longest` [m] apart.

        mass: nodal masses [kg], shape (n,); closed: masks, shape (n,), of sets of nodes that stay on a wall; faces with all
        nodes in one set have no contact.
        """
        return skin_points(self._mesh, self.evaluator, mass, longest, closed)
