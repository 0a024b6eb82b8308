"""Where two velocity fields meet: the nodes that both reach, the normal there, and how far apart the surfaces are.

A surface gives its own normal, a volume the gradient of its volume (Bardenhagen, Brackbill & Sulsky 2000, Comput. Methods Appl.
Mech. Eng. 187, 529). Between two volumes the difference of their gradients, each of the two, and the axes are tried, and the
one along which they lie furthest apart separates them: the gradient at an edge or a corner leans, and sliding over it would
plough. Which way the normal points is told by where the two bodies lie about the node: a membrane has two sides, and a layer
thinner than a cell turns its gradient round.

The velocities of two fields approach as soon as both reach a node, a cell too early. So the surfaces must touch too: the
distance along the normal between the foremost points of both about the node (Ma, Zhang & Huang 2010, CMES 55, 61), each with
half of its point's width, or of the membrane's thickness.
"""

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import Any

import numpy as np
from numba import prange
from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.bundle import Bundle
from pellucid.grid.grid import Grid
from pellucid.grid.motion import CHUNK, NOTHING
from pellucid.jit import kernel

CLOSE = 0.1
"""Distance in cells at which two membranes touch: less than one may turn round in, and than a quarter of a cell.

It leaves each a side of the other: sheets as thin as these do not tell by themselves from which side they met.
"""
SHARES = ((1.0, -1.0), (1.0, 0.0), (0.0, 1.0))
"""Of the gradients of two volumes in the normals that are tried."""
NORMAL, CENTRE, VOLUME, COLUMNS = 0, 3, 6, 7  # columns of an outline


@kernel()
def _count_chunk(first, second, counts, chunk):
    found = 0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(first))):
        if first[I] > NOTHING and second[I] > NOTHING:
            found += 1
    counts[chunk] = found


@kernel(parallel=True)
def _count(chunks, first, second, counts):
    for chunk in prange(chunks):
        _count_chunk(first, second, counts, chunk)


@kernel()
def _list_chunk(first, second, start, node, chunk):
    n = start[chunk]
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(first))):
        if first[I] > NOTHING and second[I] > NOTHING:
            node[n] = I
            n += 1


@kernel(parallel=True)
def _list(chunks, first, second, start, node):
    for chunk in prange(chunks):
        if start[chunk + 1] > start[chunk]:
            _list_chunk(first, second, start, node, chunk)


@kernel()
def _mark(node, slot, near, reach, strides, on):
    """Number the nodes in `slot`, and flag the first nodes of all stencils that hold one of them; or take both back."""
    for e in range(len(node)):
        I = node[e]
        slot[I] = e if on else -1
        for a in range(reach[0]):
            for b in range(reach[1]):
                for c in range(reach[2]):
                    first = I - a * strides[0] - b * strides[1] - c * strides[2]
                    if first >= 0:
                        near[first] = 1 if on else 0


@kernel()
def _outline_slab(mapped, where, areas, outline, beside, s):
    """Sums about each numbered node: volume gradients (or, where there are `areas`, these), places and volumes.

    The points that reach such nodes are listed in `beside` from the slab's first one on, and after them -1.
    """
    fn, _, lattice, _, points, slabs, _ = mapped.content
    slot, near = where.content
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    surface = len(areas) > 0
    listed = slabs.first[s]
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, gx = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, gy = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, gz = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        start = i * stride[0] + j * stride[1] + k * stride[2]
        if near[start] == 0:
            continue
        beside[listed] = signed
        listed += 1
        V = points.mass[p] if surface else points.volume[p]
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[start + a * stride[0] + b * stride[1] + c * stride[2]]
                    if e >= 0:
                        w = wx[a] * wy[b] * wz[c]
                        if surface:
                            for d in range(3):
                                outline[e, NORMAL + d] += w * areas[p, d]
                        else:
                            outline[e, NORMAL] += V * gx[a] * wy[b] * wz[c]
                            outline[e, NORMAL + 1] += V * wx[a] * gy[b] * wz[c]
                            outline[e, NORMAL + 2] += V * wx[a] * wy[b] * gz[c]
                        for d in range(3):
                            outline[e, CENTRE + d] += w * V * x[p, d]
                        outline[e, VOLUME] += w * V
    if listed < slabs.first[s + 1]:
        beside[listed] = -1


@kernel(parallel=True)
def _outline(n, mapped, where, areas, outline, beside):
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _outline_slab(mapped, where, areas, outline, beside, 2 * half + colour)


@kernel()
def _orient(one, other, normal):
    """Make of directions unit normals from one side to the other; zero where there is none."""
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


