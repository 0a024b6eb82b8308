"""Kernels for the position of points of one surface relative to another surface.

The other surface is given by points x_q with normals n_q and area vectors. At a place x, the tangent planes of the points
that face it are averaged, with weights w that extend over a few points, in two ways: the mean of n_q·(x - x_q), and n·(x -
x̄) with the mean normal n and the mean position x̄. On a surface of radius R and for weights of variance s² the first has
the error -s²/2R and the second s²/2R, so that their mean is the distance up to third order. (The first is the implicit
moving-least-squares surface of Kolluri 2008, ACM Trans. Algorithms 4, 18.)

The weights extend beyond the rim of a surface that ends. There, their sum is smaller than on an unlimited plane. The
contact area of the point decreases from its full value at three quarters of that sum to zero at one quarter; it is half at
the rim. A place outside the plane of its nearest point is not inside the body, although it may be behind the plane of
another side. It is not in contact if the two sides form a corner, so that a body that slides over an edge or a joint is not
held there, or if its depth behind the averaged planes exceeds its height above the plane of the nearest point. The contact
area of a node of a sheet decreases gradually beyond such a corner: these nodes stay near a rim for long, and with their full
depth on one side of the rim and none on the other they would gain energy each time they pass it.
"""

from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy import uintp

from pellucid.contact.contact_surface import FULL_CONTACT, NO_CONTACT
from pellucid.jit import kernel, pointwise
from pellucid.jit.loops import parallel_loop
from pellucid.jit.space import Vector3, cross, set_vector, vector_at

CHUNK = 256  # number of points per chunk of a thread
CLEAR = 0.5  # largest distance from the plane of the nearest point for an overlap, in reaches
CORNER = 0.5  # cosine between the normals of two sides below which they form a corner
ALONE = 1e-4  # smallest spread of points for a correction of the weights, in squared reaches
BEYOND = 0.25  # distance beyond a corner over which the contact area of sheet nodes fades, in reaches
GAP, SHARE, WEIGHT, NORMAL, SLOPE, LEVEL, COLUMNS = 0, 1, 2, 3, 6, 9, 10
"""Columns of the results of a point: distance [m], factor of the contact area, sum of the weights, normal of the other
surface, and the linear correction of the weights (slope [1/m] and value at the point), with which their mean position is
the foot of the point."""
LEAST_FACING = 1e-6


class Asking(NamedTuple):
    """Points of one surface whose position relative to another surface is computed; m is their number."""

    place: np.ndarray  # (m, 3) positions [m]
    normal: np.ndarray  # (m, 3) unit normals


class Points(NamedTuple):
    """Points of the other surface, which define its position; m is their number."""

    place: np.ndarray  # (m, 3) positions [m]
    normal: np.ndarray  # (m, 3) unit normals
    area: np.ndarray  # (m,) areas [m²]
    reach: np.ndarray  # (m,) radius of the weights of a point along the surface [m]


class Candidates(NamedTuple):
    """Points of one surface that are near the other surface (candidates), and for each candidate the points of the other
    surface within the search radius.

    Indices are in ascending order.
    """

    asks: np.ndarray  # (n,) points of the one surface
    first: np.ndarray  # (n + 1,) start of the list of each point in `near`
    near: np.ndarray  # points of the other surface


class Meeting(NamedTuple):
    """Parameters of the contact of two surfaces, the one that searches and the other one."""

    two_sided: tuple[bool, bool]  # for both surfaces, True if both sides can be in contact
    deepest: float  # largest depth behind a plane that counts as contact [m]
    dimension: int  # dimension of the surfaces: 2 in 3-D, 1 in the plane, 0 along a line
    thickness: float  # thickness of a slice [m]
    any_way: bool = False  # True to ignore the direction of normals: nodes of a sheet
    slack: float = 0.0  # excess of a depth over the height above the nearest point's plane that still counts as contact [m]


class Found(NamedTuple):
    """Result arrays for n candidates with k points in their lists: weights, feet, and data of the overlap. The kernels of
    this module fill them.

    The data of the feet and of the overlap have one entry for each candidate that is near enough, in the order of the
    candidates.
    """

    beside: np.ndarray  # (n, COLUMNS) distance, factor of the contact area, weights and normal of candidates, see `GAP`
    end: np.ndarray  # (n,) end of the points with weight in the list of each candidate
    heavy: np.ndarray  # (k,) points with weight, at the start of each list
    weight: np.ndarray  # (k,) weights of these points
    first: np.ndarray  # (n + 1,) start of the entries of each foot in `point` and `share`
    point: np.ndarray  # (k,) points of the other surface
    share: np.ndarray  # (k,) weights of these points in the position of a foot
    listed: np.ndarray  # (n,) indices of the overlapping points
    depth: np.ndarray  # (n,) depths [m]
    normal: np.ndarray  # (n, 3) outward unit normals of the other surface
    area: np.ndarray  # (n,) effective areas [m²]
    relative: np.ndarray  # (n, 3) velocities relative to the other surface [m/s]
    new: np.ndarray  # (n,) mask of the points without force in the previous step


