"""Repairs of surface meshes: merged vertices, removed elements, consistent orientation, closed holes."""

from collections import Counter
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from pellucid.geometry.checks import counted, in_file
from pellucid.geometry.checks.surface_checks import MOST_FOLDED, crooked_quads, empty_elements, rims
from pellucid.geometry.meshes.cells import cut_in_two
from pellucid.geometry.meshes.enclosure import inside, is_inside_out
from pellucid.geometry.meshes.points import width_of_place
from pellucid.geometry.meshes.surface_mesh import Mesh, joined
from pellucid.geometry.meshes.triangulation import directed_edges, first_of_each, pieces

FLATTEST = 1e-6  # area over the square of the longest side: a flatter triangle is treated as a slit, and closes no hole
MOST_TURNED = 170.0  # largest angle between the halves of a quadrilateral [degrees], above which its edges cross
Mended = tuple[Mesh, list[str]]


def repaired(mesh: Mesh, close_holes: int = 0) -> Mended:
    """Return the repaired surface, and notes on the changes, with positions in the unit of the vertices.

    Coincident vertices are merged; duplicate and degenerate elements and unused vertices are removed; elements are oriented
    consistently, closed pieces outward (holes, i.e. pieces inside another one, inward); holes of up to `close_holes` edges are
    closed.
    """
    notes: list[str] = []
    steps: tuple[Callable[[Mesh], Mended], ...] = (
        _merged,
        _of_different_corners,
        _without_slits,
        _once,
        _flat_quads,
        turned_alike,
        lambda so_far: without_holes(so_far, close_holes),
        lambda so_far: (_without_slits(so_far)[0], []),
        outward,
        _without_lone,
    )
    for step in steps:
        mesh, done = step(mesh)
        notes += done
    return mesh, notes


def _merged(mesh: Mesh) -> Mended:
    place, _ = joined(mesh.vertices, mesh.quads, mesh.triangles, width_of_place(mesh.vertices, [mesh.quads, mesh.triangles]))
    merged = np.flatnonzero(place != np.arange(len(place)))
    if not len(merged):
        return mesh, []
    kept = place == np.arange(len(place))
    number = (np.cumsum(kept) - 1)[place]
    note = f"{counted(len(merged), 'vertex was', 'vertices were')} merged with a coincident one, the first"
    merged_mesh = Mesh(mesh.vertices[kept], number[mesh.quads], number[mesh.triangles])
    return merged_mesh, [f"{note} {in_file(mesh.vertices[merged[0]])}"]


def _of_different_corners(mesh: Mesh) -> Mended:
    """Convert quadrilaterals with a repeated corner to triangles, and remove elements with fewer than three different corners;
    return the mesh and notes for the user on the changes."""
    notes, triangles = [], [mesh.triangles]
    again = mesh.quads == np.roll(mesh.quads, 1, axis=1)
    three = again.sum(axis=1) == 1
    if three.any():
        triangles.append(mesh.quads[three][~again[three]].reshape(-1, 3))
        text = counted(int(three.sum()), "quadrilateral was made a triangle", "quadrilaterals were made triangles")
        notes.append(f"{text}, as one of its corners is repeated")
    quads, every = mesh.quads[~three], np.concatenate(triangles)
    kept = [(np.diff(np.sort(corners, axis=1), axis=1) > 0).all(axis=1) for corners in (quads, every)]
    gone = [corners[~keep] for corners, keep in zip((quads, every), kept, strict=True)]
    if n := sum(map(len, gone)):
        where = in_file(mesh.vertices[next(corners for corners in gone if len(corners))[0, 0]])
        notes.append(f"{counted(n, 'element without area was', 'elements without area were')} removed, the first {where}")
    return Mesh(mesh.vertices, quads[kept[0]], every[kept[1]]), notes


