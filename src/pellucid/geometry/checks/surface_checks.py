"""Checks of surface meshes: holes, inconsistent orientation, repeated, degenerate or non-convex elements, unused vertices."""

from collections.abc import Callable, Iterator

import numpy as np

from pellucid.geometry.checks import REPAIR, Fault, counted
from pellucid.geometry.meshes.cells import cut_in_two
from pellucid.geometry.meshes.enclosure import is_inside_out, signed_volume
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, Mesh, layers_parted
from pellucid.geometry.meshes.triangulation import directed_edges, first_of_each, pieces

FLATTEST = 1e-10  # area over the square of the longest edge: the normal of an element with a smaller value is not meaningful
STRAIGHTEST = 1e-3  # twice the area of the triangle at a corner over the area of the quadrilateral: 1 for a square
MOST_EDGES = 200  # of a hole that `repair` closes: the time grows with the cube, and is a few seconds then
MOST_FOLDED = 45.0  # degrees between the halves of a quadrilateral; the element formulation assumes a flat one


def faults(vertices: np.ndarray, triangles: np.ndarray, closed: bool, may_be_open: bool = False) -> Iterator[Fault]:
    """Yield the faults of a triangulated surface, each as a text that describes it and a remedy. vertices: positions, shape
    (n, 3); triangles: vertex numbers, shape (m, 3); closed, may_be_open: see `mesh_faults`."""
    return mesh_faults(Mesh(vertices, NO_QUADS, triangles), closed, may_be_open)


def mesh_faults(mesh: Mesh, closed: bool, may_be_open: bool = False) -> Iterator[Fault]:
    """Yield the faults of a surface of quadrilaterals and triangles, each as a text that describes it and a remedy. closed:
    the surface must have no holes; may_be_open: True if an open surface can be used in its place, as for a membrane.

    Faults that make neighbours ambiguous (repeated and degenerate elements, edges with more than two elements) hide the
    others until they are repaired.
    """
    nowhere = np.flatnonzero(~np.isfinite(mesh.vertices).all(axis=1))
    if len(nowhere):
        number = int(nowhere[0])
        text = f"vertex {number} has the position {tuple(mesh.vertices[number].tolist())}, which is not finite"
        yield text, "correct its coordinates"
        return
    elements = _Elements(mesh)
    ambiguous = False
    yield from _lone(elements)
    empty, repeated = list(_empty(elements)), list(_repeated(elements))
    # edges that are crowded only by repeated or degenerate elements are not reported again
    sound = elements
    if empty or repeated:
        no_quads, no_triangles = np.split(empty_elements(mesh), [len(mesh.quads)])
        quads, triangles = mesh.quads[~no_quads], mesh.triangles[~no_triangles]
        sound = _Elements(Mesh(mesh.vertices, quads[first_of_each(quads)], triangles[first_of_each(triangles)]))
    for fault in (*empty, *repeated, *_crowded(sound)):
        ambiguous = True
        yield fault
    if ambiguous:
        return
    yield from _crooked(elements)
    flipped = list(_flipped(elements))
    yield from flipped
    if closed:
        holes = list(_holes(elements, may_be_open))
        yield from holes
        if not (flipped or holes) and is_inside_out(*mesh.triangulated()):
            volume = signed_volume(*mesh.triangulated())
            text = f"the normals point inward: the {elements.many} enclose {volume:.4g} m^3, which must be positive"
            yield text, f"reverse the {elements.many}; for a mesh file, set `repair = true` or `reverse = true`"


