"""Contact surfaces of triangles whose vertices the tests move directly, and geometric checks of such surfaces."""

import numpy as np

from pellucid.contact.contact_surface import ContactSurface, MovingTriangles


class FreeTriangles(ContactSurface):
    """Contact surface of triangles without a body; force: sum of the forces that contact adds to the vertices [N], shape
    (n, 3)."""

    mass_per_area, rate = 1.0, 1000.0

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, thickness: float = 0.0) -> None:
        self.vertices, self.speeds = np.array(vertices, float), np.zeros((len(vertices), 3))
        self.two_sided, self.half_width = thickness > 0.0, 0.5 * thickness
        self.force = np.zeros_like(self.vertices)
        self.triangles = MovingTriangles(triangles, lambda: self.vertices, lambda: self.speeds, self._take)

    def _take(self, force: np.ndarray) -> None:
        self.force += force

    def add_forces(self, force: np.ndarray) -> None:
        raise NotImplementedError


def square(n: int, size: float = 1.0, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices [m] and triangles of n × n squares of two triangles each, with alternating diagonals."""
    along = np.linspace(0.0, size, n + 1)
    x, y = np.meshgrid(along, along, indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    triangles = []
    for i in range(n):
        for j in range(n):
            a, b, c, d = i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1
            triangles += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
    return vertices, np.array(triangles)


def step(pair: object, dt: float = 1e-5) -> bool:
    """Find the overlap of a pair of surfaces and add its forces for a step dt [s]; return True if there is an overlap."""
    for surface in pair.surfaces:
        surface.force[:] = 0.0
    pair.step = dt
    pair.follow(dt)
    touches = pair.find({})
    if touches:
        pair.push(dt, dt, {}, {})
    else:
        pair.law.separate(dt)
    return touches


def write_obj(path: object, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Write a surface of triangles to a Wavefront file."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f {} {} {}".format(*corners) for corners in (triangles + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")


def strip(parts: tuple[int, int], length: float, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the coordinates of the vertices along and across a strip of squares [m], and its triangles."""
    vertices, triangles = square(max(parts))
    n, (along, across) = max(parts) + 1, parts
    inside = (vertices[:, 0] * (n - 1) <= along + 1e-9) & (vertices[:, 1] * (n - 1) <= across + 1e-9)
    number = np.cumsum(inside) - 1
    kept = inside[triangles].all(axis=1)
    s, y = vertices[inside, 0] * (n - 1) / along * length, vertices[inside, 1] * (n - 1) / across * width
    return s, y, number[triangles[kept]]


def folded_in_three(parts: tuple[int, int], length: float, width: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices [m] and triangles of a strip folded into a Z: three layers on each other, joined by half circles."""
    s, y, triangles = strip(parts, length, width)
    bend = np.pi * radius
    arm = (length - 2.0 * bend) / 3.0
    fine = np.linspace(0.0, length, 4001)
    knots = [0.0, arm, arm + bend, 2.0 * arm + bend, 2.0 * (arm + bend), length]
    angle = np.interp(fine, knots, [0.0, 0.0, np.pi, np.pi, 0.0, 0.0])
    half = 0.5 * length / 4000
    x, z = (np.concatenate([[0.0], np.cumsum(half * (f(angle)[1:] + f(angle)[:-1]))]) for f in (np.cos, np.sin))
    return np.column_stack([np.interp(s, fine, x), y, np.interp(s, fine, z)]), triangles


def crossings(vertices: np.ndarray, triangles: np.ndarray) -> int:
    """Return the number of pairs of an edge and a triangle without a common vertex that intersect, from a check of all
    pairs."""
    edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    p, q, corners = vertices[edges[:, 0]], vertices[edges[:, 1]], vertices[triangles]
    low, high = np.minimum(p, q), np.maximum(p, q)
    near = np.ones((len(edges), len(triangles)), bool)
    for d in range(3):
        near &= (low[:, None, d] <= corners[None, :, :, d].max(axis=2)) & (
            high[:, None, d] >= corners[None, :, :, d].min(axis=2)
        )
    e, t = np.nonzero(near)
    apart = (edges[e][:, :, None] != triangles[t][:, None, :]).all(axis=(1, 2))
    e, t = e[apart], t[apart]

    def volume(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
        return np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a)

    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
    through = volume(a, b, c, p[e]) * volume(a, b, c, q[e]) < 0.0
    sides = [volume(p[e], q[e], i, j) for i, j in ((a, b), (b, c), (c, a))]
    inside = (sides[0] * sides[1] > 0.0) & (sides[1] * sides[2] > 0.0)
    return int((through & inside).sum())


def layers_apart(vertices: np.ndarray, triangles: np.ndarray, along: np.ndarray, least: float) -> float:
    """Return the smallest distance of a vertex from triangles of other layers of a strip [m]. Triangles more than `least`
    away along the strip are other layers; along: coordinate of each vertex along the strip [m]."""
    found = np.inf
    corners = vertices[triangles]
    for i, x in enumerate(vertices):
        far = np.abs(along[triangles] - along[i]).min(axis=1) > least
        if far.any():
            found = min(found, float(_distance(x, corners[far]).min()))
    return found


def _distance(x: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the distances of a point from triangles: from their planes, or from their edges if its projection lies outside."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    n = np.cross(u, v)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    height = np.einsum("ni,ni->n", x - a, n)
    foot = x - height[:, None] * n
    inside, least = np.ones(len(corners), bool), np.full(len(corners), np.inf)
    for k in range(3):
        p, q = corners[:, k], corners[:, (k + 1) % 3]
        inside &= np.einsum("ni,ni->n", np.cross(q - p, foot - p), n) >= 0.0
        share = np.clip(np.einsum("ni,ni->n", x - p, q - p) / np.einsum("ni,ni->n", q - p, q - p), 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(x - p - share[:, None] * (q - p), axis=1))
    return np.where(inside, np.abs(height), least)
