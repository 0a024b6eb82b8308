"""Curvatures of open membranes from the angles at the edges of their triangles, and the bending stiffness.

A triangle of area A has the curvature tensor of a Morley element,

    κ = 1/A Σ_edges l α m⊗m,

with the length l and the outward normal m of an edge in the plane of the triangle; α is the angle between the normal of the
triangle and the normal of the smooth surface at the midpoint of the edge. The angles of both triangles at an edge add up to
the fold φ between their normals, so that a constant moment does no work on inner nodes. They are

    α = φ/2 ± Σ_patch c φ

with the smallest c for which every quadratic surface has its exact curvature; the patch consists of both triangles and
their neighbours. On meshes of equal triangles c is 0. The energy of an isotropic plate [J] with the folds φ₀ in the unbent
state is

    E = D/2 Σ A [(tr κ)² - 2(1-ν) det κ] = ½ (φ - φ₀)ᵀ S (φ - φ₀),    with κ of φ - φ₀,

minimised over α at free edges, where no moment acts. At an edge next to a clamped triangle α = φ: that triangle has the
normal of the clamp. In a plane of symmetry the mirror image is the neighbour, α = φ/2.

Source: Morley 1971, J. Strain Anal. 6, 20, for the element; Oñate & Flores 2005, Comput. Methods Appl. Mech. Eng. 194,
2406, for angles from neighbours and clamped edges.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from pellucid.geometry.meshes.triangulation import pair_edges

TINY = 1e-12
RANK = 2.5e-3  # eigenvalue, relative to the largest, below which the folds of a patch do not determine a curvature
LEAVES = 0.5  # cosine of the angle with the plane's normal from which on a triangle has a mirror image
BACK = 0.1  # 1 + cosine of the angle between normals of a patch below which it counts as folded back


class BendingSupports(NamedTuple):
    """Supports that affect the bending of a mesh of t triangles and n nodes: clamps and planes of symmetry."""

    led: np.ndarray  # (t,) True for triangles that move as a clamp
    on_plane: np.ndarray  # (n, 3) True if a node lies in a plane of symmetry normal to the axis
    fixed: np.ndarray  # (n,) True for nodes that cannot move freely in any direction


def no_supports(n_triangles: int, n_nodes: int) -> BendingSupports:
    """Return the supports of a membrane without any constraints."""
    return BendingSupports(np.zeros(n_triangles, bool), np.zeros((n_nodes, 3), bool), np.zeros(n_nodes, bool))


def find_led_triangles(triangles: np.ndarray, normals: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return a mask of the triangles that move as a clamp, shape (t,): all nodes of the triangle and of at least one
    neighbour follow the same constraint along every axis along which the normal of the triangle has a component. A single
    triangle, as in the corner of a plate on knife edges, clamps nothing.

    triangles: shape (t, 3); normals: normals of the triangles, shape (t, 3); rows: number of the constraint of a node along
    each axis, 0 if it is free, shape (n, 3).
    """
    of = rows[triangles]
    agree = (of[:, 0] == of[:, 1]) & (of[:, 1] == of[:, 2]) & (of[:, 0] > 0)
    led = np.all(agree | (np.abs(normals) < 1e-6), axis=1)
    chosen, partner = pair_edges(triangles)
    left, right = chosen % len(triangles), partner % len(triangles)
    both = led[left] & led[right]
    beside = np.zeros(len(triangles), bool)
    beside[left[both]] = beside[right[both]] = True
    return led & beside


