"""Rendering with a depth buffer, one light, darkened creases, and outlines where the depth jumps."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter

from pellucid.results.pictures.rendering.camera import Camera, Plane
from pellucid.results.pictures.rendering.drawables import Balls, Drawable, Mesh
from pellucid.results.pictures.rendering.raster import Canvas

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
