"""The interface of nodal approximants: shape functions of a body with its own nodes, over the simplices of a background mesh.

Which nodes are active is a matter of the cell: all points of a cell share one list of nodes.
"""

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from pellucid.approximants.nodal.lists import Lists
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import generic
from pellucid.model import Model
from pellucid.registry import Family, OneOf

FACE_BLOCK, FACE_COLUMNS = 32, 5  # faces whose distances are found side by side, and what is kept of each

OK, NOT_CONVERGED, NO_PRIOR, SINGULAR_MOMENTS = range(4)
FAILURES = {
    NOT_CONVERGED: "no weights of maximum entropy in 100 iterations: it lies outside the convex hull of its nodes",
    NO_PRIOR: "no node has a weight there",
    SINGULAR_MOMENTS: "the moment matrix has no inverse: too few neighbours, or all of them on one plane",
}


class NoFunctions(ValueError):
    """An approximant has no functions at a place."""


class Scratch(NamedTuple):
    """Memory of one thread for the nodes of a cell."""

    offset: np.ndarray  # (n, 3)
    log_prior: np.ndarray  # (n,)
    slope: np.ndarray  # (n, 3)
    moments: np.ndarray  # (4, 10, 10)
    terms: np.ndarray  # (5, 10)
    faces: np.ndarray  # (FACE_COLUMNS * FACE_BLOCK,)
    normal: np.ndarray  # (3,) of the face on which the point lies, zero where it lies on none


class Evaluator(NamedTuple):
    """An approximant for a mesh: the nodes of each cell, in ascending order, and the parameters of its functions, a NamedTuple
    of its own."""

    active: Lists
    functions: Any
    positive: bool = True
    """Whether no function is negative anywhere."""


class NodalApproximant(Model):
    """A nodal approximant as the user describes it. A new one is a subclass with a `kind` of its own."""

    kind: str
    reach: ClassVar[str | None] = None
    """Its key for how far functions reach, where they need neighbours enough."""
    follows_cells: ClassVar[bool] = False
    """Whether its functions are linear in each cell, so that one flat cell makes them steep and the step small."""
    remedy: ClassVar[str | None] = None
    """What to do where it has no functions; None where it has some wherever tetrahedra have a volume."""

    @abstractmethod
    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        """Its functions for a mesh."""

    def vanishing(self, evaluator: Evaluator, mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> Evaluator:
        """Functions of which those of nodes, shape (k,), vanish on boundary faces of these numbers, shape (k,). Those of the
        evaluator where the approximant has no such."""
        return evaluator

    @property
    @abstractmethod
    def nodes_in_a_cell(self) -> float:
        """About how many nodes are active in a tetrahedron within an irregular mesh: for estimates of memory."""


NODAL_APPROXIMANTS = Family("approximant", NodalApproximant)
AnyNodalApproximant = Annotated[NodalApproximant, OneOf(NODAL_APPROXIMANTS)]


@generic
def shape_functions(functions: Any, cell: int, x: Any, active: Any, scratch: Any, values: Any, gradients: Any) -> Any:
    """Fill values (n,) and gradients (3, n) of the active nodes (n,) at a place x of a cell; `OK` or a code of `FAILURES`.

    Gradients with no columns are left out.
    """
