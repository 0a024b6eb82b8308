"""The interface of a body to the clock, the balance, contact, conditions and results; `families` has its two families."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from math import fsum
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from pellucid.contact.contact_body import ContactBody
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.faces import Faces
from pellucid.contact.wall import WallPlane
from pellucid.energy import Totals, kinetic_energies
from pellucid.errors import RunStopped, UnknownName
from pellucid.findings import absent
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.face_shares import FaceShares
from pellucid.geometry.region import Selectable
from pellucid.grid.model import GridCase
from pellucid.grid.points import FAULTS, LOST
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.named import Named
from pellucid.parts.relaxable import SLOWER_LOADS
from pellucid.parts.standing import Standing
from pellucid.parts.step_limit import NO_LIMIT, StepLimit
from pellucid.parts.surface_load import Traction


class NodalSupport(NamedTuple):
    """A support on nodes of a body that has its own."""

    nodes: np.ndarray  # (n,) whether it constrains a node
    axes: tuple[bool, bool, bool]  # constrained directions
    velocity: tuple[float, float, float]  # [m/s]
    wall: tuple[int, int] | None  # axis and end (0 lower, 1 upper) of the face of the grid that it makes a wall
    label: str = "a support"  # for messages
    friction: float = 0.0  # coefficient of the wall


class Placement(NamedTuple):
    """With what a body is built; without a grid in the case there is no velocity field either."""

    grid_case: GridCase | None
    velocity_field: VelocityField | None
    velocity_transfer: VelocityTransfer
    gravity: tuple[float, float, float]  # [m/s²], which a body with its own nodes applies itself
    n_loads: int  # channels of external forces

    def on_grid(self) -> tuple[GridCase, VelocityField]:
        """Grid and velocity field of a body that needs them; its model checks that they are there."""
        if self.grid_case is None or self.velocity_field is None:
            raise ValueError("this body needs a grid, and the case has none")
        return self.grid_case, self.velocity_field


class PointConstraint(Protocol):
    """What leads the points of a body as a whole, such as a prescribed motion: it changes what grid-to-particle gave them."""

    strains: bool
    """Whether the points are strained by the grid; not where the body is rigid, and the constraint gives all positions."""
    top_speed: float
    """Largest prescribed velocity along an axis [m/s]."""

    def prescribe_velocities(self) -> None:
        """After grid-to-particle, and before their sums are taken: the velocities of the points."""

    def prescribe_positions(self) -> None:
        """After the points moved: their positions."""


@runtime_checkable
class RepeatedConstraint(PointConstraint, Protocol):
    """A constraint that can lead the points once more in a step, after the second impulses of contact."""

    def prescribe_velocities_again(self) -> None:
        """The same, in addition, when the fields' `external.impulse` has these impulses alone."""


class AnswersContact(Protocol):
    """What moves the nodes that a body reaches otherwise than by their own masses."""

    def answer_contact(self) -> bool:
        """See `Body.answer_contact`."""

    def end_contact(self) -> None:
        """See `Body.end_contact`."""


def in_metres(place: np.ndarray) -> str:
    """A place [m] as errors tell it."""
    return f"({', '.join(f'{value:.6g}' for value in place.tolist())}) m"


