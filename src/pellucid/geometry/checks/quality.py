"""Element quality: dihedral angles of tetrahedra, and one quality number for each element."""

import numpy as np

_EDGES = ((0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 2, 0), (2, 3, 0, 1))  # an edge, the opposite corners


def dihedral_angles(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return the angles between the faces of tetrahedra at their six edges [degrees], shape (c, 6); 70.53 if regular.
    nodes: positions, shape (n, 3); cells: node numbers, shape (c, 4)."""
    x = nodes[cells]
    angles = []
    for a, b, c, d in _EDGES:
        along = x[:, b] - x[:, a]
        one, other = np.cross(along, x[:, c] - x[:, a]), np.cross(along, x[:, d] - x[:, a])
        across = np.linalg.norm(np.cross(one, other), axis=1)
        angles.append(np.degrees(np.arctan2(across, np.einsum("ij,ij->i", one, other))))
    return np.stack(angles, axis=1)


def triangle_qualities(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return for each triangle its area divided by its mean squared side length, scaled to 1 if equilateral (0 if flat),
    shape (m,)."""
    x = vertices[triangles]
    area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    return np.asarray(4.0 / np.sqrt(3.0) * area / _mean_square(x, ((0, 1), (1, 2), (2, 0))))


def quad_qualities(vertices: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return for each quadrilateral twice the smallest triangle area at a corner, divided by the mean squared side length: 1
    for squares, shape (m,)."""
    x = vertices[quads]
    sides = np.roll(x, -1, axis=1) - x
    corners = np.linalg.norm(np.cross(np.roll(sides, 1, axis=1), sides), axis=2).min(axis=1, initial=np.inf)
    return np.asarray(corners / _mean_square(x, ((0, 1), (1, 2), (2, 3), (3, 0))))


def tetrahedron_qualities(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return for each tetrahedron its volume to the power 2/3 divided by its mean squared edge length, scaled to 1 for
    regular and 0 for flat tetrahedra, shape (c,). nodes: positions, shape (n, 3); cells: node numbers, shape (c, 4)."""
    x = nodes[cells]
    volume = np.abs(np.einsum("ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0])) / 6.0
    edges = tuple((a, b) for a, b, _, _ in _EDGES)
    return np.asarray((6.0 * np.sqrt(2.0) * volume) ** (2.0 / 3.0) / _mean_square(x, edges))


def _mean_square(places: np.ndarray, sides: tuple[tuple[int, int], ...]) -> np.ndarray:
    """Return the mean squared side length of each element, shape (m,), at least the smallest positive number, so that it
    can be a divisor. places: corner positions, shape (m, corners, 3); sides: pairs of corner indices."""
    squares = [np.square(places[:, a] - places[:, b]).sum(axis=1) for a, b in sides]
    return np.maximum(np.mean(squares, axis=0), np.finfo(float).tiny)
