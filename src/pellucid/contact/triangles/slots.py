"""Kernels for slots: records of the triangle and side on which a point may be in contact with a triangulated surface.

A point of a sheet has two slots, one for each side of its sheet; a point of a solid has one slot. A slot stores a triangle
of the other surface and the side of that triangle, +1 or -1, on which the point was when the contact was detected. In each
step the closest triangle is found by a walk over the mesh from the triangle of the previous step, so that a slot stays on
its sheet even if many other sheets are near. A search with boxes fills empty slots and replaces more distant triangles. It
is performed only when the surfaces may have approached by the margin of the search distance.

Five rules exclude false contacts:

- A point does not touch the triangles around it. A slot is emptied if the walk reaches such a triangle, which happens if it
  contains the closest point and is nearer.
- A slot does not accept a neighbour of the triangle in the other slot of the point. Otherwise a slightly pressed-in sheet
  would be detected again from behind and pushed further.
- A gap decreases by at most the distance that the surfaces have moved. If the walk crosses a fold and reaches a part that
  faces the other way, the side is determined again. A part that is suddenly near exerts no force until the point has left
  its thickness.
- Faces of solids touch only faces with opposite normals. A point that is deeper behind one face than behind another face at
  an edge of the body is not pushed out sideways.
- Beyond the rim of an open surface, the distance is the distance from the rim, without a side. The rim is therefore round,
  the energy of the overlap is continuous, and a point can pass from one side to the other around the rim.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from pellucid.contact.triangles.closest_point import INSIDE, at_foot, closest_on, normal_at
from pellucid.jit import kernel, pointwise
from pellucid.jit.loops import parallel_loop
from pellucid.jit.space import Vector3, set_vector, vector_at

CHUNK = 128  # number of points per chunk of a thread
STEPS = 30  # largest number of steps of a walk
OPPOSED = 0.2  # smallest cosine between the normal of a point and the opposite of a face normal for contact
APART, STAYS, ENTERS = range(3)
"""States of a slot: no overlap now or predicted within the next steps at the current velocities; overlap as in the previous
step; first step of an overlap."""

HOLDS = 1e-9  # largest distance of a position on a triangle, relative to the search distance
OVER_RIM = 0.95  # cosine between the normal and the direction to a point below which the point is beyond the rim


class ContactPoints(NamedTuple):
    """Points of a surface, each in a triangle of that surface; m is their number."""

    place: np.ndarray  # (m, 3) positions [m]
    velocity: np.ndarray  # (m, 3) velocities [m/s]
    normal: np.ndarray  # (m, 3) normals of any length
    corner: np.ndarray  # (m, 3) vertices of the triangle of each point
    share: np.ndarray  # (m, 3) barycentric coordinates in this triangle
    area: np.ndarray  # (m,) initial areas [m²]
    first: np.ndarray  # (m + 1,) start of the list of each point in `excluded`
    excluded: np.ndarray  # triangles excluded from contact with a point, in ascending order


class Slots(NamedTuple):
    """State of s slots of each of m points, which a checkpoint stores. A slot stores the contact of a point with one
    triangle of the other surface."""

    triangle: np.ndarray  # (m, s) triangle; -1 for an empty slot
    side: np.ndarray  # (m, s) side of the triangle: +1 or -1; 0 beyond a rim
    state: np.ndarray  # (m, s) no overlap (APART), overlap (STAYS) or first step of an overlap (ENTERS)
    clear: np.ndarray  # (m, s) bound of the approach of the surfaces below which no overlap is possible [m]
    born: np.ndarray  # (m, s) depth at the start of the contact, which exerts no force; reduced as the point moves out [m]
    depth: np.ndarray  # (m, s) overlap; before contact, minus the distance to contact [m]
    share: np.ndarray  # (m, s, 3) barycentric coordinates of the closest point
    normal: np.ndarray  # (m, s, 3) unit normals from the other surface to the point
    slip: np.ndarray  # (m, s, 3) tangential displacement from the sticking position [m]
    lossy: np.ndarray  # (m, s, 3) friction minus normal force of the step, whose power is counted after it [N]


def make_slots(m: int, s: int) -> Slots:
    """Return s empty slots (records of the contact with a triangle) for each of m points, see `Slots`."""
    whole = [np.full((m, s), -1), np.zeros((m, s), np.int64), np.zeros((m, s), np.int64)]
    return Slots(*whole, *(np.zeros((m, s)) for _ in range(3)), *(np.zeros((m, s, 3)) for _ in range(4)))


class Sight(NamedTuple):
    """Distances and angles that define the contact search between two surfaces."""

    thickness: float  # distance at which contact begins, the mean of both thicknesses [m]
    far: float  # search distance [m]
    forgets: float  # distance beyond which a slot is emptied [m]
    two_sided: bool  # True if the other surface has two sides
    faces: bool  # True if both surfaces are one-sided, so that only faces with opposite normals touch
    outside: float  # largest depth of a point behind a one-sided triangle that a search finds [m]


@pointwise
def _is_among(first, listed, i, q):
    """Return True if triangle q is in list i; first: start of each list in `listed`. Lists are short and in ascending
    order."""
    for r in range(first[i], first[i + 1]):
        if listed[r] >= q:
            return listed[r] == q
    return False


@pointwise
def _looks_away(points, facets, sight, p, q):
    """Return True if point p and triangle q belong to solids and the triangle does not face the point; False if one surface
    is a sheet (see `Sight.faces`)."""
    if not sight.faces:
        return False
    m = vector_at(points.normal, p)
    return m @ vector_at(facets.normal, q) > -OPPOSED * sqrt(m @ m)


@pointwise
def _holds(facets, sight, q, foot):
    """Return True if a position (`foot`) on a neighbour of triangle q also lies on q."""
    return closest_on(facets, q, foot)[4] <= (HOLDS * sight.far) ** 2


@kernel(inner=True)
def _leads_to_excluded(points, facets, sight, p, q, foot):
    """Return True if a position (`foot`) on triangle q also lies on a neighbouring triangle that is excluded from
    contact with point p."""
    if points.first[p] == points.first[p + 1]:
        return False
    for r in range(facets.first[q], facets.first[q + 1]):
        t = facets.neighbour[r]
        if _is_among(points.first, points.excluded, p, t) and _holds(facets, sight, t, foot):
            return True
    return False


@kernel(inner=True)
def _walk(points, facets, sight, p, x, t):
    """Return the triangle closest to point p at position x, found by a walk over neighbours from triangle t; then, for the
    closest point on this triangle, the barycentric coordinates, the region, and the squared distance from x [m²].

    The triangle is -1 if the walk reaches a triangle that is excluded for the point, or if t does not face the point.
    points, facets, sight: `ContactPoints`, `Facets` of the other surface, `Sight`.
    """
    u, v, w, region, square = closest_on(facets, t, x)
    if _looks_away(points, facets, sight, p, t):
        return -1, u, v, w, region, square
    for _ in range(STEPS):
        if region == INSIDE:
            break
        best, foot = t, at_foot(facets.place, facets.triangle, t, u, v, w)
        for r in range(facets.first[t], facets.first[t + 1]):
            q = facets.neighbour[r]
            if q == t or _looks_away(points, facets, sight, p, q):
                continue
            if _is_among(points.first, points.excluded, p, q) and not _holds(facets, sight, q, foot):
                continue
            uu, vv, ww, rr, ss = closest_on(facets, q, x)
            if ss < square * (1.0 - 1e-12) or (ss <= square and rr < region and rr == INSIDE):
                best, u, v, w, region, square = q, uu, vv, ww, rr, ss
        if best == t:
            break
        t = best
        if _is_among(points.first, points.excluded, p, t):
            return -1, u, v, w, region, square
    return t, u, v, w, region, square


@kernel(inner=True)
def _search(points, facets, boxes, sight, p, x, hand, held, square):
    """Return the triangle closest to point p at position x, if it lies within a distance with the given square [m²]; else -1.

    points, facets, boxes, sight: `ContactPoints`, `Facets` of the other surface, its triangles sorted by `Boxes`, `Sight`.
    hand: side of the point's own surface on which to search, 1 or -1; 0 for both. held: triangle in the other slot of the
    point, or -1.
    """
    found, least, b = -1, square, 0
    for d, coordinate in enumerate((x.x, x.y, x.z)):
        i = int(np.floor((coordinate - boxes.lower[d]) / boxes.size))
        if i < 0 or i >= boxes.counts[d]:
            return found
        b = b * boxes.counts[d] + i
    m = vector_at(points.normal, p)
    for r in range(boxes.first[b], boxes.first[b + 1]):
        q = boxes.order[r]
        u, v, w, region, s = closest_on(facets, q, x)
        if s >= least:
            continue
        f = at_foot(facets.place, facets.triangle, q, u, v, w)
        away = x - f
        if hand != 0 and hand * (away @ m) > 0.0:
            continue
        if not sight.two_sided:
            n = normal_at(facets, q, region)
            if away @ n < -sight.outside * sqrt(n @ n):
                continue
        if _looks_away(points, facets, sight, p, q) or _is_among(points.first, points.excluded, p, q):
            continue
        if held >= 0 and _is_among(facets.first, facets.neighbour, held, q):
            continue
        if region != INSIDE and _leads_to_excluded(points, facets, sight, p, q, f):
            continue
        found, least = q, s
    return found


@pointwise
def _empty(slots, p, k):
    slots.triangle[p, k], slots.side[p, k], slots.state[p, k] = -1, 0, APART
    slots.born[p, k] = slots.depth[p, k] = 0.0
    set_vector(slots.slip[p], k, Vector3(0.0, 0.0, 0.0))


@pointwise
def _measure(facets, sight, slots, p, k, x, t, u, v, w, region, square):
    """Store the closest point of triangle t, with barycentric coordinates u, v, w, its region and squared distance [m²], in
    slot k of point p at position x; return the signed distance of the point from the surface [m]."""
    n = normal_at(facets, t, region)
    away = x - at_foot(facets.place, facets.triangle, t, u, v, w)
    along, size, r = away @ n, sqrt(n @ n), sqrt(square)
    side, beyond = slots.side[p, k], False
    if size == 0.0:  # on the rim
        n = vector_at(facets.normal, t)
        along, size = away @ n, 1.0
        beyond = abs(along) < OVER_RIM * r
    if beyond:
        side = 0
    elif not sight.two_sided:
        side = 1
    elif side == 0:
        side = 1 if along >= 0.0 else -1
    slots.triangle[p, k], slots.side[p, k] = t, side
    set_vector(slots.share[p], k, Vector3(u, v, w))
    sign = 1.0
    if side != 0 and side * along < 0.0:
        sign = -1.0
    if r > 1e-9 * sight.far:
        outward = (sign / r) * away
    else:
        outward = (side / size if side != 0 else 1.0) * n
    set_vector(slots.normal[p], k, outward)
    return sign * r


@pointwise
def relative_velocity(points, facets, slots, p, k):
    """Return the velocity of point p relative to the closest point on the other surface that slot k of the point stores
    [m/s]."""
    share = vector_at(slots.share[p], k)
    of_foot = at_foot(facets.velocity, facets.triangle, slots.triangle[p, k], share.x, share.y, share.z)
    return vector_at(points.velocity, p) - of_foot


@kernel()
def find_power(points, facets, slots):
    """Return the power of the forces `Slots.lossy` [W] at the current velocities of the points relative to the other
    surface."""
    power = 0.0
    for p in range(len(points.place)):
        for k in range(slots.triangle.shape[1]):
            if slots.state[p, k] == APART:
                continue
            power += relative_velocity(points, facets, slots, p, k) @ vector_at(slots.lossy[p], k)
    return power


@parallel_loop()
def update_slots(chunk, points, facets, slots, boxes, sight, way, coming, ahead, looks):
    """Update the closest points and the overlap in all slots of the points.

    points, facets, boxes, sight: `ContactPoints`, `Facets` of the other surface, its triangles sorted by `Boxes`, `Sight`.
    slots: the `Slots` to update. way: largest distance by which the surfaces may have approached since the start of the run
    [m]. ahead: time for which an overlap is predicted [s], or 0. coming: largest approach within the time `ahead` [m].
    looks: True to search for new triangles.
    """
    n_slots = slots.triangle.shape[1]
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(points.place))):
        x = vector_at(points.place, p)
        for k in range(n_slots):
            t = slots.triangle[p, k]
            if t < 0 and not looks:
                continue
            if t >= 0 and not looks and way + coming < slots.clear[p, k]:
                slots.state[p, k] = APART
                continue
            gap, fresh = inf, False
            if t >= 0:
                t, u, v, w, region, square = _walk(points, facets, sight, p, x, t)
                if t < 0 or square > sight.forgets * sight.forgets:
                    _empty(slots, p, k)
                    t = -1
                else:
                    least = slots.clear[p, k] - way + sight.thickness  # smallest gap that the motion of the surfaces allows
                    gap = _measure(facets, sight, slots, p, k, x, t, u, v, w, region, square)
                    if gap < 0.0 and least > 0.0 and sight.two_sided:  # the walk crossed a fold to a part that faces back
                        slots.side[p, k] = 0
                        gap = _measure(facets, sight, slots, p, k, x, t, u, v, w, region, square)
                    fresh = least > sight.thickness and gap < sight.thickness  # the walk reached another part of the surface
            if looks and gap > sight.thickness:
                hand = 0 if n_slots == 1 else 1 - 2 * k
                held = slots.triangle[p, 1 - k] if n_slots == 2 else -1
                limit = min(sight.far, gap)
                q = _search(points, facets, boxes, sight, p, x, hand, held, limit * limit)
                if q >= 0 and q != t:
                    q, u, v, w, region, square = _walk(points, facets, sight, p, x, q)
                    if q >= 0 and not (held >= 0 and _is_among(facets.first, facets.neighbour, held, q)):
                        _empty(slots, p, k)
                        gap, fresh, t = _measure(facets, sight, slots, p, k, x, q, u, v, w, region, square), True, q
            if t < 0:
                continue
            within = max(sight.thickness - gap, 0.0)
            slots.born[p, k] = within if fresh else min(slots.born[p, k], within)
            depth = slots.depth[p, k] = sight.thickness - gap - slots.born[p, k]
            slots.clear[p, k] = way + gap - sight.thickness
            if depth <= 0.0:
                depth -= ahead * (relative_velocity(points, facets, slots, p, k) @ vector_at(slots.normal[p], k))
            if depth > 0.0:
                slots.state[p, k] = ENTERS if slots.state[p, k] == APART else STAYS
            else:
                slots.state[p, k] = APART
                set_vector(slots.slip[p], k, Vector3(0.0, 0.0, 0.0))
