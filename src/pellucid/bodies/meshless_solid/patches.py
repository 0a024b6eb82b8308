"""Patches of nodes over which the volume ratio of a nearly incompressible solid is averaged.

The patch of a node is its quarter of each cell around it, and each patch is a constraint on the volume. A node on a face of
the solid has half the patch of an inner node, on an edge a quarter. With one patch per node there are thus two to four times as
many constraints per volume at the boundary as inside, and at prescribed faces more constraints than coefficients that could
follow: the solid is too stiff. There patches are united with that of a node further inside.
"""

import numpy as np

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh

SMALL = 2.0**0.5  # ratio of solid angles half way between equal patches and a half one
EQUAL = 1e-6  # difference of cosines or relative lengths that rounding can cause
_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def patch_nodes(mesh: SimplexMesh) -> np.ndarray:
    """Return, for each node of a tetrahedral mesh, the node to whose patch its quarters of cells belong, shape (n,).

    A node has a patch of its own if the cells around it fill at least 1/`SMALL` of the solid angle of each neighbour: every
    inner node, and nodes of a face if no neighbour lies further inside, as in a single layer of cells. Other nodes belong to
    the neighbour with a patch of its own that lies best in the direction in which the solid extends from the node further than
    from the neighbour; without such a neighbour, to the patch of the nearest node.
    """
    n, angles = len(mesh.nodes), solid_angles(mesh)
    whole = np.bincount(mesh.cells.ravel(), angles.ravel(), n)
    pairs = np.unique(np.sort(mesh.cells[:, _EDGES].reshape(-1, 2), axis=1), axis=0)
    node, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    largest = np.zeros(n)
    np.maximum.at(largest, node, whole[other])
    small = SMALL * whole < largest
    inward, middles = np.zeros((n, 3)), mesh.nodes[mesh.cells].mean(axis=1)
    for corner in range(4):  # mean direction of the solid around each node: of a half-space half of its inward normal
        way = middles - mesh.nodes[mesh.cells[:, corner]]
        np.add.at(inward, mesh.cells[:, corner], (angles[:, corner] / np.linalg.norm(way, axis=1))[:, None] * way)
    inward /= whole[:, None]
    way, wanted = mesh.nodes[other] - mesh.nodes[node], inward[node] - inward[other]
    length = np.linalg.norm(way, axis=1)
    along = np.einsum("ei,ei->e", way, wanted) / np.maximum(length * np.linalg.norm(wanted, axis=1), np.finfo(float).tiny)
    cosine = np.round(along / EQUAL)
    distance = np.round(length / (np.bincount(node, length, n)[node] * EQUAL))

    def best(edges: np.ndarray, *keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes at the start of these edges, and for each the end with the smallest keys."""
        edges = edges[np.lexsort((other[edges], *(key[edges] for key in reversed(keys)), node[edges]))]
        nodes, first = np.unique(node[edges], return_index=True)
        return nodes, other[edges[first]]

    found = np.arange(n)
    nodes, ends = best(np.flatnonzero(small[node] & ~small[other]), -cosine, distance)
    found[nodes] = ends
    lone = small & (found == np.arange(n))
    nodes, ends = best(np.flatnonzero(lone[node] & ~lone[other]), distance)
    found[nodes] = found[ends]
    return found


def solid_angles(mesh: SimplexMesh) -> np.ndarray:
    """Return the solid angles of tetrahedra at their corners, shape (c, 4), by Van Oosterom & Strackee 1983, IEEE Trans.
    Biomed. Eng. 30, 125."""
    corners, found = mesh.nodes[mesh.cells], np.empty((len(mesh.cells), 4))
    for corner in range(4):
        a, b, c = (corners[:, (corner + k) % 4] - corners[:, corner] for k in (1, 2, 3))
        A, B, C = (np.linalg.norm(edge, axis=1) for edge in (a, b, c))
        ab, ac, bc = (np.einsum("ci,ci->c", *pair) for pair in ((a, b), (a, c), (b, c)))
        volume = np.abs(np.einsum("ci,ci->c", a, np.cross(b, c)))
        found[:, corner] = 2.0 * np.arctan2(volume, A * B * C + ab * C + ac * B + bc * A)
    return found
