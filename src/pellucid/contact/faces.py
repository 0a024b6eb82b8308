"""Where the surfaces of bodies lie about a node: means over points on them, which are as exact on curved faces as on flat ones.

A foremost point may lie a cell beside the node: on a sphere of radius R it tells at a place r of a depth r h/R that is not
there yet, an error of first order in the cell h. The mean over the points about the node, with the weights N_I of the
velocities that contact stops, has one of second order.
"""

from typing import NamedTuple

import numpy as np

from pellucid.contact.normals import CENTRE, NORMAL, VOLUME
from pellucid.contact.shared import beyond
from pellucid.grid.folding import seen_from
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop_by_colour


class FaceAreas(NamedTuple):
    """The areas of points on a surface, as kernels take them."""

    vector: np.ndarray  # (m, 3) the share of the vector area of each, outwards [m²]
    half_width: float = 0.0  # how far the body reaches beyond them [m]
    two_sided: bool = False  # whether others may meet them from either side


class Faces(NamedTuple):
    """Points on a surface."""

    mapped: Bundle  # as the kernels over points take them
    n_slabs: int  # number of slabs into which they are divided
    areas: FaceAreas


@parallel_loop_by_colour(gives="sums")
def sum_places(s, mapped, where, areas, along, sums):
    """Areas that face along sign times the normal of each numbered node, and these times the places along it, (n, 2).

    areas: `FaceAreas`; along: an `Along` of `pellucid.contact.normals`; sums: an `OfListed`.
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    normal, sign, vector = along.normal, along.sign, areas.vector
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if beyond(where, x, p):
            continue
        about = stencil(functions, lattice, x, p)
        wx, wy, wz, place = about.wx, about.wy, about.wz, (x[p, 0], x[p, 1], x[p, 2])
        if where.near[about.start] == 0:
            continue
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = where.slot[node_at(about, lattice, a, b, c)]
                    if e >= 0:
                        n0, n1, n2 = normal[e, 0], normal[e, 1], normal[e, 2]
                        facing = sign * (vector[p, 0] * n0 + vector[p, 1] * n1 + vector[p, 2] * n2)
                        w = wx[a] * wy[b] * wz[c] * (abs(facing) if areas.two_sided else max(0.0, facing))
                        sums.values[e, 0] += w
                        x0, x1, x2 = seen_from(lattice.folding, lattice, about, place, a, b, c)
                        sums.values[e, 1] += w * (x0 * n0 + x1 * n1 + x2 * n2 + sign * areas.half_width)


def mean_places(sums: np.ndarray) -> np.ndarray:
    """How far the first side reaches along the normals, and the second against them [m], shape (2, n), from such sums.

    Infinite where a side has no face: there the direction tells nothing.
    """
    area, place = sums[:, :, 0], sums[:, :, 1]
    means = np.where(area > 0.0, place / np.where(area > 0.0, area, 1.0), np.inf)
    means[1] = np.where(area[1] > 0.0, -means[1], np.inf)
    return np.asarray(means)


def move_inwards(moments: np.ndarray, distance: float) -> None:
    """Put the centres of moments, shape (n, COLUMNS), this [m] behind the faces, where the body is."""
    outwards = moments[:, NORMAL:VOLUME]
    size = np.linalg.norm(outwards, axis=1, keepdims=True)
    moments[:, CENTRE : CENTRE + 3] -= distance * moments[:, VOLUME:CENTRE] * outwards / np.where(size > 0.0, size, 1.0)
