"""What two velocity fields are like about the nodes that both reach: the kernels of `pellucid.contact.detection`.

The nodes are listed and numbered; what is summed about a node is its moments, a row of COLUMNS.
"""

from math import sqrt
from typing import Annotated, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.contact.shared import beyond
from pellucid.grid.folding import seen_from
from pellucid.grid.nodal_fields import MAX, STEP, SUM, NodalField
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit import kernel, pointwise
from pellucid.jit.elementary import cube_root
from pellucid.jit.loops import parallel_loop_by_colour
from pellucid.jit.vector import load, row, splat, store

NORMAL, VOLUME, CENTRE, COLUMNS = 0, 3, 4, 8
"""Columns of moments, two vectors; of a surface its area at rest is the volume."""


class Areas(NamedTuple):
    """What the points of a body have of its surface."""

    vector: np.ndarray  # (m, 3) vector areas, outwards [m²]; no rows of a volume, which has the gradients of its volumes
    at_rest: float = 0.0  # area of a membrane by its mass [m²/kg]


class Along(NamedTuple):
    """The ways along which a side reaches at the numbered nodes: sign times the normals."""

    normal: np.ndarray  # (n, 3)
    sign: float


class NumberedNodes(NamedTuple):
    """What is known of the nodes that two velocity fields share, by their numbers; of either side where there are several."""

    moments: Annotated[
        np.ndarray,
        NodalField(COLUMNS, SUM, STEP, "m², m³, m⁴", "normal, volume, centre of a body about it", several=True),
    ]
    foremost: Annotated[np.ndarray, NodalField(1, MAX, STEP, "m", "how far a body reaches along the normal", several=True)]


@pointwise
def reach_of_point(radius, volume):
    """How far the body reaches beyond a point of this volume [m], by its `half_width` (`pellucid.contact.contact_body`)."""
    half, scale, exponent = radius
    if half >= 0.0:
        return half
    size = volume * scale
    if exponent == 1.0 / 3.0:
        return 0.5 * cube_root(size)
    return 0.5 * (sqrt(size) if exponent == 0.5 else size)


@parallel_loop_by_colour(gives="moments")
def sum_moments(s, mapped, where, areas, moments, beside):
    """Sums about each numbered node: vector areas, or where `areas` has no rows volume gradients; places and volumes.

    moments: an `OfListed` of shape (n COLUMNS,). The points that reach such nodes are listed in `beside` from the slab's first
    one on, and after them -1.
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    slot, near, values = where.slot, where.near, moments.values
    x = points.position
    vector = areas.vector
    surface = len(vector) > 0
    listed = slabs.first[s]
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if beyond(where, x, p):
            continue
        about = stencil(functions, lattice, x, p)
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        if near[about.start] == 0:
            continue
        beside[listed] = p
        listed += 1
        V = areas.at_rest * points.mass[p] if surface else points.volume[p]
        shared = row(vector[p, 0], vector[p, 1], vector[p, 2], V) if surface else splat(V)
        place = (x[p, 0], x[p, 1], x[p, 2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0:
                        w, at = wx[a] * wy[b] * wz[c], COLUMNS * e
                        share = (
                            splat(w) if surface else row(gx[a] * wy[b] * wz[c], wx[a] * gy[b] * wz[c], wx[a] * wy[b] * gz[c], w)
                        )
                        x0, x1, x2 = seen_from(lattice.folding, lattice, about, place, a, b, c)
                        centre = row(V * x0, V * x1, V * x2, 0.0)
                        store(values, at, load(values, at) + share * shared)
                        store(values, at + CENTRE, load(values, at + CENTRE) + w * centre)
    if listed < slabs.first[s + 1]:
        beside[listed] = -1


@kernel()
def orient(one, other, normal):
    """Make of directions unit normals from one side to the other; zero where there is none."""
    for e in range(len(normal)):
        length = across = 0.0
        for d in range(3):
            length += normal[e, d] * normal[e, d]
            apart = other[e, CENTRE + d] / other[e, VOLUME] - one[e, CENTRE + d] / one[e, VOLUME]
            across += normal[e, d] * apart
        scale = 0.0
        if length > 0.0:
            scale = 1.0 / sqrt(length) if across >= 0.0 else -1.0 / sqrt(length)
        for d in range(3):
            normal[e, d] *= scale


@parallel_loop_by_colour(gives="foremost")
def foremost_along(s, mapped, where, beside, along, radius, foremost):
    """How far the points beside the numbered nodes reach along sign times the normals [m], each with its own extent; an
    `OfListed` of shape (n,)."""
    functions, lattice, slot = mapped.functions, mapped.lattice, where.slot
    normal, sign = along.normal, along.sign
    points, slabs = mapped.points, mapped.slabs
    surface, x = radius[0] >= 0.0, points.position
    for q in range(slabs.first[s], slabs.first[s + 1]):
        if beside[q] < 0:
            break
        p = uintp(beside[q])
        about = stencil(functions, lattice, x, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        r, position = radius[0] if surface else reach_of_point(radius, points.volume[p]), (x[p, 0], x[p, 1], x[p, 2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0 and wx[a] * wy[b] * wz[c] > 0.0:
                        x0, x1, x2 = seen_from(lattice.folding, lattice, about, position, a, b, c)
                        place = x0 * normal[e, 0] + x1 * normal[e, 1] + x2 * normal[e, 2]
                        foremost.values[e] = max(foremost.values[e], sign * place + r)


@kernel()
def keep_widest_gap(candidate, foremost, normal, gap):
    """Take the candidates along which the two sides lie further apart than along the normals so far."""
    for e in range(len(gap)):
        n0, n1, n2 = candidate[e, 0], candidate[e, 1], candidate[e, 2]
        apart = -foremost[0, e] - foremost[1, e]
        if apart > gap[e] and (n0 != 0.0 or n1 != 0.0 or n2 != 0.0):
            gap[e] = apart
            normal[e, 0], normal[e, 1], normal[e, 2] = n0, n1, n2


@kernel()
def drop_open_gaps(gap, most, normal):
    """No normal where surfaces are further apart than `most`."""
    for e in range(len(gap)):
        if gap[e] > most:
            normal[e, 0] = normal[e, 1] = normal[e, 2] = 0.0
