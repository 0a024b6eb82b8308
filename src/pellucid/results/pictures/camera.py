"""Camera: direction of view and projection of positions to pixels; display of a rendered picture on the axes of a figure.

Bodies have lengths in metres. Projected lengths are in pixels: x to the right, y up, depth towards the eye.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.results.pictures.style import Axes


class View(NamedTuple):
    """Direction from which a picture in space is seen: azimuth of the eye about z, measured from x (`turn`), and its
    elevation above the x-y plane (`rise`), both in degrees."""

    turn: float
    rise: float

    def axes(self) -> np.ndarray:
        """Unit vectors of the view as rows, shape (3, 3): right, up, towards the eye."""
        turn, rise = np.radians(self)
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        eye = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        return np.stack([right, np.cross(eye, right), eye])


class Plane(NamedTuple):
    """Cut plane: material at normal·x > offset [m] is not drawn. The normal is a unit vector."""

    normal: tuple[float, float, float]
    offset: float

    def beyond(self, position: np.ndarray) -> np.ndarray:
        """Return the signed distance of positions [m], shape (n, 3), from the plane [m], shape (n,); negative where
        material is drawn."""
        return position @ np.array(self.normal) - self.offset


class Camera(NamedTuple):
    """Camera with parallel projection, from positions in space to pixels.

    `axes`: unit vectors right, up and towards the eye, as rows; `low`, `high`: corners of the picture along the first two
    axes [m]; `scale`: pixels per metre.
    """

    axes: np.ndarray
    low: np.ndarray
    high: np.ndarray
    scale: float

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns of pixels of the picture."""
        columns, rows = np.ceil((self.high - self.low) * self.scale).astype(int)
        return int(rows), int(columns)

    def project(self, position: np.ndarray) -> np.ndarray:
        """Return the pixel coordinates x, y and the depth towards the eye [pixels], shape (n, 3), of positions [m], shape
        (n, 3)."""
        return np.asarray((position @ self.axes.T - np.append(self.low, 0.0)) * self.scale)

    def depth_of(self, plane: Plane, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the depth of a plane towards the eye [pixels] at the pixel coordinates x, y. The plane must not be
        parallel to the line of sight."""
        (nx, ny, nz), offset = self._projected(plane)
        return (offset - nx * x - ny * y) / nz

    def keeps(self, plane: Plane, x: np.ndarray, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Return a mask of the positions on the kept side of a cut plane. x, y, depth: pixel coordinates and depth towards the
        eye [pixels]."""
        (nx, ny, nz), offset = self._projected(plane)
        return nx * x + ny * y + nz * depth <= offset

    def position(self, x: np.ndarray, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Return the positions [m], shape (n, 3), of the pixel coordinates x, y and depths towards the eye [pixels], shape
        (n,) each."""
        paper = np.stack([x, y, depth], axis=-1) / self.scale + np.append(self.low, 0.0)
        return np.asarray(paper @ self.axes)

    def _projected(self, plane: Plane) -> tuple[np.ndarray, float]:
        normal = self.axes @ np.array(plane.normal)
        return normal, (plane.offset - float(normal[:2] @ self.low)) * self.scale


def camera_for(view: View, positions: np.ndarray, columns: int, margin: float = 0.03) -> Camera:
    """Return the camera that looks along `view` and whose picture, `columns` pixels wide, shows all positions [m], shape (n,
    3).

    margin: space around the positions, relative to the size of the picture.
    """
    axes = view.axes()
    paper = positions @ axes[:2].T
    low, high = paper.min(axis=0), paper.max(axis=0)
    gap = margin * ((high - low).max() or 1.0)  # a single place needs some paper too
    low, high = low - gap, high + gap
    return Camera(axes, low, high, columns / (high - low)[0])


LENGTHS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))
INK = "#222233"
UNCOLOURED = "#c4c8d0"
"""Colour of points without a value."""


def coloured(values: np.ndarray, limits: tuple[float, float], palette: str) -> np.ndarray:
    """Return the RGB colours of values, shape (*values.shape, 3); NaN where a value is NaN or infinite.

    limits: the values that have the first and the last colour of the colour map `palette`.
    """
    from matplotlib import colormaps

    low, high = limits
    known = np.isfinite(values)
    found = np.full((*values.shape, 3), np.nan)
    found[known] = colormaps[palette](np.clip((values[known] - low) / (high - low), 0.0, 1.0))[:, :3]
    return found


def show(axes: Axes, picture: np.ndarray, camera: Camera) -> None:
    """Show a rendered picture (RGBA, lowest row first) on axes, with coordinates in metres, without ticks and frame."""
    (left, low), (right, high) = camera.low, camera.high
    axes.imshow(picture, origin="lower", extent=(left, right, low, high), interpolation="antialiased")
    axes.set_axis_off()


def scale_bar(axes: Axes, camera: Camera) -> None:
    """Draw a scale bar of a round length in the lower right corner. The projection is parallel, so lengths normal to the
    line of sight are true."""
    length, text = round_length(0.22 * float((camera.high - camera.low)[0]))
    size = float((camera.high - camera.low).max())
    x, y = camera.high[0] - 0.02 * size - length, camera.low[1] + 0.02 * size
    axes.plot([x, x + length], [y, y], color=INK, linewidth=2.2, solid_capstyle="butt")
    _word(axes, x + 0.5 * length, y + 0.012 * size, text, ha="center", va="bottom", fontsize=8.5, color=INK)


def round_length(most: float) -> tuple[float, str]:
    """Return the largest length [m] of 1, 2 or 5 times a power of ten that is at most `most` [m], and its text, e.g. (2e-5, "20
    µm")."""
    power = 10.0 ** np.floor(np.log10(most))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-9))
    unit, name = next((pair for pair in LENGTHS if length >= 0.999 * pair[0]), LENGTHS[-1])
    return float(length), f"{length / unit:.3g} {name}"


def corner_words(axes: Axes, left: str, right: str, colour: str = INK) -> None:
    """Write texts in the upper corners: the left one in bold, the right one in the given colour."""
    _word(axes, 0.005, 1.0, left, transform=axes.transAxes, va="top", fontsize=11, fontweight="bold", color=INK)
    _word(axes, 0.995, 0.995, right, transform=axes.transAxes, va="top", ha="right", fontsize=8.5, color=colour)


def _word(axes: Axes, x: float, y: float, text: str, **look: Any) -> None:
    from matplotlib.patheffects import withStroke

    axes.text(x, y, text, path_effects=[withStroke(linewidth=3.0, foreground="white")], **look)
