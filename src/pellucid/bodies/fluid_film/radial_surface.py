"""Closed surfaces in space by radial point interpolation on the tangent planes of their nodes (Benet 2015, chapter 5).

Stencils of nearest nodes change from triangle to triangle, and what they interpolate would jump. So the interpolants of the
three corners are blended: N_I = Σ_a b_a N_I^(a), with the shares b_a of the corners, over a parameter triangle whose edges are
bowed as the surface is: flat ones would give areas no better than the triangles'. The surface runs through its nodes.

The functions stay as they are while the nodes move, as the mesh of an isoparametric element does: rigid motions are in the
kernel of all rows. They are made anew where nodes have moved far against each other.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pellucid.approximants.radial.contract import RadialModel
from pellucid.approximants.radial.neighbourhoods import on_surface, tangents_across
from pellucid.approximants.radial.stencils import Interpolants, functions_at, interpolants
from pellucid.bodies.fluid_film.surface_rows import SurfaceTables
from pellucid.bodies.fluid_film.triangle_surface import SIX, TriangleRule, TriangleSurface
from pellucid.errors import RunStopped
from pellucid.geometry.vertex_normals import vertex_normals

CHUNK = 1024  # triangles
FAR = 0.05  # way of nodes against each other, of the distance to the nearest, after which functions are made anew
ALONG = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])  # changes of the three shares with those of corners 1 and 2
EDGES = ((0, 1), (1, 2), (2, 0))
PAIRS = ((0, 0), (0, 1), (1, 1))


class Blended(NamedTuple):
    """Functions of the nodes of k triangles at q places, and derivatives by the shares of corners 1 and 2."""

    value: np.ndarray  # (k, q, m)
    first: np.ndarray  # (k, q, 2, m)
    second: np.ndarray  # (k, q, 3, m) 11, 12, 22


class RadialSurface(TriangleSurface):
    """A closed surface through its nodes, which stand at x (n, 3) [m] at first; six points a triangle are needed."""

    def __init__(self, triangles: np.ndarray, x: np.ndarray, radial: RadialModel, rule: TriangleRule = SIX) -> None:
        super().__init__(triangles, len(x), rule)
        self._radial, self._rule = radial, rule
        around = on_surface(x, vertex_normals(x, triangles), radial.stencil_size(2)).nodes
        self._around = around  # stays, as the matrices of the film have places for these neighbours
        self.nodes, self._slots = _union(around[triangles])
        self._fit(np.array(x, dtype=float))

    def places(self, x: np.ndarray) -> np.ndarray:
        """The values of the nodes."""
        return np.array(x)

    def through(self, places: np.ndarray) -> np.ndarray:
        """The places."""
        return np.array(places)

    def at(self, x: np.ndarray, triangle: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Places on the surface with nodes at x in triangles (k,) at shares of their corners (k, 3), shape (k, 3) [m]."""
        result = np.zeros((len(triangle), 3))
        for start in range(0, len(triangle), CHUNK):
            some = slice(start, start + CHUNK)
            functions = self._blended(triangle[some], share[some, None])
            result[some] = np.einsum("km,kmi->ki", functions.value[:, 0], x[self.nodes[triangle[some]]])
        return result

    def renew(self, x: np.ndarray) -> None:
        """Make the functions anew where nodes have moved far."""
        moved = x - self._reference
        against = np.linalg.norm(moved[self.rings.neighbours] - moved[:, None], axis=2).max(axis=1)
        if (against > FAR * self.spacing(self._reference)).any():
            self._fit(x.copy())

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Where the nodes stood when the functions were made."""
        return {"reference": self._reference}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Make the functions for nodes there."""
        self._fit(np.array(arrays["reference"]))

    def _fit(self, x: np.ndarray) -> None:
        self._reference = x
        triangles = self.rings.triangles
        normal = vertex_normals(x, triangles)
        _check_not_folded(x, normal, self._around)
        self._tangents = tangents_across(normal)
        coordinates = np.einsum("nmi,ndi->nmd", x[self._around] - x[:, None], self._tangents)
        self._found: Interpolants = interpolants(coordinates, self._radial)
        along = np.einsum("nkm,nmi->nki", self._functions_at_nodes(), x[self._around])
        fitted = np.cross(along[:, 0], along[:, 1])
        fitted /= np.linalg.norm(fitted, axis=1)[:, None]
        self._bow = _bow(x[triangles], fitted[triangles])
        whole = np.broadcast_to(self._rule.shares, (len(triangles), *self._rule.shares.shape))
        parts = [
            self._blended(np.arange(start, min(start + CHUNK, len(triangles))), whole[start : start + CHUNK])
            for start in range(0, len(triangles), CHUNK)
        ]
        value, first, second = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        self.tables = SurfaceTables(np.arange(len(triangles)), value, first, second, 0.5 * self._rule.weights)

    def _functions_at_nodes(self) -> np.ndarray:
        """First derivatives of each node's own functions there, shape (n, 2, m)."""
        n = len(self._around)
        return functions_at(self._found, np.zeros((n, 1, 2)), derivatives=1).first[:, 0]

    def _blended(self, triangle: np.ndarray, share: np.ndarray) -> Blended:
        """In triangles (k,) at shares (k, q, 3) of their corners."""
        corners = self.rings.triangles[triangle]
        place, first, second = _parameters(self._reference[corners], self._bow[triangle], share)
        k, q, m = len(triangle), share.shape[1], self.nodes.shape[1]
        result = Blended(np.zeros((k, q, m)), np.zeros((k, q, 2, m)), np.zeros((k, q, 3, m)))
        here = np.arange(k)[:, None]
        for a in range(3):
            node = corners[:, a]
            tangents = self._tangents[node]
            y = np.einsum("kqi,kdi->kqd", place - self._reference[node][:, None], tangents)
            dy, ddy = np.einsum("kqai,kdi->kqad", first, tangents), np.einsum("kpi,kdi->kpd", second, tangents)
            own = functions_at(self._found, y, of=node)
            F = own.value
            dF = np.einsum("kqdm,kqad->kqam", own.first, dy)
            slots = self._slots[triangle, a]
            b = share[..., a]
            result.value.transpose(0, 2, 1)[here, slots] += (b[..., None] * F).transpose(0, 2, 1)
            blend = b[..., None, None] * dF + ALONG[:, a, None] * F[:, :, None]
            result.first.transpose(0, 3, 1, 2)[here, slots] += blend.transpose(0, 3, 1, 2)
            bend = np.stack([dy[:, :, i, :, None] * dy[:, :, j, None] for i, j in PAIRS], axis=2)
            ddF = np.einsum("kqdgm,kqpdg->kqpm", own.second, bend) + np.einsum("kqdm,kpd->kqpm", own.first, ddy)
            mixed = np.stack([ALONG[i, a] * dF[:, :, j] + ALONG[j, a] * dF[:, :, i] for i, j in PAIRS], axis=2)
            result.second.transpose(0, 3, 1, 2)[here, slots] += (b[..., None, None] * ddF + mixed).transpose(0, 3, 1, 2)
        return result


