"""Bending of closed membranes of triangles: Jülicher's energy and its exact derivative.

At a node i, M_i = ½ Σ_edges l φ is the integral of the sum of the principal curvatures 2H. The sum is over the edges of
length l around the node; φ is the angle between the normals of the two triangles at an edge, positive if the normals
diverge. A_i is a third of the area of the triangles around the node. The energy

    E = Σ_i κ/2 (M_i - c_i A_i)²/A_i,    g_i = (M_i - c_i A_i)/A_i,
    dE = Σ_edges κ ½ (g_a + g_b)(φ dl + l dφ) - Σ_i κ (c_i g_i + ½ g_i²) dA_i

depends on the shape alone, so that the sum of its forces and the sum of its torques are zero. Open surfaces:
`plate_bending`.
Source: Jülicher 1996, J. Phys. II France 6, 1797, eq. 23, with c_i; of six schemes none has curvatures that converge at
every node (Guckenberger et al. 2016, Comput. Phys. Commun. 207, 1).

The largest eigenfrequency of the nodes is bounded by the rows of Σ_i κ/A_i |∂M_i/∂x_j| |∂M_i/∂x_k| divided by the mass of
node j, with sums over hinges of |∂φ/∂x|. The bound is 2.5 to 2.7 times too high on nearly equal triangles.
"""

from math import atan2, sqrt
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.bodies.membrane_elements.geometry import area_slopes, cross, dot, edges
from pellucid.bodies.membrane_elements.mesh import Fan, fan_of, hinges_of, incidence
from pellucid.jit import pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.reductions import ordered_sum

CHUNK = 512  # hinges, triangles or nodes
ENERGY, RATE, SUMS = range(3)  # columns of the sums of a chunk
OWN = 4  # columns of the values of a corner of a hinge: force and stiffness bound


class Hinges(NamedTuple):
    """Data of the bending kernels of a closed membrane with h hinges (pairs of triangles with a common edge), t triangles
    and n nodes: mesh, properties of the membrane, and results of the kernels, in mesh order unless stated otherwise.

    Symbols: l, length of the edge of a hinge; φ, angle between the normals of its triangles; A, a third of the area of the
    triangles around a node; g = M/A - c, with M = ½ Σ l φ over the edges around the node.
    """

    corners: np.ndarray  # (h, 4) nodes a and b of the edge, then the third node of the triangle on its left and on its right
    triangles: np.ndarray  # (t, 3) nodes
    places: np.ndarray  # (h, 4) storage rows of the corners of the hinges
    triangle_places: np.ndarray  # (t, 3) storage rows of the corners of the triangles
    where: np.ndarray  # (n,) storage row of each node
    about: Fan  # hinge corners around each node, as 4 e + corner for hinge e
    round: Fan  # triangle corners around each node, as 3 e + corner for triangle e
    rigidity: float  # κ [J]
    reference: np.ndarray  # (n,) spontaneous curvature c [1/m]
    mass: np.ndarray  # (n,) nodal masses [kg]
    bent: np.ndarray  # (h, 2) l φ [m], and Σ_corners ½ l |∇φ|
    slope: np.ndarray  # (n, 3) κ g, κ (c g + ½ g²), κ/A Σ_hinges ½ l |∇φ|
    energy: np.ndarray  # (n,) bending energies of the nodes [J]
    hinge_values: np.ndarray  # (h, 4, OWN) forces on the corners [N] and stiffness bounds [N/m]
    triangle_forces: np.ndarray  # (t, 3, 3) forces on the corners [N]
    sums: np.ndarray  # (chunks of nodes, SUMS) energy and largest squared eigenfrequency bound


