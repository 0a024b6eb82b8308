"""A quarter of an elastic ball, x, y >= 0: trilinear hexahedra with 2 x 2 x 2 Gauss points at small strain, lumped mass.

A core in the form of a rounded cube and layers between it and the surface. The rays of the surface's nodes are equal in angle
on each face of a cube, so that the facet in a direction is known without a search.
"""

import numpy as np
from scipy import sparse

CORE, ROUND = 0.45, 0.4  # half side of the core over the radius; how far its faces bulge
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
FACES = ((0, 1.0), (1, 1.0), (2, 1.0), (2, -1.0))  # axis and side; x and y below zero are left out


class Ball:
    """Elements along a cube's side n (even), layers; `rigid` keeps only mass and centre. Speeds along z [m/s]."""

    def __init__(self, radius, n, layers, young, nu, density, centre, speed, held_below, rigid) -> None:
        self.radius, self.n, self.rigid = radius, n, rigid
        nodes, hexes, self.facets = _mesh(n, layers)
        self.X = radius * nodes + np.array([0.0, 0.0, centre])
        lame, shear = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
        self.K, mass = _assemble(self.X, hexes, lame, shear, density)
        self.mass = mass * (density * np.pi / 3.0 * radius**3 / mass.sum())  # facets leave some of the ball out
        held = self.X[:, 2] < held_below
        free = np.ones_like(self.X)  # 0 where a component is held: the planes of symmetry, and the bottom
        free[np.abs(self.X[:, 0]) < 1e-9, 0] = 0.0
        free[np.abs(self.X[:, 1]) < 1e-9, 1] = 0.0
        free[held] = 0.0
        if rigid:  # moves along z alone, and not at all where something is held
            free = np.zeros_like(self.X) if held.any() else np.tile([0.0, 0.0, 1.0], (len(self.X), 1))
        self.free, self.inverse_mass = free, free / self.mass[:, None]
        self.u = np.zeros_like(self.X)
        self.v = free * np.array([0.0, 0.0, speed])
        self.top = int(np.argmax(self.X[:, 2]))

    def longest_step(self):
        """2/ω of the highest eigenfrequency [s], by power iteration; endless for a rigid ball."""
        if self.rigid:
            return np.inf
        probe = np.random.default_rng(1).standard_normal(self.X.size)
        value = 1.0
        for _ in range(300):
            probe = self.inverse_mass.ravel() * (self.K @ probe)
            value = np.linalg.norm(probe)
            probe /= value
        return 2.0 / np.sqrt(value)


def _mesh(n, layers):
    """Nodes (k, 3) of a unit ball's quarter, hexahedra (m, 8), surface node of lattice point [face, i, j], -1 outside."""
    side = np.tan(np.linspace(-0.25, 0.25, n + 1) * np.pi)
    half, found, hexes = n // 2, [], []

    def add(block, first=(0, 0, 0)):
        """Nodes of a lattice block (a, b, c, 3) and its hexahedra."""
        start = sum(len(part) for part in found)
        shape = np.array(block.shape[:3])
        found.append(block.reshape(-1, 3))
        index = start + np.arange(np.prod(shape)).reshape(shape)
        cells = [index[a : shape[0] - 1 + a, b : shape[1] - 1 + b, c : shape[2] - 1 + c].ravel() for a, b, c in CORNERS]
        hexes.append(np.column_stack(cells))
        return index

    upper = side[half:]
    lattice = np.stack(np.meshgrid(upper, upper, side, indexing="ij"), axis=-1)
    add(_core(lattice))
    surface = []
    for axis, sign in FACES:
        spans = [upper if a < 2 else side for a in range(3) if a != axis]
        p, q = np.meshgrid(*spans, indexing="ij")
        cube = np.insert(np.stack([p, q], axis=-1), axis, sign, axis=-1)
        outer = cube / np.linalg.norm(cube, axis=-1, keepdims=True)
        w = np.linspace(0.0, 1.0, layers + 1)[:, None, None, None]
        index = add((1 - w) * _core(cube) + w * outer)
        whole = np.full((n + 1, n + 1), -1)
        whole[n + 1 - p.shape[0] :, n + 1 - p.shape[1] :] = index[-1]
        surface.append(whole)
    points = np.concatenate(found)
    _, kept, same = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    same = same.ravel()
    facets = np.array([np.where(face >= 0, same[face], -1) for face in surface])
    cells = same[np.concatenate(hexes)]
    corner = points[kept][cells]
    turned = np.linalg.det(np.stack([corner[:, k] - corner[:, 0] for k in (1, 3, 4)], axis=1)) < 0.0
    cells[turned] = cells[turned][:, [4, 5, 6, 7, 0, 1, 2, 3]]
    return points[kept], cells, facets


def _core(cube):
    """Where points of the cube [-1, 1]^3 lie in the core of a unit ball."""
    length = np.linalg.norm(cube, axis=-1, keepdims=True)
    largest = np.abs(cube).max(axis=-1, keepdims=True)
    ratio = np.divide(largest, length, out=np.ones_like(length), where=length > 0.0)
    return CORE * cube * ((1 - ROUND) + ROUND * ratio * 1.2)


def _assemble(X, hexes, lame, shear, density):
    """Stiffness matrix [N/m], columns and rows 3 node + component, and lumped mass [kg] of hexahedra."""
    local = np.array(CORNERS) * 2.0 - 1.0
    stiffness = np.zeros((len(hexes), 24, 24))
    mass = np.zeros(len(X))
    C = np.diag([2 * shear] * 3 + [shear] * 3)
    C[:3, :3] += lame
    for point in local / np.sqrt(3.0):
        factors = 1.0 + local * point
        slopes = np.stack([local[:, k] * np.prod(np.delete(factors, k, axis=1), axis=1) for k in range(3)], axis=1) / 8.0
        jacobian = np.einsum("eai,ak->eik", X[hexes], slopes)
        volume = np.linalg.det(jacobian)
        if volume.min() <= 0.0:
            raise ValueError("a hexahedron is inside out")
        gradient = np.einsum("ak,eki->eai", slopes, np.linalg.inv(jacobian))
        B = np.zeros((len(hexes), 6, 24))
        for a, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]):
            B[:, a, i::3] = gradient[:, :, j]
            B[:, a, j::3] = gradient[:, :, i]
        stiffness += np.einsum("eki,kl,elj,e->eij", B, C, B, volume, optimize=True)
        np.add.at(mass, hexes, density * volume[:, None] * (np.prod(factors, axis=1) / 8.0))
    dofs = (3 * hexes[:, :, None] + np.arange(3)).reshape(len(hexes), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, (1, 24)).ravel()
    return sparse.csr_matrix((stiffness.ravel(), (rows, columns)), shape=(X.size, X.size)), mass
