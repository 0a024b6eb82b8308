"""Detection of contact between two velocity fields on the nodes: shared nodes, normals and gaps.

A membrane defines its own normal. The normal of a volume is the gradient of its volume (Bardenhagen, Brackbill & Sulsky
2000, Comput. Methods Appl. Mech. Eng. 187, 529). A membrane that is crumpled within the support of a node has no normal
there; the normal of the adjacent volume is used. Between two volumes, the candidates are the difference of both gradients,
each gradient, and the coordinate axes; the direction with the largest gap is used. At an edge or a corner a gradient is
inclined, and a fluid that slides over it would plough. The sign of the normal follows from the positions of both bodies
relative to the node, because a membrane has two sides and the gradient of a layer thinner than a cell changes sign.

The velocities of two fields interact as soon as both have mass at a node, one cell too early. The surfaces must therefore
touch as well: the gap is the distance along the normal between the foremost points of both bodies at the node (Ma, Zhang &
Huang 2010, CMES 55, 61), reduced by half of the point width or of the membrane thickness on each side.
"""

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import Annotated, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.contact.contact_body import ContactBody, is_membrane
from pellucid.grid.folded_rows import signs_at
from pellucid.grid.folding import first_node_within, nodes_before, seen_from
from pellucid.grid.nodal_conditions import MASS_EPS
from pellucid.grid.nodal_fields import FOUND, MAX, RUN, STEP, SUM, NodalField, fields_of
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, number_at, stencil
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.elementary import cube_root
from pellucid.jit.loops import parallel_loop_by_colour
from pellucid.jit.vector import load, row, splat, store
from pellucid.ranks.domain import OfListed, domain

CLOSE = 0.1
"""Distance at which two membranes touch [cells]. It is smaller than the distance in which a membrane can turn round, and
smaller than a quarter of a cell.

Each membrane therefore stays on its side of the other one. Membranes this thin do not define a side themselves.
"""
SHARES = ((1.0, -1.0), (1.0, 0.0), (0.0, 1.0))
"""Weights of the volume gradients of the first and of the second body. Each weighted sum is a candidate for the contact
normal."""
SMOOTH = 0.7
"""Smallest ratio of the vector area of a membrane at a node to its undeformed area there for which the membrane normal is
used."""
SIGNS = 1.0, -1.0  # sign of the normal towards the outside of the first and of the second side
MARGIN = 1e-6  # margin for rounding, in cells
NORMAL, VOLUME, CENTRE, COLUMNS = 0, 3, 4, 8
"""First columns of the moments of a body at a node (normal, volume, volume times position), and the number of columns,
which form two vectors. For a membrane, `VOLUME` holds its undeformed area."""


class SharedNodes(NamedTuple):
    """Numbering of the nodes shared by two velocity fields; the arrays cover all nodes of the grid."""

    slot: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "number of a node that two fields share, else -1", np.int32)]
    near: Annotated[
        np.ndarray, NodalField(1, FOUND, RUN, "", "1 if a stencil that starts here contains a shared node", np.uint8)
    ]
    box: np.ndarray  # (2, 3) box of the points with weight at a shared node [m]


class NumberedNodes(NamedTuple):
    """Sums and maxima at the nodes shared by two velocity fields, by node number; `several`: one array for each field."""

    moments: Annotated[
        np.ndarray,
        NodalField(COLUMNS, SUM, STEP, "m², m³, m⁴", "normal, volume and centre of a body around the node", several=True),
    ]
    foremost: Annotated[
        np.ndarray, NodalField(1, MAX, STEP, "m", "largest coordinate of a body along the normal", several=True)
    ]


NUMBERED = fields_of(NumberedNodes)


class Areas(NamedTuple):
    """Areas of the points of one body, from which its contact normals follow (see `_sum_moments`); m is the number of
    points."""

    vector: np.ndarray  # (m, 3) outward vector areas [m²]; no rows for a volume, which uses volume gradients
    at_rest: float = 0.0  # undeformed area of a membrane per mass [m²/kg]


OF_VOLUME = Areas(np.zeros((0, 3)))


