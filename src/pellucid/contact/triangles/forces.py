"""Forces of the overlap between surfaces of triangles, and the energy that they store and take.

A point that overlaps by a depth d is pushed out with κ a d, with its area a at the start. The energy is ½ Σ κ a d², of which
all forces are slopes (`pellucid.contact.triangles.closest_point`). Friction is a spring along the surface with a damper,
limited by the coefficient of friction times the pressure; each slot stores its own slip.

**Dampers.** Solids have a tenth of the critical damping along the normal. Sheets do not rebound: their dampers stop most of
the approach of all points in contact within a step. The impulses are found in rounds. In each, the damper of a point takes what
the vertices about it allow, of which each shares its mass among all dampers that act on it, by their areas; the next round
begins with the velocities after these impulses. So few points stop as well as many, and a sheet between two others is damped as
much as one that lies on a floor. The dampers act before the overlap begins, on the part of the approach that would cause one
within the next steps: the overlap of an impact is a fraction of the way of a step. Points beyond a rim have no damper, since
the normal turns as they pass.

**Energy.** The work of a force counts the mean velocity of a step, which is known when the step is done. So the energy that
dampers and friction take is found then, with the closest points for which the forces were found. By the power at the beginning
of a step, a damper that stops a point within some steps would seem to take up to twice as much as it does.

The springs of an overlap balance in steps of Δt as long as it lasts. An overlap that begins within a step presses from then on,
but its force would act as if it had begun with the step: contact would take (ω Δt)²/6 of the energy of an impact, in the mean,
and give the same where an overlap ends. So in these steps the force acts for the share of the step that has an overlap.
"""

from math import inf, sqrt
from typing import NamedTuple

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.triangles.slots import APART, COMES, ENTERS, relative_velocity
from pellucid.jit import kernel, pointwise

STIFF, DAMPING = 0.8, 0.1
"""Swing of two layers of solids on each other, over their step, and the share of its critical damping. Nodes can be lighter
than the layer in the mean, and solids vibrate themselves: with 1.2 contact makes energy."""
STIFF_SHEETS, STOPS = 0.7, 0.8
"""Swing of two sheets on each other, over their step, and the share of the approach that their dampers take in a step. A sheet
between two others swings √2 times as fast. Steps are stable as long as 4 - 2 c - (ω Δt)² > 0 for a share c, which leaves room
for walls that damp the same sheet."""
ROUNDS, PART = 4, 0.4
"""Of the dampers of sheets, and the part of the momentum of a vertex that these take in one: of two vertices twice as much."""
AHEAD = 3.0  # steps within which sheets come to an overlap, from where on dampers act
STORED, PENDING, N_SUMS = range(3)
"""Sums over the slots [J]: energy of the springs, and Δt/2 F·v of their forces."""


class Law(NamedTuple):
    """Contact of two surfaces, for one side that asks."""

    stiffness: float  # [Pa/m], the share of this side
    damping: float  # [Pa s/m], the same; of solids
    stops: float  # share of the approach that dampers take in a step; of sheets
    friction: float  # coefficient μ
    is_steady: bool = False  # whether slips are limited at equilibria alone, see `pellucid.simulation.steady`


def make_law(sides: tuple[ContactSurface, ContactSurface], share: float, friction: float, courant: float, step: float) -> Law:
    """Return the law of two surfaces, which may be the same one, of which at least one deforms.

    share: of the stiffness for the side that searches; courant: fraction of the largest stable step that the case takes; step:
    its fixed step [s], or 0.
    """
    soft = [side for side in sides if not side.is_hard]
    sheets = any(side.two_sided for side in soft)
    # two layers of masses m swing on a spring κ with ω² = κ Σ 1/m
    inverse = sum(1.0 / side.mass_per_area for side in soft)
    parts = (step * side.rate if step > 0.0 else courant for side in soft)
    rate = min(side.rate / (part if side.follows_steps else 1.0) for side, part in zip(soft, parts, strict=True))
    swing = (STIFF_SHEETS if sheets else STIFF) * rate
    damping, stops = (0.0, STOPS) if sheets else (share * 2.0 * DAMPING * swing / inverse, 0.0)
    return Law(share * swing**2 / inverse, damping, stops, friction)


@pointwise
def _share_of_step(state, depth, approach, dt, last):
    """Return the share of a step in which the force of a spring acts, where the overlap begins or ends."""
    began = ended = 1.0
    if state == ENTERS and approach * last > depth:
        began = depth / (approach * last)
    if -approach * dt > depth:
        ended = depth / (-approach * dt)
    return 0.5 * (began + ended)


@kernel()
def find_taken(points, facets, slots, dt):
    """Return the energy that dampers and friction took over the step that was done [J], of a length dt [s]."""
    taken = 0.0
    for p in range(len(points.place)):
        for k in range(slots.triangle.shape[1]):
            if slots.state[p, k] == APART:
                continue
            v = relative_velocity(points, facets, slots, p, k)
            for d in range(3):
                taken -= 0.5 * dt * slots.lossy[p, k, d] * (slots.relative[p, k, d] + v[d])
    return taken


@kernel()
def add_areas(points, facets, slots, of_points, of_facets):
    """Add the areas of all points that touch to those on the vertices of both surfaces [m²]: of_points (n,) and of_facets (n,),
    on which images are counted as the surface itself."""
    n = len(of_facets)
    for p in range(len(points.place)):
        for k in range(slots.triangle.shape[1]):
            if slots.state[p, k] == APART:
                continue
            for c in range(3):
                of_points[points.corner[p, c]] += points.share[p, c] * points.area[p]
                of_facets[facets.triangle[slots.triangle[p, k], c] % n] += slots.share[p, k, c] * points.area[p]


