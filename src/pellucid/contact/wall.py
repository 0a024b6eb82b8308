"""Planes without a body that surfaces touch."""

import numpy as np

from pellucid.contact.contact_surface import FULL, NONE, ContactSurface
from pellucid.contact.images import Described
from pellucid.contact.implicit import Block, NormalForces
from pellucid.contact.overlap import (
    GivenBefore,
    Implicit,
    Overlap,
    OverlapLaw,
    StartOverlap,
    may_press,
    rests_on_flat_side,
    stop_apart,
)
from pellucid.contact.steady_contact import ContactLead
from pellucid.contact.touch import Touch
from pellucid.contact.wall_plane import WallPlane


class WallContact(Touch):
    """A surface that touches a plane. friction, courant, swing, step: see `OverlapLaw`."""

    law: OverlapLaw

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
        super().__init__((surface,), OverlapLaw((surface,), friction, courant, swing, cell, step), name)
        self.plane, self.label, self._work = plane, "a wall" if name is None else f"wall {name}", 0.0
        self._overlap: Overlap | None = None
        self._given, self._described = GivenBefore(), dict[int, Described]()
        self._start = None if surface.is_hard or surface.drag is not None else StartOverlap(float(surface.reach.max()))
        self._lead: ContactLead | None = None

    @property
    def between(self) -> tuple[str, ...]:
        return *super().between, self.label

    def begin(self, time: float, rate: float) -> None:
        """Move the plane to where it is."""
        self.plane.go_to(time, rate)

    def find(self, described: dict[int, Described]) -> bool:
        """Find which points of the surface lie behind the plane and face it; whether any do."""
        self._work, self.impulse, self._overlap, self.law.lent = 0.0, np.zeros(3), None, 0.0
        self._described = described
        surface, plane = self.surfaces[0], self.plane
        self.before = self._given.power(surface.velocity, plane.velocity)
        listed = self._given.forget()
        m = len(surface.place)  # behind these are images, which planes of symmetry make
        sizes, facing = surface.weights(), np.ones(m)
        if not surface.two_sided:
            facing = -np.sum(described[id(surface)].normal[:m] * plane.normal, axis=1)
            facing[m - surface.n_edge_points :] = 1.0
        depth = surface.half_width - plane.height(surface.place)
        # as beside another surface that is flat: sides of a body across the plane do not touch it
        counts = np.clip((facing - NONE) / (FULL - NONE), 0.0, 1.0)
        over = depth > 0.0
        if self.law.is_implicit:
            relative = surface.velocity - plane.velocity
            over = may_press(depth, relative, np.broadcast_to(plane.normal, (m, 3)), self.step)
            over[listed[depth[listed] > -surface.reach[listed]]] = True
        elif self._lead is not None:
            over[:] = True
        at = np.flatnonzero(over & (counts > 0.0) & (sizes > 0.0))
        if self._start is not None:
            depth[at] = self._start.reduce(depth[at])
        if self._lead is not None:
            depth[at], lent = self._lead.applied(at, depth[at], counts[at] * sizes[at])
            self.law.lent = self.law.stiffness * lent
        if not self.law.is_implicit:
            at = at[depth[at] > 0.0]
        if not len(at):
            return False
        normal = np.broadcast_to(plane.normal, (len(at), 3))
        relative = surface.velocity[at] - plane.velocity
        self._overlap = Overlap(
            surface,
            at,
            depth[at],
            normal,
            counts[at] * sizes[at],
            relative,
            apart=stop_apart(surface) and rests_on_flat_side(surface, at),
            new=~np.isin(at, listed) if self._start is not None else None,
        )
        return True

    def start_overlaps(self) -> list[StartOverlap]:
        return [] if self._start is None else [self._start]

    def given_before(self) -> list[GivenBefore]:
        return [self._given]

    def begin_steady(self) -> None:
        super().begin_steady()
        self.law.is_implicit = False
        self._lead = None if self.surfaces[0].is_hard else ContactLead(self.surfaces[0])

    def leads(self) -> list[ContactLead]:
        return [] if self._lead is None else [self._lead]

    def way(self) -> np.ndarray:
        """Its normal."""
        return self.plane.normal

    def overlaps(self) -> list[Overlap]:
        """That of the surface."""
        return [] if self._overlap is None else [self._overlap]

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        """Add the forces of the overlap over a step dt [s] to those of the surface; last: length of the step before."""
        if self._overlap is None:
            return
        implicit: list[Implicit] = []
        if self.law.is_implicit:
            block = Block(self._overlap, self.law.normal_stiffness(self._overlap), self._given.pressed(self._overlap))
            implicit = NormalForces([block], dt, self._described, forces).solve()
        (force,) = self.law.forces([self._overlap], dt, last, touched, self.before, implicit)
        if self.law.counts_both_ends:
            self._given.keep(self._overlap.listed, self.law.given[0])
        forces[id(self.surfaces[0])][self._overlap.listed] += force
        self.impulse = dt * force.sum(axis=0)
        self._work = float(np.sum(self.impulse * self.plane.velocity))

    def external_work(self) -> float:
        """What the plane does by its motion over this step [J]."""
        return self._work
