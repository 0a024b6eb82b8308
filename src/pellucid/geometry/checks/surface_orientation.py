"""Consistent orientation of surface elements, with outward normals of closed pieces."""

import numpy as np

from pellucid.geometry.algorithms.enclosure import inside, is_inside_out
from pellucid.geometry.checks.words import in_file
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import directed_edges, pieces


def turned_alike(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Orient neighbouring elements consistently by reversing the minority of each piece; return the mesh and notes on the
    changes.

    Pieces with only one side, such as Möbius strips, are not changed.
    """
    one, other, against = _neighbours(mesh)
    n = len(mesh.quads) + len(mesh.triangles)
    piece = pieces(np.stack([one, other], axis=1), n)
    # graph with two nodes per element, as given and reversed; links connect consistent orientations of neighbours
    way = pieces(
        np.concatenate([np.stack([one, other + against * n], axis=1), np.stack([one + n, other + ~against * n], axis=1)]), 2 * n
    )
    turned = way[:n] != way[piece]
    one_sided = np.unique(piece[way[:n] == way[n:]])
    turned[np.isin(piece, one_sided)] = False
    often = np.bincount(piece, turned, n) > 0.5 * np.bincount(piece, minlength=n)
    turned = (turned != often[piece]) & ~np.isin(piece, one_sided)
    notes = []
    centres = mesh.centres()
    if turned.any():
        many = int(turned.sum())
        where = in_file(centres[np.flatnonzero(turned)[0]])
        what = "1 element was reversed to match its" if many == 1 else f"{many} elements were reversed to match their"
        notes.append(f"{what} neighbours, the first {where}")
    notes += [f"the piece {in_file(centres[first])} is one-sided, like a Möbius strip: not changed" for first in one_sided]
    return _turned(mesh, turned), notes


def outward(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Orient the normals of closed pieces outward, or inward for holes, i.e. pieces inside an odd number of other pieces;
    return the mesh and notes on the changes."""
    one, other, against = _neighbours(mesh)
    n, first = len(mesh.quads) + len(mesh.triangles), len(mesh.quads)
    if not n:
        return mesh, []
    piece = pieces(np.stack([one, other], axis=1), n)
    sides = np.concatenate([np.full(first, 4), np.full(n - first, 3)])
    met = np.bincount(np.concatenate([one, other]), minlength=n)
    is_open = np.unique(piece[met != sides])
    twisted = np.unique(piece[one[against]])
    order = np.argsort(piece, kind="stable")
    names, start = np.unique(piece[order], return_index=True)
    members = dict(zip(names.tolist(), np.split(order, start[1:]), strict=True))
    closed = [name for name in names.tolist() if name not in {*is_open.tolist(), *twisted.tolist()}]
    parts = [_triangles(mesh, members[name]) for name in closed]
    low = np.array([mesh.vertices[part].min(axis=(0, 1)) for part in parts]).reshape(-1, 3)
    high = np.array([mesh.vertices[part].max(axis=(0, 1)) for part in parts]).reshape(-1, 3)
    turned, notes = np.zeros(n, bool), []
    for k, (name, part) in enumerate(zip(closed, parts, strict=True)):
        larger = np.flatnonzero((low <= low[k]).all(axis=1) & (high >= high[k]).all(axis=1))
        corner = mesh.vertices[part[:1, 0]]
        is_hole = sum(bool(inside(corner, mesh.vertices, parts[other])[0]) for other in larger if other != k) % 2 == 1
        used, which = np.unique(part, return_inverse=True)
        own = mesh.vertices[used], which.reshape(-1, 3)
        if is_inside_out(*own) if not is_hole else is_inside_out(own[0], own[1][:, ::-1]):
            turned[members[name]] = True
            side = "inward, as it is a hole" if is_hole else "outward"
            notes.append(f"the normals of a closed piece were reversed to point {side}, {in_file(mesh.centres()[name])}")
    return _turned(mesh, turned), notes


def _triangles(mesh: Mesh, elements: np.ndarray) -> np.ndarray:
    """Return a triangulation of the elements with these numbers, as vertex numbers, shape (m, 3)."""
    first = len(mesh.quads)
    quads, triangles = elements[elements < first], elements[elements >= first] - first
    return Mesh(mesh.vertices, mesh.quads[quads], mesh.triangles[triangles]).triangulated().triangles


def _neighbours(mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the two elements at each edge that has exactly two, and a mask of the pairs with opposite normals, shape (k,)
    each."""
    n, first = len(mesh.vertices), len(mesh.quads)
    edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
    owner = np.concatenate([np.tile(np.arange(first), 4), np.tile(first + np.arange(len(mesh.triangles)), 3)])
    low, high = edges.min(axis=1), edges.max(axis=1)
    key = low * n + high
    order = np.argsort(key, kind="stable")
    _, start, count = np.unique(key[order], return_index=True, return_counts=True)
    start = start[count == 2]
    one, other = order[start], order[start + 1]
    return owner[one], owner[other], edges[one, 0] == edges[other, 0]


def _turned(mesh: Mesh, turned: np.ndarray) -> Mesh:
    quads, triangles = mesh.quads.copy(), mesh.triangles.copy()
    of_quads, of_triangles = turned[: len(quads)], turned[len(quads) :]
    quads[of_quads] = quads[of_quads][:, [0, 3, 2, 1]]
    triangles[of_triangles] = triangles[of_triangles][:, ::-1]
    return Mesh(mesh.vertices, quads, triangles)
