"""Drawable objects of a picture in space: surfaces, balls, bricks and flat sections, and the pixels that they cover
(fragments)."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from pellucid.geometry.meshes.enclosure import spread
from pellucid.results.pictures.camera import Camera, Plane

LEAST_RADIUS = 0.75  # pixels: smaller balls would fall between the pixels

Colour = tuple[float, float, float]


Fragments = Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
"""Batches of fragments (pixels of primitives): x and y [pixels, whole numbers], depth [pixels] and number of the primitive."""


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


SHARP = 40.0  # degrees between the normals of neighbouring triangles


class Faceted(NamedTuple):
    """A surface whose vertices at sharp edges are split, so that normals for shading differ on both sides of an edge:
    triangles as new vertex numbers, shape (m, 3), and the original vertex of each new vertex, shape (k,)."""

    triangles: np.ndarray
    vertex: np.ndarray


def split_at_creases(vertices: np.ndarray, triangles: np.ndarray) -> Faceted:
    """Split the vertices of a surface, shape (n, 3) [m], at every sharp edge, i.e. where the normals of two adjacent triangles
    differ by more than 40 degrees. triangles: vertex numbers, shape (m, 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    corners = np.arange(triangles.size).reshape(-1, 3)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()  # the corners at both ends of each edge
    of = triangles.ravel()
    codes = np.minimum(of[start], of[end]) * len(vertices) + np.maximum(of[start], of[end])
    order = np.argsort(codes, kind="stable")
    same = codes[order][1:] == codes[order][:-1]
    one, other = order[:-1][same], order[1:][same]
    smooth = np.einsum("ij,ij->i", normals[one // 3], normals[other // 3]) > np.cos(np.radians(SHARP))
    one, other = one[smooth], other[smooth]
    alike = of[start[one]] == of[start[other]]
    links = (
        np.concatenate([start[one], end[one]]),
        np.concatenate([np.where(alike, start[other], end[other]), np.where(alike, end[other], start[other])]),
    )
    _, number = connected_components(coo_array((np.ones(len(links[0])), links), shape=(of.size, of.size)), directed=False)
    vertex = np.empty(number.max(initial=-1) + 1, np.int64)
    vertex[number] = of
    return Faceted(number.reshape(-1, 3).astype(np.int64), vertex)


def ball_radii(mass: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Return the radii [m] of balls with the volume of the points, from mass [kg] and density [kg/m^3]."""
    return np.asarray(np.cbrt(0.75 / np.pi * mass / density))


def lattice_sides(position: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Return the spacings [m] of points on a regular lattice along x, y, z, shape (3,).

    Along an axis with a single layer the spacing follows from the volume of a point. position: [m], shape (n, 3). volume:
    [m^3], shape (n,).
    """
    mean = float(np.mean(volume))
    gaps = [np.diff(np.sort(values)) for values in position.T]
    layers = [gap[gap > 0.05 * np.cbrt(mean)] for gap in gaps]
    sides = np.array([np.median(gap) if len(gap) else np.nan for gap in layers])
    lone = np.isnan(sides)
    sides[lone] = (mean / np.prod(sides[~lone])) ** (1.0 / max(1, lone.sum()))
    return sides


def box_corners(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the corners of a box, shape (8, 3), from its lower and upper corner, shape (3,)."""
    ends = np.stack([lower, upper])
    return np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)


def bricks(centres: np.ndarray, sides: np.ndarray, colour: Colour) -> Mesh:
    """Build the surface of equal bricks centred at points of a lattice. The cut plane does not cut bricks.

    Faces between two bricks are omitted because they are not visible. centres: [m], shape (n, 3). sides: the three edge lengths
    of a brick [m]. colour: RGB.
    """
    corner = box_corners(np.full(3, -0.5), np.full(3, 0.5))  # number 4i + 2j + k
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])  # outward
    squares = (centres[:, None] + corner[faces.ravel()] * sides).reshape(-1, 4, 3)
    touching = cKDTree(squares.mean(axis=1)).query_pairs(0.25 * sides.min(), output_type="ndarray")
    vertices = np.delete(squares, touching.ravel(), axis=0).reshape(-1, 3)
    quads = np.arange(0, len(vertices), 4)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    n = len(vertices)
    return Mesh(vertices, quads.reshape(-1, 3), np.tile(colour, (n, 1)), np.zeros(n, bool), cuttable=False)


MOST = 2_000_000
"""Largest number of pixels that are processed together."""

DEPTHS = 1 << 24  # steps of depth that a canvas tells apart
REACH = 1 << 15  # pixels of depth on either side of the origin: far beyond any picture
SHIFT = 32
INNER = 1e-9  # of a triangle: a pixel on an edge belongs to both neighbours


class Canvas:
    """Depth buffer of a picture: stores, for every pixel, the depth of the nearest fragment, the part (drawn object) to
    which this fragment belongs, and the number of its primitive (triangle, ball or pixel) in the part.

    shape: numbers of rows and columns of pixels.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self.shape = shape
        self._key = np.full(shape[0] * shape[1], -1, np.int64)
        self._starts = [0]

    def begin_part(self, primitives: int) -> None:
        """Start a new part, i.e. the next drawn object. primitives: number of its triangles, balls or pixels."""
        self._starts.append(self._starts[-1] + primitives)

    def add(self, x: np.ndarray, y: np.ndarray, depth: np.ndarray, primitive: np.ndarray) -> None:
        """Add fragments (pixels covered by primitives) of the current part. Of fragments of a pixel at the same depth, the one
        with the highest primitive number is kept.

        x, y: pixel coordinates, whole numbers; depth: towards the eye [pixels]; primitive: number of the triangle, ball or
        pixel in the part; shape (k,) each.
        """
        step = np.clip((depth + REACH) * (DEPTHS / (2 * REACH)), 0, DEPTHS - 1).astype(np.int64)
        np.maximum.at(self._key, y * self.shape[1] + x, step << SHIFT | (primitive + self._starts[-2]))

    def seen(self, part: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels in which a part (number of the drawn object) is visible: their indices, row by row, and the
        primitive number in each, both of shape (k,)."""
        number = self._key & ((1 << SHIFT) - 1)
        index = np.flatnonzero((self._key >= 0) & (number >= self._starts[part]) & (number < self._starts[part + 1]))
        return index, number[index] - self._starts[part]

    def covered(self) -> np.ndarray:
        """Return a mask of the pixels covered by any primitive, with the canvas's shape."""
        return (self._key >= 0).reshape(self.shape)

    def depth(self) -> np.ndarray:
        """Return the depth towards the eye [pixels] of the object that each pixel shows, with the canvas's shape."""
        return ((self._key >> SHIFT) * (2 * REACH / DEPTHS) - REACH).reshape(self.shape)


def triangle_fragments(corners: np.ndarray, shape: tuple[int, int]) -> Fragments:
    """Yield the fragments (pixels covered by triangles, with depth and number of the triangle), row by row.

    corners: pixel coordinates and depth of the corners, shape (m, 3, 3). shape: rows and columns of the picture.
    """
    with np.errstate(invalid="ignore", over="ignore"):  # of points that are nowhere
        a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    shown = np.isfinite(area) & (np.abs(area) >= 1e-12)
    corners = np.where(shown[:, None, None], corners, 0.0)
    low = np.maximum(np.ceil(corners[:, :, 1].min(axis=1)), 0).astype(np.int64)
    high = np.minimum(np.floor(corners[:, :, 1].max(axis=1)), shape[0] - 1).astype(np.int64)
    rows = np.where(shown, np.maximum(high - low + 1, 0), 0)
    pixels = np.cumsum(rows * np.minimum(np.ptp(corners[:, :, 0], axis=1) + 1.0, shape[1]))
    for some in np.split(np.arange(len(corners)), np.searchsorted(pixels, np.arange(MOST, pixels.max(initial=0), MOST))):
        row, number = spread(rows[some])
        which = some[row]
        y = low[which] + number
        dy, one = y - a[which, 1], 1.0 / area[which]
        (ux, uy, uz), (vx, vy, vz) = u[which].T * one, v[which].T * one
        # the shares of the second and of the third corner in a pixel are s + ds x and t + dt x, x from the first corner on
        s, ds, t, dt = -dy * vx, vy, dy * ux, -uy
        first, last = -a[which, 0], shape[1] - 1 - a[which, 0]
        for share, slope in ((s, ds), (t, dt), (1.0 - s - t, -ds - dt)):
            with np.errstate(divide="ignore", invalid="ignore"):
                end = -(share + INNER) / slope
            first = np.where(slope > 0.0, np.maximum(first, end), first)
            last = np.where(slope < 0.0, np.minimum(last, end), last)
            last = np.where((slope == 0.0) & (share < -INNER), -np.inf, last)
        start = np.ceil(first + a[which, 0])
        line, number = spread(np.maximum(np.floor(last + a[which, 0]) - start + 1.0, 0.0).astype(np.int64))
        x = start[line].astype(np.int64) + number
        z, slope = a[which, 2] + area[which] * (uz * s + vz * t), area[which] * (uz * ds + vz * dt)
        yield x, y[line], z[line] + slope[line] * (x - a[which, 0][line]), which[line]


def ball_fragments(place: np.ndarray, kept: np.ndarray, shape: tuple[int, int]) -> Fragments:
    """Yield the fragments (pixels covered by balls, with depth and number of the ball).

    place: x, y, depth and radius of all balls in pixels, shape (n, 4). kept: indices of the balls to draw. shape: rows and
    columns of the picture.
    """
    size = np.zeros(len(place), np.int64)
    size[kept] = 2 * np.ceil(place[kept, 3]).astype(np.int64) + 1
    for which, side in _by_size(size):
        step = np.arange(side) - side // 2
        cx, cy, cz, radius = place[which].T[:, :, None]
        x, y = np.rint(cx).astype(np.int64) + step, np.rint(cy).astype(np.int64) + step
        across = np.where((x >= 0) & (x < shape[1]), np.square(x - cx), np.inf)
        upward = np.where((y >= 0) & (y < shape[0]), np.square(radius) - np.square(y - cy), -np.inf)
        rest = upward[:, :, None] - across[:, None, :]
        ball, row, column = np.nonzero(rest >= 0.0)
        yield x[ball, column], y[ball, row], cz[ball, 0] + np.sqrt(rest[ball, row, column]), which[ball]


def _by_size(size: np.ndarray) -> Iterator[tuple[np.ndarray, int]]:
    """Yield batches of primitives of similar size: their indices and an upper bound of their size in pixels. size: shape (n,);
    primitives of size 0 are omitted."""
    lower, upper = 0, 1
    while lower < size.max(initial=0):
        found = np.flatnonzero((size > lower) & (size <= upper))
        batch = max(1, MOST // upper**2)
        for start in range(0, len(found), batch):
            yield found[start : start + batch], upper
        lower, upper = upper, upper + max(1, upper // 3)
