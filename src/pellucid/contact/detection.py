"""Contact detection between two velocity fields: the nodes that both reach, the normals, the gaps.

A surface gives its own normal, a volume the gradient of its volume (Bardenhagen, Brackbill & Sulsky 2000, Comput. Methods Appl.
Mech. Eng. 187, 529). A surface that is crumpled within the reach of a node has no normal there, and takes that of the volume
that it touches. Between two volumes the difference of their gradients, each of the two, and the axes are tried, and the
one along which they lie furthest apart separates them: the gradient at an edge or a corner leans, and sliding over it would
plough. Which way the normal points follows from where the two bodies lie about the node: a membrane has two sides, and a layer
thinner than a cell turns its gradient round.

The velocities of two fields approach as soon as both reach a node, a cell too early. So the surfaces must touch too: the
distance along the normal between the foremost points of both about the node (Ma, Zhang & Huang 2010, CMES 55, 61), each with
half of its point's width, or of the membrane's thickness.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.contact import normals, shared
from pellucid.contact.contact_body import ContactBody, is_membrane
from pellucid.contact.normals import NORMAL, VOLUME, Along, Areas, NumberedNodes
from pellucid.grid.nodal_fields import fields_of
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import OfListed, domain

CLOSE = 0.1
"""Distance in cells at which two membranes touch: less than one may turn round in, and than a quarter of a cell.

So each keeps its side of the other: sheets as thin as these do not tell by themselves from which side they came.
"""
SHARES = ((1.0, -1.0), (1.0, 0.0), (0.0, 1.0))
"""Of the gradients of two volumes in the normals that are tried."""
NUMBERED = fields_of(NumberedNodes)
SMOOTH = 0.7
"""Least sum of a membrane's vector areas about a node, over its area at rest there, with which it has a normal of its own."""
SIGNS = 1.0, -1.0  # of the normals, along which the first and the second side reach
OF_VOLUME = Areas(np.zeros((0, 3)))


class ContactDetection:
    """The nodes where two velocity fields touch.

    bodies: those of either field. `node` (n,), `normal` (n, 3) from the first field to the second, zero where they do not
    touch, and `gap` (n,), the distance of the surfaces [m], are of the step for which `find` was called last.
    """

    def __init__(
        self, fields: tuple[VelocityField, VelocityField], bodies: tuple[Sequence[ContactBody], Sequence[ContactBody]]
    ) -> None:
        self._fields, self._grid, self._bodies = fields, fields[0].grid, bodies
        n = self._grid.n_nodes
        self._shared = np.empty(n, np.int64)
        self._slot, self._near = shared.no_numbers(n)
        self._box = np.empty((2, 3))
        self._where = Bundle(shared.SharedNodes(self._slot, self._near, self._box))
        functions = [body.functions for side in bodies for body in side]
        self._reach = tuple(max(function[axis].stencil for function in functions) for axis in range(3))
        # a membrane beside a volume in one velocity field counts as a volume too
        self._surfaces = tuple(int(all(body.is_surface for body in side)) for side in bodies)
        # of the points of the bodies of either velocity field, those that reach the nodes
        self._beside = [[np.empty(body.n_points, np.int64) for body in side] for side in bodies]
        self._close = CLOSE if self._surfaces == (1, 1) else 0.0
        self.node, self.normal, self.gap = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)

    def find(self) -> None:
        """Find where the velocity fields touch, after the bodies' mass was mapped to the nodes."""
        masses = [field.grid.nodes.mass for field in self._fields]
        reached = [field.reached for field in self._fields if field.reached is not None]
        if reached:
            n = shared.list_shared_of(min(reached, key=len), *masses, self._shared)
        else:
            n = shared.list_shared(*masses, self._shared)
        self.node = self._shared[:n]
        self.normal, self.gap = np.zeros((n, 3)), np.full(n, -np.inf)
        if domain.any(n > 0):
            lattice = self._grid.lattice
            shared.mark_stencils(self.node, self._slot, self._near, self._reach, lattice, True)
            shared.bounding_box(self._extent(), lattice, self._reach, self._box)
            self._measure(n)
            shared.mark_stencils(self.node, self._slot, self._near, self._reach, lattice, False)

    def _extent(self) -> np.ndarray:
        """Nodes with the extent of those of all processes along each axis."""
        if not domain.is_cut:
            return self.node
        strides, rest, ends = self._grid.lattice.strides, self.node, np.zeros(2, np.int64)
        for axis in np.argsort(strides)[::-1]:
            place, rest = rest // strides[axis], rest % strides[axis]
            first = -domain.largest(float(-place.min()) if len(place) else -np.inf)
            last = domain.largest(float(place.max()) if len(place) else -np.inf)
            ends += strides[axis] * np.array([first, last]).astype(np.int64)
        return ends

    def _listed(self, values: np.ndarray) -> OfListed:
        return OfListed(values, self.node)

    def _measure(self, n: int) -> None:
        moments = NUMBERED["moments"].allocate(n, 2)
        for side in range(2):
            self._sum_moments(side, moments[side])
        crumpled = np.zeros(n, bool)
        if sum(self._surfaces) == 1:
            of_membrane = moments[self._surfaces.index(1)]
            crumpled = np.linalg.norm(of_membrane[:, NORMAL:VOLUME], axis=1) < SMOOTH * of_membrane[:, VOLUME]
        for direction in self._directions(moments[0], moments[1], crumpled):
            normals.orient(moments[0], moments[1], direction)
            normals.keep_widest_gap(direction, self._foremost(direction), self.normal, self.gap)
        normals.drop_open_gaps(self.gap, self._close * self._grid.lattice.cell, self.normal)

    def _sum_moments(self, side: int, sums: np.ndarray) -> None:
        for body, beside in zip(self._bodies[side], self._beside[side], strict=True):
            areas = OF_VOLUME
            if self._surfaces[side] and is_membrane(body):
                areas = Areas(body.vector_areas(), 1.0 / body.areal_density)
            normals.sum_moments(body.n_slabs, body.mapped, self._where, areas, self._listed(sums.reshape(-1)), beside)

    def _directions(self, one: np.ndarray, other: np.ndarray, crumpled: np.ndarray) -> Iterator[np.ndarray]:
        """Directions that may be normals, of any length and either way, each of shape (n, 3).

        crumpled, shape (n,): where a membrane takes the normal of the volume that it touches.
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
        """How far the first side reaches along the normals, and the second against them [m], shape (2, n)."""
        foremost = NUMBERED["foremost"].allocate(len(normal), 2)
        for side in range(2):
            for body, beside in zip(self._bodies[side], self._beside[side], strict=True):
                how = self._where, beside, Along(normal, SIGNS[side]), body.half_width()
                normals.foremost_along(body.n_slabs, body.mapped, *how, self._listed(foremost[side]))
        return foremost