def make_room(n: int, k: int) -> Found:
    """Return empty result arrays for n candidates with k points in their lists."""
    feet = np.zeros(n + 1, np.int64), np.zeros(k, np.int64), np.zeros(k)
    overlap = np.zeros(n, np.int64), np.zeros(n), np.zeros((n, 3)), np.zeros(n), np.zeros((n, 3)), np.zeros(n, bool)
    return Found(np.zeros((n, COLUMNS)), np.zeros(n, np.int64), np.zeros(k, np.int64), np.zeros(k), *feet, *overlap)


class Neighbourhood(NamedTuple):
    """The points of both surfaces and the parameters of their contact, bundled as an argument of kernels."""

    one: Asking
    other: Points
    meeting: Meeting


@pointwise
def _beside(other, q, x):
    """Return the vector from point q of the other surface to the place x [m]."""
    return x - vector_at(other.place, q)


@pointwise
def _weight(other, meeting, q, square, along, n, gain):
    """Return the weight of point q of the other surface in the mean planes at a place; then the normal of q, reversed if
    needed so that it points to the side of the place, and the height of the place above the plane of q with this normal [m].

    meeting: a `Meeting`. square, along: squared distance of the place from q, and its height with the normal of q. n: normal
    of the surface point at the place. gain: for nodes of a sheet, factor of the cosine between the normals, with which the
    best aligned point has full weight.
    """
    two_sided, deepest, dimension, thickness = meeting.two_sided, meeting.deepest, meeting.dimension, meeting.thickness
    m, reach = vector_at(other.normal, q), other.reach[q]
    apart, whole = square - along * along, reach * reach
    if apart >= whole:
        return 0.0, m, along
    facing, height = -(n @ m), along
    if two_sided[1] and facing < 0.0:
        m, facing, height = -m, -facing, -along
    if two_sided[0]:
        facing = min(1.0, abs(facing) * gain) if gain > 0.0 else 1.0
    if facing <= 0.0 or height < -deepest or height > reach:
        return 0.0, m, height
    rest, unlimited = whole - apart, whole * whole * thickness**2
    if dimension > 0:
        unlimited = whole * whole * (pi * whole / 3.0 if dimension == 2 else 16.0 / 15.0 * reach * thickness)
    return rest * rest * facing * other.area[q] / unlimited, m, height


@pointwise
def _asking(one, p):
    """Return the position [m] and the normal of point p of the surface `one` (an `Asking`)."""
    return vector_at(one.place, p), vector_at(one.normal, p)


@kernel(inner=True)
def _gain(about, candidates, e, x, n):
    """Return the reciprocal of the largest cosine between the normal n of a sheet node at x and the normals of the points of
    the other surface with weight; 0 if all cosines are zero: then all points have full weight.

    about: a `Neighbourhood`. e: index of the node in `candidates`.
    """
    other, largest = about.other, 0.0
    for r in range(candidates.first[e], candidates.first[e + 1]):
        q = uintp(candidates.near[r])
        d = _beside(other, q, x)
        w, m, _ = _weight(other, about.meeting, q, d @ d, d @ vector_at(other.normal, q), n, 0.0)
        if w > 0.0:
            largest = max(largest, abs(n @ m))
    return 1.0 / largest if largest > LEAST_FACING else 0.0


@kernel(inner=True)
def _sum_weights(about, candidates, e, x, n, results):
    """Return the sums Σ w, Σ w d·m, Σ w m and Σ w d over the points of the other surface, with the weights w, the normals m and
    the vectors d to candidate e; then the index of the nearest point of the other surface, and the height of the candidate
    above the plane of this point [m].

    about: a `Neighbourhood`. x, n: position [m] and normal of the candidate. The points with weight and their weights are
    stored in `results`, from the first place of the candidate's list on.
    """
    other, meeting, weight, heavy, near = about.other, about.meeting, results.weight, results.heavy, candidates.near
    gain = _gain(about, candidates, e, x, n) if meeting.any_way else 1.0
    nearest, outside, closest = inf, 0.0, uintp(0)
    s0 = s1 = 0.0
    normals = beside = Vector3(0.0, 0.0, 0.0)
    begin, end = candidates.first[e], candidates.first[e]
    for r in range(begin, candidates.first[e + 1]):
        q = uintp(near[r])
        d = _beside(other, q, x)
        square, along = d @ d, d @ vector_at(other.normal, q)
        if square < nearest and other.area[q] > 0.0:
            nearest, outside, closest = square, along, q
        w, m, height = _weight(other, meeting, q, square, along, n, gain)
        if w > 0.0:
            weight[end], heavy[end] = w, near[r]
            end += 1
            s0, s1 = s0 + w, s1 + w * height
            normals, beside = normals + w * m, beside + w * d
    results.end[e] = end
    return s0, s1, normals, beside, closest, outside


