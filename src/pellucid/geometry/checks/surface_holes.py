"""Holes of a surface closed by triangles."""

from collections import Counter

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import directed_edges, pieces

Triangles = list[tuple[int, int, int]]
MOST_EDGES = 200  # of a hole that is closed: the time goes with the cube, and takes seconds then
FLATTEST = 1e-6  # area over the square of the longest edge, of a triangle that closes a hole


def without_holes(mesh: Mesh, most_edges: int) -> tuple[Mesh, list[str]]:
    """The surface with its holes of up to so many edges closed by the triangles with the shortest sides. Slits between edges
    on one line are closed all the same, by triangles without area."""
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
            notes += [f"a hole of {len(loop)} edges stays open, {where}"] * (most_edges > 0)
            continue
        triangles = _cover(mesh.vertices, loop, known, slit)
        if triangles is None and (parts := _parted(loop)):
            waiting += parts
            continue
        if triangles is None:
            notes.append(f"a hole of {len(loop)} edges stays open, as no triangles fit into it, {where}")
            continue
        new += triangles
        known |= {frozenset(pair) for a, b, c in triangles for pair in ((a, b), (b, c), (c, a))}
        what = f"a slit of {len(loop)} edges was joined" if slit else f"a hole of {len(loop)} edges was closed"
        notes.append(f"{what}, {where}")
    triangles_of_holes = np.array(new, np.int64).reshape(-1, 3)
    return Mesh(mesh.vertices, mesh.quads, np.concatenate([mesh.triangles, triangles_of_holes])), notes


def _parted(loop: list[int]) -> list[list[int]]:
    """A ring in two at a vertex that it comes by twice, where more than two fans of elements meet; none where it does not."""
    seen: dict[int, int] = {}
    for place, vertex in enumerate(loop):
        if vertex in seen:
            parts = loop[seen[vertex] : place], loop[: seen[vertex]] + loop[place:]
            return [part for part in parts if len(part) > 2]
        seen[vertex] = place
    return []


def rims(mesh: Mesh) -> list[list[int]]:
    """The vertices of each ring of edges that have one element only, against the turn of the elements: holes and rims."""
    edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
    edges = edges[edges[:, 0] != edges[:, 1]]  # of elements that name a vertex twice
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
    """A ring from a vertex on; its edges are taken out of `after`. Empty where it does not come back, as where elements face
    opposite sides. Where holes touch at a vertex, a ring leads from a fan of elements to another one."""
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
    """To which fan of elements round a vertex the edges to its neighbours belong, by these."""
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
    """Whether places, shape (n, 3), lie on one line."""
    away = places - places[0]
    along = away[np.linalg.norm(away, axis=1).argmax()]
    across = np.linalg.norm(np.cross(away, along), axis=1).max()
    return bool(across <= 2.0 * FLATTEST * (along @ along))


def _cover(vertices: np.ndarray, loop: list[int], known: set[frozenset[int]], flat_too: bool) -> Triangles | None:
    """Triangles within a ring of vertices with the least sum of squared sides, none of them flat unless `flat_too`, and no
    side between vertices that have one already; None where there are none.

    Source: Barequet & Sharir 1995, Computer Aided Geometric Design 12, 207.
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
    return found if max(uses.values()) <= 2 else None  # a ring that comes by a vertex twice may have a side twice
