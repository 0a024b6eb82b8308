"""Kernels for the forces of an overlap on its points: pressure, damping, and the friction of Coulomb."""

from math import sqrt

from pellucid.jit import kernel, pointwise
from pellucid.jit.space import add_vector, set_vector, vector_at

STIFFNESS, IMPLICIT_STIFFNESS, DAMPER, SOFTNESS, FRICTION, STIFFENING, STEADY, N_LAW = 0, 1, 2, 3, 4, 5, 6, 7
"""Indices of the parameters of a law: stiffness of explicit and of implicit normal forces [Pa/m], damping [Pa s/m], growth
of the stiffness with the square of the depth [1/m²], coefficient of friction, largest ratio of friction stiffness to
overlap stiffness, and 1 if friction is computed from the last equilibrium."""
STORED, RUBBED, PENDING, POWER, NOW, ENTERED, LOST, N_SUMS = 0, 1, 2, 3, 4, 5, 6, 7
"""Indices of the sums over points: energy of the overlap [J]; energy dissipated by friction in the last step [J]; half
the step length times the power of forces F on points with velocities v, Δt/2 F·v [J]; power of the dampers [W]; power of
dampers and friction at the current velocities [W]; energy that points with explicit forces lost as they entered within the
last step [J]; and energy dissipated by implicit forces in this step [J]."""
GROWN = 2.0
"""Ratio of the depth of a point to its expected depth above which its overlap counts as sudden: no motion loaded its spring.

The expected depth is the one that the implicit force of the last step left, plus the approach of the point in the step. An
overlap is sudden, for example, if the closest point of a fold jumps to another layer. The implicit force removes it within a
step, so that its spring gives hardly any energy to the bodies; what it gives has no source in contact, and remains unexplained
(`ContactEnergy.unexplained`).
"""
ROUNDED = 1e-6  # relative tolerance of the friction limit for sliding points
TINY = 1e-300


@pointwise
def _along(x, n):
    """Return the tangential part of a vector x at a surface with the unit normal n."""
    return x - (x @ n) * n


@pointwise
def _carried(slip, p, n, v, last):
    """Return the current displacement of point p from its sticking position, along the surface [m]: the displacement stored
    before the previous step plus the sliding in that step.

    slip: stored displacements of all points [m]. n: unit normal. v: sliding velocity [m/s]. last: length of the previous
    step [s].
    """
    return _along(vector_at(slip, p), n) + last * v


@pointwise
def _limit(f, most):
    """Return the friction force f [N], scaled down so that its magnitude is at most `most` [N], and True if f was larger
    (Coulomb)."""
    size = sqrt(f @ f)
    return (most / size if size > most else 1.0) * f, size > most


@pointwise
def _held(square, spring, most):
    """Return the factor (at most 1) that reduces a displacement so that its spring force is at most `most` [N].

    square: square of the displacement [m²]. spring: stiffness [N/m].
    """
    longest = most / spring if spring > 0.0 else 0.0
    return min(1.0, longest / max(sqrt(square), TINY))


@kernel(inline=True)
def _keep_slip(slip, p, c, spring, most, slides, is_steady, work, damped):
    """Store the displacement c of point p from its sticking position [m] in `slip`; return the energy that friction
    dissipated in the step [J]. For a sliding point, the displacement is reduced so that its spring force equals the
    friction limit `most` [N].

    Sticking points load their springs; on sliding points the friction limit does the work. Both energies count as
    dissipated, since a spring returns its energy only while its point stays in contact. spring: friction stiffness [N/m].
    work: work of the friction force in the step [J]. damped: energy that the damper of a sticking point dissipated in the
    step [J]. is_steady: True to store the whole displacement until the next equilibrium is found.
    """
    stored = vector_at(slip, p)
    before, now = stored @ stored, c @ c
    held = _held(now, spring, most)
    if is_steady:
        before *= _held(before, spring, most) ** 2
        now *= held * held
    if is_steady or not slides:
        held = 1.0
    set_vector(slip, p, held * c)
    return -work if slides else 0.5 * spring * (now - before) + damped


@kernel()
def begin_friction(listed, normal, relative, slip, spring, most, last, carried, drag):
    """Compute the displacements of n points from their sticking positions [m] and the forces of their friction springs [N],
    at most the friction limit `most` [N] in magnitude; write them to `carried` and `drag`, shape (n, 3) each.

    Friction dampers are solved afterwards. listed, normal, relative: see `pellucid.contact.overlap.Overlap`. slip:
    displacements before the previous step [m]. spring: stiffness of the friction springs [N/m]. last: length of the
    previous step [s].
    """
    for i in range(len(listed)):
        n = vector_at(normal, i)
        c = _carried(slip, listed[i], n, _along(vector_at(relative, i), n), last)
        f, _ = _limit(-spring[i] * c, most[i])
        set_vector(carried, i, c)
        set_vector(drag, i, f)


