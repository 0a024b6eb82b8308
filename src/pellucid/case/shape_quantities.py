"""Quantities of surfaces that probes can name: area, enclosed volume, and the ellipsoid with the inertia of the enclosed
volume.

Every point has the value of the whole body, so that any reduction of the probe returns it.
"""

import numpy as np

from pellucid.case.probe import TRIANGLES, Fetch, quantity, surface_quantity
from pellucid.geometry.meshes.enclosure import ellipsoid_of, surface_area, volume_with_lids

ROUND = 1e-4  # smallest relative difference of two axes that defines a direction: meshes of balls differ less


@surface_quantity("surface_area", "m^2", "area of a surface, or of the outer faces of a solid")
def _surface_area(field: Fetch) -> np.ndarray:
    return _everywhere(field, surface_area(field("position"), field(TRIANGLES)))


@surface_quantity("enclosed_volume", "m^3", "volume enclosed by a surface; an open surface is closed by lids over its rims")
def _enclosed_volume(field: Fetch) -> np.ndarray:
    return _everywhere(field, volume_with_lids(field("position"), field(TRIANGLES)))


@surface_quantity(
    "taylor_deformation",
    "",
    "(L - B)/(L + B) of the longest axis L and the shortest axis B of the ellipsoid with the inertia of the enclosed volume",
)
def _taylor_deformation(field: Fetch) -> np.ndarray:
    return _everywhere(field, ellipsoid_of(field("position"), field(TRIANGLES)).deformation)


@surface_quantity(
    "inclination",
    "rad",
    "angle between x and the longest axis of the ellipsoid with the inertia of the enclosed volume; nan for a ball",
)
def _inclination(field: Fetch) -> np.ndarray:
    found = ellipsoid_of(field("position"), field(TRIANGLES))
    long, middle, _ = found.axes
    along = found.directions[0] if long - middle > ROUND * long else np.full(3, np.nan)
    return _everywhere(field, np.arctan2(np.hypot(along[1], along[2]), abs(along[0])))


@surface_quantity(
    "semi_axes", "m", "semi-axes of the ellipsoid with the inertia of the enclosed volume", ("long", "middle", "short")
)
def _semi_axes(field: Fetch) -> np.ndarray:
    return _everywhere(field, ellipsoid_of(field("position"), field(TRIANGLES)).axes)


@quantity("extent", "m", "extent of the body along each axis, between its outermost points", 3)
def _extent(field: Fetch) -> np.ndarray:
    return _everywhere(field, np.ptp(field("position"), axis=0))


def _everywhere(field: Fetch, value: float | np.ndarray) -> np.ndarray:
    return np.tile(value, (len(field("id")), *[1] * np.ndim(value)))