class PlateOperators(NamedTuple):
    """The h hinges (edges between two triangles) of a mesh with n nodes, and the linear operators on their fold angles."""

    corners: np.ndarray  # (h, 4) nodes a and b of the edge, then the third corners of the triangles on its left and right
    mirror: np.ndarray  # (h,) axis across which the right corner is the mirror image of the left one, else -1
    unit: np.ndarray  # (h,) fold angles per curvature of a surface with equal curvature along all directions [m]
    stiffness: sp.csr_array  # (h, h) S [J]
    curvature: sp.csr_array  # (n, h) maps folds to 2H, the sum of the principal curvatures, at the nodes [1/m]

    def folds(self, position: np.ndarray) -> np.ndarray:
        """Return the angles between the normals of both triangles at each hinge, positive if the normals diverge, shape
        (h,). position: (n, 3) [m]."""
        along, _, _, n1, n2 = self._unfolded(position)
        length = np.linalg.norm(along, axis=1)
        return np.arctan2(np.sum(along * np.cross(n1, n2), axis=1) / length, np.sum(n1 * n2, axis=1))

    def rate(self, position: np.ndarray, mass: np.ndarray, fixed: np.ndarray) -> float:
        """Return an upper bound of half the largest eigenfrequency of bending [1/s], from the rows of the stiffness.

        position: nodal positions [m], shape (n, 3); mass: nodal masses [kg], shape (n,); fixed: mask of the nodes that cannot
        move, shape (n,).
        """
        along, left, right, n1, n2 = self._unfolded(position)
        square = np.sum(along * along, axis=1)
        one, two = (np.sqrt(square) / np.linalg.norm(n, axis=1) for n in (n1, n2))
        s, t = (np.sum(way * along, axis=1) / square for way in (left, right))
        turned = np.stack([np.abs(1.0 - s) * one + np.abs(1.0 - t) * two, np.abs(s) * one + np.abs(t) * two, one, two], axis=1)
        turned[fixed[self.corners]] = 0.0
        bound = abs(self.stiffness) @ turned.sum(axis=1)
        rows = np.bincount(self.corners.ravel(), (turned * bound[:, None]).ravel(), len(mass))
        return 0.5 * float(np.sqrt((rows / mass).max(initial=0.0)))

    def _unfolded(self, position: np.ndarray) -> tuple[np.ndarray, ...]:
        a, b, c, d = (position[corner] for corner in self.corners.T)
        d, rows = d.copy(), np.flatnonzero(self.mirror >= 0)
        axis = self.mirror[rows]
        d[rows, axis] = a[rows, axis] + b[rows, axis] - d[rows, axis]
        along, left, right = b - a, c - a, d - a
        return along, left, right, np.cross(along, left), np.cross(right, along)


def build_plate_operators(
    triangles: np.ndarray, vertices: np.ndarray, rigidity: float, poisson_ratio: float, supports: BendingSupports
) -> PlateOperators:
    """Build the plate operators (curvatures and stiffness as functions of fold angles) of triangles, shape (t, 3), from their
    shapes at the vertices [m], shape (n, 3).

    rigidity: bending stiffness D of the plate [J]; poisson_ratio: ν; supports: clamps and planes of symmetry.
    """
    mesh = _Mesh(triangles, vertices, supports)
    pairs, shifts = _find_shifts(mesh)
    curvatures = _build_curvatures(mesh, pairs, shifts)
    plate = rigidity * np.array([[1.0, poisson_ratio, 0.0], [poisson_ratio, 1.0, 0.0], [0.0, 0.0, 2.0 * (1.0 - poisson_ratio)]])
    moduli, traces = _condense_free_edges(mesh, plate)
    t = len(triangles)
    block = sp.bsr_array((moduli * mesh.area[:, None, None], np.arange(t), np.arange(t + 1)), shape=(3 * t, 3 * t))
    stiffness = sp.csr_array(curvatures.T @ (block @ curvatures))
    stiffness.sort_indices()
    trace = sp.csr_array((traces.ravel(), np.arange(3 * t), 3 * np.arange(t + 1)), shape=(t, 3 * t)) @ curvatures
    whole = ~mesh.led & (mesh.hinge >= 0).all(axis=1)
    alone = np.ones(len(vertices), bool)
    alone[triangles[whole]] = False  # nodes without a triangle that has three hinges
    chosen = (whole[:, None] | alone[triangles]) & ~mesh.led[:, None]
    which = np.nonzero(chosen)
    weight = mesh.area[which[0]]
    nodes = triangles[which]
    weight = weight / np.bincount(nodes, weight, len(vertices))[nodes]
    mean = sp.csr_array((weight, (nodes, which[0])), shape=(len(vertices), t))
    unit = mesh.exact_folds(np.arange(mesh.n_hinges), np.arange(mesh.n_hinges))[:, :2].sum(axis=1)
    return PlateOperators(mesh.corners, mesh.mirror, unit, stiffness, sp.csr_array(mean @ trace))


