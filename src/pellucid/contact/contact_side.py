"""Contact sides, i.e. points of a surface that lie inside another surface or behind a wall, and contacts made of sides."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import NO_IMAGES, Described, Feet, Images
from pellucid.contact.implicit import Block, NormalForces
from pellucid.contact.overlap import Implicit, Overlap, OverlapLaw, StartOverlap
from pellucid.contact.steady_contact import ContactLead
from pellucid.contact.touch import Touch


class PreviousForces:
    """Store of the damper and friction forces on contact points in the last step, with the feet of these points
    (projections on the other surface). With an implicit contact law, the forces are friction minus normal force.

    In a step Δt, the forces dissipate the energy -½ Δt (F + F')·v', with the forces F before and F' after the step and the
    relative velocities v' after the step. The power F·v' of the stored forces is therefore computed in the next step
    (`power`).
    """

    def __init__(self) -> None:
        self._listed, self._force = np.zeros(0, np.int64), np.zeros((0, 3))
        self._before, self._pressed = self._listed, self._force
        self._feet: Feet | None = None
        self._images = NO_IMAGES

    def store(self, listed: np.ndarray, force: np.ndarray, feet: Feet | None = None, images: Images | None = NO_IMAGES) -> None:
        """Store the forces of this step [N], shape (n, 3), on the points of the surface with the indices `listed`.

        feet: feet of the points, as weights of the points and images of another surface; None for a wall. images: images of
        this surface.
        """
        self._listed, self._force, self._feet = listed, force, feet
        if feet is not None and images is not None:
            self._images = Images(images.point.copy(), images.flip.copy())

    def discard(self) -> np.ndarray:
        """Mark the stored forces as forces of an earlier step: from then on only `pressed` uses them, and `power` is 0
        until the next call of `store`. Return the indices of the points that had forces."""
        listed = self._before = self._listed
        self._pressed = self._force
        self.store(self._listed[:0], self._force[:0])
        return listed

    def pressed(self, overlap: Overlap) -> np.ndarray:
        """Return the implicit normal forces of the previous step on the points of an overlap [N], shape (n,), positive for
        pressure; 0 for points without a stored force.

        The stored forces are friction minus normal force (see `find_point_forces`); this function reverses the sign.
        """
        listed = overlap.listed
        if not len(self._before):
            return np.zeros(len(listed))
        at = np.minimum(np.searchsorted(self._before, listed), len(self._before) - 1)
        press = -np.einsum("ij,ij->i", self._pressed[at], overlap.normal)
        return np.where(self._before[at] == listed, np.maximum(press, 0.0), 0.0)

    def power(self, velocity: np.ndarray, of_other: np.ndarray) -> float:
        """Return the power of the stored forces [W] at the given velocities of the points relative to their feet.

        velocity: velocities of the points of the surface [m/s]. of_other: velocities of the points of the other surface,
        shape (q, 3), or the velocity of a wall, shape (3,), if there are no feet [m/s].
        """
        if not len(self._listed):
            return 0.0
        of_other = of_other if self._feet is None else self._feet.gather(of_other, self._images)
        return float(np.sum(self._force * (velocity[self._listed] - of_other)))

    def state_numbers(self) -> list[object]:
        """Return the stored forces, their points and their feet, for a checkpoint."""
        feet = None if self._feet is None else [part.tolist() for part in self._feet]
        return [self._listed.tolist(), self._force.tolist(), feet, [part.tolist() for part in self._images]]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore the forces, the result of `state_numbers`, from a checkpoint."""
        listed, force, feet, (point, flip) = numbers
        self._listed, self._force = np.array(listed, np.int64), np.reshape(np.array(force, float), (-1, 3))
        self._feet = None
        if feet is not None:
            self._feet = Feet(np.array(feet[0], np.int64), np.array(feet[1], np.int64), np.array(feet[2], float))
        self._images = Images(np.array(point, np.int64), np.reshape(np.array(flip, float), (-1, 3)))


class ContactSide(ABC):
    """Points of a surface that may lie inside another surface or behind a wall.

    Attributes
    ----------
    one, other : ContactSurface
        Surface of the points, and the other surface; None for a wall.
    start : StartOverlap
        Initial overlap, which exerts no pressure; None between bodies that do not deform.
    share : float
        Fraction of the contact stiffness that this side has.
    overlap : Overlap
        Overlapping points; None if no point overlaps.
    feet, images : Feet, Images
        Feet of the overlapping points on the other surface, None for a wall, and the images of the other surface.
    pushed : ndarray
        Indices of the points that had forces in the last step, in ascending order.
    lead : ContactLead
        Leads: distances ahead of the surface at which contact acts, which remove the overlap in steady states; None
        on sides without leads.
    lent : float
        Energy that the overlap gained in this step through changes of the leads, divided by the contact stiffness of this
        side [m³].
    """

    def __init__(self, one: ContactSurface, other: ContactSurface | None, start: StartOverlap | None, share: float) -> None:
        self.one, self.other, self.start, self.share = one, other, start, share
        self.overlap: Overlap | None = None
        self.feet: Feet | None = None
        self.images = NO_IMAGES
        self.lead: ContactLead | None = None
        self.lent, self.pushed, self.given = 0.0, np.zeros(0, np.int64), PreviousForces()

    @abstractmethod
    def find(self, described: Mapping[int, Described], step: float, ahead: bool) -> Overlap | None:
        """Return the overlapping points; None if no point overlaps.

        described: points and images of each surface, by the `id` of the surface. step: length of this step or of the previous
        step, whichever is longer [s]. ahead: True to include also points that would enter within the next steps and points that
        had forces in the previous step.
        """

    @property
    @abstractmethod
    def other_velocity(self) -> np.ndarray:
        """Velocities of the points of the other surface, shape (q, 3), or of the wall, shape (3,) [m/s]."""

    def remove_overlap(self) -> None:
        """Add a contact lead (see `pellucid.contact.steady_contact`) to this side, which removes the overlap in steady
        states."""
        self.lead, self.share = ContactLead(self.one), 1.0

    def apply(self, overlap: Overlap, force: np.ndarray, forces: Mapping[int, np.ndarray]) -> None:
        """Add the forces on the overlapping points [N], shape (n, 3), to the force array of their surface, and the opposite
        forces to the force array of the other surface. forces: force arrays of the surfaces, by the `id` of the surface."""
        forces[id(self.one)][overlap.listed] += force
        if self.other is not None and self.feet is not None:
            self.feet.spread(-force, forces[id(self.other)])


class PointContact(Touch):
    """Contact of the points of surfaces with other surfaces or a wall; forces follow from an `OverlapLaw`.

    sides: for each surface that searches, its points and the surface or wall in contact. surfaces, law, name: see `Touch`.
    """

    def __init__(
        self, surfaces: Sequence[ContactSurface], law: OverlapLaw, sides: Sequence[ContactSide], name: str | None
    ) -> None:
        super().__init__(surfaces, law, name)
        self.sides = list(sides)
        self._described: Mapping[int, Described] = {}

    def find(self, described: dict[int, Described]) -> bool:
        self._described = described
        self.impulse, self.before, self.law.lent = np.zeros(3), 0.0, 0.0
        for side in self.sides:
            self.before += side.given.power(side.one.velocity, side.other_velocity)
            side.pushed, side.lent = side.given.discard(), 0.0
            side.overlap = side.find(described, self.step, self.law.is_implicit)
            self.law.lent += side.share * self.law.stiffness * side.lent
        return any(side.overlap is not None for side in self.sides)

    def overlaps(self) -> list[Overlap]:
        return [side.overlap for side in self.sides if side.overlap is not None]

    def start_overlaps(self) -> list[StartOverlap]:
        return [side.start for side in self.sides if side.start is not None]

    def previous_forces(self) -> list[PreviousForces]:
        return [side.given for side in self.sides]

    def leads(self) -> list[ContactLead]:
        return [side.lead for side in self.sides if side.lead is not None]

    def begin_steady(self) -> None:
        super().begin_steady()
        self.law.is_implicit = False  # leads remove the overlap

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        touching = [(side, side.overlap) for side in self.sides if side.overlap is not None]
        overlaps = [overlap for _, overlap in touching]
        implicit: list[Implicit] = []
        if self.law.is_implicit:
            k = self.law.normal_stiffness
            blocks = [
                Block(overlap, k(overlap), side.given.pressed(overlap), side.other, side.images, side.feet)
                for side, overlap in touching
            ]
            implicit = NormalForces(blocks, dt, self._described, forces).solve()
        found = self.law.forces(overlaps, dt, last, touched, self.before, implicit)
        if self.law.counts_both_ends:
            for (side, overlap), given in zip(touching, self.law.given, strict=True):
                side.given.store(overlap.listed, given, side.feet, side.images)
        for (side, overlap), force in zip(touching, found, strict=True):
            side.apply(overlap, force, forces)
            self.impulse += (1.0 if side.one is self.surfaces[0] else -1.0) * dt * force.sum(axis=0)
