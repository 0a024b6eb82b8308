"""Base class of contacts between surfaces and of surfaces with walls, and the removal of the overlap of the contact springs in
steady states.

Contact springs exert pressure in proportion to the overlap. In an equilibrium the overlap remains as an error of the order
of the pressure over the stiffness of a surface layer, and depends on the step size. In steady states, each corner of a
surface therefore has a lead, i.e. a distance at which contact acts ahead of the surface. Near equilibrium, the leads grow
by the mean overlap around the corner and decrease where there is a gap, until the mean overlap vanishes wherever there is
pressure. Leads are the multipliers of an augmented Lagrangian divided by the stiffness (Simo & Laursen 1992, Comput.
Struct. 42, 97), one for each corner: one for each contact point would give more conditions than the corners can satisfy.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Described
from pellucid.contact.overlap import Overlap, OverlapLaw, StartOverlap

if TYPE_CHECKING:
    from pellucid.contact.contact_side import PreviousForces
    from pellucid.parts.elastic_system import ContactSprings


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
            self._changes = [] if grew else [*self._changes[1 - EXTRAPOLATED :], (result - former_result, step - former)]
            if (step == former).all():
                self._changes = []
        self._last = result, step
        if not self._changes:
            return result
        change = [of_step for _, of_step in self._changes]
        matrix = np.array([[float(np.sum(one * other)) for other in change] for one in change])
        matrix[np.diag_indices(len(change))] += 1e-8 * np.trace(matrix)  # steps may be nearly parallel
        shares = np.linalg.solve(matrix, np.array([float(np.sum(one * step)) for one in change]))
        return result - sum(share * of_result for share, (of_result, _) in zip(shares, self._changes, strict=True))


class OverlappingStart(NamedTuple):
    """An overlap at the start of a run between two bodies, a body and a wall, or parts of one body: names, depth and
    contact distance [m], and the message for the user."""

    between: tuple[str, ...]
    """Names of both, each with its kind ("body", "wall"); a single name for parts of one body."""
    depth: float
    """Largest depth of the overlap [m]."""
    distance: float
    """Distance between the given surfaces at which contact acts: the sum of both contact offsets [m]."""

    @property
    def text(self) -> str:
        """Message about the overlap for the user."""
        depth = f"{self.depth:.4g} m"
        if len(self.between) == 1:
            return (
                f"parts of {self.between[0]} start up to {depth} closer to each other than twice the contact offset, "
                f"{self.distance:.4g} m (`contact_offset`, default: half of the thickness): this overlap exerts no "
                "force on a point until the point has separated once. To have contact act from the start, move the parts "
                f"away from each other by {depth}, or set a smaller `contact_offset`."
            )
        one, other = self.between
        if self.distance > 0.0:
            limit = f"{self.distance:.4g} m (`contact_offset` of each membrane, default: half of the thickness)"
            where = f"start {depth} closer to each other than the contact distance of {limit}"
            remedy = f"move one of the two away by {depth}"
            if self.depth < self.distance:
                remedy += ", or set a smaller `contact_offset`"
        else:
            where, remedy = f"overlap by {depth} at the start", f"move one of the two away by {depth}"
        return (
            f"{one} and {other} {where}: this overlap exerts no force until they have separated once, so contact starts "
            f"{depth} late. To have contact act from the start, {remedy}."
        )

    def facts(self) -> dict[str, Any]:
        """Return the data of the overlap for the summary of the run, by name."""
        return {"between": list(self.between), "depth": self.depth, "distance": self.distance}


class Touch(ABC):
    """Base class of a contact of a body with another body or a wall, for `SurfacePairs`. `impulse`: impulse on the first
    surface in this step [N s], shape (3,).

    surfaces: the surface or the two surfaces in contact. law: force law of their overlap. name: name of the contact force
    for probes; None if no probe reads this force.
    """

    def __init__(self, surfaces: Sequence[ContactSurface], law: OverlapLaw, name: str | None) -> None:
        self.surfaces, self.name = surfaces, name
        self.law = law
        self.impulse = np.zeros(3)
        self.step = 0.0
        """Length of this step or of the previous step, whichever is longer [s]."""
        self.before = 0.0
        """Power of the damper and friction forces of the last step at the current velocities [W]."""

    is_last = False
    """True if this contact applies its forces after all others, when the bodies have received the other forces."""

    @property
    def between(self) -> tuple[str, ...]:
        """Labels of the bodies in contact, for messages."""
        return tuple(f"body {surface.body}" for surface in self.surfaces)

    @property
    def distance(self) -> float:
        """Distance between the points of both surfaces at which contact begins [m]."""
        return sum(float(np.max(surface.half_width, initial=0.0)) for surface in self.surfaces)

    def begin(self, time: float, rate: float) -> None:  # noqa: B027
        """Prepare the contact for a step: a wall moves to its position.

        time: load time at the start of the step [s]. rate: increment of the load time per increment of the step time.
        """

    def follow(self, last: float) -> None:  # noqa: B027
        """Account for the motion of the surfaces in the previous step of length `last` [s], before the overlap is searched."""

    @abstractmethod
    def find(self, described: dict[int, Described]) -> bool:
        """Find the points of the surfaces that overlap; return True if there are any.

        described: points and images of each surface, by the `id` of the surface.
        """

    def way(self) -> np.ndarray:
        """Return the mean normal of the overlap, along which this contact pushes a rigid body, as a unit vector, shape
        (3,); the sign of the vector has no meaning. Zero if this contact pushes no rigid body."""
        return np.zeros(3)

    def overlaps(self) -> list[Overlap]:
        """Return the overlaps found in this step; empty for contact between triangulated surfaces, which has no lists of
        points."""
        return []

    def start_overlaps(self) -> list[StartOverlap]:
        """Return the initial overlaps of all sides of the contact; they exert no pressure."""
        return []

    def previous_forces(self) -> "list[PreviousForces]":
        """Return the stored damper and friction forces of the last step, one entry per side; empty for contact between
        triangulated surfaces, which stores these forces in its slots."""
        return []

    def start_depth(self) -> float:
        """Return the current depth of initial overlap that exerts no pressure [m]."""
        return max((start.depth for start in self.start_overlaps()), default=0.0)

    def begin_steady(self) -> None:
        """Switch to the search for equilibria; see `SurfacePairs.begin_steady`."""
        self.law.is_steady = True
        for start in self.start_overlaps():
            start.begin_steady()

    def reach_equilibrium(self) -> None:
        """Use the current equilibrium as the reference state of friction and initial overlaps."""
        self.law.reach_equilibrium()
        for start in self.start_overlaps():
            start.reach_equilibrium()

    def leads(self) -> list[ContactLead]:
        """Return the contact leads, i.e. distances ahead of the surface at which contact acts, which remove overlaps in
        steady states."""
        return []

    def springs_of(self, surface: ContactSurface) -> "Iterator[ContactSprings]":
        """Yield the springs of the last forces at the points of a surface, for the search for an equilibrium; none for contact
        between triangulated surfaces."""
        return iter(())

    @property
    def stops_apart(self) -> bool:
        """True if each overlapping point has its own damper (see `DeadStop`)."""
        return self.law.stop is not None and all(overlap.apart for overlap in self.overlaps())

    @abstractmethod
    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        """Compute the contact forces of a step dt [s] and add them to `forces` [N].

        last: length of the previous step [s]. forces: force arrays of the surfaces, shape (m, 3), by `id`. touched: masks of
        the points that friction holds, by `id`; points of this contact are marked.
        """

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return the arrays of the contact by name, for a checkpoint; empty if the contact has no arrays."""
        return {}

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the state of the contact from the arrays of a checkpoint."""
        for name, array in self.state_arrays().items():
            array[...] = arrays[name]

    def warning(self) -> str | None:
        """Return a warning about the contact in its present state; None if there is no warning."""
        return None

    def external_work(self) -> float:
        """Return the work of a moving wall over this step [J]."""
        return 0.0
