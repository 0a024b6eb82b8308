"""Bending of open membranes of triangles as isotropic plates: energy, its exact derivative, and a step limit.

E = ½ (φ - φ₀)ᵀ S (φ - φ₀) with the fold angles φ at the edges (`plate_operators`); S is computed from the initial shapes.
The forces are -S (φ - φ₀) ∂φ/∂x. Folds depend on the shape alone, so that the sum of the forces and the sum of the torques
are zero. The largest eigenfrequency of the nodes is bounded by the rows of Σ |∂φ/∂x_j| |S| |∂φ/∂x_k| divided by the mass of
node j.
"""

from math import atan2, sqrt
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.bodies.membrane_elements.geometry import cross, dot
from pellucid.bodies.membrane_elements.mesh import Fan, fan_of, incidence
from pellucid.bodies.membranes.closed_bending import CHUNK, OWN, RATE, SUMS, gather_hinges
from pellucid.bodies.membranes.plate_operators import BendingSupports, build_plate_operators, no_supports
from pellucid.jit import pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.reductions import ordered_sum


class Folds(NamedTuple):
    """Data of the bending kernels of an open membrane with h hinges (edges between two triangles) and n nodes: mesh,
    stiffness matrix S of the fold angles φ (angles between the normals of the two triangles), and results of the kernels.
    The bending energy is ½ (φ - φ₀)ᵀ S (φ - φ₀)."""

    corners: np.ndarray  # (h, 4) storage rows of the corners: start and end of the edge, left, right
    mirror: np.ndarray  # (h,) axis across which the fourth corner is the mirror image of the third, else -1
    start: np.ndarray  # (h+1,) start of the entries of each row of S
    columns: np.ndarray  # columns of the entries of S
    stiffness: np.ndarray  # entries of S [J]
    rest: np.ndarray  # (h,) fold angles φ₀ in the unbent state
    moves: np.ndarray  # (h, 4) 1 for a corner that can move freely, else 0
    about: Fan  # hinge corners around each node, as 4 e + corner for hinge e
    where: np.ndarray  # (n,) storage row of each node
    mass: np.ndarray  # (n,) nodal masses [kg]
    fold: np.ndarray  # (h, 2) φ - φ₀, and Σ_corners |∂φ/∂x|
    turn: np.ndarray  # (h, 2) S (φ - φ₀) [J], and |S| Σ_corners |∂φ/∂x|
    values: np.ndarray  # (h, 4, OWN) forces on the corners [N] and stiffness bounds [N/m]
    energy: np.ndarray  # (n,) bending energies of the nodes [J]
    sums: np.ndarray  # (chunks of nodes, SUMS) column RATE: largest squared eigenfrequency bound
    hinge_sums: np.ndarray  # (chunks of hinges, 1) energies [J]


