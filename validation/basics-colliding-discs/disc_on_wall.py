"""Independent reference: one elastic disc meets a smooth rigid wall, by finite elements that follow the material.

Two equal discs that meet head-on mirror each other in the plane between them, so each sees a smooth wall there.
Plane strain, three-node triangles, linear elasticity in rate form (Jaumann), explicit central differences; a node that
would pass the wall is put on it. Nothing here is shared with the package.

    python disc_on_wall.py > disc_on_wall.csv
"""

import numpy as np
from scipy.spatial import Delaunay

RADIUS, DENSITY, YOUNG, POISSON = 0.2, 1000.0, 1000.0, 0.3
SPEED = 0.1 * np.sqrt(2.0)
GAP = 0.5 * (0.6 * np.sqrt(2.0) - 2.0 * RADIUS)  # from the disc's rim to the plane of symmetry
LAM = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))


def disc(n):
    """Nodes (m, 2) and triangles (k, 3) of a disc about the origin: n rings, ring i with 6i nodes."""
    rings = [np.zeros((1, 2))]
    for i in range(1, n + 1):
        angle = 2 * np.pi * np.arange(6 * i) / (6 * i)
        rings.append(RADIUS * i / n * np.column_stack([np.cos(angle), np.sin(angle)]))
    points = np.vstack(rings)
    triangles = Delaunay(points).simplices
    p = points[triangles]
    edge = p[:, 1:] - p[:, :1]
    area = 0.5 * (edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0])
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    return points, triangles[np.abs(area) > 1e-6 * RADIUS**2 / n**2]


def gradients(x, tri):
    """Areas (k,) and gradients (k, 3, 2) of the linear functions."""
    p = x[tri]
    e = np.roll(p, -2, axis=1) - np.roll(p, -1, axis=1)  # edge opposite to each node
    area = 0.5 * (e[:, 2, 0] * -e[:, 1, 1] - e[:, 2, 1] * -e[:, 1, 0])
    grad = np.stack([-e[:, :, 1], e[:, :, 0]], axis=2) / (2 * area)[:, None, None]
    return area, grad


def collide(n, end=2.4, courant=0.3):
    """Times, mean velocity along the wall's normal, whether any node touches, and the energy over the first one."""
    x, tri = disc(n)
    area, _ = gradients(x, tri)
    mass = np.zeros(len(x))
    np.add.at(mass, tri.ravel(), np.repeat(DENSITY * area / 3, 3))
    element_mass = DENSITY * area
    x[:, 0] -= RADIUS + GAP
    v = np.tile([SPEED, 0.0], (len(x), 1))
    stress = np.zeros((len(tri), 3))  # xx, yy, xy
    szz = np.zeros(len(tri))
    speed = np.sqrt((LAM + 2 * MU) / DENSITY)
    dt = courant * RADIUS / n / speed
    history, t = [], 0.0
    while t < end:
        area, grad = gradients(x, tri)
        sigma = np.stack([stress[:, [0, 2]], stress[:, [2, 1]]], axis=1)
        element_force = -area[:, None, None] * np.einsum("kij,kaj->kai", sigma, grad)
        force = np.stack([np.bincount(tri.ravel(), element_force[..., i].ravel(), len(x)) for i in (0, 1)], axis=1)
        v += dt * force / mass[:, None]
        inside = x[:, 0] + dt * v[:, 0] > 0.0
        v[inside, 0] = -x[inside, 0] / dt
        half = x + 0.5 * dt * v
        _, grad = gradients(half, tri)
        L = np.einsum("kai,kaj->kij", v[tri], grad)
        x = x + dt * v
        D = 0.5 * (L + L.transpose(0, 2, 1))
        w = 0.5 * (L[:, 0, 1] - L[:, 1, 0])
        trace = D[:, 0, 0] + D[:, 1, 1]
        turn = 2 * w * stress[:, 2]
        shear = -w * (stress[:, 0] - stress[:, 1])
        stress[:, 0] += dt * (LAM * trace + 2 * MU * D[:, 0, 0] + turn)
        stress[:, 1] += dt * (LAM * trace + 2 * MU * D[:, 1, 1] - turn)
        stress[:, 2] += dt * (2 * MU * D[:, 0, 1] + shear)
        szz += dt * LAM * trace
        t += dt
        s2 = stress[:, 0] ** 2 + stress[:, 1] ** 2 + szz**2 + 2 * stress[:, 2] ** 2
        pull = stress[:, 0] + stress[:, 1] + szz
        strain_energy = np.sum(area * 0.25 / MU * (s2 - LAM / (3 * LAM + 2 * MU) * pull**2))
        kinetic = 0.5 * np.sum(mass[:, None] * v**2)
        history.append((t, np.sum(mass * v[:, 0]) / mass.sum(), inside.any(), kinetic + strain_energy))
    table = np.array(history, dtype=float)
    table[:, 3] /= 0.5 * element_mass.sum() * SPEED**2
    return table


def crossing(times, signal, level):
    """When a falling signal first passes a level, by linear interpolation."""
    i = np.flatnonzero(signal < level)[0]
    return times[i - 1] + (signal[i - 1] - level) / (signal[i - 1] - signal[i]) * (times[i] - times[i - 1])


if __name__ == "__main__":
    print("# disc against a smooth wall: finite elements of our own; see disc_on_wall.py")
    print("# slowed, released: mean velocity 1 % off the approach, and within 1 % of the rebound (as the case measures)")
    print("rings,first_touch_s,last_touch_s,slowed_s,released_s,restitution,energy_left")
    for n in (6, 12, 24, 48):
        table = collide(n, end=3.4)
        times, along, touching = table[:, 0], table[:, 1] / SPEED, table[:, 2] > 0
        first, last = times[touching][[0, -1]]
        rebound = along[times > last].mean()
        slowed, released = crossing(times, along, 0.99), crossing(times, along, 0.99 * rebound + 0.01)
        print(f"{n},{first:.4f},{last:.4f},{slowed:.4f},{released:.4f},{-rebound:.5f},{table[-1, 3]:.4f}")
    print(f"# contact begins at {GAP / SPEED:.4f} s by geometry")
