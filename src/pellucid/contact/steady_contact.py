"""Contact in steady states: removal of the overlap of the contact springs.

Contact springs exert pressure in proportion to the overlap. In an equilibrium the overlap remains as an error of the order
of the pressure over the stiffness of a surface layer, and depends on the step size. In steady states, each corner of a
surface therefore has a lead, i.e. a distance at which contact acts ahead of the surface. Near equilibrium, the leads grow
by the mean overlap around the corner and decrease where there is a gap, until the mean overlap vanishes wherever there is
pressure. Leads are the multipliers of an augmented Lagrangian divided by the stiffness (Simo & Laursen 1992, Comput.
Struct. 42, 97), one for each corner: one for each contact point would give more conditions than the corners can satisfy.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface


class ContactLead:
    """Contact leads of a deforming surface, one for each corner (mesh vertex): distances ahead of the surface at which
    contact acts [m]. They grow until no overlap remains in a steady state.

    surface: surface of the contact points; its `corner_shares` are the weights of the corners in the position of each
    point.
    """

    def __init__(self, surface: ContactSurface) -> None:
        shares = surface.corner_shares()
        self._shares = sparse.eye_array(len(surface.place), format="csr") if shares is None else shares
        self._to_corners = sparse.csr_array(self._shares.T)
        self._corners = np.zeros(self._shares.shape[1])
        self.points = np.zeros(self._shares.shape[0])
        """Lead of each point [m], shape (m,)."""
        self.is_due = False
        """True if the leads are updated at the next contact detection."""
        self.change = 0.0
        """Largest change of a lead in the last update [m]."""

    @property
    def largest(self) -> float:
        """Largest of the contact leads of all corners [m]."""
        return float(self._corners.max(initial=0.0))

    def applied(self, listed: np.ndarray, depth: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the depths of the listed points including their leads [m], and the energy that the overlap gained by an update
        of the leads, divided by the contact stiffness [m³].

        The leads are updated if `is_due` is set; otherwise this energy is 0. depth, area: see `renew`.
        """
        led = depth + self.points[listed]
        if not self.is_due:
            return led, 0.0
        before = float(np.sum(area * np.maximum(led, 0.0) ** 2))
        self.renew(listed, depth, area)
        led = depth + self.points[listed]
        return led, 0.5 * (float(np.sum(area * np.maximum(led, 0.0) ** 2)) - before)

    def renew(self, listed: np.ndarray, depth: np.ndarray, area: np.ndarray) -> None:
        """Update the leads from the depths of the listed points; the lead of a corner without listed points becomes zero.

        depth: depths without leads [m], negative across gaps. area: weights of the points [m²].
        """
        self.is_due = False
        weight, moment = np.zeros(len(self.points)), np.zeros(len(self.points))
        weight[listed], moment[listed] = area, area * depth
        weight, moment = self._to_corners @ weight, self._to_corners @ moment
        mean = np.where(weight > 0.0, moment / np.where(weight > 0.0, weight, 1.0), -np.inf)
        new = np.maximum(self._corners + mean, 0.0)
        self.change = float(np.abs(new - self._corners).max(initial=0.0))
        self._corners[:] = new
        self.points[:] = self._shares @ new

    def state_numbers(self) -> list[object]:
        """Return the leads of the corners and the state of their update, for a checkpoint."""
        (at,) = np.nonzero(self._corners)
        return [self.is_due, self.change, at.tolist(), self._corners[at].tolist()]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore the leads, the result of `state_numbers`, from a checkpoint."""
        self.is_due, self.change, at, lead = numbers
        self._corners.fill(0.0)
        self._corners[np.array(at, np.int64)] = lead
        self.points[:] = np.asarray(self._shares @ self._corners)
