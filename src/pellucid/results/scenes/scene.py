"""From bodies to a drawing on axes: the view, sections through closed membranes, the scale bar."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from pellucid.results.scenes.render import inside
from pellucid.results.scenes.things import Camera, Colour, Mesh, Plane, vertex_normals

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LENGTHS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))
INK = "#222233"
NEIGHBOURS = 14  # points that give a pixel of a section its value
HAIR = 2e-3  # of the thickness of a membrane
COARSE = 3  # pixels between those that are looked up


class View(NamedTuple):
    """Where the eye is [degrees]: turned from x about z, and above the horizon."""

    turn: float
    rise: float

    def axes(self) -> np.ndarray:
        """Rows right, up, towards the eye: unit vectors."""
        turn, rise = np.radians(self)
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        eye = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        return np.stack([right, np.cross(eye, right), eye])


def camera_for(view: View, positions: np.ndarray, columns: int, margin: float = 0.03) -> Camera:
    """The camera whose picture of so many columns holds all positions [m], shape (n, 3), and a margin around them."""
    axes = view.axes()
    paper = positions @ axes[:2].T
    low, high = paper.min(axis=0), paper.max(axis=0)
    gap = margin * (high - low).max()
    low, high = low - gap, high + gap
    return Camera(axes, low, high, columns / (high - low)[0])


def box_corners(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """The corners of a box, shape (8, 3)."""
    ends = np.stack([lower, upper])
    return np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)


def ball_radii(mass: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Radii [m] of balls that have the volume of the points, from mass [kg] and density [kg/m^3]."""
    return np.asarray(np.cbrt(0.75 / np.pi * mass / density))


def lattice_sides(position: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Distances [m] between the layers of a lattice of points along x, y, z; of a single layer what the volume [m^3] gives."""
    mean = float(np.mean(volume))
    gaps = [np.diff(np.sort(values)) for values in position.T]
    layers = [gap[gap > 0.05 * np.cbrt(mean)] for gap in gaps]
    sides = np.array([np.median(gap) if len(gap) else np.nan for gap in layers])
    lone = np.isnan(sides)
    sides[lone] = (mean / np.prod(sides[~lone])) ** (1.0 / max(1, lone.sum()))
    return sides


def bricks(centres: np.ndarray, sides: np.ndarray, colour: Colour) -> Mesh:
    """A body whose points lie on a lattice, as bricks of those three sides [m] about them; no plane cuts a brick.

    Faces between two bricks are left out: nobody sees them.
    """
    corner = box_corners(np.full(3, -0.5), np.full(3, 0.5))  # number 4i + 2j + k
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])  # outward
    squares = (centres[:, None] + corner[faces.ravel()] * sides).reshape(-1, 4, 3)
    touching = cKDTree(squares.mean(axis=1)).query_pairs(0.25 * sides.min(), output_type="ndarray")
    vertices = np.delete(squares, touching.ravel(), axis=0).reshape(-1, 3)
    quads = np.arange(0, len(vertices), 4)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    n = len(vertices)
    return Mesh(vertices, quads.reshape(-1, 3), np.tile(colour, (n, 1)), np.zeros(n, bool), cuttable=False)


def section(mesh: Mesh, camera: Camera, plane: Plane, position: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A field of points, shape (n,), on the pixels of the plane inside a closed mesh, else not a number.

    The mean of the nearest points, weighted by a bell curve as wide as the points are apart, on a lattice of pixels; linear
    between them.
    """
    within = inside(mesh, camera, plane)
    found = np.full(within.shape, np.nan)
    y, x = np.nonzero(within)
    if not len(x) or not len(position):
        return found
    rows, columns = (np.arange(z.min(), z.max() + 2 * COARSE, COARSE, dtype=float) for z in (y, x))
    v, u = np.meshgrid(rows, columns, indexing="ij")
    nearest = np.arange(1, min(NEIGHBOURS, len(position)) + 1)
    distance, which = cKDTree(position).query(camera.position(u, v, camera.depth_of(plane, u, v)), k=nearest)
    apart = np.mean(np.asarray(distance)[..., min(3, len(nearest) - 1)])
    weight = np.exp(-np.square(distance / apart)) + np.finfo(float).tiny
    coarse = (weight * values[which]).sum(axis=-1) / weight.sum(axis=-1)
    found[y, x] = map_coordinates(coarse, [(y - rows[0]) / COARSE, (x - columns[0]) / COARSE], order=1)
    return found


def rim(mesh: Mesh, plane: Plane, thickness: float, colour: Colour) -> Mesh:
    """The section of a membrane of that thickness [m] with a plane: a flat ribbon in its true width, marked as the mesh.

    It lies a hair beyond the plane, so that it covers what else is painted there.
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
    return Mesh(vertices, ribbon, np.tile(colour, (len(vertices), 1)), marked, mesh.mark, lit=False, cuttable=False)


def coloured(values: np.ndarray, limits: tuple[float, float], palette: str) -> np.ndarray:
    """RGB colours of values, of their shape and one axis more; not a number stays that."""
    from matplotlib import colormaps

    low, high = limits
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    rgb = colormaps[palette](np.nan_to_num(share))[..., :3]
    return np.where(np.isfinite(values)[..., None], rgb, np.nan)


def show(axes: "Axes", picture: np.ndarray, camera: Camera) -> None:
    """Put a picture on axes whose unit is the metre, without ticks and frame."""
    (left, low), (right, high) = camera.low, camera.high
    axes.imshow(picture, origin="lower", extent=(left, right, low, high), interpolation="antialiased")
    axes.set_axis_off()


def scale_bar(axes: "Axes", camera: Camera) -> None:
    """A bar of a round length in the lower right corner. Lengths across the line of sight are true in a parallel view."""
    length, text = round_length(0.22 * float((camera.high - camera.low)[0]))
    size = float((camera.high - camera.low).max())
    x, y = camera.high[0] - 0.02 * size - length, camera.low[1] + 0.02 * size
    axes.plot([x, x + length], [y, y], color=INK, linewidth=2.2, solid_capstyle="butt")
    _word(axes, x + 0.5 * length, y + 0.012 * size, text, ha="center", va="bottom", fontsize=8.5, color=INK)


def round_length(most: float) -> tuple[float, str]:
    """The largest length of 1, 2 or 5 times a power of ten that is at most so long [m], and its name: (2e-5, "20 µm")."""
    power = 10.0 ** np.floor(np.log10(most))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-9))
    unit, name = next((pair for pair in LENGTHS if length >= 0.999 * pair[0]), LENGTHS[-1])
    return float(length), f"{length / unit:.3g} {name}"


def corner_words(axes: "Axes", left: str, right: str, colour: str = INK) -> None:
    """Words in the upper corners, those on the left bold, those on the right in a colour."""
    _word(axes, 0.005, 1.0, left, transform=axes.transAxes, va="top", fontsize=11, fontweight="bold", color=INK)
    _word(axes, 0.995, 0.995, right, transform=axes.transAxes, va="top", ha="right", fontsize=8.5, color=colour)


def _word(axes: "Axes", x: float, y: float, text: str, **look: Any) -> None:
    from matplotlib.patheffects import withStroke

    axes.text(x, y, text, path_effects=[withStroke(linewidth=3.0, foreground="white")], **look)
