"""Rendering with a depth buffer, one light, darkened creases, and outlines where the depth jumps; sections of closed membranes
and solids by a plane."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import cKDTree

from pellucid.results.pictures.camera import Camera, Plane
from pellucid.results.pictures.drawables import Balls, Canvas, Colour, Drawable, Mesh, vertex_normals

LIGHT = np.array([0.25, 0.50, 0.83]) / np.linalg.norm([0.25, 0.50, 0.83])
"""Direction towards the light in the axes of the camera: from the upper right, behind the viewer."""

AMBIENT, DIFFUSE = 0.52, 0.52  # shares of the colour
GLOSS, SHARPNESS = 0.10, 18.0
CREASE = 0.5  # how much a place darkens that lies far behind its surroundings
CREASE_WIDTH = 0.02  # of the picture's width
COARSE = 4.0  # steps in a width, at least
OUTLINE = 0.5  # what an outline leaves of the colour
SKIN = 0.004  # of the picture's width: roughness below it is smoothed where balls are to look like one body
JUMP = 0.012  # of the picture's width in depth between neighbours makes an outline


def render(drawables: Sequence[Drawable], camera: Camera, cut: Plane | None = None) -> np.ndarray:
    """Render objects as seen by a camera, without the material in front of the plane `cut`; return RGBA, shape (rows, columns,
    4), lowest row first.

    Colours are from 0 to 1; pixels without an object are transparent.
    """
    canvas = _painted(drawables, camera, cut)
    rows, columns = camera.shape
    depth, covered = canvas.depth(), canvas.covered()
    light = (_creases(depth, covered) * np.where(_outlines(depth, covered), OUTLINE, 1.0)).ravel()
    rgba = np.ones((rows * columns, 4), np.float32)
    rgba[:, 3] = covered.ravel()
    for part, drawable in enumerate(drawables):
        index, primitive = canvas.seen(part)
        normal, colour = drawable.look(camera, index % columns, index // columns, primitive)
        if isinstance(drawable, Balls) and drawable.skin:
            normal = _skin(canvas, index)
        rgba[index, :3] = np.clip(_shaded(colour, normal) * light[index, None], 0.0, 1.0) if drawable.lit else colour
    return rgba.reshape(rows, columns, 4)


def inside(mesh: Mesh, camera: Camera, cut: Plane) -> np.ndarray:
    """Return a mask of the pixels at which the plane `cut` lies inside a closed mesh with outward normals, shape (rows,
    columns).

    The eye must be in front of the plane, on the side of its normal. A pixel is inside if the first triangle behind the plane
    on its line of sight shows its back.
    """
    canvas = _painted([mesh], camera, cut)
    index, triangle = canvas.seen(0)
    a, b, c = (camera.project(mesh.vertices)[mesh.triangles[:, k], :2].T for k in range(3))
    back = (b - a)[0] * (c - a)[1] < (b - a)[1] * (c - a)[0]
    found = np.zeros(canvas.shape, bool)
    found.ravel()[index[back[triangle]]] = True
    return found


def _painted(drawables: Sequence[Drawable], camera: Camera, cut: Plane | None) -> Canvas:
    canvas = Canvas(camera.shape)
    for drawable in drawables:
        canvas.begin_part(drawable.primitives)
        for x, y, depth, primitive in drawable.fragments(camera, cut):
            canvas.add(x, y, depth, primitive)
    return canvas


def _shaded(colour: np.ndarray, normal: np.ndarray) -> np.ndarray:
    facing = np.where(normal[:, 2:] < 0.0, -normal, normal)  # both sides of a surface can be seen
    facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-12)
    half = LIGHT + np.array([0.0, 0.0, 1.0])
    diffuse, gloss = np.maximum(0.0, facing @ LIGHT), np.maximum(0.0, facing @ (half / np.linalg.norm(half)))
    return np.asarray(colour * (AMBIENT + DIFFUSE * diffuse)[:, None] + GLOSS * (gloss**SHARPNESS)[:, None])


def _skin(canvas: Canvas, index: np.ndarray) -> np.ndarray:
    """Return normals of the visible surface, smoothed over several pixels, shape (k, 3), in the axes of the camera; not
    normalized. index: numbers of the k pixels, row by row."""
    if not len(index):
        return np.zeros((0, 3))
    columns = canvas.shape[1]
    y, x = index // columns, index % columns
    window = slice(max(0, y.min() - 1), y.max() + 2), slice(max(0, x.min() - 1), x.max() + 2)
    mask = np.zeros(canvas.shape, np.float32)
    mask.ravel()[index] = 1.0
    width = SKIN * columns
    share = np.maximum(gaussian_filter(mask[window], width), 1e-6)
    depth = gaussian_filter(np.where(mask[window] > 0.0, canvas.depth()[window], 0.0), width) / share
    within = y - window[0].start, x - window[1].start
    slope_y, slope_x = (np.gradient(depth, axis=axis)[within] for axis in (0, 1))
    return np.stack([-slope_x, -slope_y, np.ones(len(index))], axis=1)


def _creases(depth: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Return a factor for the brightness of each pixel, shape (rows, columns), below 1 where the surroundings are nearer to the
    eye.

    Unsharp masking of the depth: Luft, Colditz & Deussen 2006, ACM Transactions on Graphics 25, 1206. depth: depth towards the
    eye [pixels]; covered: mask of the pixels that show an object, both of shape (rows, columns).
    """
    width = CREASE_WIDTH * depth.shape[1]
    step = max(1, int(width / COARSE))  # what a wide bell has smoothed is found on every so many pixels, linear between them
    filled = np.where(covered, depth, 0.0)[::step, ::step].astype(np.float32)
    share, around = (
        gaussian_filter(coarse, width / step, truncate=2.5) for coarse in (covered[::step, ::step].astype(np.float32), filled)
    )
    around /= np.maximum(share, 1e-6)
    if step > 1:
        around = _between(_between(around.T, step, depth.shape[1]).T, step, depth.shape[0])
    return np.asarray(1.0 - CREASE * np.clip((around - depth) / (4.0 * width), 0.0, 1.0))


