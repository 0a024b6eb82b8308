"""The triangulated surface of membrane points: neighbours, normals, area shares, forces of a pressure, tears without damage,
and the nonlocal mean of a field over a radius of the initial surface.

Weights of the mean are (1 - r²/R²)² times the area share of the neighbour, divided by their sum, with the straight distance r
at the start: Pijaudier-Cabot & Bažant 1987, J. Eng. Mech. 113, 1512; the bell function of Bažant & Ožbolt 1990, J. Eng. Mech.
116, 2485. Its arrays are in the order of point numbers, independent of sorting, and each sum has a fixed order: results are
bitwise equal for any number of threads.
"""

from typing import NamedTuple

import numpy as np
from numpy import uintp
from scipy.spatial import cKDTree

from pellucid.geometry.meshes.triangulation import axes_along
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_fields import aligned_rows
from pellucid.grid.points import place_of
from pellucid.grid.stencil import add_vector, stencil
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour
from pellucid.materials.damage import has_failed


class Fans(NamedTuple):
    """The triangles of a membrane, and for each point p the list of the triangles around the point, at the indices start[p]
    to start[p + 1] of `corners` and `triangle`.

    Triangles are numbered in the order of their points, so that neighbouring triangles are close in memory.
    """

    start: np.ndarray  # (n+1,) index in `corners` and `triangle` of the first triangle of each point
    corners: np.ndarray  # (3 m, 2) for each triangle around a point, its other two corners, counterclockwise
    triangle: np.ndarray  # (3 m,) numbers of the triangles around the points, in the order of `corners`
    triangles: np.ndarray  # (m, 3) points at the corners of the m triangles
    normals: np.ndarray  # (4 m,) unit normal and area [m²] of each triangle, computed by `find_normals`


def fans_of(triangles: np.ndarray, n: int) -> Fans:
    """List the triangles around each of n points. triangles: shape (m, 3), counterclockwise around the normal. The normals are
    not computed yet."""
    triangles = triangles[np.argsort(triangles.min(axis=1), kind="stable")].astype(np.int32)
    a, b, c = triangles.T
    owner = np.concatenate([a, b, c])
    corners = np.concatenate([np.stack(pair, axis=1) for pair in ((b, c), (c, a), (a, b))])
    order = np.argsort(owner, kind="stable")
    start = np.searchsorted(owner[order], np.arange(n + 1))
    number = (order % len(triangles)).astype(np.int32)
    return Fans(start, np.ascontiguousarray(corners[order]), number, triangles, aligned_rows(len(triangles)).reshape(-1))


