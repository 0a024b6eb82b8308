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
from pellucid.jit.memory import zeros

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
    weight: np.ndarray  # (k,) weights of the points in the lists
    candidate: np.ndarray  # (n,) candidate of each foot
    place: np.ndarray  # (n, 3) positions of the feet [m]
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
    feet = np.zeros(n, np.int64), np.zeros((n, 3)), np.zeros(n + 1, np.int64), np.zeros(k, np.int64), np.zeros(k)
    overlap = np.zeros(n, np.int64), np.zeros(n), np.zeros((n, 3)), np.zeros(n), np.zeros((n, 3)), np.zeros(n, bool)
    return Found(np.zeros((n, COLUMNS)), np.zeros(k), *feet, *overlap)


class Neighbourhood(NamedTuple):
    """The points of both surfaces and the parameters of their contact, bundled as an argument of kernels."""

    one: Asking
    other: Points
    meeting: Meeting


@pointwise
def _beside(other, q, x):
    """Return three values: the vector from point q of the other surface to the place x [m], the square of its length [m²],
    and the height of x above the plane of q [m]."""
    d = (x[0] - other.place[q, 0], x[1] - other.place[q, 1], x[2] - other.place[q, 2])
    beyond = d[0] * other.normal[q, 0] + d[1] * other.normal[q, 1] + d[2] * other.normal[q, 2]
    return d, d[0] * d[0] + d[1] * d[1] + d[2] * d[2], beyond


@pointwise
def _weight(other, meeting, q, square, along, n, gain):
    """Return the weight of point q of the other surface in the mean planes at a place, and the normal of q, reversed if needed
    so that it points to the side of the place.

    meeting: a `Meeting`. square, along: squared distance and height of the place, see `_beside`. n: normal of the surface point
    at the place. gain: for nodes of a sheet, factor of the cosine between the normals, with which the best aligned point has
    full weight.
    """
    two_sided, deepest, dimension, thickness = meeting.two_sided, meeting.deepest, meeting.dimension, meeting.thickness
    m, reach = (other.normal[q, 0], other.normal[q, 1], other.normal[q, 2]), other.reach[q]
    apart = square - along * along
    if apart >= reach * reach:
        return 0.0, m
    facing = -(n[0] * m[0] + n[1] * m[1] + n[2] * m[2])
    if two_sided[1] and facing < 0.0:
        m, facing, along = (-m[0], -m[1], -m[2]), -facing, -along
    if two_sided[0]:
        facing = min(1.0, abs(facing) * gain) if gain > 0.0 else 1.0
    if facing <= 0.0 or along < -deepest or along > reach:
        return 0.0, m
    ratio = 1.0 - apart / (reach * reach)
    whole = thickness**2
    if dimension > 0:
        whole = pi * reach * reach / 3.0 if dimension == 2 else 16.0 / 15.0 * reach * thickness
    return ratio * ratio * facing * other.area[q] / whole, m


@pointwise
def _asking(one, p):
    """Return the position [m] and the normal of point p of the surface `one` (an `Asking`)."""
    return (one.place[p, 0], one.place[p, 1], one.place[p, 2]), (one.normal[p, 0], one.normal[p, 1], one.normal[p, 2])


@kernel(inner=True)
def _gain(about, candidates, e, x, n):
    """Return the reciprocal of the largest cosine between the normal n of a sheet node at x and the normals of the points of
    the other surface with weight; 0 if all cosines are zero: then all points have full weight.

    about: a `Neighbourhood`. e: index of the node in `candidates`.
    """
    other, meeting, largest = about.other, about.meeting, 0.0
    for r in range(candidates.first[e], candidates.first[e + 1]):
        q = uintp(candidates.near[r])
        _, square, beyond = _beside(other, q, x)
        w, m = _weight(other, meeting, q, square, beyond, n, 0.0)
        if w > 0.0:
            largest = max(largest, abs(n[0] * m[0] + n[1] * m[1] + n[2] * m[2]))
    return 1.0 / largest if largest > LEAST_FACING else 0.0