class PlateBending:
    """Computes bending energy and forces of an open membrane of triangles that bends like an isotropic plate: ½ (φ - φ₀)ᵀ S
    (φ - φ₀) for the fold angles φ (angles between the normals of adjacent triangles), with the values φ₀ in the unbent
    state and the stiffness matrix S. Has the interface of `Bending`."""

    def __init__(
        self, triangles: np.ndarray, vertices: np.ndarray, mass: np.ndarray, rigidity: float, poisson_ratio: float
    ) -> None:
        """triangles: shape (t, 3); vertices: initial positions [m], shape (n, 3); mass: nodal masses [kg], shape (n,);
        rigidity: bending stiffness D of the plate [J]; poisson_ratio: ν of the bending.
        """
        self.triangles, self._vertices, self._mass = triangles, vertices.copy(), mass
        first, second, third = (vertices[corner] for corner in triangles.T)
        normals = np.cross(second - first, third - first)
        self.normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        """Unit normals of the triangles at the start, shape (t, 3)."""
        self.rigidity, self.poisson_ratio = rigidity, poisson_ratio
        self._relaxed: tuple[float, np.ndarray | None] = (0.0, None)
        self._where = np.arange(len(vertices))
        self._bent: np.ndarray | None = None  # positions of the last evaluation
        self.energies = np.zeros(len(vertices))
        self.rate = 0.0
        """Upper bound of half the largest eigenfrequency of the nodes [1/s]."""
        self.support(no_supports(len(triangles), len(vertices)))

    def relax(self, curvature: float = 0.0, shape: np.ndarray | None = None) -> None:
        """Set the shape in which the membrane has no bending moments: a surface with both principal curvatures ½c₀, or a given
        shape.

        curvature: c₀ [1/m]; shape: vertices of the given shape [m], shape (n, 3), used instead of the curvature; None for none.
        """
        self._relaxed = curvature, None if shape is None else shape.copy()
        operators = self._operators
        self._rest[:] = 0.5 * curvature * operators.unit if shape is None else operators.folds(shape)
        self._bent = None

    def support(self, supports: BendingSupports) -> None:
        """Rebuild the bending operators for these supports: clamps and planes of symmetry."""
        self.supports = supports
        properties = self.triangles, self._vertices, self.rigidity, self.poisson_ratio
        self._operators = operators = build_plate_operators(*properties, supports)
        h, n = len(operators.corners), len(self._mass)
        self._chunks = [(size + CHUNK - 1) // CHUNK for size in (h, n)]
        self._about = fan_of(operators.corners, n)
        self._rest = np.zeros(h)
        self._room = np.zeros((h, 2)), np.zeros((h, 2)), np.zeros((h, 4, OWN)), self.energies
        self._sums, self._hinge_sums = np.zeros((self._chunks[1], SUMS)), np.zeros((max(1, self._chunks[0]), 1))
        self.relax(*self._relaxed)
        self.bind(self._where)

    def bind(self, where: np.ndarray) -> None:
        """Set the storage row of each node, `where`, shape (n,), in the order of the node numbers; positions and forces are
        stored in these rows.
        """
        self._where, self._bent = where, None
        operators = self._operators
        corners, rows = operators.corners, operators.stiffness
        mesh = where[corners], operators.mirror
        stiffness = rows.indptr.astype(np.int64), rows.indices.astype(np.int64), rows.data
        moves = np.where(self.supports.fixed[corners], 0.0, 1.0)
        found = *self._room, self._sums, self._hinge_sums
        self._bundle = Bundle(Folds(*mesh, *stiffness, self._rest, moves, self._about, where, self._mass, *found))

    def curvatures(self, position: np.ndarray) -> np.ndarray:
        """Return the sum of the principal curvatures at the nodes [1/m], shape (n,), in mesh order.

        The curvature at a node is an average over the triangles around the node; at free edges it follows from zero moment.
        position: in storage order [m], shape (n, 3).
        """
        return np.asarray(self._operators.curvature @ self._operators.folds(position[self._where]))

    def energy(self, position: np.ndarray) -> float:
        """Return the bending energy [J] for nodes at these positions [m], shape (n, 3), in storage order."""
        self._bend(position)
        return float(ordered_sum(self._hinge_sums)[0])

    def add_forces(self, position: np.ndarray, target: np.ndarray) -> None:
        """Add the nodal forces of bending [N] at these positions [m] to `target`, shape (n, 3) both, in storage order, and
        update `rate`, the upper bound of half the largest eigenfrequency of the nodes [1/s]."""
        self._bend(position)
        _push_corners(self._chunks[0], self._bundle, position)
        _gather(self._chunks[1], self._bundle, target)
        self.rate = 0.5 * sqrt(float(self._sums[:, RATE].max(initial=0.0)))

    def linked_nodes(self) -> csr_array:
        rows = self._operators.stiffness
        pattern = csr_array((np.ones(len(rows.data)), rows.indices, rows.indptr), rows.shape)
        return csr_array(pattern @ incidence(self._operators.corners, len(self._mass)))

    def _bend(self, position: np.ndarray) -> None:
        # a step asks for the energy and then for the forces of the same positions
        if self._bent is not None and np.array_equal(self._bent, position):
            return
        _fold(self._chunks[0], self._bundle, position)
        _turn(self._chunks[0], self._bundle)
        _share_energy(self._chunks[1], self._bundle)
        self._bent = position.copy()


@pointwise
def _unfolded(x, corners, mirror, e):
    """Return the vectors of hinge e (an edge and its two triangles): the edge, the vectors from its start to the left and
    right corners, and the normals of the two triangles.

    x: nodal positions [m]; corners: rows of the four nodes of each hinge; mirror: for a hinge in a plane of symmetry the
    axis normal to the plane, else -1. The right triangle of a hinge in a plane of symmetry is the mirror image of the left
    one.
    """
    a, b, c, d = corners[e, 0], corners[e, 1], corners[e, 2], corners[e, 3]
    along = (x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2])
    left = (x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2])
    p, q, r = x[d, 0], x[d, 1], x[d, 2]
    if mirror[e] == 0:
        p = x[a, 0] + x[b, 0] - p
    elif mirror[e] == 1:
        q = x[a, 1] + x[b, 1] - q
    elif mirror[e] == 2:
        r = x[a, 2] + x[b, 2] - r
    right = (p - x[a, 0], q - x[a, 1], r - x[a, 2])
    return along, left, right, cross(along, left), cross(right, along)


@pointwise
def _places(along, left, right):
    """Return the positions of the left and right corners along the edge of a hinge, as fractions of its length. along: edge
    vector; left, right: vectors from its start to the corners [m].
    """
    square = dot(along, along)
    return dot(left, along) / square, dot(right, along) / square


