"""Contact leads: distances ahead of a surface at which contact acts, which remove the overlap of the contact springs in steady
states.

Contact springs exert pressure in proportion to the overlap. In an equilibrium the overlap remains as an error of the order
of the pressure over the stiffness of a surface layer, and depends on the step size. In steady states, each corner of a
surface therefore has a lead. Near equilibrium, the leads grow by the mean overlap around the corner and decrease where there
is a gap, until the mean overlap vanishes wherever there is pressure. Leads are the multipliers of an augmented Lagrangian
divided by the stiffness (Simo & Laursen 1992, Comput. Struct. 42, 97), one for each corner: one for each contact point would
give more conditions than the corners can satisfy.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface

EXTRAPOLATED = 3  # changes of leads in an extrapolation


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
        self.pressed, self.moments = 0.0, np.zeros(2)
        """Sum of the leads, weighted with the areas around the corners [m³], and sums of mean overlaps and leads, weighted with
        leads and areas [m⁴], before the last update."""
        self._extrapolation: Extrapolation | None = None

    def extrapolate(self, extrapolates: bool) -> None:
        """Extrapolate the coming updates of the leads, each of which a search for an equilibrium follows, or stop it."""
        self._extrapolation = Extrapolation() if extrapolates else None

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
        pressed = self._corners * weight
        self.moments = np.array([np.sum(pressed * np.abs(np.where(weight > 0.0, mean, 0.0))), np.sum(pressed * self._corners)])
        self.pressed = float(np.sum(pressed))
        if self._extrapolation is not None:
            new = np.maximum(self._extrapolation.next(self._corners, new), 0.0)
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


class Extrapolation:
    """Extrapolation of a fixed-point iteration from its last steps (Anderson 1965, J. ACM 12, 547), which starts again where
    the steps grow."""

    def __init__(self) -> None:
        self._last: tuple[np.ndarray, np.ndarray] | None = None  # values and their step, of the last call
        self._changes: list[tuple[np.ndarray, np.ndarray]] = []  # of results and steps, between successive calls

    def next(self, values: np.ndarray, result: np.ndarray) -> np.ndarray:
        """Return better values than the result of the iteration at `values`, shape (n,) each."""
        step = result - values
        if self._last is not None:
            former_result, former = self._last
            grew = float(np.sum(step * step)) > float(np.sum(former * former))
            stays = bool((step == former).all())
            last = result - former_result, step - former
            self._changes = [] if grew or stays else [*self._changes[1 - EXTRAPOLATED :], last]
        self._last = result, step
        if not self._changes:
            return result
        change = [of_step for _, of_step in self._changes]
        matrix = np.array([[float(np.sum(one * other)) for other in change] for one in change])
        matrix[np.diag_indices(len(change))] += 1e-8 * np.trace(matrix)  # steps may be nearly parallel
        shares = np.linalg.solve(matrix, np.array([float(np.sum(one * step)) for one in change]))
        return result - sum(share * of_result for share, (of_result, _) in zip(shares, self._changes, strict=True))
