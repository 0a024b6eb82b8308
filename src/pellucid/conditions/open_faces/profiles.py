"""Velocity profiles of steady laminar flows across openings. Their scale is arbitrary; the caller normalizes them."""

from collections.abc import Sequence
from typing import TypeGuard

import numpy as np

from pellucid.findings import Reason
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box, Cylinder

TERMS = 200  # terms of the series of a duct, which decrease with the cube of their index
Wall = tuple[float, float]


def across_tube(tube: Cylinder, axis: int, places: np.ndarray) -> np.ndarray:
    """Return the velocity profile 1 - r²/R² of the flow in a tube with radius R along an axis, at the positions `places`
    [m], shape (n, 3), with the distances r from the axis: dimensionless, shape (n,); 0 outside the tube."""
    offset = np.delete(places - np.array(tube.centre_), axis, axis=1)
    return np.maximum(1.0 - np.sum(offset * offset, axis=1) / tube.radius**2, 0.0)


def across_walls(walls: Sequence[Wall | None], places: np.ndarray) -> np.ndarray:
    """Return the velocity profile of the flow between one or two pairs of walls at the positions `places` [m], shape (n,
    3): dimensionless with an arbitrary scale, shape (n,); 0 outside the walls.

    walls: for each axis the positions of its two walls [m], or None. For two pairs the profile is Boussinesq's series, see
    White 2006, Viscous Fluid Flow, section 3-3.3.
    """
    pairs = [(axis, pair) for axis, pair in enumerate(walls) if pair is not None]
    scaled = [(2.0 * places[:, axis] - low - high) / (high - low) for axis, (low, high) in pairs]
    half = [0.5 * (high - low) for _, (low, high) in pairs]
    inside = np.all([np.abs(y) <= 1.0 for y in scaled], axis=0)
    if len(pairs) == 1:
        return np.where(inside, 1.0 - scaled[0] ** 2, 0.0)
    y, z = (np.clip(s, -1.0, 1.0) for s in scaled)
    share = np.zeros(len(places))
    for n in range(1, 2 * TERMS, 2):
        k, side = 0.5 * n * np.pi, half[1] / half[0]
        # cosh(k b z)/cosh(k b), without large numbers
        decay = (np.exp(k * side * (np.abs(z) - 1.0)) + np.exp(-k * side * (np.abs(z) + 1.0))) / (1.0 + np.exp(-2.0 * k * side))
        share += (-1.0) ** (n // 2) / n**3 * (1.0 - decay) * np.cos(k * y)
    return np.where(inside, np.maximum(share, 0.0), 0.0)


def why_no_profile(geometry: Geometry, axis: int) -> Reason | None:
    """Return the reason why the laminar velocity profile across an opening of this geometry is unknown, None if it is known
    (slit, duct or tube); axis: normal axis of the face."""
    if isinstance(geometry, Box) or is_tube(geometry, axis):
        return None
    text = "only slits, ducts and tubes along the normal have this profile, but the opening has another shape"
    return Reason(text, f'define a box, or a cylinder along {"xyz"[axis]}, with `through`, or use profile = "uniform"')


def is_tube(geometry: Geometry, axis: int) -> TypeGuard[Cylinder]:
    """Return True if `geometry` is a cylinder along the axis `axis`, the normal of a face, so that its opening in the face
    is round."""
    return isinstance(geometry, Cylinder) and "xyz".index(geometry.axis) == axis
