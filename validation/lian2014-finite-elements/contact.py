"""Contact without friction between the nodes of a sheet and the surface of a ball.

They touch where a node, which lies midway between the faces of the sheet, is half the thickness away. The ball's surface is the
sphere, moved along its normal by the displacement that its nodes have there (bilinear in the angles of a facet). Without a
penalty, projected Gauss-Seidel finds the impulses, none pulling, after which no node is inside at the end of the step: an
impact that does not rebound. With one, a spring pushes each node that is inside: an impact that does.
"""

import numpy as np
from numba import njit

SWEEPS, CLOSE = 500, 1e-9  # at most so many sweeps; they end when no relative speed changes by more than this [m/s]


def meet(sheet, ball, dt, penalty):
    """Changes the velocities of sheet and ball by contact; gives the impulse on the sheet along z [N s].

    penalty: 0 for none, otherwise the spring of a node of mass m is penalty m / dt^2.
    """
    lead = 0.0 if penalty else dt
    moved = ball.u + lead * ball.v
    shift = np.average(moved[:, 2], weights=ball.mass)
    moved[:, 2] -= shift
    middle = ball.X[ball.top, 2] - ball.radius + shift
    half = 0.5 * sheet.thickness
    near = _near(sheet.x, sheet.v, sheet.free, lead, ball.radius, half, middle, moved, ball.facets, ball.n, 1e-3 * sheet.h)
    if near[0].size == 0:
        return 0.0
    inverse_mass = ball.inverse_mass
    if ball.rigid:
        inverse_mass = np.array([[0.0, 0.0, 1.0 / ball.mass.sum()]]) if ball.free.any() else np.zeros((1, 3))
    impulse = _impulses(*near, sheet.v, sheet.mass, sheet.free, ball.v, inverse_mass, ball.rigid, dt, penalty)
    if ball.rigid:
        ball.v[:, 2] = ball.v[0, 2]
    return impulse


@njit(cache=True)
def _near(x, v, free, lead, radius, half, middle, moved, facets, n, margin):
    """Nodes at the surface or inside: index, outward normals, facets' nodes and weights, gaps [m]."""
    index = np.empty(len(x), np.int64)
    normals = np.empty((len(x), 3))
    nodes = np.zeros((len(x), 4), np.int64)
    weights = np.zeros((len(x), 4))
    gaps = np.empty(len(x))
    found = 0
    for k in range(len(x)):
        if free[k, 2] == 0.0:
            continue
        a = x[k, 0] + lead * v[k, 0]
        b = x[k, 1] + lead * v[k, 1]
        c = x[k, 2] + lead * v[k, 2] - middle
        distance = np.sqrt(a * a + b * b + c * c)
        if distance > radius + half + margin:
            continue
        normal = (a / distance, b / distance, c / distance)
        if normal[0] >= max(normal[1], abs(normal[2])):
            face, p, q = 0, normal[1] / normal[0], normal[2] / normal[0]
        elif normal[1] >= abs(normal[2]):
            face, p, q = 1, normal[0] / normal[1], normal[2] / normal[1]
        else:
            face = 2 if normal[2] > 0.0 else 3
            p, q = normal[0] / abs(normal[2]), normal[1] / abs(normal[2])
        s, t = (0.5 + np.arctan(p) * 2.0 / np.pi) * n, (0.5 + np.arctan(q) * 2.0 / np.pi) * n
        # the planes of symmetry run through lattice lines: a node a round-off beyond one belongs to the quarter
        least_s, least_t = n // 2, (n // 2 if face > 1 else 0)
        i = min(max(int(s), least_s), n - 1)
        j = min(max(int(t), least_t), n - 1)
        s, t = s - i, t - j
        facet = (facets[face, i, j], facets[face, i + 1, j], facets[face, i + 1, j + 1], facets[face, i, j + 1])
        weight = ((1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t)
        gap = distance - radius - half
        for o in range(4):
            for d in range(3):
                gap -= weight[o] * normal[d] * moved[facet[o], d]
        if gap > margin:
            continue
        index[found], gaps[found] = k, gap
        for d in range(3):
            normals[found, d] = normal[d]
        for o in range(4):
            nodes[found, o], weights[found, o] = facet[o], weight[o]
        found += 1
    return index[:found], normals[:found], nodes[:found], weights[:found], gaps[:found]


@njit(cache=True)
def _impulses(index, normals, nodes, weights, gaps, v, mass, free, ball_v, inverse_mass, rigid, dt, penalty):
    """Applies impulses along the normals; their sum along z on the sheet [N s]."""
    count = len(index)
    if rigid:  # all of the ball moves as its first node does
        nodes = np.zeros_like(nodes)
        weights = np.zeros_like(weights)
        weights[:, 0] = 1.0
    give = np.empty(count)  # relative speed per impulse
    apart = np.empty(count)  # gap at the end of the step over dt, less the relative speed
    for k in range(count):
        node, give[k] = index[k], 0.0
        for d in range(3):
            give[k] += normals[k, d] ** 2 * free[node, d] / mass[node]
            for o in range(4):
                give[k] += (weights[k, o] * normals[k, d]) ** 2 * inverse_mass[nodes[k, o], d]
        apart[k] = gaps[k] / dt - _approach(k, node, normals, nodes, weights, v, ball_v)
    pushed = np.zeros(count)
    for _ in range(1 if penalty > 0.0 else SWEEPS):
        largest = 0.0
        for k in range(count):
            node = index[k]
            if penalty > 0.0:
                change = max(0.0, -gaps[k]) * penalty * mass[node] / dt
            else:
                lacking = -(apart[k] + _approach(k, node, normals, nodes, weights, v, ball_v))
                change = max(-pushed[k], lacking / give[k])
                largest = max(largest, abs(change) * give[k])
            pushed[k] += change
            for d in range(3):
                v[node, d] += change * normals[k, d] * free[node, d] / mass[node]
                for o in range(4):
                    ball_v[nodes[k, o], d] -= change * weights[k, o] * normals[k, d] * inverse_mass[nodes[k, o], d]
        if largest < CLOSE:
            break
    return np.sum(pushed * normals[:, 2])


@njit(cache=True)
def _approach(k, node, normals, nodes, weights, v, ball_v):
    """Relative speed of a node and the surface along the normal [m/s], positive where they part."""
    speed = 0.0
    for d in range(3):
        surface = 0.0
        for o in range(4):
            surface += weights[k, o] * ball_v[nodes[k, o], d]
        speed += normals[k, d] * (v[node, d] - surface)
    return speed
