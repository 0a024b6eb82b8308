"""What is wrong with a triangulated surface: holes, flipped, repeated or empty triangles, lone vertices."""

from collections.abc import Callable, Iterator

import numpy as np

from pellucid.geometry.enclosure import signed_volume
from pellucid.geometry.triangulation import directed_edges, pieces

FLATTEST = 1e-10  # area over the square of the longest edge; a triangle below it has no normal worth the name


def faults(vertices: np.ndarray, triangles: np.ndarray, closed: bool) -> Iterator[tuple[str, str]]:
    """Everything wrong with a surface, as text and remedy.

    What makes neighbours ambiguous (repeated and empty triangles, edges with more than two) hides the rest until it is mended.
    """
    lone = np.flatnonzero(np.bincount(triangles.ravel(), minlength=len(vertices)) == 0)
    if len(lone):
        text = f"{_count(len(lone), 'vertex belongs', 'vertices belong')} to no triangle, the first is number {lone[0]}"
        yield f"{text}{_place(vertices[lone[0]])}; such a point has no mass", "remove them"
    ambiguous = False
    edges = _Edges(vertices, triangles)
    for text, remedy in (*_empty(vertices, triangles), *_repeated(vertices, triangles), *_crowded(edges)):
        ambiguous = True
        yield text, remedy
    if ambiguous:
        return
    flipped = list(_flipped(edges))
    yield from flipped
    if closed:
        holes = list(_holes(edges))
        yield from holes
        if not (flipped or holes) and (volume := signed_volume(vertices, triangles)) < 0.0:
            text = f"the normals point inward: the triangles enclose {volume:.4g} m^3, which must be positive"
            yield text, "turn the triangles round: of a file with `reverse`"


def _empty(vertices: np.ndarray, triangles: np.ndarray) -> Iterator[tuple[str, str]]:
    a, b, c = vertices[triangles.T]
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([np.einsum("ij,ij->i", edge, edge) for edge in (b - a, c - b, a - c)], axis=0)
    found = np.flatnonzero(area <= FLATTEST * longest)
    if len(found):
        text = f"{_count(len(found), 'triangle has', 'triangles have')} no area, the first is number {found[0]}"
        yield text + _place(a[found[0]]), "remove them, and join their corners where they are one"


def _repeated(vertices: np.ndarray, triangles: np.ndarray) -> Iterator[tuple[str, str]]:
    low, middle, high = np.sort(triangles, axis=1).T
    order = np.lexsort((high, low * len(vertices) + middle))
    corners = np.stack([low, middle, high], axis=1)[order]
    again = np.flatnonzero(np.all(corners[1:] == corners[:-1], axis=1))
    if len(again):
        text = f"{_count(len(again), 'triangle is', 'triangles are')} there twice, for example numbers"
        one, other = np.sort(order[[again[0], again[0] + 1]])
        yield f"{text} {one} and {other}{_place(vertices[triangles[other, 0]])}", "keep each triangle once"


def _crowded(edges: "_Edges") -> Iterator[tuple[str, str]]:
    crowded = edges.of_triangles(lambda n: n > 2)
    if len(crowded):
        text = f"{_count(len(crowded), 'edge has', 'edges have')} more than two triangles, for example {_between(crowded[0])}"
        yield text + edges.place(crowded[0]), "make each sheet that meets there a body of its own"


def _flipped(edges: "_Edges") -> Iterator[tuple[str, str]]:
    same = np.flatnonzero(edges.codes[1:] == edges.codes[:-1])
    if len(same):
        directed = edges.ends(edges.codes[same[:1]] // 2)[0]
        if edges.codes[same[0]] % 2:
            directed = directed[::-1]
        one, other = np.flatnonzero(np.all(directed_edges(edges.triangles) == directed, axis=1)) % len(edges.triangles)
        text = f"neighbouring triangles face opposite sides at {_count(len(same), 'edge', 'edges')}, for example numbers"
        remedy = "let all triangles turn the same way about the normal"
        yield f"{text} {min(one, other)} and {max(one, other)}{edges.place(directed)}", remedy


def _holes(edges: "_Edges") -> Iterator[tuple[str, str]]:
    rim = edges.of_triangles(lambda n: n == 1)
    if len(rim):
        loops = len(np.unique(pieces(rim, len(edges.vertices))[rim[:, 0]]))
        text = f"is declared closed and has {_count(loops, 'hole', 'holes')} with {_count(len(rim), 'edge', 'edges')} in all"
        remedy = "close it, or declare it open with `closed = false`"
        yield f"{text}, one of them {_between(rim[0])}{edges.place(rim[0])}", remedy


class _Edges:
    """The edges of all triangles in order, so that those between the same vertices are neighbours."""

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        self.vertices, self.triangles = vertices, triangles
        start, end = directed_edges(triangles).T
        low, high = np.minimum(start, end), np.maximum(start, end)
        self.codes = np.sort(2 * (low * len(vertices) + high) + (start > end))  # the last bit is the direction

    def ends(self, codes: np.ndarray) -> np.ndarray:
        """The two vertices of edges without direction, the smaller one first, shape (k, 2)."""
        return np.stack([codes // len(self.vertices), codes % len(self.vertices)], axis=1)

    def of_triangles(self, wanted: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """The edges, shape (k, 2), whose number of triangles is as wanted."""
        first = np.flatnonzero(np.diff(self.codes // 2, prepend=-1))
        counts = np.diff(first, append=len(self.codes))
        return self.ends(self.codes[first[wanted(counts)]] // 2)

    def place(self, edge: np.ndarray) -> str:
        """Where an edge is, for a message."""
        return _place(self.vertices[edge].mean(axis=0))


def _count(n: int, one: str, many: str) -> str:
    return f"{n} {one if n == 1 else many}"


def _between(edge: np.ndarray) -> str:
    return f"between vertices {edge[0]} and {edge[1]}"


def _place(position: np.ndarray) -> str:
    return f", near ({', '.join(f'{value:.4g}' for value in position)}) m"