def area_shares(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return a third of the area of all triangles around each point [m²], shape (n,). position: [m], shape (n, 3); triangles:
    shape (m, 3).
    """
    a, b, c = position[triangles.T]
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.bincount(triangles.ravel(), np.repeat(area / 3.0, 3), minlength=len(position))


def initial_frames(position: np.ndarray, triangles: np.ndarray, direction: np.ndarray | None = None) -> np.ndarray:
    """Return the initial frames of the points (rows t₁, t₂, n), shape (n, 9); the normal n is the normalised mean of the
    unit normals of the triangles around a point (Gan 2011, eq. 8).

    position: positions of the points [m], shape (n, 3); triangles: shape (m, 3); direction: vector, shape (3,), whose
    projection onto the surface has the direction of t₁; None: any tangent.
    """
    a, b, c = position[triangles.T]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    mean = np.zeros_like(position)
    for corner in triangles.T:
        np.add.at(mean, corner, normal)
    third = mean / np.linalg.norm(mean, axis=1)[:, None]
    # where any tangent will do, take the axis that is farthest from the normal
    away = np.eye(3)[np.argmin(np.abs(third), axis=1)] if direction is None else direction
    return np.ascontiguousarray(np.concatenate([*axes_along(away, mean), third], axis=1))


@parallel_loop_by_colour(gives="load")
def press(s, mapped, surface, load, pressure):
    """Add the forces of a pressure [Pa] along the normals of a membrane's points in slab s (a layer of grid cells) to the
    nodal forces `load` [N].

    mapped: data of the points for transfers to the grid; surface: a `StrainedMembrane`. Points that have failed leave a hole,
    on which no pressure acts.
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    start, corners = surface.fans.start, surface.fans.corners
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if has_failed(surface.damage, surface.record, p):
            continue
        fx = fy = fz = 0.0
        for t in range(start[p], start[p + 1]):
            i, j = corners[t, 0], corners[t, 1]
            ax, ay, az = x[i, 0] - x[p, 0], x[i, 1] - x[p, 1], x[i, 2] - x[p, 2]
            bx, by, bz = x[j, 0] - x[p, 0], x[j, 1] - x[p, 1], x[j, 2] - x[p, 2]
            fx += ay * bz - az * by
            fy += az * bx - ax * bz
            fz += ax * by - ay * bx
        # a third of the vector area of each triangle: over a closed surface these sum to zero exactly
        force = (pressure / 6.0 * fx, pressure / 6.0 * fy, pressure / 6.0 * fz)
        add_vector(stencil(functions, lattice, x, p), lattice, load, force)


LONGEST = 1.5
"""Longest admissible edge in cells. A strip with edges of half a cell at the start carries its load until the edges are 1.1
cells long, for linear functions and quadratic splines. After that, one edge takes all of the stretch, and the others lose
their tension."""


def torn(name: str, place: np.ndarray, triangles: np.ndarray, failed: np.ndarray, grid: Grid) -> str | None:
    """Return a warning about the longest edge of membrane `name`; None if no edge is longer than `LONGEST` grid cells.

    place: positions of its points [m], shape (n, 3); triangles: shape (m, 3); failed: mask of the points that failed by
    damage, shape (n,), whose edges are not checked. Lengths along an axis that is one cell thick are ignored.
    """
    corners = np.where(np.array(grid.thin), 0.0, place)[triangles]
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    length[failed[triangles].any(axis=1)] = 0.0
    worst, cell = int(np.argmax(length)), grid.lattice.cell
    if length[worst] <= LONGEST * cell:
        return None
    centre = ", ".join(f"{value:.4g}" for value in place[triangles[worst]].mean(axis=0))
    return (
        f"membrane {name} is torn: its triangle at ({centre}) m is {length[worst]:.3g} m long, {length[worst] / cell:.2g} "
        f"cells of {cell:g} m; beyond {LONGEST:g} the grid velocities have gaps between its points, which carry no "
        f'tension and let other bodies through; use a finer surface, or kind = "membrane-elements"'
    )


CHUNK = 256  # points that a thread processes at a time


class Neighbours(NamedTuple):
    """The neighbours of n points within the radius of a nonlocal mean, the weights of the mean, and its argument and
    result: the local field and the weighted means."""

    start: np.ndarray  # (n + 1,) index in `neighbour` of the first neighbour of each point
    neighbour: np.ndarray  # numbers of the neighbours, point by point
    weight: np.ndarray  # weights of the neighbours; their sum is 1 for each point
    local: np.ndarray  # (n,) the field to be averaged
    mean: np.ndarray  # (n,) the weighted means


@parallel_loop()
def _mean(chunk, about):
    start, neighbour, weight, local, mean = about.start, about.neighbour, about.weight, about.local, about.mean
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mean))):
        total = 0.0
        for k in range(start[i], start[i + 1]):
            total += weight[k] * local[uintp(neighbour[k])]
        mean[i] = total


class NonlocalMean:
    """Computes weighted means of a field over a radius [m] around n points with initial positions [m], shape (n, 3), and areas
    [m²], shape (n,).

    Callers write the field to `local`; `update` computes `mean`. Both have the shape (n,), in the order of point numbers.
    """

    def __init__(self, position: np.ndarray, area: np.ndarray, radius: float) -> None:
        n = len(position)
        pairs = cKDTree(position).query_pairs(radius, output_type="ndarray").astype(np.int32)
        itself = np.arange(n, dtype=np.int32)
        owner = np.concatenate([pairs[:, 0], pairs[:, 1], itself])
        neighbour = np.concatenate([pairs[:, 1], pairs[:, 0], itself])
        order = np.lexsort((neighbour, owner))
        owner, neighbour = owner[order], neighbour[order]
        squared = ((position[neighbour] - position[owner]) ** 2).sum(axis=1) / radius**2
        weight = (1.0 - np.minimum(squared, 1.0)) ** 2 * area[neighbour]
        weight /= np.bincount(owner, weight, minlength=n)[owner]
        self.local, self.mean = np.zeros(n), np.zeros(n)
        start = np.searchsorted(owner, np.arange(n + 1))
        self._neighbours = Bundle(Neighbours(start, neighbour, weight, self.local, self.mean))

    def update(self) -> None:
        """Compute the weighted means `mean` of the present values of the field `local`."""
        _mean((len(self.mean) + CHUNK - 1) // CHUNK, self._neighbours)