def _check_not_folded(x: np.ndarray, normal: np.ndarray, around: np.ndarray) -> None:
    """Raise RunStopped where the surface under a stencil has come to bend by more than a right angle."""
    alike = np.einsum("nmi,ni->nm", normal[around], normal).min(axis=1)
    worst = int(alike.argmin())
    if alike[worst] <= 0.0:
        place = ", ".join(f"{value:.6g}" for value in x[worst])
        text = f"the surface about node {worst} has come to bend so much that the stencil there folds over itself"
        advice = 'use more nodes, or interpolation = "loop"'
        raise RunStopped(f"{text}, near ({place}) m: {advice}", node=worst, position=tuple(x[worst].tolist()))


def _bow(corner: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """How far the middles of edges lie off their chords [m], shape (e, 3, 3), by corners and their normals, shape (e, 3, 3)."""
    bows = []
    for i, j in EDGES:
        mean = normal[:, i] + normal[:, j]
        mean /= np.linalg.norm(mean, axis=1)[:, None]
        sagitta = np.einsum("ei,ei->e", corner[:, j] - corner[:, i], normal[:, j] - normal[:, i]) / 8.0
        bows.append(sagitta[:, None] * mean)
    return np.stack(bows, axis=1)


def _parameters(corner: np.ndarray, bow: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (k, q, 3) of bowed triangles at shares (k, q, 3), first derivatives (k, q, 2, 3) and second ones (k, 3, 3)."""
    place = np.einsum("kqa,kai->kqi", share, corner)
    first = np.repeat(np.einsum("pa,kai->kpi", ALONG, corner)[:, None], share.shape[1], axis=1)
    second = np.zeros((len(corner), 3, 3))
    for number, (i, j) in enumerate(EDGES):
        rise = 4.0 * bow[:, number]
        place += (share[..., i] * share[..., j])[..., None] * rise[:, None]
        slope = share[..., i, None] * ALONG[:, j] + share[..., j, None] * ALONG[:, i]
        first += slope[..., None] * rise[:, None, None]
        second += np.array([ALONG[p, i] * ALONG[r, j] + ALONG[p, j] * ALONG[r, i] for p, r in PAIRS])[:, None] * rise[:, None]
    return place, first, second


def _union(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All different nodes of each element, shape (e, m), and where those of its stencils (e, 3, s) are among them.

    Where there are fewer than m, the last one repeated; it has its functions at its first place.
    """
    e, _, s = nodes.shape
    flat = nodes.reshape(e, -1)
    order = np.argsort(flat, axis=1, kind="stable")
    ranked = np.take_along_axis(flat, order, axis=1)
    rank = np.cumsum(np.diff(ranked, axis=1, prepend=ranked[:, :1]) > 0, axis=1).astype(np.int64)
    m = int(rank.max()) + 1
    union = np.repeat(ranked[:, -1:], m, axis=1)
    np.put_along_axis(union, rank, ranked, axis=1)
    slots = np.empty_like(flat)
    np.put_along_axis(slots, order, rank, axis=1)
    return union, slots.reshape(e, 3, s)
