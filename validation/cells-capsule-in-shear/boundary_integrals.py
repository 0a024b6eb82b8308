"""Capsules with a neo-Hookean surface in a shear flow without bounds, walls or inertia, by boundary integrals.

    python validation/cells-capsule-in-shear/boundary_integrals.py [REFINEMENTS, 3]

Inside and outside have one viscosity, so that there is no double layer (Pozrikidis 1992, Boundary Integral and Singularity
Methods):

    v(x) = γ̇ y e_x + 1/(8πμ) ∫ G(x, x') f(x') dS',   G = I/r + r r/r³,

with the force f per area that the surface exerts. It is interpolated linearly in flat triangles, from the forces on nodes (the
slopes of the energy of triangles of uniform strain) over their share of the area. Triangles at a node itself are integrated by
Duffy's transformation, near ones by six points and far ones by one. Heun's method in time. Lengths in radii, times in
reciprocal shear rates, μ = 1. Each refinement of the icosahedron quarters the triangles. The error goes with their area, and
the deformations that are written are extrapolated from the last two refinements.
Nothing of the package is used.
"""

import sys
from pathlib import Path

import numpy as np
from numba import njit, prange

GALLERY = Path(__file__).parents[2] / "src/pellucid/gallery/cells"
PLAIN = {"small": (0.0375, 0, 0, 0), "stiff": (0.15, 0, 0, 0), "middle": (0.3, 0, 0, 0), "soft": (0.6, 0, 0, 0)}
BENDING = {"bent": (0.15, 0.1125, 1, 0), "tensor": (0.15, 0.1125, 1, 0.5)}
"""μ γ̇ a / G with the surface shear modulus G, κ / a² G with the bending rigidity κ, spontaneous curvature, tension / κ.

A moment κ (b - 1/a) with the tensor b of curvature, zero on the sphere, has the energy κ/2 (2H - 1/a)² + κ/2a²: "tensor".
"""
TABLES = {"capsule-boundary-integrals": (PLAIN, 5.0), "capsule-bending-boundary-integrals": (BENDING, 2.0)}
EVERY = 0.25
FAR = 5  # widths of a triangle, from where on one point stands for it


