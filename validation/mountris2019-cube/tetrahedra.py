"""The whole cube in linear tetrahedra on a body-centred lattice: how far they lock.

python tetrahedra.py > tetrahedra.csv
"""

import felupe as fem
import numpy as np
from cube import SIDE
from statics import LAWS, Static, minimize


def lattice(n):
    """Nodes [m] and tetrahedra of n x n x n cubes: a node at each corner and in each middle.

    Around each square between two cubes stand four tetrahedra with both middles; over a square of the surface stand two,
    cut from its least corner to the opposite one.
    """
    corners = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
    middles = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1).reshape(-1, 3)
    points = np.concatenate([corners, middles + 0.5])
    number = {tuple(np.round(2 * p).astype(int)): i for i, p in enumerate(points)}
    cells = []
    for axis in range(3):
        e, a, b = np.eye(3, dtype=int)[[axis, (axis + 1) % 3, (axis + 2) % 3]]
        for place in np.ndindex(*(n + 1 if k == axis else n for k in range(3))):
            low = 2 * np.array(place)
            ring = [number[tuple(low + d)] for d in (0 * a, 2 * a, 2 * a + 2 * b, 2 * b)]
            sides = [number.get(tuple(low + a + b + s * e)) for s in (-1, 1)]
            if None not in sides:
                cells += [[ring[k], ring[(k + 1) % 4], *sides] for k in range(4)]
            else:
                top = sides[0] if sides[1] is None else sides[1]
                cells += [[ring[0], ring[1], ring[2], top], [ring[0], ring[2], ring[3], top]]
    points, cells = points / n * SIDE, np.array(cells)
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    turned = np.linalg.det(edges) < 0
    cells[turned] = cells[turned][:, [0, 2, 1, 3]]
    return points, cells


def solve(n, law, to, steps):
    """Nodes, cells, energy [J], reaction on the upper face [N], least J."""
    points, cells = lattice(n)
    static = Static(fem.RegionTetra(fem.Mesh(points, cells, "tetra")), law)
    z = points[:, 2]
    ends = np.flatnonzero((z < 1e-9) | (z > SIDE - 1e-9))
    fixed = (3 * ends[:, None] + np.arange(3)).ravel()
    u, length = np.zeros_like(points), SIDE
    for new in SIDE + to * np.arange(1, steps + 1) / steps:
        u[:, 2] = (z + u[:, 2]) * new / length - z
        u, length = minimize(static, u.ravel(), fixed)[0].reshape(-1, 3), new
    state = static.state(u.ravel())
    forces = static.forces(state).reshape(-1, 3)
    return len(points), len(cells), static.energy(state), forces[z > SIDE - 1e-9, 2].sum(), state[1].min()


if __name__ == "__main__":
    print("# linear tetrahedra on a body-centred lattice, static: tetrahedra.py. m, J, N")
    print("form,moved,cubes,nodes,tetrahedra,energy,reaction,least_j")
    for form, law in LAWS.items():
        for to in (0.05, -0.05):
            for n in (4, 7, 13):
                nodes, cells, energy, reaction, least = solve(n, law, to, 10 if to > 0 else 20)
                print(f"{form},{to},{n},{nodes},{cells},{energy:.6f},{reaction:.4f},{least:.3f}", flush=True)
