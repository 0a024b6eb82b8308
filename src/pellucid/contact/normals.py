"""What two velocity fields are like about the nodes that both reach: the kernels of `pellucid.contact.detection`.

The nodes are listed and numbered; what is summed about a node is its moments, a row of COLUMNS.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy import uintp

from pellucid.grid.momentum import NOTHING
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit import kernel, pointwise
from pellucid.jit.parallel import parallel_by_colour

SMOOTH = 0.7
"""Least sum of a membrane's vector areas about a node, over its area at rest there, with which it has a normal of its own."""
MARGIN = 1e-6  # of a cell, for rounding
NORMAL, CENTRE, VOLUME, COLUMNS = 0, 3, 6, 7  # columns of an moments; of a surface its area at rest is the volume


class SharedNodes(NamedTuple):
    """Where the numbered nodes are, over all nodes of the grid."""

    slot: np.ndarray  # (nodes,) number of the node, -1 where it has none
    near: np.ndarray  # (nodes,) 1 where a stencil that begins here holds a numbered node
    box: np.ndarray  # (2, 3) the points beyond it reach none [m]


@pointwise
def reach_of_point(radius, volume):
    """How far the body reaches beyond a point of this volume [m], by its `half_width` (`pellucid.contact.surface`)."""
    half, scale, exponent = radius
    if half >= 0.0:
        return half
    size = volume * scale
    if exponent == 1.0 / 3.0:  # a fraction of the time of a power
        return 0.5 * np.cbrt(size)
    return 0.5 * (sqrt(size) if exponent == 0.5 else size)


@kernel()
def list_shared(first, second, node):
    """The nodes that have mass of both velocity fields into `node`; how many they are."""
    n = 0
    for I in range(len(first)):
        if first[I] > NOTHING and second[I] > NOTHING:
            node[n] = I
            n += 1
    return n


@kernel()
def mark_stencils(node, slot, near, reach, strides, on):
    """Number the nodes in `slot`, and flag the first nodes of all stencils that hold one of them; or take both back."""
    for e in range(len(node)):
        I = node[e]
        slot[I] = e if on else -1
        for a in range(reach[0]):
            for b in range(reach[1]):
                for c in range(reach[2]):
                    first = I - a * strides[0] - b * strides[1] - c * strides[2]
                    if first >= 0:
                        near[first] = 1 if on else 0