@pointwise
def _turned(length, n1, n2, s, t):
    """Return |∂φ/∂x| [1/m] of the fold angle φ for the four corners x of a hinge; for the two ends of its edge the results
    are upper bounds.

    length: length of the edge [m]; n1, n2: normals of the triangles, with lengths of twice the areas of the triangles [m²];
    s, t: positions of the left and right corners along the edge, see `_places`.
    """
    one, two = length / sqrt(dot(n1, n1)), length / sqrt(dot(n2, n2))
    return abs(1.0 - s) * one + abs(1.0 - t) * two, abs(s) * one + abs(t) * two, one, two


@parallel_loop()
def _fold(chunk, of, x):
    """Compute the change φ - φ₀ of the fold angle at each hinge of a chunk since the unbent state, and the sum of |∂φ/∂x| over
    the corners x of the hinge. of: data of `Folds`, to which the results are written; x: nodal positions [m], shape (n, 3).
    """
    corners, fold, moves = of.corners, of.fold, of.moves
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        along, left, right, n1, n2 = _unfolded(x, corners, of.mirror, e)
        length = sqrt(dot(along, along))
        fold[e, 0] = atan2(dot(along, cross(n1, n2)) / length, dot(n1, n2)) - of.rest[e]
        s, t = _places(along, left, right)
        first, second, one, two = _turned(length, n1, n2, s, t)
        fold[e, 1] = moves[e, 0] * first + moves[e, 1] * second + moves[e, 2] * one + moves[e, 3] * two


@parallel_loop()
def _turn(chunk, of):
    """Compute the bending moments S (φ - φ₀) at a chunk of hinges, with the stiffness matrix S and the fold angles φ, φ₀ now
    and in the unbent state, and the energy of these hinges. of: data of `Folds`, to which the results are written.
    """
    start, columns, stiffness, fold, turn, total = of.start, of.columns, of.stiffness, of.fold, of.turn, 0.0
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(turn))):
        moment = bound = 0.0
        for k in range(start[e], start[e + 1]):
            moment += stiffness[k] * fold[columns[k], 0]
            bound += abs(stiffness[k]) * fold[columns[k], 1]
        turn[e, 0], turn[e, 1] = moment, bound
        total += 0.5 * moment * fold[e, 0]
    of.hinge_sums[chunk, 0] = total


@parallel_loop()
def _share_energy(chunk, of):
    """Compute the bending energies of a chunk of nodes: half the energy of each hinge for each end of its edge. of: data of
    `Folds`.
    """
    about, fold, turn = of.about, of.fold, of.turn
    for K in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(of.where))):
        total = 0.0
        for k in range(about.start[K], about.start[K + 1]):
            e, corner = about.places[k] // 4, about.places[k] % 4
            if corner < 2:
                total += 0.25 * turn[e, 0] * fold[e, 0]
        of.energy[K] = total


@parallel_loop()
def _push_corners(chunk, of, x):
    """Compute the forces of a chunk of hinges on their corners, and the terms that limit the time step. of: data of `Folds`,
    to which the results are written; x: nodal positions [m], shape (n, 3).
    """
    corners, mirror, values, turn, moves = of.corners, of.mirror, of.values, of.turn, of.moves
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        along, left, right, n1, n2 = _unfolded(x, corners, mirror, e)
        length = sqrt(dot(along, along))
        s, t = _places(along, left, right)
        first, second, one, two = _turned(length, n1, n2, s, t)
        here, there = turn[e, 0] * length / dot(n1, n1), turn[e, 0] * length / dot(n2, n2)
        for i in range(3):
            across, beyond = here * n1[i], there * n2[i]
            values[e, 2, i], values[e, 3, i] = across, beyond
            values[e, 0, i] = -(1.0 - s) * across - (1.0 - t) * beyond
            values[e, 1, i] = -s * across - t * beyond
            if mirror[e] == i:  # the image follows the edge and the corner itself
                values[e, 3, i] = -beyond
                values[e, 0, i] += beyond
                values[e, 1, i] += beyond
        values[e, 0, 3], values[e, 1, 3] = moves[e, 0] * turn[e, 1] * first, moves[e, 1] * turn[e, 1] * second
        values[e, 2, 3], values[e, 3, 3] = moves[e, 2] * turn[e, 1] * one, moves[e, 3] * turn[e, 1] * two


@parallel_loop()
def _gather(chunk, of, target):
    """Sum the bending forces at a chunk of nodes into `target`, shape (n, 3), and compute the largest ratio of stiffness bound
    to mass, the square of the bound on the eigenfrequency. of: data of `Folds`.
    """
    fastest = 0.0
    for K in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(of.where))):
        stiff = gather_hinges(of.about, of.values, K, target, of.where[K])
        fastest = max(fastest, stiff / of.mass[K])
    of.sums[chunk, RATE] = fastest
