"""Films on a sphere by flat (P1) and by quadratic triangles (P2), with numpy and scipy alone: controls of the film in space.

    ∫ 2μ D:D(δv) + λ tr D tr D(δv) = ∫ p tr D(δv) + b·δv    for every δv,

D in the surface, places and velocities by the same functions. Prints the table of README.md.
"""

from math import exp, pi, sqrt

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import LinearOperator, cg, splu

A, B = 0.445948490915965, 0.091576213509771  # six points on a triangle, exact to degree 4 (Dunavant 1985)
POINTS = np.array([[A, A], [A, 1 - 2 * A], [1 - 2 * A, A], [B, B], [B, 1 - 2 * B], [1 - 2 * B, B]])
EXACT = sqrt(2.0 - exp(-0.5))  # R(1) with μ = λ = a = ρ₀ = 1, from 2 ρ₀ at R = 1
WEIGHTS = 0.5 * np.repeat([0.223381589678011, 0.109951743655322], 3)


def linear(point):
    """Values and derivatives along both parameters, shape (3, 3)."""
    x, y = point
    return np.array([[1 - x - y, x, y], [-1, 1, 0], [-1, 0, 1]])


def quadratic(point):
    """Of corners, then of the middles of the sides 01, 12, 20: shape (3, 6)."""
    value, dx, dy = linear(point)
    rows = [[*(value * (2 * value - 1)), *(4 * value * np.roll(value, -1))]]
    rows += [[*(d * (4 * value - 1)), *(4 * (d * np.roll(value, -1) + value * np.roll(d, -1)))] for d in (dx, dy)]
    return np.array(rows)


