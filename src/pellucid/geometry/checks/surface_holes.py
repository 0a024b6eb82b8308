"""Closing of holes in a surface by triangles."""

from collections import Counter

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import directed_edges, pieces

Triangles = list[tuple[int, int, int]]
MOST_EDGES = 200  # of a hole that is closed: the time grows with the cube, and is a few seconds then
FLATTEST = 1e-6  # smallest area over the square of the longest edge of a triangle that closes a hole


def without_holes(mesh: Mesh, most_edges: int) -> tuple[Mesh, list[str]]:
    """Close holes of up to `most_edges` edges by the triangles with the shortest sides; return the mesh and notes for the user
    on the changes.

    Slits between collinear edges are always closed, by triangles without area.
    """
    loops = rims(mesh)
    if not loops:
        return mesh, []
    edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
    known = {frozenset(edge) for edge in edges.tolist()}
    new: list[tuple[int, int, int]] = []
    notes = []
    waiting = loops[::-1]
    while waiting:
        loop = waiting.pop()
        where = "near ({:.6g}, {:.6g}, {:.6g}), in the unit of the file".format(*mesh.vertices[loop].mean(axis=0))
        slit = _is_straight(mesh.vertices[loop])
        if not slit and len(loop) > most_edges:
            text = f"a hole of {len(loop)} edges was not closed, as it has more than {most_edges}, {where}"
            notes += [text] * (most_edges > 0)
            continue
        triangles = _cover(mesh.vertices, loop, known, slit)
        if triangles is None and (parts := _parted(loop)):
            waiting += parts
            continue
        if triangles is None:
            notes.append(f"a hole of {len(loop)} edges was not closed, as no triangles fit into it, {where}")
            continue
        new += triangles
        known |= {frozenset(pair) for a, b, c in triangles for pair in ((a, b), (b, c), (c, a))}
        what = f"a slit of {len(loop)} edges was closed" if slit else f"a hole of {len(loop)} edges was closed"
        notes.append(f"{what}, {where}")
    triangles_of_holes = np.array(new, np.int64).reshape(-1, 3)
    return Mesh(mesh.vertices, mesh.quads, np.concatenate([mesh.triangles, triangles_of_holes])), notes


def _parted(loop: list[int]) -> list[list[int]]:
    """Return the two rings into which a ring of vertices is split at a vertex that it visits twice; [] if there is no such
    vertex.

    A ring visits a vertex twice if more than two fans (sets of elements connected across edges at the vertex) share the
    vertex.
    """
    seen: dict[int, int] = {}
    for place, vertex in enumerate(loop):
        if vertex in seen:
            parts = loop[seen[vertex] : place], loop[: seen[vertex]] + loop[place:]
            return [part for part in parts if len(part) > 2]
        seen[vertex] = place
    return []


def rims(mesh: Mesh) -> list[list[int]]:
    """Return the vertices of each closed ring of boundary edges (holes and rims), in the direction opposite to the elements."""
    edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
    edges = edges[edges[:, 0] != edges[:, 1]]  # elements with a repeated vertex have edges of zero length
    key = edges.min(axis=1) * len(mesh.vertices) + edges.max(axis=1)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    after: dict[int, list[int]] = {}
    for a, b in edges[first[count == 1]].tolist():
        after.setdefault(b, []).append(a)
    shared = {vertex: _fans(mesh, vertex) for vertex, following in after.items() if len(following) > 1}
    loops = []
    for start in sorted(after, key=lambda vertex: vertex in shared):
        while start in after:
            loop = _ring(start, after, shared)
            loops += [loop] * (len(loop) > 2)
    return loops


def _ring(start: int, after: dict[int, list[int]], shared: dict[int, dict[int, int]]) -> list[int]:
    """Return the ring of boundary edges that starts at a vertex, and remove these edges from `after`.

    after: for each vertex, the vertices that follow it along boundary edges; shared: for each vertex at which several
    rings touch, the fans as `_fans` returns them.

    The result is empty if the path does not return to its start, as for inconsistently oriented elements. If holes touch
    at a vertex, a ring connects different fans of elements.
    """
    way = [start]
    while (following := after.get(way[-1])) is not None:
        fans = shared.get(way[-1], {})
        own = fans.get(way[-2]) if len(way) > 1 else None
        step = next((other for other in following if fans.get(other) != own), following[0])
        following.remove(step)
        if not following:
            del after[way[-1]]
        if step == start:
            fans = shared.get(start, {})
            if start not in after or not fans or fans.get(way[-1]) != fans.get(way[1]):
                return way
        way.append(step)
    return []


def _fans(mesh: Mesh, vertex: int) -> dict[int, int]:
    """Return, for each neighbour of a vertex, the number of the fan (elements connected across edges at the vertex) that
    contains the edge to this neighbour."""
    neighbours = []
    for corners in (mesh.quads, mesh.triangles):
        element, place = np.nonzero(corners == vertex)
        n = corners.shape[1]
        neighbours.append(np.stack([corners[element, (place - 1) % n], corners[element, (place + 1) % n]], axis=1))
    pairs = np.concatenate(neighbours)
    names, which = np.unique(pairs, return_inverse=True)
    label = pieces(which.reshape(-1, 2), len(names))
    return dict(zip(names.tolist(), label.tolist(), strict=True))


def _is_straight(places: np.ndarray) -> bool:
    """Return True if positions, shape (n, 3), are collinear."""
    away = places - places[0]
    along = away[np.linalg.norm(away, axis=1).argmax()]
    across = np.linalg.norm(np.cross(away, along), axis=1).max()
    return bool(across <= 2.0 * FLATTEST * (along @ along))


def _cover(vertices: np.ndarray, loop: list[int], known: set[frozenset[int]], flat_too: bool) -> Triangles | None:
    """Triangulate a ring of vertices (`loop`) with the least sum of squared sides; return the triangles as vertex numbers,
    None if there is no triangulation.

    No triangle may be flat, unless `flat_too`, and no side may connect vertices that have a `known` edge. Source:
    Barequet & Sharir 1995, Computer Aided Geometric Design 12, 207.
    """
    n, x = len(loop), vertices[loop]
    cost, cut = np.zeros((n, n)), np.zeros((n, n), int)
    for span in range(2, n):
        for i in range(n - span):
            k = i + span
            middles = np.arange(i + 1, k)
            sides = np.square(x[middles] - x[i]).sum(axis=1), np.square(x[k] - x[middles]).sum(axis=1)
            base = float(np.square(x[k] - x[i]).sum())
            area = 0.5 * np.linalg.norm(np.cross(x[middles] - x[i], x[k] - x[i]), axis=1)
            flat = (area <= FLATTEST * np.maximum(np.maximum(*sides), base)) & (not flat_too)
            total = np.where(flat, np.inf, cost[i, middles] + cost[middles, k] + sides[0] + sides[1] + base)
            if (i, k) != (0, n - 1) and frozenset((loop[i], loop[k])) in known:
                total[:] = np.inf
            best = int(total.argmin())
            cost[i, k], cut[i, k] = total[best], middles[best]
    if not np.isfinite(cost[0, n - 1]):
        return None
    found, waiting = [], [(0, n - 1)]
    while waiting:
        i, k = waiting.pop()
        if k - i >= 2:
            j = int(cut[i, k])
            found.append((loop[i], loop[j], loop[k]))
            waiting += [(i, j), (j, k)]
    uses = Counter(frozenset(pair) for a, b, c in found for pair in ((a, b), (b, c), (c, a)))
    return found if max(uses.values()) <= 2 else None  # a ring that visits a vertex twice may have a side twice
