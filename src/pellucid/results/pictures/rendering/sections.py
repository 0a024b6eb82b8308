"""Sections of closed membranes and solids by a plane: field inside, rim of the membrane, cut face of the solid."""

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from pellucid.results.pictures.rendering.camera import Camera, Plane
from pellucid.results.pictures.rendering.drawables import Colour, Mesh, vertex_normals
from pellucid.results.pictures.rendering.render import inside

NEIGHBOURS = 14  # points that give a pixel of a section its value
HAIR = 2e-3  # of the thickness of a membrane
COARSE = 4  # pixels between those that are looked up
_CROSSED = {
    1: [[0, 1], [0, 2], [0, 3]],
    2: [[0, 2], [0, 3], [1, 3], [0, 2], [1, 3], [1, 2]],
    3: [[0, 3], [1, 3], [2, 3]],
}
"""Edges of a tetrahedron that cross the plane, by the number of corners above it, three for each triangle of the face; with
two corners above, the face has four corners and two triangles."""


def section(mesh: Mesh, camera: Camera, plane: Plane, position: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the values of a field on a cut plane inside a closed mesh, one per pixel, shape (rows, columns); NaN outside the
    mesh.

    position, values: points [m], shape (n, 3), and the field there, shape (n,). Values on a coarse lattice of pixels are means
    of the nearest points, weighted by a Gaussian of the width of the point spacing. Between lattice pixels the interpolation is
    linear.
    """
    within = inside(mesh, camera, plane)
    found = np.full(within.shape, np.nan)
    y, x = np.nonzero(within)
    if not len(x) or not len(position):
        return found
    rows, columns = (np.arange(z.min(), z.max() + 2 * COARSE, COARSE, dtype=float) for z in (y, x))
    v, u = np.meshgrid(rows, columns, indexing="ij")
    about = np.zeros(u.shape, bool)  # those next to a pixel of the section
    row, column = (y - y.min()) // COARSE, (x - x.min()) // COARSE
    for i in (0, 1):
        for j in (0, 1):
            about[row + i, column + j] = True
    u, v = u[about], v[about]
    nearest = np.arange(1, min(NEIGHBOURS, len(position)) + 1)
    distance, which = cKDTree(position).query(camera.position(u, v, camera.depth_of(plane, u, v)), k=nearest)
    apart = np.mean(np.asarray(distance)[..., min(6, len(nearest) - 1)])
    weight = np.exp(-np.square(distance / apart)) + np.finfo(float).tiny
    coarse = np.zeros(about.shape)
    coarse[about] = (weight * values[which]).sum(axis=-1) / weight.sum(axis=-1)
    found[y, x] = map_coordinates(coarse, [(y - rows[0]) / COARSE, (x - columns[0]) / COARSE], order=1)
    return found


def cut_face(vertices: np.ndarray, tetrahedra: np.ndarray, colours: np.ndarray, plane: Plane) -> Mesh:
    """Return the flat section of a solid with a plane, as triangles. vertices: [m], shape (n, 3). tetrahedra: vertex numbers,
    shape (m, 4). colours: RGB of the vertices, shape (n, 3), interpolated linearly within each tetrahedron."""
    beyond = plane.beyond(vertices)
    above = beyond[tetrahedra] > 0.0
    number = above.sum(axis=1)
    corners = np.take_along_axis(tetrahedra, np.argsort(~above, axis=1, kind="stable"), axis=1)  # those above come first
    edges = np.concatenate([corners[number == n][:, pairs].reshape(-1, 2) for n, pairs in _CROSSED.items()])
    a, b = edges.T
    share = (beyond[a] / (beyond[a] - beyond[b]))[:, None]
    place, colour = ((1.0 - share) * values[a] + share * values[b] for values in (vertices, colours))
    triangles = np.arange(len(edges)).reshape(-1, 3)
    return Mesh(place, triangles, colour, np.zeros(len(edges), bool), lit=False, cuttable=False)


def rim(mesh: Mesh, plane: Plane, thickness: float, colour: Colour | None = None) -> Mesh:
    """Return the section of a membrane of a given thickness [m] with a plane, as a flat ribbon of this width.

    The ribbon has the given colour, by default the colours of the mesh, and the flags `marked` of the mesh. The ribbon lies
    slightly in front of the plane so that it covers other sections.
    """
    beyond = plane.beyond(mesh.vertices)
    above = beyond[mesh.triangles] > 0.0
    cut = mesh.triangles[above.any(axis=1) & ~above.all(axis=1)]
    edges = np.stack([cut, np.roll(cut, -1, axis=1)], axis=2)
    a, b = edges[(beyond[edges] > 0.0).sum(axis=2) == 1].T  # of each triangle two edges cross the plane, one after the other
    share = (beyond[a] / (beyond[a] - beyond[b]))[:, None]

    def there(values: np.ndarray) -> np.ndarray:
        return np.asarray((1.0 - share) * values[a] + share * values[b])

    along = np.array(plane.normal) / np.linalg.norm(plane.normal)
    side = there(vertex_normals(mesh.vertices, mesh.triangles))
    side -= (side @ along)[:, None] * along
    side *= 0.5 * thickness / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), np.finfo(float).tiny)
    middle = there(mesh.vertices) + HAIR * thickness * along
    vertices = np.stack([middle + side, middle - side], axis=1).reshape(-1, 3)
    ribbon = (4 * np.arange(len(cut))[:, None, None] + np.array([[0, 1, 2], [1, 3, 2]])).reshape(-1, 3)
    marked = np.repeat(there(mesh.marked[:, None].astype(float)), 2)
    colours = np.tile(colour, (len(vertices), 1)) if colour else np.repeat(there(mesh.colours), 2, axis=0)
    return Mesh(vertices, ribbon, colours, marked, mesh.mark, lit=False, cuttable=False)
