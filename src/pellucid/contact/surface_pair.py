"""Contact of two surfaces with each other: which of their points search for the other surface, and with which shares of the
stiffness. `pellucid.contact.surface_pairs` describes the forces."""

from collections.abc import Sequence

import numpy as np

from pellucid.contact.contact_side import PointContact, SurfaceSide
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Seam
from pellucid.contact.overlap import OverlapLaw, mean_way
from pellucid.contact.proximity import Meeting

COARSE, LARGE = 1.5, 1.01  # ratios of point distances and of areas above which two surfaces count as different
NARROW = 0.4  # width of a body that may lie between the points of a surface, in reaches of these points


class SurfacePair(PointContact):
    """Contact of two surfaces, each with points that may lie inside the other surface.

    If exactly one of the surfaces is a sheet, only the points of the sheet are tested against the other surface. With
    points of both surfaces, one side may have no overlap, and the fraction of the damper that belongs to the other side
    would not stop the nodes of the sheet.

    friction, courant, swing, cell, step: see `OverlapLaw`. dimension: dimension of the surfaces, 2 in 3-D, 1 in the plane,
    0 along a line. thickness: thickness of a slice in a plane problem [m]. name: see `Touch`. seams: seams of a periodic
    grid.
    """

    sides: list[SurfaceSide]  # type: ignore[assignment]

    def __init__(
        self,
        surfaces: tuple[ContactSurface, ContactSurface],
        friction: float,
        dimension: int,
        thickness: float,
        courant: float,
        swing: float = 0.0,
        name: str | None = None,
        cell: float = np.inf,
        seams: Sequence[Seam] = (),
        step: float = 0.0,
    ) -> None:
        law = OverlapLaw(surfaces, friction, courant, swing, cell, step)
        one, other = surfaces
        ways = [(one, other), (other, one)]
        if one.is_sheet != other.is_sheet:
            ways = [(first, second) for first, second in ways if first.is_sheet]
        elif not law.is_implicit:
            ways = [(first, second) for first, second in ways if id(first) in law.compliance or _passes(first, second)]
        compliances = [law.compliance.get(id(first), 1.0 / law.stiffness) for first, _ in ways]
        fine = [c / float(np.median(first.reach)) ** 2 for c, (first, _) in zip(compliances, ways, strict=True)]
        sides = []
        for (first, second), share in zip(ways, fine, strict=True):
            meeting = Meeting((first.two_sided, second.two_sided), _deepest(second), dimension, thickness, first.is_sheet)
            how = share / sum(fine), law.stop is not None, seams, law.is_implicit
            sides.append(SurfaceSide(first, second, meeting, *how))
        super().__init__(surfaces, law, sides, name)

    @property
    def sight(self) -> float:
        """Distance within which the contact searches for points of the other surface [m]."""
        return min(float(side.other.reach.min()) for side in self.sides)

    @property
    def deepest(self) -> float:
        """Largest depth at which a point inside the other body counts as in contact [m]."""
        return min(side.deepest for side in self.sides)

    def begin_steady(self) -> None:
        """Select the one surface whose points get contact leads: of the deforming surfaces the smaller, or the finer of two
        equally large ones.

        Leads on both surfaces would give more than one lead per overlap. Without overlap, points of the other surface would
        touch intermittently because of curvature. The forces act on both surfaces. If the larger surface searched, edges of
        the smaller one would sink in between its points. The smaller surface does not search if it is much coarser.
        """
        super().begin_steady()
        soft = [side for side in self.sides if not side.one.is_hard]
        if soft:
            reach = {id(side): float(np.median(side.one.reach)) for side in soft}
            area = {id(side): float(side.one.weights().sum()) for side in soft}
            coarse, large = COARSE * min(reach.values()), LARGE * min(area.values())
            side = min(soft, key=lambda side: (reach[id(side)] > coarse, area[id(side)] > large, -side.share))
            side.remove_overlap()
            self.sides = [side]

    def way(self) -> np.ndarray:
        return mean_way(self.overlaps(), self.surfaces[0])


def _deepest(surface: ContactSurface) -> float:
    """Return the largest depth [m] at which a point behind a surface counts as in contact: the radius that a surface point
    represents, and for a surface that is not two-sided at most 0.4 of the smallest extent of the body."""
    reach = float(np.median(surface.reach))
    return reach if surface.two_sided else min(reach, 0.4 * _width(surface))


def _width(surface: ContactSurface) -> float:
    """Return the smallest extent of a body along an axis in which it has any [m]."""
    extent = np.ptp(surface.place, axis=0)
    return float(extent[extent > 1e-3 * extent.max()].min(initial=np.inf))


def _passes(one: ContactSurface, other: ContactSurface) -> bool:
    """Return True if the body of surface `one` is so narrow that it may lie between the points of surface `other`."""
    return _width(one) < NARROW * float(np.median(other.reach))