def _without_slits(mesh: Mesh) -> Mended:
    """Remove triangles with collinear corners, and divide the element across their longest edge at the third corner, so that
    no slit remains. Return the mesh and notes on the changes.

    Other elements without area are kept.
    """
    flat = np.flatnonzero(empty_elements(mesh, FLATTEST)[len(mesh.quads) :])
    if not len(flat):
        return mesh, []
    elements: list[tuple[int, ...] | None] = [*map(tuple, mesh.quads.tolist()), *map(tuple, mesh.triangles.tolist())]
    of_edge: dict[frozenset[int], set[int]] = {}

    def note(number: int, there: bool) -> None:
        corners = elements[number] or ()
        for pair in zip(corners, corners[1:] + corners[:1], strict=True):
            owners = of_edge.setdefault(frozenset(pair), set())
            owners.add(number) if there else owners.discard(number)

    for number in range(len(elements)):
        note(number, True)
    mended = []
    for number in (len(mesh.quads) + flat).tolist():
        corners = elements[number]
        if corners is None or len(corners) != 3:
            continue
        sides = [
            (float(np.linalg.norm(mesh.vertices[a] - mesh.vertices[b])), a, b)
            for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
        ]
        _, a, b = max(sides)
        (middle,) = set(corners) - {a, b}
        across = of_edge[frozenset((a, b))] - {number}
        if len(across) > 1 or any(middle in (elements[other] or ()) for other in across):
            continue
        note(number, False)
        elements[number] = None
        mended.append(middle)
        for other in across:
            whole = elements[other] or ()
            note(other, False)
            at = next(k for k in range(len(whole)) if {whole[k], whole[(k + 1) % len(whole)]} == {a, b})
            ring = whole[at + 1 :] + whole[: at + 1]  # from the far end of the edge round to its start
            parts = [(middle, *pair) for pair in pairwise(ring)]
            elements[other] = parts[0]
            note(other, True)
            for part in parts[1:]:
                elements.append(part)
                note(len(elements) - 1, True)
    if not mended:
        return mesh, []
    left = [corners for corners in elements if corners is not None]
    quads, triangles = (np.array([c for c in left if len(c) == n], np.int64).reshape(-1, n) for n in (4, 3))
    text = f"{counted(len(mended), 'triangle without area was', 'triangles without area were')} removed, the first"
    return Mesh(mesh.vertices, quads, triangles), [f"{text} {in_file(mesh.vertices[mended[0]])}"]


def _flat_quads(mesh: Mesh) -> Mended:
    """Divide quadrilaterals that are not convex or far from flat along the diagonal with the smaller fold angle; return the
    mesh and notes for the user on the changes.

    Quadrilaterals whose edges cross are kept.
    """
    bent, folds = crooked_quads(mesh.vertices, mesh.quads)
    cut = (bent | (folds.max(axis=0) > MOST_FOLDED)) & (folds.min(axis=0) < MOST_TURNED)
    if not cut.any():
        return mesh, []
    quads = mesh.quads[cut]
    second = folds[1, cut] < folds[0, cut]
    quads[second] = np.roll(quads[second], -1, axis=1)
    halves = cut_in_two(quads)
    which = "not convex or far from flat"
    text = counted(len(quads), f"quadrilateral was {which} and was", f"quadrilaterals were {which} and were")
    text += " divided into triangles, the first"
    where = in_file(mesh.vertices[quads[0]].mean(axis=0))
    return Mesh(mesh.vertices, mesh.quads[~cut], np.concatenate([mesh.triangles, halves])), [f"{text} {where}"]


def _once(mesh: Mesh) -> Mended:
    kept, gone = [], []
    for corners in (mesh.quads, mesh.triangles):
        first = first_of_each(corners)
        kept.append(corners[first])
        gone.append(corners[~first])
    n = sum(map(len, gone))
    if not n:
        return mesh, []
    where = in_file(mesh.vertices[next(corners for corners in gone if len(corners))[0]].mean(axis=0))
    return Mesh(mesh.vertices, *kept), [
        f"{counted(n, 'duplicate element was', 'duplicate elements were')} removed, the first {where}"
    ]


def _without_lone(mesh: Mesh) -> Mended:
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.quads], used[mesh.triangles] = True, True
    lone = np.flatnonzero(~used)
    if not len(lone):
        return mesh, []
    number = np.cumsum(used) - 1
    text = f"{counted(len(lone), 'unused vertex was', 'unused vertices were')} removed"
    text += f", the first {in_file(mesh.vertices[lone[0]])}"
    return Mesh(mesh.vertices[used], number[mesh.quads], number[mesh.triangles]), [text]


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


Triangles = list[tuple[int, int, int]]


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