@kernel()
def _reach_slab(mapped, beside, slot, normal, radius, foremost, sign, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    half, scale, exponent = radius
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        if beside[signed] < 0:
            break
        p = uintp(beside[signed])
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        start = i * stride[0] + j * stride[1] + k * stride[2]
        r = half if half >= 0.0 else 0.5 * (points.volume[p] * scale) ** exponent
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[start + a * stride[0] + b * stride[1] + c * stride[2]]
                    if e >= 0 and wx[a] * wy[b] * wz[c] > 0.0:
                        along = x[p, 0] * normal[e, 0] + x[p, 1] * normal[e, 1] + x[p, 2] * normal[e, 2]
                        foremost[e] = max(foremost[e], sign * along + r)


@kernel(parallel=True)
def _reach(n, mapped, beside, slot, normal, radius, foremost, sign):
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _reach_slab(mapped, beside, slot, normal, radius, foremost, sign, 2 * half + colour)


class Meeting:
    """The nodes where two fields meet.

    bodies: those of either field. `node` (n,), `normal` (n, 3) from the first field to the second, zero where they do not
    touch, and `gap` (n,), the distance of the surfaces [m], are of the step for which `find` was called last.
    """

    def __init__(self, grids: tuple[Grid, Grid], bodies: tuple[Sequence[Any], Sequence[Any]]) -> None:
        self._grids, self._bodies = grids, bodies
        n = grids[0].n_nodes
        self._chunks = (n + CHUNK - 1) // CHUNK
        self._counts = np.zeros(self._chunks, np.int64)
        self._slot, self._near = np.full(n, -1, np.int32), np.zeros(n, np.uint8)
        self._where = Bundle(self._slot, self._near)
        functions = [body.functions for side in bodies for body in side]
        self._reach = tuple(max(function[axis].stencil for function in functions) for axis in range(3))
        # a membrane beside a volume in one field counts as a volume too
        self._surfaces = tuple(int(all(body.is_surface for body in side)) for side in bodies)
        self._beside: list[list[np.ndarray]] = []  # of the points of either field's bodies, those that reach the nodes
        self._close = CLOSE if self._surfaces == (1, 1) else 0.0
        self.node, self.normal, self.gap = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)

    def find(self) -> None:
        """Find where the fields meet now, after the bodies gave their mass to the nodes."""
        one, other = (grid.nodes.mass for grid in self._grids)
        _count(self._chunks, one, other, self._counts)
        start = np.concatenate(([0], np.cumsum(self._counts)))
        self.node = np.empty(start[-1], np.int64)
        _list(self._chunks, one, other, start, self.node)
        n = len(self.node)
        self.normal, self.gap = np.zeros((n, 3)), np.zeros(n)
        if n:
            strides = self._grids[0].lattice.strides
            _mark(self.node, self._slot, self._near, self._reach, strides, True)
            self._measure(n)
            _mark(self.node, self._slot, self._near, self._reach, strides, False)

    def _measure(self, n: int) -> None:
        outlines = np.zeros((2, n, COLUMNS))
        self._beside = [[np.empty(body.n_points, np.int64) for body in side] for side in self._bodies]
        for side, besides, surface, outline in zip(self._bodies, self._beside, self._surfaces, outlines, strict=True):
            for body, beside in zip(side, besides, strict=True):
                areas = body.vector_areas() if surface else np.zeros((0, 3))
                _outline(body.n_slabs, body.mapped, self._where, areas, outline, beside)
        self.gap.fill(-np.inf)
        for normal in self._directions(*outlines):
            _orient(outlines[0], outlines[1], normal)
            gap = self._distance(normal)
            better = (gap > self.gap) & normal.any(axis=1)
            self.normal[better], self.gap[better] = normal[better], gap[better]
        self.normal[self.gap > self._close * self._grids[0].lattice.cell] = 0.0

    def _directions(self, one: np.ndarray, other: np.ndarray) -> Iterator[np.ndarray]:
        """Directions that may be normals, of any length and either way, each of shape (n, 3)."""
        A, B = one[:, NORMAL:CENTRE], other[:, NORMAL:CENTRE]
        if self._surfaces == (1, 1):
            along = np.sum(A * B, axis=1, keepdims=True)
            yield A + np.where(along > 0.0, B, -B)
        elif self._surfaces != (0, 0):
            yield (A if self._surfaces[0] else B).copy()
        else:
            for a, b in SHARES:
                yield a * A + b * B
            for axis in np.flatnonzero(~np.array(self._grids[0].thin)):
                yield np.tile(np.eye(3)[axis], (len(A), 1))

    def _distance(self, normal: np.ndarray) -> np.ndarray:
        foremost = np.full((2, len(normal)), -np.inf)
        for side, besides, ends, sign in zip(self._bodies, self._beside, foremost, (1.0, -1.0), strict=True):
            for body, beside in zip(side, besides, strict=True):
                _reach(body.n_slabs, body.mapped, beside, self._slot, normal, body.half_width(), ends, sign)
        return -foremost[0] - foremost[1]