class ContactDetection:
    """Nodes where two velocity fields are in contact.

    bodies: bodies of the first and of the second field.

    Attributes
    ----------
    node : ndarray, shape (n,)
        Nodes at which both fields have mass, as of the last call of `find`.
    normal : ndarray, shape (n, 3)
        Unit normals from the first to the second field; zero where the fields do not touch.
    gap : ndarray, shape (n,)
        Distance of the surfaces [m].
    """

    def __init__(
        self, fields: tuple[VelocityField, VelocityField], bodies: tuple[Sequence[ContactBody], Sequence[ContactBody]]
    ) -> None:
        self._fields, self._grid, self._bodies = fields, fields[0].grid, bodies
        self._slot, self._near = allocate_numbers(self._grid.n_nodes)
        self._box = np.empty((2, 3))
        self._where = Bundle(SharedNodes(self._slot, self._near, self._box))
        functions = [body.functions for side in bodies for body in side]
        self._reach = tuple(max(function[axis].stencil for function in functions) for axis in range(3))
        # a velocity field with membranes and volumes counts as a volume
        self._surfaces = tuple(int(all(body.is_surface for body in side)) for side in bodies)
        # for each body of both velocity fields, the points with weight at shared nodes
        self._near_points = [[np.empty(body.n_points, np.int64) for body in side] for side in bodies]
        self._close = (CLOSE if self._surfaces == (1, 1) else 0.0) * self._grid.lattice.cell
        self.node, self.normal, self.gap = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)

    def find(self) -> None:
        """Find the nodes where the fields touch, with normals and gaps. Call after mapping the mass to the nodes."""
        first, second = (field.grid.nodes.mass for field in self._fields)
        reached = [field.reached for field in self._fields if field.reached is not None]
        if reached:
            node = min(reached, key=len)
            self.node = node[(first[node] > MASS_EPS) & (second[node] > MASS_EPS)]
        else:
            self.node = np.flatnonzero((first > MASS_EPS) & (second > MASS_EPS))
        n = len(self.node)
        self.normal, self.gap = np.zeros((n, 3)), np.full(n, -np.inf)
        if domain.any(n > 0):
            self._set_box()
            mark_stencils(self.node, self._slot, self._near, self._reach, self._grid.lattice, True)
            self._find_normals(n)
            mark_stencils(self.node, self._slot, self._near, self._reach, self._grid.lattice, False)

    def _set_box(self) -> None:
        """Set the bounding box of the points that can have weight at a shared node of any process."""
        lattice, slow = self._grid.lattice, self._grid.lattice.slab_axis
        middle = 1 if slow == 0 else 0  # the order of the axes in memory
        strides, rest = lattice.strides, self.node % lattice.strides[slow]
        along, across = (rest // strides[middle], rest % strides[middle])
        for axis, place in ((slow, self.node // strides[slow]), (middle, along), (3 - slow - middle, across)):
            lowest = -domain.largest(-float(place.min()) if len(place) else -np.inf)
            highest = domain.largest(float(place.max()) if len(place) else -np.inf)
            wide = 0.5 * self._reach[axis] + MARGIN
            self._box[:, axis] = lattice.lower[axis] + np.array([lowest - wide, highest + wide]) * lattice.cell
            if self._grid.periodic[axis]:  # points may have crossed it any number of times
                self._box[:, axis] = -np.inf, np.inf

    def _find_normals(self, n: int) -> None:
        moments = NUMBERED["moments"].allocate(n, 2)
        for side in range(2):
            self._sum_moments(side, moments[side])
        crumpled = np.zeros(n, bool)
        if sum(self._surfaces) == 1:
            of_membrane = moments[self._surfaces.index(1)]
            crumpled = np.linalg.norm(of_membrane[:, NORMAL:VOLUME], axis=1) < SMOOTH * of_membrane[:, VOLUME]
        for direction in self._directions(moments[0], moments[1], crumpled):
            _orient(moments[0], moments[1], direction)
            foremost = self._foremost(direction)
            gap = -foremost[0] - foremost[1]
            wider = (gap > self.gap) & direction.any(axis=1)
            self.normal[wider], self.gap[wider] = direction[wider], gap[wider]
        self.normal[self.gap > self._close] = 0.0

    def _sum_moments(self, side: int, sums: np.ndarray) -> None:
        for body, near_points in zip(self._bodies[side], self._near_points[side], strict=True):
            areas = OF_VOLUME
            if self._surfaces[side] and is_membrane(body):
                areas = Areas(body.vector_areas(), 1.0 / body.areal_density)
            moments = OfListed(sums.reshape(-1), self.node)
            _sum_moments(body.n_slabs, body.mapped, self._where, areas, moments, near_points)

    def _directions(self, one: np.ndarray, other: np.ndarray, crumpled: np.ndarray) -> Iterator[np.ndarray]:
        """Yield candidates for the contact normals at the shared nodes, of any length and sign, shape (n, 3) each.

        one, other: moments of both sides at the nodes (see `_sum_moments`), shape (n, COLUMNS). crumpled: mask of the nodes
        that use the normal of the volume instead of the membrane normal, shape (n,).
        """
        A, B = one[:, NORMAL:VOLUME], other[:, NORMAL:VOLUME]
        if self._surfaces == (1, 1):
            along = np.sum(A * B, axis=1, keepdims=True)
            yield A + np.where(along > 0.0, B, -B)
        elif self._surfaces != (0, 0):
            yield np.where(crumpled[:, None] == self._surfaces[0], B, A)
        else:
            for a, b in SHARES:
                yield a * A + b * B
            for axis in np.flatnonzero(~np.array(self._grid.thin)):
                yield np.tile(np.eye(3)[axis], (len(A), 1))

    def _foremost(self, normal: np.ndarray) -> np.ndarray:
        """Return, for each shared node, the largest coordinate of the first side along the normal, and of the second side
        along the opposite direction [m], shape (2, n)."""
        foremost = NUMBERED["foremost"].allocate(len(normal), 2)
        for side, sign in enumerate(SIGNS):
            for body, near_points in zip(self._bodies[side], self._near_points[side], strict=True):
                how = self._where, near_points, sign * normal, body.half_width()
                _find_foremost(body.n_slabs, body.mapped, *how, OfListed(foremost[side], self.node))
        return foremost


def allocate_numbers(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return initial arrays `slot` (filled with -1) and `near` (filled with 0) of `SharedNodes` for a grid of n nodes."""
    slot, near = (fields_of(SharedNodes)[name].allocate(n) for name in ("slot", "near"))
    slot.fill(-1)
    return slot, near


@kernel()
def mark_stencils(node, slot, near, reach, lattice, on):
    """Write for each shared node its index in the list `node` to slot[node], and set near[n] to 1 for the first nodes n of
    all stencils that contain a shared node (see `SharedNodes`).

    node: storage indices of the shared nodes. If `on` is False, reset both arrays instead. reach: number of nodes of a
    stencil along each axis. lattice: the grid."""
    for e in range(len(node)):
        I = node[e]
        slot[I] = e if on else -1
        for a in range(reach[0]):
            for b in range(reach[1]):
                for c in range(reach[2]):
                    first = nodes_before(lattice.folding, lattice, I, a, b, c)
                    if first >= 0:
                        near[first] = 1 if on else 0


@pointwise
def _is_beyond(where, x, p):
    """Return True if point p, with position x[p] [m], lies outside `where.box`, the box of points with weight at shared
    nodes (see `SharedNodes`)."""
    box = where.box
    below = x[p, 0] < box[0, 0] or x[p, 1] < box[0, 1] or x[p, 2] < box[0, 2]
    return below or x[p, 0] > box[1, 0] or x[p, 1] > box[1, 1] or x[p, 2] > box[1, 2]


@pointwise
def reach_of_point(radius, volume):
    """Return the distance of the surface of a body from a point with the given volume [m³], i.e. half of the width of the
    point [m]; radius: result of `ContactBody.half_width`."""
    half, scale, exponent = radius
    if half >= 0.0:
        return half
    size = volume * scale
    if exponent == 1.0 / 3.0:
        return 0.5 * cube_root(size)
    return 0.5 * (sqrt(size) if exponent == 0.5 else size)


@parallel_loop_by_colour(gives="moments")
def _sum_moments(s, mapped, where, areas, moments, near_points):
    """Add the contributions of the points of slab s (layers of cells that one thread processes) to the moments of a body at
    each shared node.

    The moments are the vector area (or the volume gradient if `areas` has no rows), the volume, and volume times position.
    mapped: see `ContactBody.mapped`. where: a `SharedNodes`. areas: an `Areas`. moments: an `OfListed` with n·COLUMNS values.
    The indices of the points with weight at shared nodes are written to `near_points`, from the slab's first entry on, followed
    by -1.
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    slot, near, values = where.slot, where.near, moments.values
    x = points.position
    vector = areas.vector
    surface = len(vector) > 0
    listed = slabs.first[s]
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if _is_beyond(where, x, p):
            continue
        about = stencil(functions, lattice, x, p)
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        if near[first_node_within(lattice.folding, about.start)] == 0:
            continue
        near_points[listed] = p
        listed += 1
        V = areas.at_rest * points.mass[p] if surface else points.volume[p]
        shared = row(vector[p, 0], vector[p, 1], vector[p, 2], V) if surface else splat(V)
        place = (x[p, 0], x[p, 1], x[p, 2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0:
                        w, at = wx[a] * wy[b] * wz[c], COLUMNS * e
                        share = (
                            splat(w) if surface else row(gx[a] * wy[b] * wz[c], wx[a] * gy[b] * wz[c], wx[a] * wy[b] * gz[c], w)
                        )
                        signs = signs_at(lattice.folding, number_at(about, lattice, a, b, c))
                        x0, x1, x2 = seen_from(lattice.folding, lattice, about, place, a, b, c)
                        centre = row(V * x0, V * x1, V * x2, 0.0)
                        store(values, at, load(values, at) + share * shared * signs)
                        store(values, at + CENTRE, load(values, at + CENTRE) + w * centre)
    if listed < slabs.first[s + 1]:
        near_points[listed] = -1


@kernel()
def _orient(one, other, normal):
    """Scale the directions in `normal`, shape (n, 3), to unit normals from the first to the second side; zero directions
    stay zero. one, other: moments of both sides, see `_sum_moments`."""
    for e in range(len(normal)):
        length = across = 0.0
        for d in range(3):
            length += normal[e, d] * normal[e, d]
            apart = other[e, CENTRE + d] / other[e, VOLUME] - one[e, CENTRE + d] / one[e, VOLUME]
            across += normal[e, d] * apart
        scale = 0.0
        if length > 0.0:
            scale = 1.0 / sqrt(length) if across >= 0.0 else -1.0 / sqrt(length)
        for d in range(3):
            normal[e, d] *= scale


@parallel_loop_by_colour(gives="foremost")
def _find_foremost(s, mapped, where, near_points, direction, radius, foremost):
    """Compute, at each shared node, the largest coordinate of a body along a direction [m]: of the points of slab s with weight
    at the node, plus the half-width of each point.

    mapped, where, near_points: see `_sum_moments`. direction: unit vectors at the nodes, shape (n, 3). radius: result of
    `ContactBody.half_width`. foremost: an `OfListed` of shape (n,), in which larger values replace smaller ones.
    """
    functions, lattice, slot = mapped.functions, mapped.lattice, where.slot
    points, slabs = mapped.points, mapped.slabs
    surface, x = radius[0] >= 0.0, points.position
    for q in range(slabs.first[s], slabs.first[s + 1]):
        if near_points[q] < 0:
            break
        p = uintp(near_points[q])
        about = stencil(functions, lattice, x, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        r, position = radius[0] if surface else reach_of_point(radius, points.volume[p]), (x[p, 0], x[p, 1], x[p, 2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0 and wx[a] * wy[b] * wz[c] > 0.0:
                        x0, x1, x2 = seen_from(lattice.folding, lattice, about, position, a, b, c)
                        place = x0 * direction[e, 0] + x1 * direction[e, 1] + x2 * direction[e, 2]
                        foremost.values[e] = max(foremost.values[e], place + r)