class _Mesh:
    """Triangles with axes in their planes, and their hinges: edges between two triangles, and edges in planes of symmetry."""

    def __init__(self, triangles: np.ndarray, vertices: np.ndarray, supports: BendingSupports) -> None:
        t = len(triangles)
        self.led = supports.led
        x = vertices[triangles]
        chi, psi = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]
        normal = np.cross(chi, psi)
        twice = np.linalg.norm(normal, axis=1)
        self.area, self.normal, self._chi, self._psi = 0.5 * twice, normal / twice[:, None], chi, psi
        first = chi / np.linalg.norm(chi, axis=1)[:, None]
        flat = _corners_in(first, np.cross(self.normal, first), chi, psi)
        self.edges = np.roll(flat, -1, axis=1) - flat
        self.length = np.linalg.norm(self.edges, axis=2)
        chosen, partner = pair_edges(triangles)
        left, right = np.stack([chosen % t, chosen // t]), np.stack([partner % t, partner // t])  # triangle, and which edge
        live = ~(self.led[left[0]] & self.led[right[0]])
        left, right = left[:, live], right[:, live]
        rim = np.ones((t, 3), bool)
        rim[chosen % t, chosen // t] = rim[partner % t, partner // t] = False
        number, edge = np.nonzero(rim & ~self.led[:, None])
        a, b = triangles[number, edge], triangles[number, (edge + 1) % 3]
        # a triangle that lies in a plane, rather than leaves it, has no image there
        way = np.cross(vertices[b] - vertices[a], self.normal[number])
        leaves = np.abs(way) / np.linalg.norm(way, axis=1)[:, None]
        leaves[~(supports.on_plane[a] & supports.on_plane[b])] = 0.0
        axis = np.argmax(leaves, axis=1)
        mirrored = leaves.max(axis=1, initial=0.0) > LEAVES
        number, edge, axis = number[mirrored], edge[mirrored], axis[mirrored]
        n_inner = left.shape[1]
        self.n_hinges = n_inner + len(number)
        self.left = np.concatenate([left, np.stack([number, edge])], axis=1)
        self.right = np.concatenate([right, np.stack([number, edge])], axis=1)
        self.mirror = np.concatenate([np.full(n_inner, -1), axis]).astype(np.int64)
        self.hinge = np.full((t, 3), -1)
        self.hinge[tuple(self.left)] = self.hinge[tuple(self.right)] = np.arange(self.n_hinges)
        self.beside = np.full((t, 3), -1)  # the triangle across each edge
        self.beside[tuple(left)], self.beside[tuple(right)] = right[0], left[0]
        (first_one, k), (other, m) = self.left, self.right
        ends = triangles[first_one, k], triangles[first_one, (k + 1) % 3]
        self.corners = np.column_stack([*ends, triangles[first_one, (k + 2) % 3], triangles[other, (m + 2) % 3]]).astype(
            np.int64
        )
        self._along = vertices[self.corners[:, 1]] - vertices[self.corners[:, 0]]
        self._along /= np.linalg.norm(self._along, axis=1)[:, None]
        middle = self.normal[first_one] + self.normal[other]
        rows = np.flatnonzero(self.mirror >= 0)
        middle[rows, self.mirror[rows]] = 0.0  # of a triangle and its image
        size = np.linalg.norm(middle, axis=1)
        self._middle = np.where((size > BACK)[:, None], middle / np.maximum(size, TINY)[:, None], self.normal[first_one])
        one_led, other_led = self.led[first_one], self.led[other]
        self.counts = np.stack([~one_led, ~other_led & (self.mirror < 0)])  # whether each triangle at a hinge bends
        self.counts = self.counts.astype(float)
        self.counts[0, rows] = 2.0  # the image bends as the triangle does
        self.is_shared = (self.mirror < 0) & ~one_led & ~other_led

    def exact_folds(self, frames: np.ndarray, hinges: np.ndarray) -> np.ndarray:
        """Return the fold angles at k hinges of triangles whose corners lie on the surfaces z = ½x², z = ½y² and z = xy,
        shape (k, 3). As these z have the unit m², the angles have the unit m.

        frames: numbers of the hinges that define the axes, shape (k,): x along the edge of the hinge and y across it;
        hinges: numbers of the k hinges at which the angles are computed.
        """
        one, other = (self.shares(frames, *side[:, hinges]) for side in (self.left, self.right))
        return self.counts[0, hinges, None] * one + self.counts[1, hinges, None] * other

    def shares(self, frames: np.ndarray, number: np.ndarray, edge: np.ndarray) -> np.ndarray:
        """Return the angles between triangles whose corners lie on the surfaces z = ½x², z = ½y² and z = xy, and these surfaces
        at the midpoint of an edge [m], shape (k, 3): from the slope of the triangle to the slope of the surface.

        frames: hinges that define the axes x (along) and y (across), shape (k,); number, edge: triangles and their edges (0 to
        2), shape (k,). Triangles are first rotated into the planes of the hinges.
        """
        up, along = self._middle[frames], self._along[frames]
        normal = self.normal[number]
        cosine = np.maximum(1.0 + np.sum(up * normal, axis=1), BACK)[:, None]

        def turned(way: np.ndarray) -> np.ndarray:
            return np.asarray(way - np.sum(up * way, axis=1)[:, None] / cosine * (up + normal))

        flat = _corners_in(along, np.cross(up, along), turned(self._chi[number]), turned(self._psi[number]))
        edges = np.roll(flat, -1, axis=1) - flat
        twice = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
        across = np.roll(edges, -1, axis=1)  # from each corner the opposite edge
        slopes = np.stack([-across[:, :, 1], across[:, :, 0]], axis=2) / twice[:, None, None]
        x, y = flat[:, :, 0], flat[:, :, 1]
        by_corners = np.einsum("kjq,kji->kqi", np.stack([0.5 * x * x, 0.5 * y * y, x * y], axis=2), slopes)
        rows = np.arange(len(flat))
        along_edge = edges[rows, edge]
        out = np.stack([along_edge[:, 1], -along_edge[:, 0]], axis=1) / np.linalg.norm(along_edge, axis=1)[:, None]
        middle = flat[rows, edge] + 0.5 * along_edge
        zero = np.zeros(len(flat))
        exact = np.stack([middle[:, 0], zero, zero, middle[:, 1], middle[:, 1], middle[:, 0]], axis=1).reshape(-1, 3, 2)
        return np.asarray(np.einsum("kqi,ki->kq", exact - by_corners, out))


def _corners_in(first: np.ndarray, second: np.ndarray, chi: np.ndarray, psi: np.ndarray) -> np.ndarray:
    """Return the corners of triangles along two in-plane axes, relative to the first corner [m], shape (k, 3, 2).

    first, second: the axes, shape (k, 3); chi, psi: edge vectors from the first corner [m], shape (k, 3).
    """
    zero = np.zeros(len(chi))
    columns = [zero, zero, *(np.sum(way * axis, axis=1) for way in (chi, psi) for axis in (first, second))]
    return np.stack(columns, axis=1).reshape(-1, 3, 2)


def _find_shifts(mesh: _Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients c of corrections that give every quadratic surface its exact curvature: at a hinge between
    two triangles, the angle of each triangle to the smooth surface is half the fold angle of the hinge, plus (left
    triangle) or minus (right triangle) Σ c φ over nearby hinges with fold angles φ.

    Returns the pairs (hinge, nearby hinge), shape (2, k), and the coefficient c of each pair, shape (k,).
    """
    shared = np.flatnonzero(mesh.is_shared)
    both = np.stack([mesh.left[0, shared], mesh.right[0, shared]], axis=1)
    uneven = 0.5 * (mesh.shares(shared, *mesh.left[:, shared]) - mesh.shares(shared, *mesh.right[:, shared]))
    length = mesh.length[tuple(mesh.left[:, shared])]
    skew = np.abs(uneven).max(axis=1, initial=0.0) > 1e-9 * length
    shared, both, uneven, length = shared[skew], both[skew], uneven[skew], length[skew]
    around = np.concatenate([both, mesh.beside[both].reshape(-1, 6)], axis=1)
    hinges = np.where((around >= 0)[:, :, None], mesh.hinge[around], -1).reshape(len(shared), 24)
    rows = np.repeat(np.arange(len(shared)), hinges.shape[1])[hinges.ravel() >= 0]
    code = np.unique(rows * mesh.n_hinges + hinges.ravel()[hinges.ravel() >= 0])
    rows, others = code // mesh.n_hinges, code % mesh.n_hinges
    folds = mesh.exact_folds(shared[rows], others) / length[rows, None]
    squares = np.zeros((len(shared), 3, 3))
    np.add.at(squares, rows, folds[:, :, None] * folds[:, None, :])
    values, vectors = np.linalg.eigh(squares)
    inverse = np.where(values > RANK * values[:, -1:], 1.0 / np.maximum(values, TINY), 0.0)
    wanted = np.einsum("kij,kj,klj,kl->ki", vectors, inverse, vectors, uneven / length[:, None])
    return np.stack([shared[rows], others]), np.sum(folds * wanted[rows], axis=1)


def _build_curvatures(mesh: _Mesh, pairs: np.ndarray, shifts: np.ndarray) -> sp.csr_array:
    """Return the matrix that maps the fold angles at hinges to the curvatures xx, yy, xy of the triangles [1/m], shape (3 t,
    h). pairs, shifts: results of `_find_shifts`.
    """
    out = np.stack([mesh.edges[:, :, 1], -mesh.edges[:, :, 0]], axis=2) / mesh.length[:, :, None]
    tensors = np.stack([out[:, :, 0] ** 2, out[:, :, 1] ** 2, out[:, :, 0] * out[:, :, 1]], axis=2)
    tensors *= (mesh.length / mesh.area[:, None])[:, :, None]
    tensors[mesh.led] = 0.0
    half = np.where(mesh.is_shared | (mesh.mirror >= 0), 0.5, 1.0)
    every, single = np.arange(mesh.n_hinges), np.flatnonzero(mesh.mirror < 0)
    parts = [
        (mesh.left, every, half),
        (mesh.right[:, single], single, half[single]),
        (mesh.left[:, pairs[0]], pairs[1], shifts),
        (mesh.right[:, pairs[0]], pairs[1], -shifts),
    ]
    entries = [
        (3 * number + i, hinge, factor * tensors[number, edge, i]) for (number, edge), hinge, factor in parts for i in range(3)
    ]
    rows, columns, values = (np.concatenate(each) for each in zip(*entries, strict=True))
    return sp.csr_array((values, (rows, columns)), shape=(3 * len(mesh.area), mesh.n_hinges))


def _condense_free_edges(mesh: _Mesh, plate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bending moduli of the triangles [J], shape (t, 3, 3), and the coefficients of the trace of their curvatures,
    shape (t, 3), both condensed so that no moment acts on free edges. plate: bending moduli without free edges [J], shape (3,
    3).
    """
    t = len(mesh.area)
    moduli, traces = np.tile(plate, (t, 1, 1)), np.tile((1.0, 1.0, 0.0), (t, 1))
    for k in range(3):
        rows = np.flatnonzero((mesh.hinge[:, k] < 0) & ~mesh.led)
        x, y = (mesh.edges[rows, k] / mesh.length[rows, k, None]).T
        free = np.stack([y * y, x * x, -x * y], axis=1)
        moment = np.einsum("kij,kj->ki", moduli[rows], free)
        stiff = np.sum(moment * free, axis=1)
        rows, free, moment, stiff = (each[stiff > TINY * plate[0, 0]] for each in (rows, free, moment, stiff))
        traces[rows] -= (np.sum(traces[rows] * free, axis=1) / stiff)[:, None] * moment
        moduli[rows] -= moment[:, :, None] * moment[:, None, :] / stiff[:, None, None]
    moduli[mesh.led] = 0.0
    return moduli, traces