@kernel(inner=True)
def _sum_moments(about, candidates, e, clear, s, weight):
    """Compute the moments s of the weights at candidate e, shape (17,): Σ w, Σ w d·m, Σ w m, Σ w d, Σ w d⊗d, where the points
    of the other surface have the weights w, the normals m and the vectors d to the candidate.

    Return the index of the nearest point of the other surface, and the height of the candidate above the plane of this point
    [m]. about: a `Neighbourhood`. clear: see `find_beside`. The weights are stored in `weight`.
    """
    other = about.other
    x, n = _asking(about.one, uintp(candidates.asks[e]))
    for a in range(17):
        s[a] = 0.0
    nearest, outside, closest = inf, 0.0, uintp(0)
    gain = _gain(about, candidates, e, x, n) if about.meeting.any_way else 1.0
    for r in range(candidates.first[e], candidates.first[e + 1]):
        q = uintp(candidates.near[r])
        d, square, beyond = _beside(other, q, x)
        if square < nearest and other.area[q] > 0.0:
            nearest, outside, closest = square, beyond, q
        w, m = _weight(other, about.meeting, q, square, beyond, n, gain)
        weight[r] = w
        if w > 0.0:
            s[0] += w
            s[1] += w * (d[0] * m[0] + d[1] * m[1] + d[2] * m[2])
            for a in range(3):
                s[2 + a] += w * m[a]
                s[5 + a] += w * d[a]
                for c in range(3):
                    s[8 + 3 * a + c] += w * d[a] * d[c]
    if abs(outside) > clear + CLEAR * other.reach[closest] and (about.meeting.two_sided[1] or outside > 0.0):
        s[0] = 0.0  # it lies too far above to overlap
    return closest, outside


@parallel_loop()
def find_beside(chunk, about, candidates, clear, results):
    """Compute, for each candidate of one surface, its distance from the other surface, the normal of that surface, the weights
    of its points and the factor of the contact area.

    about: a `Neighbourhood`. candidates: a `Candidates`. clear: distance of the surfaces below which they overlap [m]. results:
    a `Found`, whose `beside` and `weight` are filled.
    """
    other, meeting, found, s = about.other, about.meeting, results.beside, zeros(17)
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(candidates.asks))):
        found[p, SHARE] = 0.0
        closest, outside = _sum_moments(about, candidates, p, clear, s, results.weight)
        if s[0] <= NO_CONTACT:
            continue
        size = sqrt(s[2] * s[2] + s[3] * s[3] + s[4] * s[4])
        if size < 0.3 * s[0]:  # the normals of the points that face it have no common direction
            continue
        found[p, SHARE] = min(1.0, (s[0] - NO_CONTACT) / (FULL_CONTACT - NO_CONTACT))
        found[p, WEIGHT] = s[0]
        n0, n1, n2 = s[2] / size, s[3] / size, s[4] / size
        found[p, NORMAL], found[p, NORMAL + 1], found[p, NORMAL + 2] = n0, n1, n2
        e = (s[5] / s[0], s[6] / s[0], s[7] / s[0])
        away = n0 * e[0] + n1 * e[1] + n2 * e[2]
        found[p, GAP] = 0.5 * (s[1] / s[0] + away)
        turned = n0 * other.normal[closest, 0] + n1 * other.normal[closest, 1] + n2 * other.normal[closest, 2] < CORNER
        if not meeting.two_sided[1] and outside > 0.0 and (turned or outside < -found[p, GAP] - meeting.slack):
            fades = meeting.any_way and turned
            found[p, SHARE] *= max(0.0, 1.0 - outside / (BEYOND * other.reach[closest])) if fades else 0.0
        _find_slope(p, s, (n0, n1, n2), e, ALONE * other.reach[closest] ** 2, meeting.dimension, found)


@kernel(inline=True)
def _find_slope(p, s, n, e, alone, dimension, found):
    """Compute the linear correction c of the weights w of the points of the other surface, such that Σ w (1 + c·(d - e)) d = 0
    along the surface, with the vectors d from these points to point p; store it in row p of `found` (`Found.beside`).

    s: moments of the weights, see `_sum_moments`. n: normal of the surface. e: weighted mean of d. alone: square of a distance
    [m²]; if the points are closer together, the correction tends to zero.
    """
    found[p, LEVEL] = 1.0
    for a in range(3):
        found[p, SLOPE + a] = 0.0
    if dimension == 0:
        return
    # two directions along the surface
    if abs(n[0]) <= abs(n[1]) and abs(n[0]) <= abs(n[2]):
        t = (0.0, -n[2], n[1])
    elif abs(n[1]) <= abs(n[2]):
        t = (n[2], 0.0, -n[0])
    else:
        t = (-n[1], n[0], 0.0)
    size = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    t = (t[0] / size, t[1] / size, t[2] / size)
    u = (n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0])
    tt = tu = uu = et = eu = 0.0
    for a in range(3):
        et += t[a] * e[a]
        eu += u[a] * e[a]
        for c in range(3):
            tt += t[a] * t[c] * s[8 + 3 * a + c]
            tu += t[a] * u[c] * s[8 + 3 * a + c]
            uu += u[a] * u[c] * s[8 + 3 * a + c]
    tt, tu, uu = tt / s[0] - et * et, tu / s[0] - et * eu, uu / s[0] - eu * eu
    least = 1e-3 * (tt + uu) + alone  # in a plane problem the points have no spread across the slice
    tt, uu = tt + least, uu + least
    whole = tt * uu - tu * tu
    if not whole > 0.0:
        return
    a, b = -(uu * et - tu * eu) / whole, -(tt * eu - tu * et) / whole
    for d in range(3):
        found[p, SLOPE + d] = a * t[d] + b * u[d]
    found[p, LEVEL] = 1.0 - a * et - b * eu


