"""Walls: planes without a body that surfaces can touch."""

from collections.abc import Mapping

import numpy as np

from pellucid.contact.contact_side import ContactSide, PointContact
from pellucid.contact.contact_surface import FULL_CONTACT, NO_CONTACT, ContactSurface
from pellucid.contact.images import Described
from pellucid.contact.overlap import Overlap, OverlapLaw, StartOverlap, rests_on_flat_side, stop_apart
from pellucid.contact.wall_plane import WallPlane


class BehindPlane(ContactSide):
    """Points of the surface `one` that lie behind the plane of a wall. Unless both sides of the surface can be in contact,
    only points whose normals point towards the plane count."""

    def __init__(self, one: ContactSurface, plane: WallPlane) -> None:
        start = None if one.is_hard or one.drag is not None else StartOverlap(float(one.reach.max()))
        super().__init__(one, None, start, 1.0)
        self._plane, self._apart = plane, stop_apart(one)

    @property
    def other_velocity(self) -> np.ndarray:
        return self._plane.velocity

    def find(self, described: Mapping[int, Described], step: float, ahead: bool) -> Overlap | None:
        one, plane, m = self.one, self._plane, len(self.one.place)  # entries after the first m are images
        sizes, facing = one.weights(), np.ones(m)
        if not one.two_sided:
            facing = -np.sum(described[id(one)].normal[:m] * plane.normal, axis=1)
            facing[m - one.n_edge_points :] = 1.0
        depth = one.half_width - plane.height(one.place)
        # as for another flat surface: sides of a body perpendicular to the plane do not touch it
        counts = np.clip((facing - NO_CONTACT) / (FULL_CONTACT - NO_CONTACT), 0.0, 1.0)
        over = depth > 0.0
        if ahead:
            over = depth - 1.5 * step * np.minimum(np.sum((one.velocity - plane.velocity) * plane.normal, axis=1), 0.0) > 0.0
            over[self.pushed[depth[self.pushed] > -one.reach[self.pushed]]] = True
        elif self.lead is not None:
            over[:] = True
        at = np.flatnonzero(over & (counts > 0.0) & (sizes > 0.0))
        area, depth = counts[at] * sizes[at], depth[at]
        if self.start is not None:
            depth = self.start.reduce(depth)
        if self.lead is not None:
            depth, self.lent = self.lead.applied(at, depth, area)
        if not (ahead or self.keeps_near):
            kept = depth > 0.0
            at, depth, area = at[kept], depth[kept], area[kept]
        if not len(at):
            return None
        normal, relative = np.tile(plane.normal, (len(at), 1)), one.velocity[at] - plane.velocity
        apart = self._apart and rests_on_flat_side(one, at)
        new = ~np.isin(at, self.pushed) if self.start is not None else None
        return Overlap(one, at, depth, normal, area, relative, 1.0, apart, new)


class WallContact(PointContact):
    """Contact of a surface with a wall, a plane without a body. friction, courant, swing, cell, step: see `OverlapLaw`.
    name: see `Touch`."""

    def __init__(
        self,
        surface: ContactSurface,
        plane: WallPlane,
        friction: float,
        courant: float,
        swing: float = 0.0,
        name: str | None = None,
        cell: float = np.inf,
        step: float = 0.0,
    ) -> None:
        law = OverlapLaw((surface,), friction, courant, swing, cell, step)
        super().__init__((surface,), law, [BehindPlane(surface, plane)], name)
        self.plane, self.label = plane, "a wall" if name is None else f"wall {name}"

    @property
    def between(self) -> tuple[str, ...]:
        return *super().between, self.label

    def begin(self, time: float, rate: float) -> None:
        self.plane.go_to(time, rate)

    def begin_steady(self) -> None:
        super().begin_steady()
        if not self.surfaces[0].is_hard:
            self.sides[0].remove_overlap()

    def way(self) -> np.ndarray:
        return self.plane.normal

    def external_work(self) -> float:
        return float(np.sum(self.impulse * self.plane.velocity))

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return the arrays of the surface if it belongs to the wall and not to its body: points of a fluid."""
        surface = self.surfaces[0]
        return {} if surface.drag is None else surface.state_arrays()

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        if self.surfaces[0].drag is not None:
            self.surfaces[0].restore(arrays)
