"""Kernel for the forces of an overlap on its points: pressure, damping and friction in one pass."""

from math import sqrt

from pellucid.jit import kernel
from pellucid.jit.local import numbers

STIFFNESS, IMPLICIT_STIFFNESS, DAMPING, SOFTNESS, FRICTION, STIFFER, STEADY, N_LAW = 0, 1, 2, 3, 4, 5, 6, 7
"""Indices of the parameters of a law: stiffness of explicit and of implicit normal forces [Pa/m], damping [Pa s/m], growth
of the stiffness with the square of the depth [1/m²], coefficient of friction, largest ratio of friction stiffness to
overlap stiffness, and 1 if friction is computed from the last equilibrium."""
STORED, RUBBED, PENDING, POWER, NOW, ENTERED, LOST, N_SUMS = 0, 1, 2, 3, 4, 5, 6, 7
"""Indices of the sums over points: energy of the overlap [J]; energy dissipated by friction in the last step [J]; half
the step length times the power of forces F on points with velocities v, Δt/2 F·v [J]; power of the dampers [W]; power of
dampers and friction at the current velocities [W]; energy that points with explicit forces lost as they entered within the
last step [J]; and energy dissipated by implicit forces in this step [J]."""
GROWN = 2.0
"""Smallest ratio of the depth of a point to its expected depth for which the difference did not load its spring.

The expected depth is the one that the implicit force of the last step left. If the depth is also larger than that by more
than the approach of the point explains, the overlap is sudden, for example because the closest point of a fold changed. Its
spring gives hardly any energy to the bodies, since the implicit force removes the overlap within a step. The energy that it
does give has no source in contact and remains unexplained (`ContactEnergy.unexplained`).
"""
TINY = 1e-300


@kernel(inline=True)
def _rub(i, p, law, along, most, spring, damping, last, drag, slip, keeps, limits, sums):
    """Replace the tangential velocity `along` of a point [m/s] by its friction force, at most `most` [N]; update slip and
    sums.

    keeps: tangential displacement of the point from its sticking position [m]. spring, damping: stiffness [N/m] and damping
    [kg/s] of friction. last: length of the previous step [s].
    """
    vx, vy, vz = along[0], along[1], along[2]
    cx = cy = cz = 0.0
    if len(drag):  # a fluid resists by its viscosity alone
        fx, fy, fz = -drag[p] * vx, -drag[p] * vy, -drag[p] * vz
    else:
        cx, cy, cz = keeps[0] + last * vx, keeps[1] + last * vy, keeps[2] + last * vz
        fx, fy, fz = -spring * cx - damping * vx, -spring * cy - damping * vy, -spring * cz - damping * vz
    size, scale = sqrt(fx * fx + fy * fy + fz * fz), 1.0
    slides = size > most
    if slides:
        scale = most / size
    along[0], along[1], along[2] = scale * fx, scale * fy, scale * fz
    work = last * (along[0] * vx + along[1] * vy + along[2] * vz)
    if len(drag):
        sums[RUBBED] -= work
        return
    before = (slip[p, 0] * slip[p, 0] + slip[p, 1] * slip[p, 1]) + slip[p, 2] * slip[p, 2]
    now, longest = cx * cx + cy * cy + cz * cz, most / spring if spring > 0.0 else 0.0
    held = min(1.0, longest / max(sqrt(now), TINY))
    limits[i, 0], limits[i, 1] = spring, most
    if law[STEADY] > 0.0:
        before *= min(1.0, longest / max(sqrt(before), TINY)) ** 2
        now *= held * held
        held = 1.0
    elif not slides:
        held = 1.0
    slip[p, 0], slip[p, 1], slip[p, 2] = held * cx, held * cy, held * cz
    damped = last * damping * (vx * vx + vy * vy + vz * vz)
    sums[RUBBED] += -work if slides else 0.5 * spring * (now - before) + damped


@kernel()
def find_point_forces(
    law, share, listed, depth, normal, area, relative, new, extra, implicit, drag, slip, dt, last, force, given, limits, sums
):
    """Compute the forces on n points of an overlap over a step dt [s]; last: length of the previous step [s].

    Arguments
    ---------
    law, sums
        Parameters and sums with the indices above; contributions are added to the sums.
    share, listed, depth, normal, area, relative, new
        See `pellucid.contact.overlap.Overlap`; an empty `new` means that no point is new.
    extra
        Normal forces of an additional damper [N], shape (n,) or empty.
    implicit
        The fields of `pellucid.contact.overlap.Implicit`, shape (3, n); shape (3, 0) if the law is explicit.
    drag, slip
        Drag coefficients of a fluid (or empty) and slip of the points of the surface, see `ContactSurface`.
    force, given
        Output: forces, and their damper and friction part without implicit normal forces [N], shape (n, 3).
    limits
        Output: stiffness [N/m] and limit [N] of friction, shape (n, 2).
    """
    friction, is_implicit = law[FRICTION], implicit.shape[1] > 0
    span = 0.5 * (last if last > 0.0 else dt)  # before the first step nothing was done, and the first does half of its own
    along, keeps = numbers(3), numbers(3)
    for i in range(len(listed)):
        p, d, a = listed[i], depth[i], share * area[i]
        n0, n1, n2 = normal[i, 0], normal[i, 1], normal[i, 2]
        approach = -(relative[i, 0] * n0 + relative[i, 1] * n1 + relative[i, 2] * n2)
        along[0], along[1], along[2] = (
            relative[i, 0] + approach * n0,
            relative[i, 1] + approach * n1,
            relative[i, 2] + approach * n2,
        )
        spring, damping = law[STIFFNESS] * a, law[DAMPING] * a
        holds = spring
        if is_implicit:
            k, press, after, before = law[IMPLICIT_STIFFNESS] * a, implicit[0, i], implicit[1, i], implicit[2, i]
            pressure, energy = 2.0 * press, 0.5 * k * max(d, 0.0) ** 2
            lost = press * (after - d + 0.5 * dt * approach) - (0.5 * press * press / k if k > 0.0 else 0.0)
            if last > 0.0 and k * d > GROWN * before:
                # nothing gave the spring more than the last step left in it: the point moved in, or the overlap is a sudden one
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
                # a point that comes in by d of its way in a step gives ½ κ d way to the springs, as leapfrog steps count, which
                # hold ½ κ d² then; with critical dampers it does not come out again
                sums[ENTERED] += 0.5 * spring * d * max(way - d, 0.0)
            # what presses harder than the overlap alone is held by as much stiffer springs along it
            holds *= min(max(press / max(pressure, TINY), 1.0), law[STIFFER])
        force[i, 0], force[i, 1], force[i, 2] = press * n0, press * n1, press * n2
        surplus = press - pressure
        given[i, 0], given[i, 1], given[i, 2] = surplus * n0, surplus * n1, surplus * n2
        if friction > 0.0:
            across = slip[p, 0] * n0 + slip[p, 1] * n1 + slip[p, 2] * n2
            keeps[0], keeps[1], keeps[2] = slip[p, 0] - across * n0, slip[p, 1] - across * n1, slip[p, 2] - across * n2
            _rub(i, p, law, along, friction * press, holds, damping, last, drag, slip, keeps, limits, sums)
            power = along[0] * relative[i, 0] + along[1] * relative[i, 1] + along[2] * relative[i, 2]
            sums[NOW] += power
            sums[PENDING] += span * power
            for c in range(3):
                force[i, c] += along[c]
                given[i, c] += along[c]
