"""Holes of a surface closed by triangles."""

import numpy as np

from pellucid.geometry.mesh import Mesh
from pellucid.geometry.triangulation import directed_edges

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
    for loop in loops:
        where = "near ({:.6g}, {:.6g}, {:.6g}), in the unit of the file".format(*mesh.vertices[loop].mean(axis=0))
        if slit := _is_straight(mesh.vertices[loop]):
            notes.append(f"a slit of {len(loop)} edges was joined, {where}")
        elif len(loop) > most_edges:
            if not most_edges:
                continue
            notes.append(f"a hole of {len(loop)} edges stays open, {where}")
            continue
        triangles = _cover(mesh.vertices, loop, known, slit)
        if triangles is None:
            notes.append(f"a hole of {len(loop)} edges stays open, as no triangles fit into it, {where}")
            continue
        new += triangles
        known |= {frozenset(pair) for a, b, c in triangles for pair in ((a, b), (b, c), (c, a))}
        if not slit:
            notes.append(f"a hole of {len(loop)} edges was closed, {where}")
    triangles_of_holes = np.array(new, np.int64).reshape(-1, 3)
    return Mesh(mesh.vertices, mesh.quads, np.concatenate([mesh.triangles, triangles_of_holes])), notes


def rims(mesh: Mesh) -> list[list[int]]:
    """The vertices of each ring of edges that have one element only, against the turn of the elements: holes and rims."""
    edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
    key = edges.min(axis=1) * len(mesh.vertices) + edges.max(axis=1)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    after: dict[int, list[int]] = {}
    for a, b in edges[first[count == 1]].tolist():
        after.setdefault(b, []).append(a)
    return _loops(after)


def _loops(after: dict[int, list[int]]) -> list[list[int]]:
    """Rings of vertices round holes. Where holes touch at a vertex, each ring is left as soon as it comes back to one."""
    loops = []
    while after:
        way = [next(iter(after))]
        while True:
            following = after.get(way[-1])
            if not following:
                break  # a rim that ends: elements there face opposite sides
            step = following.pop()
            if not following:
                del after[way[-1]]
            if step in way:
                at = way.index(step)
                if len(way) - at >= 3:
                    loops.append(way[at:])
                way = way[: at + 1]
                if len(way) == 1 and step not in after:
                    break
                continue
            way.append(step)
    return loops


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
    return found
