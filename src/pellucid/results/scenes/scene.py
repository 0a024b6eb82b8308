"""From bodies to a drawing on axes: the view, sections through closed membranes, the scale bar."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from pellucid.results.scenes.render import inside
from pellucid.results.scenes.things import Camera, Colour, Mesh, Plane, Section, vertex_normals

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEIGHBOURS = 8  # points that give a pixel of a section its value


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
    """Radii [m] at which the balls of a body overlap enough to look like one thing, from mass [kg] and density [kg/m^3]."""
    return 0.75 * np.cbrt(mass / density)


def section(mesh: Mesh, camera: Camera, plane: Plane, position: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A field of points on the pixels of the plane inside a closed mesh, shape (rows, columns, ...), else not a number.

    A pixel takes the mean of the nearest points, weighted with the inverse square of their distances.
    """
    within = inside(mesh, camera, plane)
    y, x = np.nonzero(within)
    found = np.full((*within.shape, *values.shape[1:]), np.nan)
    if len(x) and len(position):
        places = camera.position(x, y, camera.depth_of(plane, x, y))
        count = min(NEIGHBOURS, len(position))
        distance, which = cKDTree(position).query(places, k=np.arange(1, count + 1))
        weight = 1.0 / (distance**2 + 0.05 * distance.mean() ** 2 + np.finfo(float).tiny)
        weight /= weight.sum(axis=1, keepdims=True)
        found[within] = np.einsum("kn,kn...->k...", weight, values[which])
    return found


def rim(mesh: Mesh, plane: Plane, thickness: float, colour: Colour) -> Mesh:
    """The section of a membrane of that thickness [m] with a plane: a flat ribbon in its true width, marked as the mesh."""
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
    middle = there(mesh.vertices)
    vertices = np.stack([middle + side, middle - side], axis=1).reshape(-1, 3)
    ribbon = (4 * np.arange(len(cut))[:, None, None] + np.array([[0, 1, 2], [1, 3, 2]])).reshape(-1, 3)
    marked = np.repeat(there(mesh.marked[:, None].astype(float)), 2)
    return Mesh(vertices, ribbon, np.tile(colour, (len(vertices), 1)), marked, mesh.mark, lit=False)


def painted(plane: Plane, values: np.ndarray, limits: tuple[float, float], palette: str) -> Section:
    """A section coloured by its values."""
    return Section(plane, coloured(values, limits, palette))


def coloured(values: np.ndarray, limits: tuple[float, float], palette: str) -> np.ndarray:
    """RGB colours of values, of their shape and one axis more; not a number stays that."""
    from matplotlib import colormaps

    low, high = limits
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    rgb = colormaps[palette](np.nan_to_num(share))[..., :3]
    return np.where(np.isfinite(values)[..., None], rgb, np.nan)


def show(axes: "Axes", picture: np.ndarray, camera: Camera) -> None:
    """Put a picture on axes whose unit is the metre, without a frame."""
    (left, low), (right, high) = camera.low, camera.high
    axes.imshow(picture, origin="lower", extent=(left, right, low, high), interpolation="antialiased")
    axes.set_axis_off()


def scale_bar(axes: "Axes", camera: Camera, length: float, text: str) -> None:
    """A bar of that length [m] in the lower left corner. Lengths across the line of sight are true in a parallel view."""
    size = camera.high - camera.low
    x, y = camera.low + 0.04 * size.max()
    axes.plot([x, x + length], [y, y], color="#223", linewidth=2.2, solid_capstyle="butt")
    axes.text(x + 0.5 * length, y + 0.015 * size.max(), text, ha="center", va="bottom", fontsize=8.5, color="#223")