@pointwise
def _most_damping(points, facets, slots, p, k, own, other):
    """Return the damping per area that the vertices about a point allow, for a share 1 of their momentum in a step of 1 s
    [kg/m²]. own, other: mass of the vertices over the area of the points that touch them, shape (n,) each."""
    most = inf
    for c in range(3):
        if points.share[p, c] > 0.0:
            most = min(most, own[points.corner[p, c]])
        if slots.share[p, k, c] > 0.0:
            most = min(most, other[facets.triangle[slots.triangle[p, k], c] % len(other)])
    return most


@kernel()
def add_impulses(points, facets, slots, law, dt, own, other, flips, changes, impulse, given):
    """Add what the dampers of sheets give in a round, of a step dt [s], to the impulses of the points, shape (m, s) [N s].

    own, other: see `_most_damping`; flips: of the images of the surface with the triangles, shape (images, 3); changes: of the
    velocities of the vertices of both surfaces by the rounds before [m/s]; given: momentum that they take in this round [N s].
    """
    n = len(other)
    for p in range(len(points.place)):
        for k in range(slots.triangle.shape[1]):
            if slots.state[p, k] == APART or slots.side[p, k] == 0:
                continue
            v, t = relative_velocity(points, facets, slots, p, k), slots.triangle[p, k]
            approach, depth, area = 0.0, slots.depth[p, k], points.area[p]
            for d in range(3):
                change = v[d]
                for c in range(3):
                    q = facets.triangle[t, c]
                    change += points.share[p, c] * changes[0][points.corner[p, c], d]
                    change -= slots.share[p, k, c] * flips[q // n, d] * changes[1][q % n, d]
                approach -= change * slots.normal[p, k, d]
            least = 0.0
            if slots.state[p, k] == COMES:  # up to where the overlap begins
                approach += depth / (AHEAD * dt)
            else:
                least = -law.stiffness * area * depth * dt
            more = PART * area * _most_damping(points, facets, slots, p, k, own, other) * approach
            more = max(more, least / law.stops - impulse[p, k])
            impulse[p, k] += more
            for d in range(3):
                part = more * slots.normal[p, k, d]
                for c in range(3):
                    q = facets.triangle[t, c]
                    given[0][points.corner[p, c], d] += points.share[p, c] * part
                    given[1][q % n, d] -= slots.share[p, k, c] * flips[q // n, d] * part


@kernel()
def find_forces(points, facets, slots, law, dt, last, own, other, impulse, of_points, of_facets, sums):
    """Add the forces of the overlap over a step dt [s] to those on the vertices of both surfaces [N].

    last: length of the step before [s]; own, other: see `_most_damping`; impulse: of the dampers of sheets [N s], shape (m, s);
    of_points: forces on the vertices of the surface with the points, shape (n, 3); of_facets: on those of the other one, with
    its images; sums: N_SUMS numbers.
    """
    for p in range(len(points.place)):
        for k in range(slots.triangle.shape[1]):
            if slots.state[p, k] == APART:
                continue
            n = (slots.normal[p, k, 0], slots.normal[p, k, 1], slots.normal[p, k, 2])
            v = relative_velocity(points, facets, slots, p, k)
            approach = -(v[0] * n[0] + v[1] * n[1] + v[2] * n[2])
            depth, area = slots.depth[p, k], points.area[p]
            spring, damper = law.stiffness * area, law.damping * area
            if law.stops > 0.0:
                damper = PART * law.stops / dt * area * _most_damping(points, facets, slots, p, k, own, other)
            damped = law.stops / dt * impulse[p, k] if law.stops > 0.0 else damper * approach
            pressure = 0.0
            if slots.state[p, k] != COMES:
                pressure = spring * depth * _share_of_step(slots.state[p, k], depth, approach, dt, last)
                sums[STORED] += 0.5 * spring * depth * depth
            press = max(pressure + damped, 0.0)
            # friction: displacement along the surface since it holds
            along = (v[0] + approach * n[0], v[1] + approach * n[1], v[2] + approach * n[2])
            s = (slots.slip[p, k, 0], slots.slip[p, k, 1], slots.slip[p, k, 2])
            off = s[0] * n[0] + s[1] * n[1] + s[2] * n[2]
            s = (
                s[0] - off * n[0] + last * along[0],
                s[1] - off * n[1] + last * along[1],
                s[2] - off * n[2] + last * along[2],
            )
            drag = (
                -spring * s[0] - damper * along[0],
                -spring * s[1] - damper * along[1],
                -spring * s[2] - damper * along[2],
            )
            most, size = law.friction * press, sqrt(drag[0] * drag[0] + drag[1] * drag[1] + drag[2] * drag[2])
            if size > most:
                drag = (drag[0] * most / size, drag[1] * most / size, drag[2] * most / size)
                length, longest = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]), most / max(spring, 1e-300)
                if length > longest and not law.is_steady:
                    s = (s[0] * longest / length, s[1] * longest / length, s[2] * longest / length)
            t = slots.triangle[p, k]
            for d in range(3):
                slots.slip[p, k, d], slots.relative[p, k, d] = s[d], v[d]
                lossy = (press - pressure) * n[d] + drag[d]
                slots.lossy[p, k, d] = lossy
                force = pressure * n[d] + lossy
                for c in range(3):
                    of_points[points.corner[p, c], d] += points.share[p, c] * force
                    of_facets[facets.triangle[t, c], d] -= slots.share[p, k, c] * force
            sums[PENDING] -= 0.5 * (last if last > 0.0 else dt) * pressure * approach
