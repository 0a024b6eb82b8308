"""Contact forces at trial positions of an equilibrium, for the geometry of contact at one of them.

Detection finds, for each point near another surface, its depth, normal, area and foot. With these kept, the depth is linear in
the displacements of the points, and the forces derive from a convex energy apart from friction: the search for an equilibrium
then converges quickly. With detection at every trial, forces would jump wherever a point passes an edge of the other surface.
Detection is repeated when the equilibrium for the kept geometry is found, together with the update of the contact leads.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Feet, Images
from pellucid.contact.leads import ContactLead
from pellucid.contact.overlap import Overlap


class ContactSprings(NamedTuple):
    """Springs of contact at k points of a body with n nodes, which resist displacements of these points."""

    shares: sparse.csr_array  # (k, n) weights of the nodes in the displacements of the points
    normal: np.ndarray  # (k, 3) unit normals of contact
    across: np.ndarray  # (k,) stiffness along the normals [N/m]
    along: np.ndarray  # (k,) stiffness along the surface [N/m]: 0 for points that slide


class Pressed(NamedTuple):
    """Forces at the n points of a `FrozenSide`."""

    depth: np.ndarray  # (n,) depths with the contact leads [m], negative across a gap
    press: np.ndarray  # (n,) normal forces [N]
    drag: np.ndarray  # (n, 3) friction forces [N]
    sticks: np.ndarray  # (n,) mask of the points that do not slide


TOUCHING = 1e-3  # gap, relative to the reach of a point, below which the point counts as touching for the stiffness


class Beneath(NamedTuple):
    """Feet of points on another surface."""

    surface: ContactSurface
    feet: Feet
    images: Images  # of the other surface


class FrozenSide:
    """Points of a surface near another surface or a wall, with their depths and normals at the time of detection.

    one: surface of the points; overlap: points that were found, also those across a gap; beneath: their feet on the other
    surface, None for a wall; stiffness: stiffness of the contact springs [Pa/m]; friction: coefficient of friction; lead:
    contact leads of the points; slip: displacements of the points of the surface from their sticking positions at the last
    equilibrium [m]; dt: step of the time of the loads since then [s], to which velocities refer.
    """

    def __init__(
        self,
        one: ContactSurface,
        overlap: Overlap,
        beneath: Beneath | None,
        stiffness: float,
        friction: float,
        lead: ContactLead | None,
        slip: np.ndarray,
        dt: float,
    ) -> None:
        self._one, self._listed, self._normal, self._friction = one, overlap.listed, overlap.normal.copy(), friction
        self._beneath = beneath
        if beneath is not None:  # detection uses its arrays again
            feet, images = Feet(*(part.copy() for part in beneath.feet)), Images(*(part.copy() for part in beneath.images))
            self._beneath = Beneath(beneath.surface, feet, images)
        self.weight = 1.0
        """Weight of this geometry in the mean with others."""
        self._lead = lead
        self._depth = overlap.depth - (0.0 if lead is None else lead.points[self._listed])
        self._stiffness = stiffness * overlap.share * overlap.area
        self._carried = self._along(slip[self._listed] + dt * overlap.relative)
        self._place, self._beside = one.place.copy(), None if beneath is None else beneath.surface.place.copy()
        self.last = self._press(np.zeros_like(self._normal))

    def _along(self, vectors: np.ndarray) -> np.ndarray:
        """Return the parts of vectors, shape (n, 3), along the surface."""
        return vectors - np.sum(vectors * self._normal, axis=1)[:, None] * self._normal

    def _moved(self) -> np.ndarray:
        """Return the displacements of the points relative to their feet since the detection [m], shape (n, 3)."""
        moved = (self._one.place - self._place)[self._listed]
        if self._beneath is not None and self._beside is not None:
            surface, feet, images = self._beneath
            moved = moved - feet.gather(surface.place - self._beside, images)
        return np.asarray(moved)

    def _press(self, moved: np.ndarray) -> Pressed:
        spring, depth = self.weight * self._stiffness, self._depth - np.sum(moved * self._normal, axis=1)
        if self._lead is not None:
            depth = depth + self._lead.points[self._listed]
        press = spring * np.maximum(depth, 0.0)
        carried = self._carried + self._along(moved)
        pull, most = -spring[:, None] * carried, self._friction * press
        size = np.sqrt(np.sum(pull * pull, axis=1))
        sticks = size <= most
        drag = np.where(sticks, 1.0, most / np.where(size > 0.0, size, 1.0))[:, None] * pull
        return Pressed(depth, press, drag, sticks & (self._friction > 0.0))

    def exert(self, forces: Mapping[int, np.ndarray], of: ContactSurface) -> np.ndarray:
        """Add the forces at the present places of both surfaces to `forces`, forces on their points and images [N], shape (m,
        3), by the `id` of the surface. Returns the sum of those on the surface `of` [N], shape (3,)."""
        self.last = self._press(self._moved())
        force = self.last.press[:, None] * self._normal + self.last.drag
        forces[id(self._one)][self._listed] += force
        if self._beneath is not None:
            self._beneath.feet.spread(-force, forces[id(self._beneath.surface)])
        return np.asarray((1.0 if of is self._one else -1.0) * force.sum(axis=0))

    def store_slip(self) -> None:
        """Store the displacements from the sticking positions of the points under pressure in the surface; those of points that
        slide are such that their springs exert the friction force."""
        pressed = (self.last.press > 0.0) & (self._friction > 0.0)
        self._one.slip[self._listed[pressed]] += -self.last.drag[pressed] / self._stiffness[pressed, None]

    def touches(self, surface: ContactSurface) -> bool:
        """Return True if the points are those of a surface or touch it."""
        return self._one is surface or (self._beneath is not None and self._beneath.surface is surface)

    def springs_of(self, surface: ContactSurface) -> ContactSprings | None:
        """Return the springs of the last forces on a surface: at the points if it is theirs, at their feet if it is the other
        one; None for any other surface."""
        pressed = np.flatnonzero(self.last.depth >= -TOUCHING * self._one.reach[self._listed])
        across = self.weight * self._stiffness[pressed]
        # points without pressure may stick as soon as they are pressed
        holds = self.last.sticks | ((self._friction > 0.0) & (self.last.press == 0.0))
        along = np.where(holds[pressed], across, 0.0)
        if surface is self._one:
            shares = surface.node_shares()[self._listed[pressed]]
        elif self._beneath is not None and surface is self._beneath.surface:
            shares = (self._beneath.feet.shares(len(surface.place), self._beneath.images) @ surface.node_shares())[pressed]
        else:
            return None
        return ContactSprings(sparse.csr_array(shares), self._normal[pressed], across, along)
