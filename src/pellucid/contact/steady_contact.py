"""Contact in steady states: the overlap that its springs need is removed.

Springs of contact push by the overlap, which in an equilibrium is left as an error: in the order of the pressure over the
stiffness of a layer of the surface, and other with another step. In steady states each corner of a surface therefore has a
lead, a distance by which contact acts ahead of the surface. Leads grow by the mean overlap about the corner where the bodies
are near equilibrium, and decrease where there is a gap, until the mean overlap vanishes wherever there is pressure. These are
the multipliers of an augmented Lagrangian over the stiffness (Simo & Laursen 1992, Comput. Struct. 42, 97), one for each
corner: with one for each contact point there would be more conditions than the corners can satisfy.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface


class ContactLead:
    """The lead of the contact points of a surface that deforms [m].

    surface: whose points these are; its `corner_shares` are the shares of the corners in them.
    """

    def __init__(self, surface: ContactSurface) -> None:
        shares = surface.corner_shares()
        self._shares = sparse.eye_array(len(surface.place), format="csr") if shares is None else shares
        self._to_corners = sparse.csr_array(self._shares.T)
        self._corners = np.zeros(self._shares.shape[1])
        self.points = np.zeros(self._shares.shape[0])
        """Lead of each point [m], shape (m,)."""
        self.is_due = False
        """Whether leads are renewed when overlaps are found next."""
        self.change = 0.0
        """Largest change when they were renewed last [m]."""

    @property
    def largest(self) -> float:
        """The largest lead [m]."""
        return float(self._corners.max(initial=0.0))

    def applied(self, listed: np.ndarray, depth: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the depths of listed points with their lead [m], and where leads are renewed the energy that overlaps get by
        this over their stiffness [m³]. depth, area: see `renew`."""
        led = depth + self.points[listed]
        if not self.is_due:
            return led, 0.0
        before = float(np.sum(area * np.maximum(led, 0.0) ** 2))
        self.renew(listed, depth, area)
        led = depth + self.points[listed]
        return led, 0.5 * (float(np.sum(area * np.maximum(led, 0.0) ** 2)) - before)

    def renew(self, listed: np.ndarray, depth: np.ndarray, area: np.ndarray) -> None:
        """Renew the leads from the depths without lead of listed points [m], negative across gaps; area: by which these
        count [m²]. Corners without any of these points get no lead."""
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
        """Return the state for a checkpoint."""
        (at,) = np.nonzero(self._corners)
        return [self.is_due, self.change, at.tolist(), self._corners[at].tolist()]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore a checkpoint."""
        self.is_due, self.change, at, lead = numbers
        self._corners.fill(0.0)
        self._corners[np.array(at, np.int64)] = lead
        self.points[:] = np.asarray(self._shares @ self._corners)