@parallel_loop()
def find_beside(chunk, about, candidates, clear, results):
    """Compute, for each candidate of one surface, its distance from the other surface, the normal of that surface, the weights
    of its points and the factor of the contact area; the factor is 0 for candidates at the distance `clear` [m] or more.

    about: a `Neighbourhood`. candidates: a `Candidates`. results: a `Found`, whose `beside`, `end`, `heavy` and `weight` are
    filled.
    """
    other, meeting, found = about.other, about.meeting, results.beside
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(candidates.asks))):
        found[p, SHARE] = 0.0
        x, n = _asking(about.one, uintp(candidates.asks[p]))
        weight, height, normals, beside, closest, outside = _sum_weights(about, candidates, p, x, n, results)
        if abs(outside) > clear + CLEAR * other.reach[closest] and (meeting.two_sided[1] or outside > 0.0):
            continue  # it lies too far above to overlap
        if weight <= NO_CONTACT:
            continue
        size = sqrt(normals @ normals)
        if size < 0.3 * weight:  # the normals of the points that face it have no common direction
            continue
        n, e = normals / size, beside / weight
        gap = 0.5 * (height / weight + n @ e)
        if gap >= clear:
            continue
        share = min(1.0, (weight - NO_CONTACT) / (FULL_CONTACT - NO_CONTACT))
        turned = n @ vector_at(other.normal, closest) < CORNER
        if not meeting.two_sided[1] and outside > 0.0 and (turned or outside < -gap - meeting.slack):
            fades = meeting.any_way and turned
            share *= max(0.0, 1.0 - outside / (BEYOND * other.reach[closest])) if fades else 0.0
        found[p, GAP], found[p, SHARE], found[p, WEIGHT] = gap, share, weight
        found[p, NORMAL], found[p, NORMAL + 1], found[p, NORMAL + 2] = n.x, n.y, n.z
        if share > 0.0:
            alone = ALONE * other.reach[closest] ** 2
            _find_slope(about, candidates.first[p], results, p, x, n, e, alone)


@kernel(inner=True)
def _find_slope(about, first, results, p, x, n, e, alone):
    """Compute the linear correction c of the weights w of the points of the other surface, such that Σ w (1 + c·(d - e)) d = 0
    along the surface, with the vectors d from these points to point p; store it in row p of `Found.beside`.

    first: start of the list of the point. x: position of the point [m]. n: normal of the surface. e: weighted mean of d.
    alone: square of a distance [m²]; if the points are closer together, the correction tends to zero.
    """
    other, found, heavy, weight = about.other, results.beside, results.heavy, results.weight
    found[p, LEVEL] = 1.0
    for a in range(3):
        found[p, SLOPE + a] = 0.0
    if about.meeting.dimension == 0:
        return
    # two directions along the surface
    if abs(n.x) <= abs(n.y) and abs(n.x) <= abs(n.z):
        t = Vector3(0.0, -n.z, n.y)
    elif abs(n.y) <= abs(n.z):
        t = Vector3(n.z, 0.0, -n.x)
    else:
        t = Vector3(-n.y, n.x, 0.0)
    t = t / sqrt(t @ t)
    u = cross(n, t)
    tt = tu = uu = 0.0
    for r in range(first, results.end[p]):
        d, w = _beside(other, uintp(heavy[r]), x) - e, weight[r]
        along_t, along_u = t @ d, u @ d
        tt, tu, uu = tt + w * along_t * along_t, tu + w * along_t * along_u, uu + w * along_u * along_u
    scale = 1.0 / found[p, WEIGHT]
    tt, tu, uu = scale * tt, scale * tu, scale * uu
    et, eu = t @ e, u @ e
    least = 1e-3 * (tt + uu) + alone  # in a plane problem the points have no spread across the slice
    tt, uu = tt + least, uu + least
    whole = tt * uu - tu * tu
    if not whole > 0.0:
        return
    a, b = -(uu * et - tu * eu) / whole, -(tt * eu - tu * et) / whole
    slope = a * t + b * u
    found[p, SLOPE], found[p, SLOPE + 1], found[p, SLOPE + 2] = slope.x, slope.y, slope.z
    found[p, LEVEL] = 1.0 - a * et - b * eu


