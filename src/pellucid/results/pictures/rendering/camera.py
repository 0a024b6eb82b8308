"""Camera: direction of view and projection of positions to pixels.

Bodies have lengths in metres. Projected lengths are in pixels: x to the right, y up, depth towards the eye.
"""

from typing import NamedTuple

import numpy as np


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
