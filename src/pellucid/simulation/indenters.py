"""Hard bodies that are small beside the cells or faces of a soft one, in which they press too hard."""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Plane
from pellucid.contact.surface_pairs import SurfacePair
from pellucid.simulation.assembly import Surfaces

FEWEST = 3.0  # cells or edges of the soft body in the radius of a hard one, below which its force is far too large


def coarse_indenters(
    pairs: Sequence[SurfacePair], surfaces: Surfaces, thin: tuple[bool, bool, bool], planes: Sequence[Plane]
) -> Iterator[str]:
    """Warnings about hard bodies that soft ones resolve too coarsely, one for each two of them; planes: of symmetry."""
    names = {id(surface): name for name, surface in surfaces.items()}
    for pair in pairs:
        hard, soft = sorted(pair.surfaces, key=lambda surface: not surface.is_hard)
        if not hard.is_hard or soft.is_hard or not len(hard.place) or not len(soft.place):
            continue
        radius, spacing = _radius_and_spacing(hard, soft, ~np.array(thin), planes)
        if radius < FEWEST * spacing:
            one, other = names[id(hard)], names[id(soft)]
            yield (
                f"body {one}, which does not deform, has a radius of {radius:.3g} m where it meets body {other}: "
                f"{radius / spacing:.2g} of the {soft.resolved_by} there ({spacing:.3g} m), fewer than {FEWEST:g}; pressed "
                f"into {other} it meets too large a force (126 in place of 100 at 1.4); use {soft.finer}"
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