class Bending:
    """Computes bending energy and forces of a closed membrane of triangles with the energy κ/2 (2H - c)² per unit area. The
    sum of the principal curvatures at a node, 2H, is ½ Σ l φ over the edges around the node (length l, angle φ between the
    normals of the triangles), divided by the area around the node."""

    def __init__(self, triangles: np.ndarray, vertices: np.ndarray, mass: np.ndarray, rigidity: float) -> None:
        """triangles: shape (t, 3); vertices: initial positions [m], shape (n, 3); mass: nodal masses [kg], shape (n,);
        rigidity: bending rigidity κ [J].
        """
        n, corners = len(vertices), hinges_of(triangles)
        self._corners, self._triangles, self._mass, self.rigidity = corners, triangles, mass, rigidity
        self._about, self._round = fan_of(corners, n), fan_of(triangles, n)
        self._chunks = [(len(part) + CHUNK - 1) // CHUNK for part in (corners, triangles, vertices)]
        self.reference = np.zeros(n)
        self.energies = np.zeros(n)
        self.rate = 0.0
        """Upper bound of half the largest eigenfrequency of the nodes [1/s]."""
        self._bent: tuple[np.ndarray, np.ndarray] | None = None  # positions and reference of the last evaluation
        self.bind(np.arange(n))

    def bind(self, where: np.ndarray) -> None:
        """Set the storage row of each node, `where`, shape (n,), in the order of the node numbers; positions and forces are
        stored in these rows.
        """
        h, t, n = len(self._corners), len(self._triangles), len(self._mass)
        self._bent = None
        self._sums = np.zeros((self._chunks[2], SUMS))
        self._slope = np.zeros((n, 3))
        room = np.zeros((h, 2)), self._slope, self.energies, np.zeros((h, 4, OWN)), np.zeros((t, 3, 3)), self._sums
        stored = where[self._corners], where[self._triangles], where
        mesh = self._corners, self._triangles, *stored, self._about, self._round
        self._bundle = Bundle(Hinges(*mesh, self.rigidity, self.reference, self._mass, *room))

    def curvatures(self, position: np.ndarray) -> np.ndarray:
        """Return the sum of the principal curvatures at the nodes [1/m], shape (n,), in mesh order. position: nodal positions
        in storage order [m], shape (n, 3).
        """
        self._bend(position)
        return self._slope[:, 0] / self.rigidity + self.reference

    def energy(self, position: np.ndarray) -> float:
        """Return the bending energy [J] for nodes at these positions [m], shape (n, 3), in storage order."""
        self._bend(position)
        return float(ordered_sum(self._sums)[ENERGY])

    def add_forces(self, position: np.ndarray, target: np.ndarray) -> None:
        """Add the nodal forces of bending [N] at these positions [m] to `target`, shape (n, 3) both, in storage order, and
        update `rate`, the upper bound of half the largest eigenfrequency of the nodes [1/s]."""
        self._bend(position)
        _push_hinges(self._chunks[0], self._bundle, position)
        _push_triangles(self._chunks[1], self._bundle, position)
        _gather(self._chunks[2], self._bundle, target)
        self.rate = 0.5 * sqrt(float(self._sums[:, RATE].max()))

    def linked_nodes(self) -> csr_array:
        of_hinges = incidence(self._corners, len(self._mass))
        at_ends = incidence(self._corners[:, :2], len(self._mass))  # the curvature of a node is that of its edges
        return csr_array(at_ends.T @ of_hinges)

    def _bend(self, position: np.ndarray) -> None:
        # a step asks for the energy and then for the forces of the same positions
        if self._bent and np.array_equal(self._bent[0], position) and np.array_equal(self._bent[1], self.reference):
            return
        _bend_hinges(self._chunks[0], self._bundle, position)
        _bend_nodes(self._chunks[2], self._bundle, position)
        self._bent = position.copy(), self.reference.copy()


@pointwise
def _unfolded(x, places, e):
    """Return the vectors of hinge e (an edge and its two triangles): the edge, the vectors from its start to the left and
    right corners, and the normals of both triangles. x: nodal positions [m]; places: storage rows of the four nodes of each
    hinge.
    """
    a, b, c, d = places[e, 0], places[e, 1], places[e, 2], places[e, 3]
    along = (x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2])
    left = (x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2])
    right = (x[d, 0] - x[a, 0], x[d, 1] - x[a, 1], x[d, 2] - x[a, 2])
    return along, left, right, cross(along, left), cross(right, along)


@parallel_loop()
def _bend_hinges(chunk, of, x):
    """Compute for each hinge (pair of triangles with a common edge) of a chunk the length l of the edge times the angle φ
    between the normals of the triangles, and ½ l times the sum of |∂φ/∂x| over the four corners x of the hinge.

    of: data of `Hinges`, to which the results are written; x: nodal positions [m], shape (n, 3).
    """
    places, bent = of.places, of.bent
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(places))):
        along, left, right, n1, n2 = _unfolded(x, places, e)
        square = dot(along, along)
        length = sqrt(square)
        bent[e, 0] = length * atan2(dot(along, cross(n1, n2)) / length, dot(n1, n2))
        # |∂φ/∂x| is l over twice the area of the triangle across, and follows from both at the ends of the edge
        one, two = length / sqrt(dot(n1, n1)), length / sqrt(dot(n2, n2))
        s, t = dot(left, along) / square, dot(right, along) / square
        bent[e, 1] = 0.5 * length * (one * (1.0 + abs(s) + abs(1.0 - s)) + two * (1.0 + abs(t) + abs(1.0 - t)))


