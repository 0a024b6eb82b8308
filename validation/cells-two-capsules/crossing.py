"""Two capsules with a neo-Hookean surface pass each other in a shear flow without bounds, walls or inertia.

    python validation/cells-two-capsules/crossing.py [REFINEMENTS, 3]

Boundary integrals as in validation/cells-capsule-in-shear/boundary_integrals.py, with the surfaces and forces of that script.
The second capsule is the image of the first one in the point midway between them: its nodes are at -x, with the forces -f.
Only one surface is therefore computed. Triangles of the other capsule that are nearer than NEAR widths are integrated over
sixteen parts. Lengths in radii, times in reciprocal shear rates, μ = 1. Nothing of the package is used.
"""

import sys
from pathlib import Path

import numpy as np
from numba import njit, prange

sys.path.insert(0, str(Path(__file__).parents[1] / "cells-capsule-in-shear"))
from boundary_integrals import FAR, areas_of, forces, icosphere, rest_shape, rules

TABLE = Path(__file__).parents[2] / "src/pellucid/gallery/cells/two-capsules-boundary-integrals.csv"
CAPILLARY, INFLATION = 0.45, 0.05  # μ γ̇ a / G with the surface shear modulus G; radius over that at rest, less 1
OFFSET, END = 0.25, 3.8  # distance of the centres across the flow at the start, and along it at the end, in diameters
STARTS = (4.0, 2.5)  # distances along the flow at the start, in diameters; the table has the last one
PLACES = (-1.43, -0.51, 0.43, 1.05, 2.13, 3.6)  # distances along the flow of the points that are printed
STEP = 0.025
NEAR = 2  # widths of a triangle


def divided(rule, parts):
    """The rule on each of the parts² triangles that a unit triangle is divided into."""
    found = []
    for i in range(parts):
        for j in range(parts - i):
            found += [((i + u) / parts, (j + w) / parts, weight / parts**2) for u, w, weight in rule]
            if i + j < parts - 1:
                found += [((i + 1 - u) / parts, (j + 1 - w) / parts, weight / parts**2) for u, w, weight in rule]
    return np.array(found)


@njit(parallel=True, cache=True)
def induced(X, T, density, far, regular, singular, near):
    """1/8π ∫ G f dS' at the nodes, over the surface and the one at -x."""
    velocity = np.zeros_like(X)
    for i in prange(len(X)):
        v0 = v1 = v2 = 0.0
        for image in (1, -1):
            x0, x1, x2 = image * X[i, 0], image * X[i, 1], image * X[i, 2]
            for t in range(len(T)):
                a, b, c = T[t]
                own = image == 1 and (a == i or b == i or c == i)
                if own and b == i:
                    a, b, c = b, c, a
                elif own and c == i:
                    a, b, c = c, a, b
                e, g = X[b] - X[a], X[c] - X[a]
                twice = np.sqrt(
                    (e[1] * g[2] - e[2] * g[1]) ** 2 + (e[2] * g[0] - e[0] * g[2]) ** 2 + (e[0] * g[1] - e[1] * g[0]) ** 2
                )
                d0 = x0 - X[a, 0] - (e[0] + g[0]) / 3
                d1 = x1 - X[a, 1] - (e[1] + g[1]) / 3
                d2 = x2 - X[a, 2] - (e[2] + g[2]) / 3
                distance = (d0 * d0 + d1 * d1 + d2 * d2) / twice
                if own:
                    rule = singular
                elif distance > FAR * FAR:
                    rule = far
                elif image == 1 or distance > NEAR * NEAR:
                    rule = regular
                else:
                    rule = near
                for k in range(len(rule)):
                    u, w, weight = rule[k, 0], rule[k, 1], image * rule[k, 2] * twice
                    s = 1 - u - w
                    r0 = x0 - s * X[a, 0] - u * X[b, 0] - w * X[c, 0]
                    r1 = x1 - s * X[a, 1] - u * X[b, 1] - w * X[c, 1]
                    r2 = x2 - s * X[a, 2] - u * X[b, 2] - w * X[c, 2]
                    f0 = s * density[a, 0] + u * density[b, 0] + w * density[c, 0]
                    f1 = s * density[a, 1] + u * density[b, 1] + w * density[c, 1]
                    f2 = s * density[a, 2] + u * density[b, 2] + w * density[c, 2]
                    inverse = 1 / np.sqrt(r0 * r0 + r1 * r1 + r2 * r2)
                    along = (r0 * f0 + r1 * f1 + r2 * f2) * inverse * inverse
                    v0 += weight * inverse * (f0 + along * r0)
                    v1 += weight * inverse * (f1 + along * r1)
                    v2 += weight * inverse * (f2 + along * r2)
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = v0 / (8 * np.pi), v1 / (8 * np.pi), v2 / (8 * np.pi)
    return velocity


def centroid(X, T):
    """Centre and size of the enclosed volume."""
    corners = [X[T[:, k]] for k in range(3)]
    volume = np.einsum("ti,ti->t", corners[0], np.cross(corners[1], corners[2])) / 6
    return np.einsum("t,ti->i", volume, sum(corners)) / 4 / volume.sum(), volume.sum()


def course(start, refinements, capillary=CAPILLARY, inflation=INFLATION, step=STEP):
    """Return distances of the centres along the flow and across it, in diameters, and the volume of a capsule."""
    sphere, T = icosphere(refinements)
    rest = sphere / (1 + inflation)
    inverse, area = rest_shape(rest, T), areas_of(rest, T)
    X = sphere + np.array([-start, OFFSET, 0.0])
    far, regular, singular = rules()
    near = divided(regular, 4)

    def velocity(X):
        share = np.zeros(len(X))
        for k in range(3):
            np.add.at(share, T[:, k], areas_of(X, T) / 3)
        f = forces(X, T, inverse, area, 1 / capillary)
        v = induced(X, T, f / share[:, None], far, regular, singular, near)
        v[:, 0] += X[:, 1]
        return v

    found = []
    while True:
        centre, volume = centroid(X, T)
        found.append((centre[0], centre[1], volume))
        if centre[0] > END:
            return np.array(found)
        v = velocity(X)
        X = X + step / 2 * (v + velocity(X + step * v))


def main():
    refinements = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    for start in STARTS:
        along, across, volume = course(start, refinements).T
        print(f"start {start}: volume {volume.min():.4f} to {volume.max():.4f}, largest offset {across.max():.4f}")
        print(*(f"{place}: {np.interp(place, along, across):.4f}" for place in PLACES), flush=True)
    rows = np.append(np.arange(0, len(along) - 1, 8), len(along) - 1)
    head = "# Two capsules pass each other: distances of the centres along the flow and across it, in diameters\n"
    head += "# validation/cells-two-capsules/crossing.py\nalong [m],across [m]"
    np.savetxt(TABLE, np.stack([along, across], axis=1)[rows], fmt="%.5g", delimiter=",", header=head, comments="")


if __name__ == "__main__":
    main()