@pointwise
def _corrected(w, found, p, d):
    """Return the corrected weight of a point of the other surface with weight w at a vector d from point p. The corrected
    weights have the sum one, and the mean position with these weights is the foot of point p. found: `Found.beside`."""
    along = found[p, SLOPE] * d[0] + found[p, SLOPE + 1] * d[1] + found[p, SLOPE + 2] * d[2]
    return w * (found[p, LEVEL] + along) / found[p, WEIGHT]


@kernel()
def find_feet(about, candidates, results, counts, most):
    """Compute the feet (projections on the other surface) of the candidates that are closer than `most` [m] to the other
    surface, and write them to `results`.

    Return the number of feet, and the number of weights that define them (`pellucid.contact.feet`). about: a
    `Neighbourhood`. results: a `Found` in which `find_beside` has stored the distances. counts: factors of the contact
    areas of the points, shape (m,); points with the factor 0 are omitted.
    """
    other, found, weight, n, k = about.other, results.beside, results.weight, 0, 0
    for e in range(len(candidates.asks)):
        p = uintp(candidates.asks[e])
        if not found[e, SHARE] * counts[p] > 0.0 or found[e, GAP] >= most:
            continue
        x, _ = _asking(about.one, p)
        results.candidate[n], results.first[n] = e, k
        for d in range(3):
            results.place[n, d] = 0.0
        for r in range(candidates.first[e], candidates.first[e + 1]):
            q = uintp(candidates.near[r])
            if weight[r] > 0.0:
                w = _corrected(weight[r], found, e, _beside(other, q, x)[0])
                results.point[k], results.share[k] = q, w
                k += 1
                for a in range(3):
                    results.place[n, a] += w * other.place[q, a]
        n += 1
    results.first[n] = k
    return n, k


@kernel()
def measure_depths(about, candidates, results, counts, weights, velocity, of_other, width, most, from_feet, by_own_normals):
    """Compute the depths, contact areas and relative velocities of the candidates that are closer than `most` [m] to the
    other surface, and write them to `results`; return the number of these candidates.

    Parameters
    ----------
    about, candidates, results, counts, most
        See `find_feet`.
    weights
        Areas of the points of the surface with the candidates [m²], shape (m,).
    velocity, of_other
        Velocities of the points of both surfaces [m/s], shape (m, 3) and (q, 3).
    width
        Distance of the surfaces at which they touch [m].
    from_feet
        True to measure depths from the feet (see `find_feet`), on which the forces act, as required for deforming surfaces:
        with another distance they would gain energy when they vibrate. False to measure from the surface itself.
    by_own_normals
        True to measure depths along the normals of the points instead of the normals of the other surface.
    """
    n, _ = find_feet(about, candidates, results, counts, most)
    one, found = about.one, results.beside
    for i in range(n):
        e = results.candidate[i]
        p = uintp(candidates.asks[e])
        n0, n1, n2, gap = found[e, NORMAL], found[e, NORMAL + 1], found[e, NORMAL + 2], found[e, GAP]
        if by_own_normals:
            sign = 1.0 if one.normal[p, 0] * n0 + one.normal[p, 1] * n1 + one.normal[p, 2] * n2 > 0.0 else -1.0
            n0, n1, n2 = sign * one.normal[p, 0], sign * one.normal[p, 1], sign * one.normal[p, 2]
        if from_feet:
            gap = n0 * (one.place[p, 0] - results.place[i, 0]) + n1 * (one.place[p, 1] - results.place[i, 1])
            gap += n2 * (one.place[p, 2] - results.place[i, 2])
        results.listed[i], results.depth[i] = p, width - gap
        results.normal[i, 0], results.normal[i, 1], results.normal[i, 2] = n0, n1, n2
        results.area[i] = found[e, SHARE] * counts[p] * weights[p]
        for d in range(3):
            results.relative[i, d] = 0.0
        for r in range(results.first[i], results.first[i + 1]):
            q = uintp(results.point[r])
            for d in range(3):
                results.relative[i, d] += results.share[r] * of_other[q, d]
        for d in range(3):
            results.relative[i, d] = velocity[p, d] - results.relative[i, d]
    return n


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
            opening = 0.0
            for d in range(3):
                opening += results.relative[i, d] * results.normal[i, d]
            stays = not new or depth - 1.5 * step * min(opening, 0.0) > 0.0
        if not stays:
            continue
        results.listed[kept], results.depth[kept], results.area[kept], results.new[kept] = p, depth, results.area[i], new
        for d in range(3):
            results.normal[kept, d], results.relative[kept, d] = results.normal[i, d], results.relative[i, d]
        first[kept] = k
        for s in range(begin, end):
            results.point[k], results.share[k] = results.point[s], results.share[s]
            k += 1
        kept += 1
    first[kept] = k
    return kept, k