class Body(ABC):
    """A body of a simulation, of either family."""

    name: str
    energy_kind: str
    """What it stores: "internal" or "strain" energy."""
    totals: Totals
    """Sums over the body at the end of the step, and its largest stable step."""
    asks_for_loads = False
    """Whether it asks for loads on its surface itself, at the instants that it needs within a step: see `add_traction`."""
    is_surface = False
    """Whether it is a membrane, which has two sides."""
    areal_density = 0.0
    """Of a membrane at rest [kg/m²]."""
    arrays: dict[str, np.ndarray]
    """State of its points or nodes, first axis n; `id` is their number in the order of seeding or of the mesh."""
    element_arrays: Mapping[str, np.ndarray] = {}
    """State of its elements, in the order of the mesh; most bodies have none."""
    constraint: PointConstraint | None = None
    _leads_again: RepeatedConstraint | None = None
    answers: AnswersContact | None = None
    relaxes = False
    """Whether it is being brought to rest in equilibrium."""

    @property
    def n_points(self) -> int:
        """Number of points or nodes."""
        return len(self.arrays["mass"])

    @property
    def n_stress_points(self) -> int:
        """Number of points at which it finds stresses: what its kernels work on."""
        return self.n_points

    @property
    def mass(self) -> float:
        """Mass [kg], the same to the last bit in whatever order the points are stored."""
        return fsum(self.arrays["mass"])

    def order(self) -> np.ndarray | slice:
        """Where the points that have not left are stored, in the order of their numbers, which is that of mesh, surface or
        seeding: all that users' code sees of points is in this order."""
        return np.argsort(self.arrays["id"])

    def volumes(self) -> np.ndarray:
        """Volumes of the points [m³], shape (n,), in the order in which they are stored."""
        return self.arrays["volume"]

    # the step

    def step_limit(self) -> StepLimit:
        """The largest stable step of the state as it is, that of its totals, and why."""
        if self.totals.rate <= 0.0:
            return NO_LIMIT
        return StepLimit(1.0 / self.totals.rate, "wave", "its fastest signal")

    def fastest(self) -> float:
        """The largest speed of its points or nodes [m/s]."""
        velocity = self.arrays["velocity"]
        return float(np.sqrt(np.max(np.sum(velocity * velocity, axis=1), initial=0.0)))

    load_rate = 1.0
    """How fast the loads change over the coming step, in simulated time over that of the step: another in steady states."""

    def begin(self, dt: float) -> None:  # noqa: B027
        """Before the conditions of a step dt [s]: forget the external forces of the last one, if the body keeps them."""

    def damp(self, rate: float, dt: float) -> tuple[float, np.ndarray]:
        """Let a drag act over this step dt [s], at a rate [1/s].

        Returns what it took that the body does not count itself: energy [J] and impulse on the body [N s], shape (3,).
        """
        raise ValueError(f"body {self.name} has no inertia to damp")

    def come_to_rest(self) -> None:
        """Take all velocity from its points or nodes."""
        for name in ("velocity", "affine"):
            if name in self.arrays:
                self.arrays[name].fill(0.0)
        totals = self.totals
        totals.kinetic = totals.affine = totals.half_power = totals.momentum_size = 0.0
        totals.momentum = np.zeros(3)

    @abstractmethod
    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the point, where something impossible was found in this step."""

    def state_warning(self) -> str | None:
        """A warning about the state that it has come to, looked for now and then; most bodies have none."""
        return None

    # conditions

    @abstractmethod
    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the points [N], shape (n, 3), in the order in which they are stored, over this step.

        column: that of their channel in a row of works, see `pellucid.energy`.
        """

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add the forces of a pressure [Pa] along the normals of a membrane over this step; other bodies have none."""
        raise ValueError(f"body {self.name} is no membrane: it has no normal to push along")

    def add_traction(self, traction: Traction, column: int, label: str) -> None:
        """Add forces on the surface of a fluid film over this step, which asks for them itself; other bodies have none.

        label: what users know it by.
        """
        raise ValueError(f"body {self.name} does not ask for loads on its surface")

    @abstractmethod
    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """Let supports constrain its own nodes."""

    @abstractmethod
    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Let own nodes follow prescribed motions, which its model may refuse before (`why_no_motion`).

        numbers, shape (n,): 1 + that of a point's motion, else 0; axes, shape (motions, 3): 1 where a motion prescribes it.
        """

    def constrain(self, constraint: PointConstraint, answers: AnswersContact | None = None) -> None:
        """Let a condition lead its points, and answer contact if it does. Raises ValueError where another one does."""
        if self.constraint is not None:
            raise ValueError(f"the points of body {self.name} are led by a condition already")
        self.constraint, self.answers = constraint, answers
        self._leads_again = constraint if isinstance(constraint, RepeatedConstraint) else None

    @abstractmethod
    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""

    def lead_along_normal(self, names: Sequence[str], numbers: np.ndarray) -> None:
        """Let nodes of a fluid film follow prescribed motions along its normal; the model of other bodies refuses them.

        numbers, shape (n,): 1 + that of a node's motion, else 0.
        """
        raise ValueError(f"the nodes of body {self.name} follow no motion along a normal")

    def set_normal_velocities(self, rates: np.ndarray) -> None:
        """The velocities of these motions over this step [m/s], shape (motions,)."""
        raise ValueError(f"the nodes of body {self.name} follow no motion along a normal")

    @property
    def node_sets(self) -> Mapping[str, np.ndarray]:
        """The sets of nodes that its mesh names, by the numbers of the nodes; most bodies have none."""
        return {}

    def selectable(self) -> Selectable:
        """What regions of conditions choose from, in the order in which the points are stored: asked for at the start."""
        place = np.argsort(self.arrays["id"])
        faces, position = place[self.cells().surface()], self.arrays["position"]
        if self.is_surface:
            return Selectable.of_membrane(position, faces)
        sets = {name: place[nodes] for name, nodes in self.node_sets.items()}
        return Selectable(position, faces, np.unique(faces), sets)

    def face_shares(self, faces: np.ndarray) -> FaceShares:
        """How what acts on triangles of its surface, shape (f, 3), of those that are selectable, goes to its nodes.

        It is asked for when all conditions are known: its functions may depend on them.
        """
        return FaceShares.linear(faces)

    def complete(self) -> None:
        """All conditions are known: called once, before the first step. What depends on them is made now."""
        if self.constraint is not None:
            self.renew_totals()  # what bounds the step of a body may have changed

    @abstractmethod
    def renew_totals(self) -> None:
        """Find the totals of the state as it is, after conditions changed what bounds the step."""

    # checkpoint

    @abstractmethod
    def state_arrays(self) -> dict[str, np.ndarray]:
        """Every array that the next step depends on, by name."""

    @abstractmethod
    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from such arrays, bit for bit."""

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Begin, before conditions act on it, with the arrays that such a body had in an earlier run, in the order of the
        numbers of its points. Raises KeyError naming the array without which it cannot."""
        for name in self.arrays.keys() - {"id"}:
            self.arrays[name][...] = state[name][self.arrays["id"]]
        self.renew_totals()

    # contact

    @property
    def on_grid(self) -> ContactBody | None:
        """Its points on the grid, where others may touch it; nothing where it was given none."""
        return None

    def make_contact_surface(self, column: int) -> ContactSurface | None:
        """Make the surface by which others touch it, whose forces do work in this column; None where it has none."""
        return None

    def make_points_at(self, plane: WallPlane, column: int) -> ContactSurface | None:
        """Make what a wall touches of a body without a surface, its points beside a plane; None where it touches none."""
        return None

    def bound_by_contact(self, touching: Sequence[ContactSurface]) -> None:  # noqa: B027
        """All surfaces that touch are known: leave its own where it touches nothing; bound the first step by how fast the body
        swings on others."""

    @property
    def met(self) -> ContactBody | None:
        """What others meet of it by contact: itself, or its surface."""
        return self.on_grid

    def vector_areas(self) -> np.ndarray:
        """Of a membrane, the share of its vector area of each point [m²], shape (n, 3); of a volume none, shape (0, 3)."""
        return np.zeros((0, 3))

    def pressed_areas(self) -> np.ndarray:
        """Of a membrane, the vector areas by which a pressure pushes its points [m²], shape (n, 3), in the order of their
        numbers; in plane problems those of the slice."""
        return self.vector_areas()[self.order()]

    def surface_areas(self) -> np.ndarray:
        """Of a membrane, the shares of its points in its area [m²], shape (n,), in the same order."""
        return np.asarray(np.linalg.norm(self.pressed_areas(), axis=1))

    def faces(self) -> Faces | None:
        """Points on the surface of a volume, where it has such; None of a membrane, all of whose points lie on it."""
        return None

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """A warning about the body where it touches others at these nodes of the grid, shape (n,), or None."""
        return None

    @property
    def takes_second_impulses(self) -> bool:
        """Whether contact may give it impulses again; see `pellucid.contact.contact_body`."""
        return False

    def take_second_impulses(self, dt: float) -> float:
        """Take them; the kinetic energy won [J]."""
        raise ValueError(f"body {self.name} takes no second impulses")

    @property
    def led_again(self) -> bool:
        """Whether what leads its points, if anything, can do so once more in a step."""
        return self.constraint is None or self._leads_again is not None

    def lead_again(self) -> None:
        """Let it do so."""
        if self._leads_again is not None:
            self._leads_again.prescribe_velocities_again()

    def answer_contact(self) -> bool:
        """Let the nodes of the grid have the velocities that contact gave the body so far; False where they have these."""
        return self.answers is not None and self.answers.answer_contact()

    def end_contact(self) -> None:
        """Contact is resolved: make what the nodes of the grid answered theirs, where these move the points."""
        if self.answers is not None:
            self.answers.end_contact()

    # results

    @property
    @abstractmethod
    def field_names(self) -> list[str]:
        """The fields that results show: `id`, `position`, `velocity`, `mass`, `density`, `stress` and more of its own."""

    constant_fields: Sequence[str] = ("id", "mass")
    """Of these fields those that never change."""

    @abstractmethod
    def field(self, name: str) -> np.ndarray:
        """A field of the points that have not left, in the order of their numbers; units in `pellucid.state.FIELDS`. Raises
        `UnknownName`, see `no_field`."""

    def stored_field(self, name: str) -> np.ndarray:
        """The same in the order in which the points are stored at the moment."""
        return self.field(name)

    def no_field(self, name: str) -> UnknownName:
        """The error that it has no such field."""
        return UnknownName(absent(f"body {self.name} has no field", name, self.field_names))

    def cells(self) -> Cells:
        """Cells that results draw, by the numbers of the points in `frame`; of most bodies the points themselves."""
        return Cells.of_points(self.n_points)

    def places(self) -> np.ndarray:
        """Positions in the order of `frame` [m], shape (n, 3)."""
        return np.asarray(self.arrays["position"][np.argsort(self.arrays["id"])])

    def standing(self, goes_on: bool) -> Standing:
        """Where it stands, with the volumes of its points where it begins in the state of an earlier run."""
        if self.is_surface:
            return Standing(self.places(), self.cells().surface())
        return Standing(self.arrays["position"], volume=self.volumes() if goes_on else None)

    def frame(self) -> dict[str, np.ndarray]:
        """The fields of all points in the order of their numbers; units in `pellucid.state.FIELDS`."""
        return Named(f"body {self.name} has no field", {name: np.array(self.field(name)) for name in self.field_names})

    def facts(self) -> Mapping[str, float]:
        """Numbers about its state by name, which the summary of a run shows, in SI units."""
        return {}

    def kinetic_energies(self) -> np.ndarray:
        """Of each point [J], shape (n,)."""
        return kinetic_energies(self.arrays["mass"], self.arrays["velocity"])

    @property
    def may_leave(self) -> bool:
        """Whether its points could leave through faces of the grid."""
        return False

    def whereabouts(self, p: int) -> str:
        """Where point p is, for an error."""
        return f"at {in_metres(self.arrays['position'][p])}"

    def stop(self, code: int, p: int, n_steps: int, time: float) -> None:
        """Raise `RunStopped` for a fault (of `pellucid.grid.points`) at point p."""
        state = {name: array[p].tolist() for name, array in self.arrays.items()}
        fault = FAULTS[int(code)]
        leave = ", or let it leave through an [[outflow]]" if code == LOST and self.may_leave else ""
        raise RunStopped(
            f"step {n_steps}, time {time:.6g} s: point {state['id']} of body `{self.name}` {self.whereabouts(p)}: "
            f"{fault.meaning}; {SLOWER_LOADS if self.relaxes else fault.remedy + leave}",
            step=n_steps,
            time=time,
            body=self.name,
            point=state["id"],
            state=state,
        )
