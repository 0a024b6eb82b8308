"""Sheets (membranes) with contact at their nodes only: parts of other surfaces that may pass between the nodes, and the points
of a sheet that are close to another surface."""

from math import sqrt

import numpy as np
from scipy.spatial import cKDTree

from pellucid.contact.contact_surface import ContactSurface

PASSES = sqrt(0.5)
"""Smallest admissible half-width of a body divided by the edge length of a sheet's elements: a narrower body may pass between
four nodes at the corners of a square."""
WAYS = 12  # number of directions along a sheet in which widths are measured
SPACINGS = 2.5  # range of a contact point, in distances between the points of its surface
HIGH = 2.0  # in element edges: height of the approaching part of a body whose width is measured
ABOUT = 3.0  # in element edges: distance of this part from the closest point of the body


def passes_between(sheet: ContactSurface, other: ContactSurface, ahead: float) -> str | None:
    """Return a warning if the part of a body that approaches a sheet (membrane) may pass between the nodes of the sheet; None
    otherwise.

    sheet, other: contact surfaces of the sheet, with contact at its nodes, and of the body; ahead: largest decrease of the
    distance between the surfaces until the next check [m].
    """
    edges, place = sheet.edges(), other.place[: len(other.place) - other.n_edge_points]
    margin = HIGH * float(edges.max()) + ahead
    lower, upper = sheet.place.min(axis=0) - margin, sheet.place.max(axis=0) + margin
    near = place[((place >= lower) & (place <= upper)).all(axis=1)]
    if not len(near):
        return None
    distance, node = map(np.asarray, cKDTree(sheet.place).query(near))
    first = int(np.argmin(distance))
    edge, normal, foot = float(edges[node[first]]), sheet.normals()[node[first]], sheet.place[node[first]]
    if distance[first] > HIGH * edge + ahead or not normal.any():
        return None
    normal = normal if (place.mean(axis=0) - foot) @ normal > 0.0 else -normal
    near = near[np.linalg.norm(near - near[first], axis=1) <= ABOUT * edge]
    height = (near - foot) @ normal
    front = near[height <= height.min() + HIGH * edge]
    half = 0.5 * _find_width(front, normal, sheet.is_plane) + float(np.max(sheet.half_width))
    if not 0.0 < half < PASSES * edge:
        return None
    at = ", ".join(f"{value:.4g}" for value in foot)
    return describe_passage(other.body, sheet.body, 2.0 * half, f"near ({at}) m", edge)


def find_places_beside(sheet: ContactSurface, other: ContactSurface) -> np.ndarray:
    """Return the positions of those points of a sheet (membrane) that are close to another surface `other` [m], shape (n, 3):
    within the distance between neighbouring points of that surface, whether or not the surfaces overlap.
    """
    distance = float(np.max(other.reach)) / SPACINGS + float(np.max(sheet.half_width))
    lower, upper = other.place.min(axis=0) - distance, other.place.max(axis=0) + distance
    near = sheet.place[((sheet.place >= lower) & (sheet.place <= upper)).all(axis=1)]
    if not len(near):
        return near
    found = cKDTree(other.place).query(near, distance_upper_bound=distance)[0]
    return np.asarray(near[np.isfinite(found)])


def _find_width(place: np.ndarray, normal: np.ndarray, is_plane: bool) -> float:
    """Return the smallest extent [m] of a set of positions [m], shape (n, 3), along directions perpendicular to a normal, of
    which it tries `WAYS`; in a plane problem (`is_plane`), the extent perpendicular to the normal in the plane.
    """
    tangents = np.linalg.svd(normal[None])[2][1:]
    angle = np.pi * np.arange(WAYS) / WAYS
    widths = np.ptp(place @ (np.stack([np.cos(angle), np.sin(angle)], axis=1) @ tangents).T, axis=0)
    return float(widths.max() if is_plane else widths.min())


def describe_passage(body: str, sheet: str, width: float, where: str, edge: float) -> str:
    """Return the warning that body `body`, with a part of this width [m], may pass through membrane `sheet` with this edge
    length [m]. where: text that describes the location.
    """
    return (
        f"body {body} approaches membrane {sheet} with a part of {width:.3g} m in width {where}, and the edges of the elements "
        f"are {edge:.3g} m long there: it can pass between the nodes, since contact acts only at the nodes; use elements with "
        f"edges of at most {0.5 * width:.2g} m there"
    )
