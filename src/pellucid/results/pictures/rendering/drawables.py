"""Drawable objects of a picture in space: surfaces, balls and flat sections, and the pixels that they cover."""

from typing import NamedTuple

import numpy as np

from pellucid.results.pictures.rendering.camera import Camera, Plane
from pellucid.results.pictures.rendering.raster import Fragments, ball_fragments, triangle_fragments

LEAST_RADIUS = 0.75  # pixels: smaller balls would fall between the pixels

Colour = tuple[float, float, float]


class Look(NamedTuple):
    """Appearance of k pixels, which the renderer shades: surface normals in the axes of the camera and RGB colours, shape
    (k, 3) each."""

    normals: np.ndarray
    colours: np.ndarray


class Mesh(NamedTuple):
    """A surface to draw: vertices [m], shape (n, 3), triangles as vertex numbers, shape (m, 3), RGB colours of the
    vertices, shape (n, 3).

    `marked`, shape (n,): flags of vertices, 0 or 1. A pixel has the colour `mark` where the interpolated flag exceeds one
    half. If `lit` is False, colours are not shaded. If `cuttable` is False, the cut plane does not cut this surface; flat
    sections in the cut plane are drawn with this setting.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    colours: np.ndarray
    marked: np.ndarray
    mark: Colour = (0.0, 0.0, 0.0)
    lit: bool = True
    cuttable: bool = True

    @property
    def primitives(self) -> int:
        """Number of primitives (parts with a number of their own in the picture): the triangles."""
        return len(self.triangles)

    def fragments(self, camera: Camera, cut: Plane | None) -> Fragments:
        """Yield the fragments (pixels covered by the triangles, with their depth), without the material in front of the cut
        plane."""
        place = camera.project(self.vertices)
        if cut is None or not self.cuttable:
            yield from triangle_fragments(place[self.triangles], camera.shape)
            return
        left = np.flatnonzero((cut.beyond(self.vertices) <= 0.0)[self.triangles].any(axis=1))
        for x, y, depth, which in triangle_fragments(place[self.triangles[left]], camera.shape):
            kept = camera.keeps(cut, x, y, depth)
            yield x[kept], y[kept], depth[kept], left[which[kept]]

    def look(self, camera: Camera, x: np.ndarray, y: np.ndarray, triangle: np.ndarray) -> Look:
        """Return the interpolated normals and colours of pixels. x, y: pixel coordinates, shape (k,); triangle: number of the
        triangle visible in each pixel, shape (k,)."""
        place, corners = camera.project(self.vertices), self.triangles[triangle]
        (ax, ay, _), (bx, by, _), (cx, cy, _) = (place[self.triangles[:, k]].T for k in range(3))
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        area[area == 0.0] = np.inf  # edge on: no pixel shows it
        ux, uy, vx, vy = ((side / area)[triangle] for side in (bx - ax, by - ay, cx - ax, cy - ay))
        dx, dy = x - ax[triangle], y - ay[triangle]
        s, t = dx * vy - dy * vx, ux * dy - uy * dx
        values = np.column_stack([vertex_normals(place, self.triangles), self.colours, self.marked]).astype(np.float32)
        shown = np.zeros((len(triangle), values.shape[1]), np.float32)
        for share, corner in zip((1.0 - s - t, s, t), corners.T, strict=True):
            shown += share.astype(np.float32)[:, None] * values[corner]
        normals, colours = shown[:, :3], shown[:, 3:6]
        colours[shown[:, 6] > 0.5] = self.mark
        return Look(normals, colours)


class Balls(NamedTuple):
    """Balls: centres [m], shape (n, 3), radii [m], shape (n,), RGB colours, shape (n, 3).

    If `skin` is True, all balls are shaded as one smooth body. If `lit` is False, colours are not shaded. The cut plane cuts a
    flat face into the balls if `skin` is True or `lit` is False; otherwise balls are drawn whole or not at all.
    """

    centres: np.ndarray
    radii: np.ndarray
    colours: np.ndarray
    lit: bool = True
    skin: bool = False

    @property
    def primitives(self) -> int:
        """Number of primitives (parts with a number of their own in the picture): the balls."""
        return len(self.centres)

    def fragments(self, camera: Camera, cut: Plane | None) -> Fragments:
        """Yield the fragments (pixels covered by the balls, with their depth); balls whose centre lies in front of the cut
        plane are omitted."""
        kept = np.flatnonzero(cut.beyond(self.centres) <= 0.0) if cut else np.arange(self.primitives)
        face = cut if self.skin or not self.lit else None
        for x, y, depth, which in ball_fragments(self._projected(camera), kept, camera.shape):
            yield x, y, np.minimum(depth, camera.depth_of(face, x, y)) if face else depth, which

    def look(self, camera: Camera, x: np.ndarray, y: np.ndarray, ball: np.ndarray) -> Look:
        """Return the normals and colours of pixels. x, y: pixel coordinates, shape (k,); ball: number of the ball visible in
        each pixel, shape (k,)."""
        cx, cy, _, radius = self._projected(camera)[ball].T
        nx, ny = (x - cx) / radius, (y - cy) / radius
        nz = np.sqrt(np.maximum(0.0, 1.0 - nx**2 - ny**2))
        return Look(np.stack([nx, ny, nz], axis=1), self.colours[ball])

    def _projected(self, camera: Camera) -> np.ndarray:
        radius = np.maximum(self.radii * camera.scale, LEAST_RADIUS)
        return np.column_stack([camera.project(self.centres), radius])


class Section(NamedTuple):
    """A plane in space to draw, coloured for example by a field on the cut plane. `colours`: RGB of each pixel of the
    picture, shape (rows, columns, 3), NaN where the plane is transparent."""

    plane: Plane
    colours: np.ndarray
    lit: bool = False

    @property
    def primitives(self) -> int:
        """Number of primitives (parts with a number of their own in the picture): the pixels."""
        return self.colours.shape[0] * self.colours.shape[1]

    def fragments(self, camera: Camera, cut: Plane | None) -> Fragments:
        """Yield the fragments: the pixels that have a colour, each with the depth at which its line of sight meets the
        plane of the section. The cut plane does not cut the section itself."""
        y, x = np.nonzero(np.isfinite(self.colours[:, :, 0]))
        yield x, y, camera.depth_of(self.plane, x, y), y * self.colours.shape[1] + x

    def look(self, camera: Camera, x: np.ndarray, y: np.ndarray, pixel: np.ndarray) -> Look:
        """Return the stored colours, with normals towards the eye. x, y: pixel coordinates, shape (k,); pixel: number of each
        pixel in the picture."""
        colours = self.colours.reshape(-1, 3)[pixel]
        return Look(np.tile([0.0, 0.0, 1.0], (len(colours), 1)), colours)


Drawable = Mesh | Balls | Section


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return unit normals of the vertices, shape (n, 3): area-weighted means of the normals of the adjacent triangles."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    corners = triangles.ravel()
    total = np.stack([np.bincount(corners, np.repeat(n, 3), len(vertices)) for n in normal.T], axis=1)
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), np.finfo(float).tiny))
