"""Hard bodies that are small beside the cells or faces of a soft one, in which they press too hard."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Plane
from pellucid.simulation.assembly import Surfaces

FEWEST = 3.0  # cells or edges of the soft body in the radius of a hard one, below which its force is far too large


def coarse_indenters(
    surfaces: Surfaces, fields: Mapping[str, str], thin: tuple[bool, bool, bool], planes: Sequence[Plane]
) -> Iterator[str]:
    """Warnings about hard bodies that soft ones of other velocity fields resolve too coarsely, one for each two of them.

    surfaces: of all bodies that have one, whether these or the nodes of the grid touch; fields: those of the bodies, by name;
    planes: of symmetry.
    """
    known = [(name, surface) for name, surface in surfaces.items() if surface is not None and len(surface.place)]
    for (one, hard), (other, soft) in permutations(known, 2):
        if not hard.is_hard or soft.is_hard or fields[one] == fields[other]:
            continue
        radius, spacing = _radius_and_spacing(hard, soft, ~np.array(thin), planes)
        if radius < FEWEST * spacing:
            yield (
                f"body {one}, which does not deform, has a radius of {radius:.3g} m where it meets body {other}: "
                f"{radius / spacing:.2g} of the {soft.resolved_by} there ({spacing:.3g} m), fewer than {FEWEST:g}; pressed "
                f"into {other} it meets a wrong force, mostly too large, by 10 to 70 % at 2 and less; use {soft.finer}"
            )


def _radius_and_spacing(
    hard: ContactSurface, soft: ContactSurface, active: np.ndarray, planes: Sequence[Plane]
) -> tuple[float, float]:
    """The smallest half extent of a hard body across the way to a soft one [m], and the length that resolves this there [m]."""
    lower, upper = _box(hard, planes)
    low, high = soft.place.min(axis=0), soft.place.max(axis=0)
    apart = np.where(active, np.maximum(low - upper, lower - high), -np.inf)
    axis = int(apart.argmax())
    across = active & (np.arange(3) != axis)
    covers = upper - lower >= high - low  # a plate on all of the other body has no edge that presses into it
    radius = 0.5 * float((upper - lower)[across & ~covers].min(initial=np.inf))
    if radius == np.inf:
        return radius, 0.0
    beside = ((soft.place >= lower - radius) & (soft.place <= upper + radius))[:, across].all(axis=1)
    side = 1.0 if lower[axis] + upper[axis] > low[axis] + high[axis] else -1.0
    beside &= side * soft.area[:, axis] > 0.5 * soft.sizes()
    lengths = np.broadcast_to(soft.resolution, len(soft.place))
    return radius, float(np.median(lengths[beside] if beside.any() else lengths))


def _box(surface: ContactSurface, planes: Sequence[Plane]) -> tuple[np.ndarray, np.ndarray]:
    """Of a surface, with the images of it that planes of symmetry join to it."""
    lower, upper = surface.place.min(axis=0), surface.place.max(axis=0)
    near = float(np.median(surface.reach))
    for plane in planes:
        axis, place = plane.axis, plane.place
        if lower[axis] - near <= place <= upper[axis] + near:
            ends = lower[axis], upper[axis], 2.0 * place - lower[axis], 2.0 * place - upper[axis]
            lower[axis], upper[axis] = min(ends), max(ends)
    return lower, upper