class _Elements:
    """Elements of a surface that is checked for faults, and their directed edges, sorted so that edges between the same two
    vertices are adjacent."""

    def __init__(self, mesh: Mesh) -> None:
        self.vertices, self.quads, self.triangles = mesh
        self.first_triangle = len(mesh.quads)
        mixed = len(mesh.quads) and len(mesh.triangles)
        self.one = "element" if mixed else "quadrilateral" if len(mesh.quads) else "triangle"
        self.many = f"{self.one}s"
        self.edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
        of_quads, of_triangles = np.arange(len(mesh.quads)), self.first_triangle + np.arange(len(mesh.triangles))
        self.owner = np.concatenate([np.tile(of_quads, 4), np.tile(of_triangles, 3)])
        start, end = self.edges.T
        low, high = np.minimum(start, end), np.maximum(start, end)
        self.codes = np.sort(2 * (low * len(self.vertices) + high) + (start > end))  # the last bit is the direction

    def corner(self, element: int) -> np.ndarray:
        """Return the position of the first corner of an element, shape (3,)."""
        k = element - self.first_triangle
        return np.asarray(self.vertices[self.quads[element, 0] if k < 0 else self.triangles[k, 0]])

    def ends(self, codes: np.ndarray) -> np.ndarray:
        """Return the two vertices of undirected edges, the smaller number first, shape (k, 2); codes: smaller vertex number
        times the number of vertices plus the larger, shape (k,)."""
        return np.stack([codes // len(self.vertices), codes % len(self.vertices)], axis=1)

    def edges_of(self, wanted: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return the vertices of the edges that have a certain number of elements, shape (k, 2); wanted: function that
        returns a mask for the numbers of elements of the edges."""
        first = np.flatnonzero(np.diff(self.codes // 2, prepend=-1))
        counts = np.diff(first, append=len(self.codes))
        return self.ends(self.codes[first[wanted(counts)]] // 2)

    def place(self, edge: np.ndarray) -> str:
        """Return the position of the middle of an edge (two vertex numbers) as text for a message."""
        return _place(self.vertices[edge].mean(axis=0))

    def count(self, n: int, verb: str, verbs: str) -> str:
        """Return a number n of elements with a verb, in the singular (`verb`) or plural form (`verbs`), as text for a
        message."""
        return counted(n, f"{self.one} {verb}", f"{self.many} {verbs}")


def _lone(elements: _Elements) -> Iterator[Fault]:
    lone = np.flatnonzero(np.bincount(elements.edges[:, 0], minlength=len(elements.vertices)) == 0)
    if len(lone):
        text = f"{counted(len(lone), 'vertex belongs', 'vertices belong')} to no {elements.one}; the first is number {lone[0]}"
        yield f"{text}{_place(elements.vertices[lone[0]])}; such a point has no mass", f"remove them: {REPAIR}"


def _empty(elements: _Elements) -> Iterator[Fault]:
    empty = empty_elements(Mesh(elements.vertices, elements.quads, elements.triangles))
    found = np.flatnonzero(empty)
    if len(found):
        text = f"{elements.count(len(found), 'has', 'have')} no area; the first is number {found[0]}"
        yield text + _place(elements.corner(found[0])), f"remove them, and merge coincident corners: {REPAIR}"
    collapsed = np.flatnonzero(
        np.any(np.diff(np.sort(elements.quads, axis=1), axis=1) == 0, axis=1) & ~empty[: elements.first_triangle]
    )
    if len(collapsed):
        text = f"{counted(len(collapsed), 'quadrilateral has', 'quadrilaterals have')} the same vertex at two corners"
        place = _place(elements.corner(collapsed[0]))
        yield f"{text}; the first is number {collapsed[0]}{place}", f"replace them by triangles: {REPAIR}"


def empty_elements(mesh: Mesh, flattest: float = FLATTEST) -> np.ndarray:
    """Return a mask of the degenerate elements, shape (q + t,): q quadrilaterals, then t triangles.

    An element is degenerate if its area is at most `flattest` times the square of its longest side.
    """
    small = []
    for corners in (mesh.quads, mesh.triangles):
        places = mesh.vertices[corners]
        longest = np.linalg.norm(places - np.roll(places, -1, axis=1), axis=2).max(axis=1, initial=0.0)
        small.append(np.linalg.norm(_vector_area(places), axis=1) <= flattest * longest**2)
    return np.concatenate(small)


def _repeated(elements: _Elements) -> Iterator[Fault]:
    found = []
    for corners, start in ((elements.quads, 0), (elements.triangles, elements.first_triangle)):
        named = np.sort(corners, axis=1)
        order = np.lexsort(named.T[::-1])
        again = np.flatnonzero(np.all(named[order][1:] == named[order][:-1], axis=1))
        found += [start + np.sort(order[[k, k + 1]]) for k in again]
    if found:
        one, other = found[0]
        are_layers = layers_parted(Mesh(elements.vertices, elements.quads, elements.triangles)) is not None
        text = f"{elements.count(len(found), 'occurs', 'occur')} twice, for example numbers {one} and {other}"
        remedy = "if these are the two layers of a flat bag, set `closed = true`, or save the mesh as OBJ or PLY with separate "
        remedy += f"vertices for each layer; otherwise remove the duplicates: {REPAIR}"
        plain = f"remove the duplicates: {REPAIR}"
        yield text + _place(elements.corner(other)), remedy if are_layers else plain


def _crowded(elements: _Elements) -> Iterator[Fault]:
    crowded = elements.edges_of(lambda n: n > 2)
    if len(crowded):
        text = f"{counted(len(crowded), 'edge has', 'edges have')} more than two {elements.many}, for example"
        yield f"{text} {_between(crowded[0])}{elements.place(crowded[0])}", "make each sheet that meets there a separate body"


def _crooked(elements: _Elements) -> Iterator[Fault]:
    """Yield faults for quadrilaterals that are not convex or far from flat."""
    bent, folds = crooked_quads(elements.vertices, elements.quads)
    found = np.flatnonzero(bent)
    if len(found):
        text = f"{counted(len(found), 'quadrilateral is', 'quadrilaterals are')} not convex; the first is number {found[0]}"
        text += f"{_place(elements.corner(found[0]))}, which has a corner of 180 degrees or more, or edges that cross"
        yield text, f"order the corners around the element, or divide it into triangles (if no edges cross: {REPAIR})"
    fold = folds.max(axis=0)
    found = np.flatnonzero((fold > MOST_FOLDED) & ~bent)
    if len(found):
        worst = found[np.argmax(fold[found])]
        text = f"{counted(len(found), 'quadrilateral is', 'quadrilaterals are')} far from flat; number {worst} is folded by "
        text += f"{fold[worst]:.0f} degrees about a diagonal, which must be at most {MOST_FOLDED:g}"
        yield text + _place(elements.corner(worst)), f"refine the mesh there, or divide them into triangles: {REPAIR}"


def crooked_quads(vertices: np.ndarray, quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a mask of the quadrilaterals that are not convex, shape (q,), and their fold angles [degrees], shape (2, q). A
    fold angle is the angle between the two triangles into which a diagonal divides the quadrilateral: the diagonal from the
    first corner, then the diagonal from the second corner."""
    places = vertices[quads]
    area = _vector_area(places)
    size = np.linalg.norm(area, axis=1)
    edge = np.roll(places, -1, axis=1) - places
    at_corner = np.cross(np.roll(edge, 1, axis=1), edge)  # twice the vector area of the triangle at each corner
    bent = np.einsum("ijk,ik->ij", at_corner, area).min(axis=1, initial=np.inf) <= STRAIGHTEST * size**2
    both_ways = np.concatenate([quads, np.roll(quads, -1, axis=1)])
    halves = _vector_area(vertices[cut_in_two(both_ways)])
    one, other = halves[0::2], halves[1::2]
    length = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    cosine = np.einsum("ij,ij->i", one, other) / np.maximum(length, np.finfo(float).tiny)
    return bent, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).reshape(2, -1)


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


def _flipped(elements: _Elements) -> Iterator[Fault]:
    same = np.flatnonzero(elements.codes[1:] == elements.codes[:-1])
    if len(same):
        directed = elements.ends(elements.codes[same[:1]] // 2)[0]
        if elements.codes[same[0]] % 2:
            directed = directed[::-1]
        one, other = elements.owner[np.all(elements.edges == directed, axis=1)]
        text = f"neighbouring {elements.many} have opposite normals at {counted(len(same), 'edge', 'edges')}, for example"
        remedy = f"order the corners of all {elements.many} consistently: {REPAIR}"
        yield f"{text} numbers {min(one, other)} and {max(one, other)}{elements.place(directed)}", remedy


def _holes(elements: _Elements, may_be_open: bool) -> Iterator[Fault]:
    rim = elements.edges_of(lambda n: n == 1)
    if len(rim):
        loops = len(np.unique(pieces(rim, len(elements.vertices))[rim[:, 0]]))
        text = f"the surface is declared closed but has {counted(loops, 'hole', 'holes')}"
        text += f" with {counted(len(rim), 'edge', 'edges')} in total"
        largest = max(map(len, rims(Mesh(elements.vertices, elements.quads, elements.triangles))), default=len(rim))
        remedy = f"close it: for a mesh file, set `repair = true` and `close_holes = {largest}`, or run `pellucid mesh FILE"
        remedy += f" --repair --close-holes {largest} --out NEW`"
        if largest > MOST_EDGES:
            remedy = f"close it in a mesh program: a hole has {largest} edges, and `close_holes` closes at most {MOST_EDGES}"
        remedy += "; or declare it open with `closed = false`" if may_be_open else ""
        yield f"{text}, one of which is {_between(rim[0])}{elements.place(rim[0])}", remedy


def _vector_area(places: np.ndarray) -> np.ndarray:
    """Return the vector areas of triangles or quadrilaterals with corner positions, shape (m, 3 or 4, 3): shape (m, 3)."""
    first, second = places[:, 2] - places[:, 0], places[:, -1] - places[:, 1]
    return 0.5 * np.cross(first, second)


def _between(edge: np.ndarray) -> str:
    return f"between vertices {edge[0]} and {edge[1]}"


def _place(position: np.ndarray) -> str:
    return f", near ({', '.join(f'{value:.4g}' for value in position)}) m"