def icosphere(rounds):
    """Triangles and nodes: an icosahedron whose triangles are cut in four so often, on the unit sphere."""
    g = (1 + sqrt(5)) / 2
    places = np.array([p for a in (-1, 1) for b in (-g, g) for p in ([a, b, 0], [0, a, b], [b, 0, a])], float)
    distance = np.linalg.norm(places[:, None] - places, axis=2)
    near = (distance > 0) & (distance < 2.1)
    triangles = np.array(
        [t for t in np.ndindex(12, 12, 12) if t[0] < t[1] < t[2] and near[t[0], t[1]] and near[t[1], t[2]] and near[t[0], t[2]]]
    )
    inward = np.linalg.det(places[triangles]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    places /= np.linalg.norm(places, axis=1)[:, None]
    for _ in range(rounds):
        nodes, places = with_middles(triangles, places)
        a, b, c, ab, bc, ca = nodes.T
        triangles = np.concatenate(
            [np.stack(corners, axis=1) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
    return triangles, places


def with_middles(triangles, places):
    """The six nodes of each triangle and all places, with the middles of the sides on the unit sphere."""
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    unique, number = np.unique(sides, axis=0, return_inverse=True)
    middle = places[unique].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    return np.hstack([triangles, len(places) + number.reshape(-1, 3)]), np.concatenate([places, middle])


def jittered(triangles, places, share, seed=1):
    """Nodes moved along the unit sphere, in a random direction, by a share of the distance to the nearest neighbour."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    nearest = np.full(len(places), np.inf)
    np.minimum.at(nearest, ends[:, 0], np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1))
    shift = np.random.default_rng(seed).normal(size=places.shape)
    shift -= np.einsum("ni,ni->n", shift, places)[:, None] * places
    places = places + shift * (share * nearest / np.linalg.norm(shift, axis=1))[:, None]
    return places / np.linalg.norm(places, axis=1)[:, None]


class Film:
    """A film at nodes x, shape (n, 3), by these nodes of the triangles and functions at their quadrature points."""

    def __init__(self, nodes, functions, x, viscosity=1.0, dilatational=1.0):
        self.nodes, self.n = nodes, len(x)
        table = np.array([functions(point) for point in POINTS])
        corner = x[nodes]
        value, first = table[:, 0], table[:, 1:]
        self.place = np.einsum("qm,emi->eqi", value, corner)
        along = np.einsum("qam,emi->eqai", first, corner)
        cross = np.cross(along[:, :, 0], along[:, :, 1])
        size = np.linalg.norm(cross, axis=2)
        self.area, self.normal = size * WEIGHTS, cross / size[..., None]
        one = along[:, :, 0] / np.linalg.norm(along[:, :, 0], axis=2)[..., None]
        frame = np.stack([one, np.cross(self.normal, one)], axis=2)
        metric = np.einsum("eqai,eqbi->eqab", along, along)
        gradient = np.einsum("qam,eqab,eqbi->eqmi", first, np.linalg.inv(metric), along)  # of each function, in space
        slope = np.einsum("eqmi,eqci->eqcm", gradient, frame)
        rows = np.einsum("eqcm,eqdi->eqcdmi", slope, frame)
        self.strain = np.stack([rows[:, :, 0, 0], rows[:, :, 1, 1], rows[:, :, 0, 1] + rows[:, :, 1, 0]], axis=2)
        self.dilatation, self.value = self.strain[:, :, 0] + self.strain[:, :, 1], value
        e, m = nodes.shape
        square = np.einsum(
            "eq,eqsmi,s,eqsnj->eminj", self.area, self.strain, viscosity * np.array([2.0, 2.0, 1.0]), self.strain
        )
        square += dilatational * np.einsum("eq,eqmi,eqnj->eminj", self.area, self.dilatation, self.dilatation)
        number = (3 * nodes[:, :, None] + np.arange(3)).reshape(e, -1)
        row = np.repeat(number, 3 * m, axis=1).ravel()
        column = np.tile(number, (1, 3 * m)).ravel()
        self.matrix = coo_array((square.ravel(), (row, column)), shape=(3 * self.n, 3 * self.n)).tocsc()
        self.free = self._rigid(x)

    def _rigid(self, x):
        turns = [np.cross(axis, x) for axis in np.eye(3)]
        return np.stack(
            [*(np.tile(axis, (self.n, 1)).ravel() for axis in np.eye(3)), *(turn.ravel() for turn in turns)], axis=1
        )

    def factor(self):
        """Of the matrix; three nodes are held against rigid motions, by forces that come out as nothing."""
        held = csc_array(np.repeat(np.arange(self.n) % (self.n // 3) == 0, 3)[:, None] * self.free)
        return splu(self.matrix + held @ held.T, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def velocity(self, factor, pressure, load=None):
        """By the film's pressure and a load per area at the quadrature points, without mean motion.

        factor: of this matrix, or of one like it.
        """
        force = np.einsum("eq,eqmi->emi", self.area * pressure, self.dilatation)
        if load is not None:
            force = force + np.einsum("eq,qm,eqi->emi", self.area, self.value, load)
        total = np.zeros((self.n, 3))
        np.add.at(total, self.nodes.ravel(), force.reshape(-1, 3))
        right = self._without_rigid(total.ravel())  # quadrature leaves some net force
        like = LinearOperator(self.matrix.shape, lambda r: self._without_rigid(factor.solve(self._without_rigid(r))))
        v, failed = cg(self.matrix, right, rtol=1e-12, M=like)
        if failed:
            raise ArithmeticError("the solution did not converge")
        return self._without_rigid(v).reshape(-1, 3)

    def _without_rigid(self, v):
        v = v.ravel()
        return v - self.free @ np.linalg.solve(self.free.T @ self.free, self.free.T @ v)

    def at_points(self, v):
        return np.einsum("qm,emi->eqi", self.value, v[self.nodes])


def legendre(degree, z):
    """P_l and its slope."""
    c = np.eye(degree + 1)[degree]
    return np.polynomial.legendre.legval(z, c), np.polynomial.legendre.legval(z, np.polynomial.legendre.legder(c))


def gradient_mode(place, degree, dilatational):
    """w = ∇Y_l and the load that drives it, (2μ (L - 1) + λ L) w - 2 (μ + λ) L Y_l n, with μ = 1."""
    n = place / np.linalg.norm(place, axis=-1, keepdims=True)
    wave, slope = legendre(degree, n[..., 2:])
    w, L = slope * (np.array([0.0, 0.0, 1.0]) - n[..., 2:] * n), degree * (degree + 1)
    return w, (2.0 * (L - 1.0) + dilatational * L) * w - 2.0 * (1.0 + dilatational) * L * wave * n


def compressed(nodes, functions, x, steps=10):
    """What R(1) is off, of 2 ρ₀ at R = 1: the film has the mass of the exact sphere; classical Runge-Kutta steps."""
    start = Film(nodes, functions, x)
    mass, factor = start.area * (8.0 * pi / start.area.sum()), start.factor()

    def rate(x):
        film = Film(nodes, functions, x)
        return film.velocity(factor, mass / film.area - 1.0)

    dt = 1.0 / steps
    for _ in range(steps):
        k1 = rate(x)
        k2 = rate(x + 0.5 * dt * k1)
        k3 = rate(x + 0.5 * dt * k2)
        x = x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(x + dt * k3))
    return np.linalg.norm(x, axis=1).mean() - EXACT


def gradient_error(nodes, functions, x):
    """Relative error of the velocity of the mode l = 2, mean square."""
    film = Film(nodes, functions, x)
    w, load = gradient_mode(film.place, 2, 1.0)
    wrong = film.at_points(film.velocity(film.factor(), 0.0 * film.area, load)) - w
    return sqrt(np.sum(film.area[..., None] * wrong**2) / np.sum(film.area[..., None] * w**2))


def power_error(nodes, functions, x, dilatational=1000.0):
    """Relative error of the power of the mode l = 4 where the film hardly changes its area."""
    film, degree = Film(nodes, functions, x, dilatational=dilatational), 4
    v, L = gradient_mode(x, degree, dilatational)[0].ravel(), degree * (degree + 1)
    exact = (2.0 * (L - 1.0) + dilatational * L) * 4.0 * pi * L / (2 * degree + 1)  # ∫ w² = L ∫ Y²
    return v @ (film.matrix @ v) / exact - 1.0


if __name__ == "__main__":
    for name, functions in (("P1", linear), ("P2", quadratic)):
        for rounds in (3, 4):
            corners, places = icosphere(rounds - (name == "P2"))
            meshes = []
            for share in (0.0, 0.2):
                x = jittered(corners, places, share) if share else places
                meshes.append((corners, x) if name == "P1" else with_middles(corners, x))
            (nodes, x), (_, uneven) = meshes
            found = [
                compressed(nodes, functions, x),
                gradient_error(nodes, functions, x),
                gradient_error(nodes, functions, uneven),
            ]
            found.append(power_error(nodes, functions, x))
            print(name, len(x), *(f"{value:.2e}" for value in found), flush=True)
