"""Interface of nodal approximants: shape functions of a body with its own nodes, over the simplices of a background mesh.

The active nodes depend only on the cell: all points of a cell share one list of nodes.
"""

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import generic
from pellucid.model import Model
from pellucid.registry import Family, OneOf


class Lists(NamedTuple):
    """A list of indices for each of n objects: the list of object i is `items[first[i]:first[i + 1]]`."""

    first: np.ndarray  # (n + 1,) start of each list, and the end of the last
    items: np.ndarray  # entries of all lists, one list after the other

    def of(self, things: np.ndarray) -> "Lists":
        """Return the lists of the objects with the numbers `things`, shape (m,), in the order of `things`."""
        count = np.diff(self.first)[things]
        first = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        return Lists(
            first, np.asarray(self.items[np.repeat(self.first[things] - first[:-1], count) + np.arange(int(first[-1]))])
        )


FACE_BLOCK, FACE_COLUMNS = 32, 5  # number of faces per vectorised block, and of values stored for each

OK, NOT_CONVERGED, NO_PRIOR, SINGULAR_MOMENTS = range(4)
FAILURES = {
    NOT_CONVERGED: "maximum entropy did not converge in 100 iterations: the point lies outside the convex hull of its nodes",
    NO_PRIOR: "no node has a positive weight at this point",
    SINGULAR_MOMENTS: "the moment matrix is singular: there are too few neighbours, or all of them lie in one plane",
}


class NoFunctions(ValueError):
    """Raised if an approximant has no shape functions at a position."""


class Scratch(NamedTuple):
    """Scratch memory of one thread in which the shape functions of the n active nodes of a cell are computed at a point."""

    offset: np.ndarray  # (n, 3) x - x_a (maximum entropy) or x_a - x (least squares) of point x and nodes x_a, over a length
    log_prior: np.ndarray  # (n,) logarithms of the nodal priors, or the weights of least squares
    slope: np.ndarray  # (n, 3) gradients of `log_prior`, times the length
    moments: np.ndarray  # (4, 10, 10) moment matrix of least squares and its derivatives along x, y, z
    terms: np.ndarray  # (5, 10) least squares: basis at a node, coefficients c, and derivatives of c along x, y, z
    faces: np.ndarray  # (FACE_COLUMNS * FACE_BLOCK,) distances from a block of faces, see `face_distances`
    normal: np.ndarray  # (3,) normal of the face on which the point lies, zero if there is none


class Evaluator(NamedTuple):
    """Shape functions of an approximant on a mesh, in the form that kernels evaluate."""

    active: Lists  # nodes whose functions can be non-zero in each cell, ascending
    functions: Any  # parameters of the functions: a NamedTuple whose type selects the kernel
    positive: bool = True
    """True if all shape functions are non-negative."""


class NodalApproximant(Model):
    """A nodal approximant as defined in a case. A new one is a subclass with its own `kind`."""

    kind: str
    reach: ClassVar[str | None] = None
    """Name of the key that sets the size of supports, if the functions need enough neighbours; None otherwise."""
    follows_cells: ClassVar[bool] = False
    """True if the functions are linear in each cell; one flat cell then makes them steep and the time step small."""
    remedy: ClassVar[str | None] = None
    """Remedy for a point without shape functions; None if there are functions in all tetrahedra with a volume."""

    @abstractmethod
    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        """Build the shape functions of the approximant for a mesh: active nodes of each cell and parameters."""

    def vanishing(self, evaluator: Evaluator, mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> Evaluator:
        """Return an evaluator in which the shape functions of given nodes vanish on given boundary faces of the mesh, where
        displacements are prescribed.

        evaluator: the shape functions so far; nodes, faces: numbers of the nodes and of the corresponding faces, shape (k,)
        each. Returns `evaluator` if the approximant does not support this.
        """
        return evaluator

    @property
    @abstractmethod
    def nodes_in_a_cell(self) -> float:
        """Approximate number of active nodes in an interior tetrahedron of an irregular mesh, for estimates of memory."""


NODAL_APPROXIMANTS = Family("approximant", NodalApproximant)
AnyNodalApproximant = Annotated[NodalApproximant, OneOf(NODAL_APPROXIMANTS)]


@generic
def shape_functions(functions: Any, cell: int, x: Any, active: Any, scratch: Any, values: Any, gradients: Any) -> Any:
    """Fill `values` (n,) and `gradients` (3, n) with the shape functions of n nodes and their gradients [1/m] at a position x
    [m] in a cell; return `OK` or a code of `FAILURES`.

    functions: parameters, see `Evaluator`; active: numbers of the nodes, shape (n,); scratch: memory, see `Scratch`.
    Gradients are skipped if their array has no columns.
    """


class FacedApproximant(NodalApproximant):
    """Base class of approximants whose shape functions can be made zero on given faces: the parameters of the functions
    include `distances` from faces."""

    def vanishing(self, evaluator: Evaluator, mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> Evaluator:
        from pellucid.approximants.nodal.rings import with_faces  # scipy is slow to import

        return with_faces(evaluator, mesh, nodes, faces)