@kernel()
def measure_depths(
    about, candidates, results, counts, weights, velocity, of_other, images, width, most, from_feet, by_own_normals
):
    """Compute the depths, contact areas and relative velocities of the candidates that are closer than `most` [m] to the
    other surface, with their feet (projections on the other surface), and write them to `results`; return the number of
    these candidates.

    Parameters
    ----------
    about, candidates, results
        A `Neighbourhood`, a `Candidates`, and a `Found` in which `find_beside` has stored distances and weights.
    counts, weights
        Factors of the contact areas and areas [m²] of the points of the surface with the candidates, shape (m,); points with
        the factor 0 are omitted.
    velocity, of_other
        Velocities of the points of both surfaces [m/s], shape (m, 3) and (q, 3).
    images
        Original points and signs of the images of the other surface, see `pellucid.contact.images.Images`.
    width
        Distance of the surfaces at which they touch [m].
    from_feet
        True to measure depths from the feet, on which the forces act, as required for deforming surfaces: with another
        distance they would gain energy when they vibrate. False to measure from the surface itself.
    by_own_normals
        True to measure depths along the normals of the points instead of the normals of the other surface.
    """
    one, other, found, i, k, own = about.one, about.other, results.beside, 0, 0, len(of_other)
    for e in range(len(candidates.asks)):
        p = uintp(candidates.asks[e])
        gap, area = found[e, GAP], found[e, SHARE] * counts[p]
        if not area > 0.0 or gap >= most:
            continue
        x, m = _asking(one, p)
        # corrected weights have the sum one, and the mean position with these weights is the foot
        scale, level = 1.0 / found[e, WEIGHT], found[e, LEVEL]
        slope = Vector3(found[e, SLOPE], found[e, SLOPE + 1], found[e, SLOPE + 2])
        foot = moves = Vector3(0.0, 0.0, 0.0)
        results.first[i] = k
        for r in range(candidates.first[e], results.end[e]):
            q = results.heavy[r]
            d = _beside(other, uintp(q), x)
            w = scale * results.weight[r] * (level + slope @ d)
            results.point[k], results.share[k] = q, w
            k += 1
            foot = foot + w * d
            if q < own:
                moves = moves + w * vector_at(of_other, q)
            else:
                flip, v = vector_at(images.flip, q - own), vector_at(of_other, images.point[q - own])
                moves = moves + w * Vector3(flip.x * v.x, flip.y * v.y, flip.z * v.z)
        n = Vector3(found[e, NORMAL], found[e, NORMAL + 1], found[e, NORMAL + 2])
        if by_own_normals:
            n = (1.0 if m @ n > 0.0 else -1.0) * m
        if from_feet:
            gap = n @ foot
        results.listed[i], results.depth[i], results.area[i] = p, width - gap, area * weights[p]
        set_vector(results.normal, i, n)
        set_vector(results.relative, i, vector_at(velocity, p) - moves)
        i += 1
    results.first[i] = k
    return i


@kernel()
def keep_touching(results, n, pushed, step, ahead):
    """Remove the points without overlap from the first n points of `results`; return the number of remaining points and the
    number of weights of their feet.

    pushed: points that had forces in the previous step, in ascending order; other points are new. ahead: True to keep also the
    points of `pushed` and points that would enter within 1.5 steps. step: step size [s].
    """
    first, kept, k, r = results.first, 0, 0, 0
    for i in range(n):
        p, depth, begin, end = results.listed[i], results.depth[i], first[i], first[i + 1]
        while r < len(pushed) and pushed[r] < p:
            r += 1
        new = r == len(pushed) or pushed[r] != p
        stays = depth > 0.0
        if ahead and not stays:
            opening = vector_at(results.relative, i) @ vector_at(results.normal, i)
            stays = not new or depth - 1.5 * step * min(opening, 0.0) > 0.0
        if not stays:
            continue
        results.new[kept] = new
        if kept < i:
            results.listed[kept], results.depth[kept], results.area[kept], first[kept] = p, depth, results.area[i], k
            set_vector(results.normal, kept, vector_at(results.normal, i))
            set_vector(results.relative, kept, vector_at(results.relative, i))
            for s in range(end - begin):
                results.point[k + s], results.share[k + s] = results.point[begin + s], results.share[begin + s]
        k += end - begin
        kept += 1
    first[kept] = k
    return kept, k