@parallel_loop()
def _bend_nodes(chunk, of, x):
    """Compute the bending energies of a chunk of nodes, and the derivatives of the energy with respect to ½ Σ l φ over the
    edges around a node (length l, angle φ between the normals of the triangles), which is the integral of the curvature 2H,
    and to the area around the node.

    of: data of `Hinges`, to which the results are written; x: nodal positions [m], shape (n, 3).
    """
    bent, slope, triangles = of.bent, of.slope, of.triangle_places
    about, whole, total = of.about, of.round, 0.0
    for K in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(slope))):
        curved = reach = area = 0.0
        for k in range(about.start[K], about.start[K + 1]):
            e, corner = about.places[k] // 4, about.places[k] % 4
            if corner < 2:
                curved += 0.5 * bent[e, 0]
                reach += bent[e, 1]
        for k in range(whole.start[K], whole.start[K + 1]):
            e = whole.places[k] // 3
            chi, psi = edges(x, triangles, e)
            n = cross(chi, psi)
            area += sqrt(dot(n, n)) / 6.0
        g = curved / area - of.reference[K]
        slope[K, 0] = of.rigidity * g
        slope[K, 1] = of.rigidity * g * (of.reference[K] + 0.5 * g)
        slope[K, 2] = of.rigidity * reach / area
        of.energy[K] = 0.5 * of.rigidity * g * g * area
        total += of.energy[K]
    of.sums[chunk, ENERGY] = total


@parallel_loop()
def _push_hinges(chunk, of, x):
    """Compute the bending forces of the hinges of a chunk on their four nodes, and the terms that limit the time step. of:
    data of `Hinges`, to which the results are written; x: nodal positions [m], shape (n, 3).
    """
    corners, places, values, slope = of.corners, of.places, of.hinge_values, of.slope
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        along, left, right, n1, n2 = _unfolded(x, places, e)
        square = dot(along, along)
        length = sqrt(square)
        one, two = length / dot(n1, n1), length / dot(n2, n2)
        s, t = dot(left, along) / square, dot(right, along) / square
        mean = 0.5 * (slope[corners[e, 0], 0] + slope[corners[e, 1], 0])
        pull = mean * of.bent[e, 0] / square  # of the change of length, over the length
        turn = mean * length  # of the change of angle; that of corner c is -n₁ l/|n₁|²
        for i in range(3):
            across, beyond = turn * one * n1[i], turn * two * n2[i]
            values[e, 2, i], values[e, 3, i] = across, beyond
            values[e, 0, i] = pull * along[i] - (1.0 - s) * across - (1.0 - t) * beyond
            values[e, 1, i] = -pull * along[i] - s * across - t * beyond
        stiff = 0.5 * length * (slope[corners[e, 0], 2] + slope[corners[e, 1], 2])
        p, q = one * sqrt(dot(n1, n1)), two * sqrt(dot(n2, n2))  # |∂φ/∂x| at the corners across
        values[e, 2, 3], values[e, 3, 3] = stiff * p, stiff * q
        values[e, 0, 3] = stiff * (abs(1.0 - s) * p + abs(1.0 - t) * q)
        values[e, 1, 3] = stiff * (abs(s) * p + abs(t) * q)


@parallel_loop()
def _push_triangles(chunk, of, x):
    """Compute the forces on the corners of a chunk of triangles due to the change of energy with area. of: data of `Hinges`,
    to which the results are written; x: nodal positions [m], shape (n, 3).
    """
    triangles, forces, slope = of.triangles, of.triangle_forces, of.slope
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(triangles))):
        chi, psi = edges(x, of.triangle_places, e)
        at_b, at_c = area_slopes(chi, psi)
        share = (slope[triangles[e, 0], 1] + slope[triangles[e, 1], 1] + slope[triangles[e, 2], 1]) / 3.0
        for i in range(3):
            forces[e, 1, i], forces[e, 2, i] = share * at_b[i], share * at_c[i]
            forces[e, 0, i] = -share * (at_b[i] + at_c[i])


@pointwise
def gather_hinges(about, values, K, target, p):
    """Add the forces of the hinges (pairs of triangles with a common edge) around node K to row p of `target`, the storage row
    of the node. Returns the upper bound of the node's stiffness [N/m].

    about: list of the hinges around each node; values: forces [N] and stiffness bounds [N/m] of the hinges at their corners,
    shape (h, 4, columns).
    """
    stiff = 0.0
    for k in range(about.start[K], about.start[K + 1]):
        e, corner = about.places[k] // 4, about.places[k] % 4
        for i in range(3):
            target[p, i] += values[e, corner, i]
        stiff += values[e, corner, 3]
    return stiff


@parallel_loop()
def _gather(chunk, of, target):
    """Sum the bending forces at a chunk of nodes into `target`, shape (n, 3), and compute the largest ratio of stiffness bound
    to mass, the square of the bound on the eigenfrequency. of: data of `Hinges`.
    """
    whole, forces, fastest = of.round, of.triangle_forces, 0.0
    for K in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(of.where))):
        p = of.where[K]
        stiff = gather_hinges(of.about, of.hinge_values, K, target, p)
        for k in range(whole.start[K], whole.start[K + 1]):
            e, corner = whole.places[k] // 3, whole.places[k] % 3
            for i in range(3):
                target[p, i] += forces[e, corner, i]
        fastest = max(fastest, stiff / of.mass[K])
    of.sums[chunk, RATE] = fastest
