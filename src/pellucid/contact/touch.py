"""Base class of contacts between surfaces and of surfaces with walls."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Described
from pellucid.contact.leads import ContactLead
from pellucid.contact.overlap import Overlap, OverlapLaw, StartOverlap

if TYPE_CHECKING:
    from pellucid.contact.contact_side import PreviousForces
    from pellucid.contact.frozen import FrozenSide


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

    def freeze(self, described: dict[int, Described], slips: Mapping[int, np.ndarray], dt: float) -> "list[FrozenSide]":
        """Detect contact at trial positions of an equilibrium, and return its geometry; empty for contact between triangulated
        surfaces.

        slips: displacements of the points of each surface from their sticking positions at the last equilibrium [m], shape
        (m, 3), by the `id` of the surface; dt: step of the time of the loads since then [s], to which velocities refer.
        """
        return []

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