def _between(rows: np.ndarray, step: int, size: int) -> np.ndarray:
    """Refine an array by linear interpolation between its rows, which become every `step`-th row of the result. The result
    has `size` rows; the last row is repeated beyond the end."""
    place = np.minimum(np.arange(size) / step, len(rows) - 1.0)
    before = place.astype(int)
    share = (place - before).astype(rows.dtype)[:, None]
    return np.asarray(rows[before] + share * (rows[np.minimum(before + 1, len(rows) - 1)] - rows[before]))


def _outlines(depth: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Return a mask of the pixels to be drawn as outlines, shape (rows, columns): pixels on the near side of a depth jump, or
    next to pixels without an object.

    depth: depth towards the eye [pixels]; covered: mask of the pixels that show an object, both of shape (rows, columns).
    """
    filled = np.where(covered, depth, -1e9)
    least = JUMP * depth.shape[1]
    edge = np.zeros(depth.shape, bool)
    edge[1:] |= filled[1:] - filled[:-1] > least
    edge[:-1] |= filled[:-1] - filled[1:] > least
    edge[:, 1:] |= filled[:, 1:] - filled[:, :-1] > least
    edge[:, :-1] |= filled[:, :-1] - filled[:, 1:] > least
    return edge & covered


NEIGHBOURS = 14  # points that give a pixel of a section its value
HAIR = 2e-3  # of the thickness of a membrane
STRIDE = 4  # pixels between those that are looked up
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
    rows, columns = (np.arange(z.min(), z.max() + 2 * STRIDE, STRIDE, dtype=float) for z in (y, x))
    v, u = np.meshgrid(rows, columns, indexing="ij")
    about = np.zeros(u.shape, bool)  # those next to a pixel of the section
    row, column = (y - y.min()) // STRIDE, (x - x.min()) // STRIDE
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
    found[y, x] = map_coordinates(coarse, [(y - rows[0]) / STRIDE, (x - columns[0]) / STRIDE], order=1)
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
