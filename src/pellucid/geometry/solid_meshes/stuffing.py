"""Isosurface stuffing: tetrahedra that fill a region, from a body-centred lattice cut at the boundary."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.quality import dihedral_angles
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh, faces_of_cells
from pellucid.geometry.solid_meshes.box import Counts, box_mesh

Contains = Callable[[np.ndarray], np.ndarray]
Corners = tuple[np.ndarray, ...]

HALVINGS = 36  # bisections of an edge that crosses the boundary, which locate the crossing to 1e-11 of its length
NEAR_LONG, NEAR_SHORT = 0.24999, 0.41189
"""Nodes closer to the boundary are moved there: fractions of a cube edge and of an edge from a corner to a centre (Labelle
& Shewchuk 2007, for the best bound on dihedral angles)."""
LONG = 0.9  # of a cube edge: longer lattice edges are cube edges, the others have a length of 0.87
_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


class _Cuts(NamedTuple):
    """Sorted edges of the lattice that cross the boundary of the region, from a node inside to a node outside."""

    inner: np.ndarray  # (k,) number of the node inside the region
    outer: np.ndarray  # (k,) number of the node outside the region
    place: np.ndarray  # (k, 3) position at which the edge crosses the boundary [m]
    share: np.ndarray  # (k,) distance of the crossing from the inner node, as a fraction of the edge


def stuffed(contains: Contains, lower: np.ndarray, counts: Counts, size: float) -> SimplexMesh:
    """Return a tetrahedral mesh of the part of a region that lies in a box of cubes with edge `size` [m], whose lower corner
    is `lower` [m]; counts: number of cubes along each axis.

    `contains` returns a mask of the points [m], shape (n, 3), that lie inside, shape (n,). Boundary nodes lie on the
    boundary of the region. Its sharp edges are cut off within a cube; the faces of the box stay flat with sharp edges.
    Raises ValueError if no node of the lattice lies inside.

    Source: Labelle & Shewchuk 2007, ACM Transactions on Graphics 26, 57; but quadrilaterals are divided from their deeper
    corner, which in tests gave larger angles than the guaranteed 10.7 degrees.
    """
    lattice = box_mesh(lower, lower + size * np.array(counts), counts)
    nodes, sign = lattice.nodes.copy(), np.where(contains(lattice.nodes), 1, -1)
    if not (sign > 0).any():
        raise Refusal(f"`size` = {size:g} m is too large: no node of the lattice lies inside the region", "decrease `size`")
    cuts = _cuts(contains, nodes, lattice.cells, sign)
    places = np.round((nodes - lower) / (0.5 * size)).astype(int)
    _move(nodes, sign, cuts, _limits(nodes, cuts, size), (places == 0, places == 2 * np.array(counts)))
    left = (sign[cuts.inner] != 0) & (sign[cuts.outer] != 0)
    cuts = _Cuts(*(part[left] for part in cuts))
    cells = lattice.cells[(sign[lattice.cells] > 0).any(axis=1)]
    cut = (sign[cells] < 0).any(axis=1)
    whole = np.concatenate([cells[~cut], _pieces(nodes, cells[cut], sign, cuts)])
    moved = np.append(sign == 0, np.zeros(len(cuts.place), bool))
    every = np.concatenate([nodes, cuts.place])
    return _upright(every, _joined(every, whole, lattice.cells[(sign[lattice.cells] == 0).all(axis=1)], moved))


def _cuts(contains: Contains, nodes: np.ndarray, cells: np.ndarray, sign: np.ndarray) -> _Cuts:
    mixed = cells[np.abs(sign[cells].sum(axis=1)) < 4]
    pairs = mixed[:, _PAIRS].reshape(-1, 2)
    pairs = pairs[sign[pairs[:, 0]] != sign[pairs[:, 1]]]
    pairs = np.where((sign[pairs[:, 0]] < 0)[:, None], pairs[:, ::-1], pairs)
    inner, outer = np.divmod(np.unique(pairs[:, 0] * len(nodes) + pairs[:, 1]), len(nodes))
    start, edge = nodes[inner], nodes[outer] - nodes[inner]
    low, high = np.zeros(len(inner)), np.ones(len(inner))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        found = contains(start + middle[:, None] * edge)
        low, high = np.where(found, middle, low), np.where(found, high, middle)
    share = 0.5 * (low + high)
    return _Cuts(inner, outer, start + share[:, None] * edge, share)


def _limits(nodes: np.ndarray, cuts: _Cuts, size: float) -> np.ndarray:
    """Return, for each edge in `cuts`, the distance from the boundary within which an end of the edge is moved to the
    boundary, as a fraction of the edge, shape (k,). nodes [m], shape (n, 3); size: edge of the cubes [m]."""
    length = np.linalg.norm(nodes[cuts.outer] - nodes[cuts.inner], axis=1)
    return np.where(length > LONG * size, NEAR_LONG, NEAR_SHORT)


def _move(nodes: np.ndarray, sign: np.ndarray, cuts: _Cuts, limits: np.ndarray, faces: tuple[np.ndarray, np.ndarray]) -> None:
    """Move nodes near the boundary onto it, each along its shortest cut edge, and set their sign (1 inside, -1 outside,
    shape (n,)) to 0. cuts: the cut edges; limits: as `_limits` returns them.

    A node on a face of the box (faces: masks of the lower and upper faces, shape (n, 3) each) stays on it. A moved node
    is no longer the end of a cut edge.
    """
    node, other = np.concatenate([cuts.inner, cuts.outer]), np.concatenate([cuts.outer, cuts.inner])
    share, edge = np.concatenate([cuts.share, 1.0 - cuts.share]), np.tile(np.arange(len(cuts.inner)), 2)
    near = share < limits[edge]
    for face in faces:
        near &= (face[other] | ~face[node]).all(axis=1)
    node, other, edge = node[near], other[near], edge[near]
    order = np.lexsort((np.linalg.norm(cuts.place[edge] - nodes[node], axis=1), node))
    for a, b, k in zip(node[order].tolist(), other[order].tolist(), edge[order].tolist(), strict=True):
        if sign[a] and sign[b]:
            sign[a], nodes[a] = 0, cuts.place[k]


def _pieces(nodes: np.ndarray, cells: np.ndarray, sign: np.ndarray, cuts: _Cuts) -> np.ndarray:
    """Return the inner parts of cut cells as tetrahedra, shape (m, 4); crossings are numbered after the nodes. cells: nodes
    of the tetrahedra of the lattice, shape (c, 4); sign: 1 for nodes inside, -1 outside, 0 on the boundary; cuts: the cut
    edges.

    A quadrilateral on a face of the lattice is divided from the deeper of its inner nodes, or from the smaller number if
    they are equally deep. Both cells at the face choose the same diagonal, and the diagonals of a prism never form a
    cycle.
    """
    n = len(nodes)
    code = cuts.inner * n + cuts.outer
    depth = np.full(n, np.inf)
    np.minimum.at(depth, cuts.inner, np.linalg.norm(cuts.place - nodes[cuts.inner], axis=1))
    rank = np.empty(n, int)
    rank[np.lexsort((np.arange(n), -depth))] = np.arange(n)
    key = np.choose(
        sign[cells] + 1, (2 * n, n, rank[cells])
    )  # inner nodes by depth, then those on the boundary, then outer ones
    cells = np.take_along_axis(cells, np.argsort(key, axis=1, kind="stable"), axis=1)
    inside, outside = (sign[cells] > 0).sum(axis=1), (sign[cells] < 0).sum(axis=1)

    def at(inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
        return n + np.searchsorted(code, inner * n + outer)

    p, *others = cells[inside == 1].T
    tip = tuple(np.where(sign[other] < 0, at(p, other), other) for other in others)
    found: list[Corners] = [(p, *tip)]
    p, q, zero, out = cells[(inside == 2) & (outside == 1)].T
    found += [(p, q, at(q, out), zero), (p, at(p, out), at(q, out), zero)]
    p, q, r, out = cells[inside == 3].T
    found += [(p, q, r, at(r, out)), (p, q, at(q, out), at(r, out)), (p, at(p, out), at(q, out), at(r, out))]
    p, q, one, two = cells[(inside == 2) & (outside == 2)].T
    a, b, c, d = at(p, one), at(p, two), at(q, one), at(q, two)
    found += [
        (p, q, c, d),
        *_better(np.concatenate([nodes, cuts.place]), ((p, a, b, d), (p, a, d, c)), ((p, a, b, c), (p, b, d, c))),
    ]
    return np.concatenate([np.stack(corners, axis=1) for corners in found])


def _better(nodes: np.ndarray, one: tuple[Corners, Corners], other: tuple[Corners, Corners]) -> list[Corners]:
    """Return for each cell the division (`one` or `other`, each into two tetrahedra) whose dihedral angles are farther from
    0 and 180 degrees; nodes: positions [m], shape (n, 3)."""
    margins = []
    for pair in (one, other):
        angles = np.concatenate([dihedral_angles(nodes, np.stack(corners, axis=1)) for corners in pair], axis=1)
        margins.append(np.minimum(angles, 180.0 - angles).min(axis=1))
    first = margins[0] >= margins[1]
    return [tuple(np.where(first, a, b) for a, b in zip(*halves, strict=True)) for halves in zip(one, other, strict=True)]


def _joined(nodes: np.ndarray, cells: np.ndarray, spare: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Add spare cells at edges where two parts of the boundary would otherwise touch, as in a narrow notch; return all
    cells, shape (c, 4).

    spare: cells whose nodes were all moved to the boundary; moved: mask of the nodes that were moved, shape (n,). Raises
    Refusal if parts still touch.
    """
    while True:
        faces, count = np.unique(faces_of_cells(cells[moved[cells].sum(axis=1) >= 2]), axis=0, return_counts=True)
        edges = faces[count == 1][:, _PAIRS[:2] + _PAIRS[3:4]].reshape(-1, 2)
        edges, count = np.unique(edges[moved[edges].all(axis=1)], axis=0, return_counts=True)
        touching = edges[count > 2]
        if not len(touching):
            return cells
        at_spare = np.sort(spare[:, _PAIRS], axis=2) @ [len(nodes), 1]
        wanted = np.isin(at_spare, touching @ [len(nodes), 1]).any(axis=1)
        if not wanted.any():
            place = "({:.6g}, {:.6g}, {:.6g}) m".format(*nodes[touching[0]].mean(axis=0))
            raise Refusal(f"two parts of the mesh are connected only by an edge at {place}", "decrease `size`")
        cells, spare = np.concatenate([cells, spare[wanted]]), spare[~wanted]


def _upright(nodes: np.ndarray, cells: np.ndarray) -> SimplexMesh:
    """Return a mesh of the cells and the nodes that they use, with corners ordered so that volumes are positive."""
    used, which = np.unique(cells, return_inverse=True)
    cells = which.reshape(cells.shape)
    turned = SimplexMesh(nodes[used], cells).volumes < 0.0
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    return SimplexMesh(nodes[used], cells)