@kernel()
def bounding_box(node, lattice, reach, box):
    """The box, (2, 3) [m], of the points that may have weight at a listed node; stencils have `reach` nodes along each axis."""
    s, slow = lattice.strides, lattice.slab_axis
    middle = 1 if slow == 0 else 0  # the order of the axes in memory
    fast = 3 - slow - middle
    for d in range(3):
        box[0, d], box[1, d] = inf, -inf
    for e in range(len(node)):
        rest = node[e] % s[slow]
        for d, i in ((slow, node[e] // s[slow]), (middle, rest // s[middle]), (fast, rest % s[middle])):
            box[0, d], box[1, d] = min(box[0, d], i), max(box[1, d], i)
    for d in range(3):
        wide = 0.5 * reach[d] + MARGIN
        box[0, d] = lattice.lower[d] + (box[0, d] - wide) * lattice.cell
        box[1, d] = lattice.lower[d] + (box[1, d] + wide) * lattice.cell


@kernel(inline=True)
def beyond(box, x, p):
    """Whether a point lies outside the box."""
    below = x[p, 0] < box[0, 0] or x[p, 1] < box[0, 1] or x[p, 2] < box[0, 2]
    return below or x[p, 0] > box[1, 0] or x[p, 1] > box[1, 1] or x[p, 2] > box[1, 2]


@kernel(inner=True)
def _sum_moments_slab(s, mapped, where, areas, at_rest, sloped, moments, beside):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    slot, near, box = where.slot, where.near, where.box
    x = points.position
    surface = len(areas) > 0
    listed = slabs.first[s]
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if beyond(box, x, p):
            continue
        about = stencil(functions, lattice, x, p)
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        if near[about.start] == 0:
            continue
        beside[listed] = p
        listed += 1
        V = at_rest * points.mass[p] if surface else points.volume[p]
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0:
                        w = wx[a] * wy[b] * wz[c]
                        if surface:
                            for d in range(3):
                                moments[e, NORMAL + d] += w * areas[p, d]
                        elif sloped:
                            moments[e, NORMAL] += V * gx[a] * wy[b] * wz[c]
                            moments[e, NORMAL + 1] += V * wx[a] * gy[b] * wz[c]
                            moments[e, NORMAL + 2] += V * wx[a] * wy[b] * gz[c]
                        for d in range(3):
                            moments[e, CENTRE + d] += w * V * x[p, d]
                        moments[e, VOLUME] += w * V
    if listed < slabs.first[s + 1]:
        beside[listed] = -1


@kernel()
def sum_moments(n, mapped, where, areas, at_rest, sloped, moments, beside):
    """Sums about each numbered node: where `sloped` volume gradients, or of a membrane its `areas`; places and volumes.

    at_rest: area of a membrane by its mass. The points that reach such nodes are listed in `beside` from the slab's first one
    on, and after them -1.
    """
    parallel_by_colour(_sum_moments_slab, n, mapped.slabs.across, mapped, where, areas, at_rest, sloped, moments, beside)


@kernel(inner=True)
def _extents_slab(s, mapped, where, normal, radius, moments, ends):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    slot, near, box = where.slot, where.near, where.box
    x = points.position
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if beyond(box, x, p):
            continue
        about = stencil(functions, lattice, x, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        if near[about.start] == 0:
            continue
        V = points.volume[p]
        r = reach_of_point(radius, V)
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    w = wx[a] * wy[b] * wz[c]
                    if e >= 0 and w > 0.0:
                        along = x[p, 0] * normal[e, 0] + x[p, 1] * normal[e, 1] + x[p, 2] * normal[e, 2]
                        ends[0, e] = max(ends[0, e], r + along)
                        ends[1, e] = max(ends[1, e], r - along)
                        moments[e, CENTRE] += w * V * along
                        moments[e, VOLUME] += w * V


@kernel()
def extents_along(n, mapped, where, normal, radius, moments, ends):
    """Places along the normal of each numbered node and volumes, and how far points reach along it and against it, (2, n)."""
    parallel_by_colour(_extents_slab, n, mapped.slabs.across, mapped, where, normal, radius, moments, ends)


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


@kernel(inner=True)
def _foremost_slab(s, mapped, beside, slot, normal, radius, foremost, sign):
    functions, lattice = mapped.functions, mapped.lattice
    points, slabs = mapped.points, mapped.slabs
    surface, x = radius[0] >= 0.0, points.position
    for q in range(slabs.first[s], slabs.first[s + 1]):
        if beside[q] < 0:
            break
        p = uintp(beside[q])
        about = stencil(functions, lattice, x, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        r = radius[0] if surface else reach_of_point(radius, points.volume[p])
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0 and wx[a] * wy[b] * wz[c] > 0.0:
                        along = x[p, 0] * normal[e, 0] + x[p, 1] * normal[e, 1] + x[p, 2] * normal[e, 2]
                        foremost[e] = max(foremost[e], sign * along + r)


@kernel()
def foremost_along(n, mapped, beside, slot, normal, radius, foremost, sign):
    """How far the points beside the nodes reach along sign times the normals [m], each with its own extent; (n,)."""
    parallel_by_colour(_foremost_slab, n, mapped.slabs.across, mapped, beside, slot, normal, radius, foremost, sign)


@kernel()
def membrane_normals(moments, normal, crumpled):
    """Unit normals of a membrane, and flags of the nodes about which its vector areas nearly cancel."""
    for e in range(len(moments)):
        a, b, c = moments[e, NORMAL], moments[e, NORMAL + 1], moments[e, NORMAL + 2]
        size = sqrt(a * a + b * b + c * c)
        crumpled[e] = size < SMOOTH * moments[e, VOLUME]
        scale = 1.0 / size if size > 0.0 else 0.0
        normal[e, 0], normal[e, 1], normal[e, 2] = scale * a, scale * b, scale * c


@kernel()
def orient_membrane_normals(surface, volume, ends, sign, normal, foremost):
    """Turn the normals of a membrane from the first side to the second, as `orient` does, for a volume of this sign.

    volume: its moments as `extents_along` leaves them; foremost, (n,): of what the volume reaches along the normals and
    against them, `ends`, that towards the membrane.
    """
    for e in range(len(normal)):
        a, b, c = normal[e, 0], normal[e, 1], normal[e, 2]
        m = surface[e, VOLUME]
        place = (a * surface[e, CENTRE] + b * surface[e, CENTRE + 1] + c * surface[e, CENTRE + 2]) / m
        ahead = volume[e, CENTRE] / volume[e, VOLUME] >= place
        foremost[e] = ends[1, e] if ahead else ends[0, e]
        if ahead == (sign > 0.0):
            normal[e, 0], normal[e, 1], normal[e, 2] = -a, -b, -c


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