def icosphere(refinements):
    """Vertices on the unit sphere and triangles, turned outwards."""
    g = (1 + 5**0.5) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    corners += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [
        (0, 11, 5),
        (0, 5, 1),
        (0, 1, 7),
        (0, 7, 10),
        (0, 10, 11),
        (1, 5, 9),
        (5, 11, 4),
        (11, 10, 2),
        (10, 7, 6),
        (7, 1, 8),
    ]
    faces += [(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    vertices = [np.array(c) / np.linalg.norm(c) for c in corners]
    for _ in range(refinements):
        middles, finer = {}, []

        def middle(a, b, middles=middles):
            key = (min(a, b), max(a, b))
            if key not in middles:
                place = vertices[a] + vertices[b]
                vertices.append(place / np.linalg.norm(place))
                middles[key] = len(vertices) - 1
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return np.array(vertices), np.array(faces)


def edges_of(X, T):
    return np.stack([X[T[:, 1]] - X[T[:, 0]], X[T[:, 2]] - X[T[:, 0]]], axis=2)


def areas_of(X, T):
    e = edges_of(X, T)
    return 0.5 * np.linalg.norm(np.cross(e[:, :, 0], e[:, :, 1]), axis=1)


def rest_shape(X, T):
    """Inverse edge matrices in axes of each triangle's plane."""
    e = edges_of(X, T)
    first = e[:, :, 0] / np.linalg.norm(e[:, :, 0], axis=1)[:, None]
    normal = np.cross(e[:, :, 0], e[:, :, 1])
    second = np.cross(normal / np.linalg.norm(normal, axis=1)[:, None], first)
    return np.linalg.inv(np.stack([np.einsum("ti,tik->tk", axis, e) for axis in (first, second)], axis=1))


def forces(X, T, inverse, area, modulus):
    """-∂/∂x of Σ A₀ G/2 (tr C + 1/det C - 3) with C = FᵀF, at the nodes."""
    F = edges_of(X, T) @ inverse
    C = np.swapaxes(F, 1, 2) @ F
    P = modulus * (F - F @ np.linalg.inv(C) / np.linalg.det(C)[:, None, None])
    H = -area[:, None, None] * (P @ np.swapaxes(inverse, 1, 2))
    f = np.zeros_like(X)
    np.add.at(f, T[:, 1], H[:, :, 0])
    np.add.at(f, T[:, 2], H[:, :, 1])
    np.add.at(f, T[:, 0], -H[:, :, 0] - H[:, :, 1])
    return f


def hinges(T):
    """The two ends of each edge, and the corners across it on its left and right."""
    across = {(T[t, k], T[t, k - 2]): T[t, k - 1] for t in range(len(T)) for k in range(3)}
    return np.array([(a, b, across[a, b], across[b, a]) for a, b in across if a < b])


def bending_forces(X, T, edges, rigidity, curvature, tension):
    """-∂/∂x of Σ κ/2 (2HA - c₀A)²/A + κσA at the nodes: HA = ¼ Σ l φ over their edges, A a third of their triangles.

    Jülicher 1996, J. Phys. II 6, 1797.
    """
    a, b, c, d = edges.T
    e = X[b] - X[a]
    length = np.linalg.norm(e, axis=1)
    sides = []
    for tip, turn in ((c, 1), (d, -1)):
        normal = turn * np.cross(e, X[tip] - X[a])
        twice = np.linalg.norm(normal, axis=1)
        sides.append((tip, normal / twice[:, None], twice / length, np.einsum("ki,ki->k", X[tip] - X[a], e) / length**2))
    n, m = sides[0][1], sides[1][1]
    angle = np.arctan2(np.einsum("ki,ki->k", np.cross(n, m), e / length[:, None]), np.einsum("ki,ki->k", n, m))
    angle *= np.sign(np.median(angle))  # positive where the surface is convex
    share, mean = np.zeros(len(X)), np.zeros(len(X))
    for k in range(3):
        np.add.at(share, T[:, k], areas_of(X, T) / 3)
    for end in (a, b):
        np.add.at(mean, end, 0.25 * length * angle)
    h = mean / share
    f, pull = np.zeros_like(X), (rigidity * (h[a] + h[b] - curvature))[:, None]
    along = pull * angle[:, None] * e / length[:, None]
    np.add.at(f, a, along)
    np.add.at(f, b, -along)
    for tip, normal, height, part in sides:
        turned = pull * length[:, None] * normal / height[:, None]
        np.add.at(f, tip, turned)
        np.add.at(f, a, -(1 - part)[:, None] * turned)
        np.add.at(f, b, -part[:, None] * turned)
    normal = np.cross(X[T[:, 1]] - X[T[:, 0]], X[T[:, 2]] - X[T[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    squares = rigidity * (2 / 3 * (h[T] ** 2).sum(axis=1) - curvature**2 / 2 - tension)[:, None]
    for k in range(3):
        np.add.at(f, T[:, k], squares * 0.5 * np.cross(normal, X[T[:, k - 1]] - X[T[:, k - 2]]))
    return f


def rules():
    """Points (u, v) and weights in a unit triangle: the middle; of degree 4; for what goes with 1/r about its first corner."""
    a, b, wa, wb = 0.445948490915965, 0.091576213509771, 0.1116907948390055, 0.054975871827661
    regular = np.array([(p, q, w) for c, w in ((a, wa), (b, wb)) for p, q in ((c, c), (1 - 2 * c, c), (c, 1 - 2 * c))])
    x, w = np.polynomial.legendre.leggauss(5)
    x, w = (x + 1) / 2, w / 2
    singular = np.array(
        [(s * (1 - t), s * t, ws * wt * s) for s, ws in zip(x, w, strict=True) for t, wt in zip(x, w, strict=True)]
    )
    return np.array([(1 / 3, 1 / 3, 0.5)]), regular, singular


@njit(parallel=True, cache=True)
def induced(X, T, density, far, regular, singular):
    """1/8π ∫ G f dS' at the nodes."""
    velocity = np.zeros_like(X)
    for i in prange(len(X)):
        v0 = v1 = v2 = 0.0
        for t in range(len(T)):
            a, b, c = T[t]
            own = a == i or b == i or c == i
            if b == i:
                a, b, c = b, c, a
            elif c == i:
                a, b, c = c, a, b
            e, g = X[b] - X[a], X[c] - X[a]
            twice = np.sqrt(
                (e[1] * g[2] - e[2] * g[1]) ** 2 + (e[2] * g[0] - e[0] * g[2]) ** 2 + (e[0] * g[1] - e[1] * g[0]) ** 2
            )
            d0 = X[i, 0] - X[a, 0] - (e[0] + g[0]) / 3
            d1 = X[i, 1] - X[a, 1] - (e[1] + g[1]) / 3
            d2 = X[i, 2] - X[a, 2] - (e[2] + g[2]) / 3
            rule = singular if own else far if d0 * d0 + d1 * d1 + d2 * d2 > FAR * FAR * twice else regular
            for k in range(len(rule)):
                u, w, weight = rule[k, 0], rule[k, 1], rule[k, 2] * twice
                s = 1 - u - w
                r0 = X[i, 0] - s * X[a, 0] - u * X[b, 0] - w * X[c, 0]
                r1 = X[i, 1] - s * X[a, 1] - u * X[b, 1] - w * X[c, 1]
                r2 = X[i, 2] - s * X[a, 2] - u * X[b, 2] - w * X[c, 2]
                f0 = s * density[a, 0] + u * density[b, 0] + w * density[c, 0]
                f1 = s * density[a, 1] + u * density[b, 1] + w * density[c, 1]
                f2 = s * density[a, 2] + u * density[b, 2] + w * density[c, 2]
                near = 1 / np.sqrt(r0 * r0 + r1 * r1 + r2 * r2)
                along = (r0 * f0 + r1 * f1 + r2 * f2) * near * near
                v0 += weight * near * (f0 + along * r0)
                v1 += weight * near * (f1 + along * r1)
                v2 += weight * near * (f2 + along * r2)
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = v0 / (8 * np.pi), v1 / (8 * np.pi), v2 / (8 * np.pi)
    return velocity


def deformation(X, T):
    """Taylor's (L-B)/(L+B) in the plane of the shear, of the ellipsoid with the inertia of what the surface encloses."""
    corners = [X[T[:, k]] for k in range(3)]
    volume = np.einsum("ti,ti->t", corners[0], np.cross(corners[1], corners[2])) / 6
    second = sum(np.einsum("t,ti,tj->ij", volume, p, p) for p in (*corners, sum(corners)))  # about the middle, which stays at 0
    squares, axes = np.linalg.eigh(second)
    B, L = (np.sqrt(squares[k]) for k in range(3) if abs(axes[2, k]) < 0.5)
    return (L - B) / (L + B)


def course(capillary, bending, curvature, tension, end, refinements):
    """Deformations every so often."""
    finer = 2 ** (refinements - 3)
    stable = min(0.0125, 0.16 * capillary / finer, 0.0008 * capillary / max(bending, 1e-9) / finer**3)
    step = EVERY / np.ceil(EVERY / stable)
    X, T = icosphere(refinements)
    inverse, area, edges = rest_shape(X, T), areas_of(X, T), hinges(T)
    far, regular, singular = rules()

    def velocity(X):
        share = np.zeros(len(X))
        for k in range(3):
            np.add.at(share, T[:, k], areas_of(X, T) / 3)
        f = forces(X, T, inverse, area, 1 / capillary)
        if bending:
            f += bending_forces(X, T, edges, bending / capillary, curvature, tension)
        v = induced(X, T, f / share[:, None], far, regular, singular)
        v[:, 0] += X[:, 1]
        return v

    found, steps = [0.0], round(EVERY / step)
    for number in range(1, round(end / step) + 1):
        v = velocity(X)
        X = X + step / 2 * (v + velocity(X + step * v))
        if number % steps == 0:
            found.append(deformation(X, T))
    return np.array(found)


def main():
    finest = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    for table, (capsules, end) in TABLES.items():
        columns = [np.arange(round(end / EVERY) + 1) * EVERY]
        for name, capsule in capsules.items():
            coarse, fine = (course(*capsule, end, refinements) for refinements in (finest - 1, finest))
            columns.append((4 * fine - coarse) / 3)
            print(name, "changed by the last refinement:", np.abs(fine - coarse).max().round(5), flush=True)
        head = "# Deformation of capsules with a neo-Hookean surface in a shear flow\n"
        head += "# validation/cells-capsule-in-shear/boundary_integrals.py\n" + ",".join(["time [s]", *capsules])
        path = (GALLERY / table).with_suffix(".csv")
        np.savetxt(path, np.transpose(columns), fmt="%.5g", delimiter=",", header=head, comments="")


if __name__ == "__main__":
    main()
