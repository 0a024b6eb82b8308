"""Repairs of surface meshes."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from pellucid.geometry.checks.surface_checks import MOST_FOLDED, crooked_quads, empty_elements
from pellucid.geometry.checks.surface_holes import without_holes
from pellucid.geometry.checks.surface_orientation import outward, turned_alike
from pellucid.geometry.checks.words import counted, in_file
from pellucid.geometry.meshes.cells import cut_in_two
from pellucid.geometry.meshes.coincident import width_of_place
from pellucid.geometry.meshes.joining import joined
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import first_of_each

FLATTEST = 1e-6  # area over the square of the longest side: a flatter triangle is treated as a slit
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