@kernel()
def end_friction(listed, normal, relative, slip, spring, most, last, carried, drag, force, damped):
    """Store the displacements of n points from their sticking positions in `slip`, given the friction forces `force` of
    springs and dampers together, shape (n, 3) [N]; return the energy that friction dissipated in the last step [J].

    listed to last: see `begin_friction`. carried, drag: its results. damped: array of forces, shape (n, 3) [N], to which
    the damper forces of sticking points are added.
    """
    taken = 0.0
    for i in range(len(listed)):
        v, f = _along(vector_at(relative, i), vector_at(normal, i)), vector_at(force, i)
        slides = sqrt(f @ f) >= most[i] * (1.0 - ROUNDED)
        taken += _keep_slip(slip, listed[i], vector_at(carried, i), spring[i], most[i], slides, False, last * (f @ v), 0.0)
        if not slides:
            add_vector(damped, i, f - vector_at(drag, i))
    return taken


@kernel()
def limit_slip(listed, slip, limits):
    """Reduce the displacements `slip` of the listed points from their sticking positions [m], so that the friction spring
    force of each point is at most its friction limit; limits: see `find_point_forces`."""
    for i in range(len(listed)):
        p = listed[i]
        c = vector_at(slip, p)
        set_vector(slip, p, _held(c @ c, limits[i, 0], limits[i, 1]) * c)


@kernel()
def find_point_forces(
    law, share, listed, depth, normal, area, relative, new, extra, implicit, drag, slip, dt, last, force, given, limits, sums
):
    """Compute the forces on n points of an overlap over a step dt [s]; last: length of the previous step [s].

    Arguments
    ---------
    law, sums
        Parameters of the law and sums over points, at the indices `STIFFNESS` ... and `STORED` ... of this module;
        contributions are added to the sums.
    share, listed, depth, normal, area, relative, new
        See `pellucid.contact.overlap.Overlap`; an empty `new` means that no point is new.
    extra
        Normal forces of an additional damper [N], shape (n,) or empty.
    implicit
        The fields of `pellucid.contact.overlap.Implicit`, shape (3, n); shape (3, 0) if the law is explicit.
    drag, slip
        Drag coefficients of a fluid (or empty) and slip of the points of the surface, see `ContactSurface`.
    force, given
        Output, shape (n, 3) [N]: the contact forces, and the part of them that dampers and friction exert. If the law is
        implicit, this part is friction minus normal force.
    limits
        Output: stiffness of the friction spring [N/m] and friction limit [N] of each point, shape (n, 2).
    """
    friction, is_implicit = law[FRICTION], implicit.shape[1] > 0
    span = 0.5 * (last if last > 0.0 else dt)  # the first step has no previous one: it counts half of its own length
    for i in range(len(listed)):
        p, d, a = listed[i], depth[i], share * area[i]
        n, moves = vector_at(normal, i), vector_at(relative, i)
        approach = -(moves @ n)
        spring, damping = law[STIFFNESS] * a, law[DAMPER] * a
        holds = spring
        if is_implicit:
            k, press, after, before = law[IMPLICIT_STIFFNESS] * a, implicit[0, i], implicit[1, i], implicit[2, i]
            pressure, energy = 2.0 * press, 0.5 * k * max(d, 0.0) ** 2
            lost = press * (after - d + 0.5 * dt * approach) - (0.5 * press * press / k if k > 0.0 else 0.0)
            if last > 0.0 and k * d > GROWN * before:
                # the spring holds only what the last step left in it: the point moved in, or the overlap is sudden
                left = 0.5 * before * before / k
                if k * d > GROWN * (before + k * last * max(approach, 0.0)):
                    gained = -(lost + 0.5 * press * (d - after) + left)  # by the bodies, without a source
                    lost += min(max(gained, 0.0), energy - left)
                energy = left
            sums[STORED] += energy
            sums[LOST] += lost + energy
        else:
            hardened = law[SOFTNESS] * d * d
            pressure = spring * d * (1.0 + hardened)
            press = max(pressure + damping * approach + (extra[i] if len(extra) else 0.0), 0.0)
            sums[STORED] += 0.5 * spring * d * d * (1.0 + 0.5 * hardened)
            sums[POWER] += (press - pressure) * approach
            sums[NOW] += (pressure - press) * approach
            sums[PENDING] -= span * press * approach
            way = last * approach
            if len(new) > 0 and new[i]:
                # a point that enters by d on its way of a step gives ½ κ d way to its spring in the balance of leapfrog steps,
                # but the spring then holds ½ κ d²; the critical damper keeps the difference
                sums[ENTERED] += 0.5 * spring * d * max(way - d, 0.0)
            # friction springs are stiffer where dampers press in addition to the overlap
            holds *= min(max(press / max(pressure, TINY), 1.0), law[STIFFENING])
        set_vector(force, i, press * n)
        set_vector(given, i, (press - pressure) * n)
        if friction > 0.0:
            most, v = friction * press, _along(moves, n)
            if len(drag):  # a fluid resists by its viscosity alone
                f, _ = _limit(-drag[p] * v, most)
                sums[RUBBED] -= last * (f @ v)
            else:
                c = _carried(slip, p, n, v, last)
                f, slides = _limit(-holds * c - damping * v, most)
                damped = last * damping * (v @ v)
                sums[RUBBED] += _keep_slip(slip, p, c, holds, most, slides, law[STEADY] > 0.0, last * (f @ v), damped)
                limits[i, 0], limits[i, 1] = holds, most
            power = f @ moves
            sums[NOW] += power
            sums[PENDING] += span * power
            add_vector(force, i, f)
            add_vector(given, i, f)
