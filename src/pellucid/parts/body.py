"""Interface of a body to the clock, the energy balance and results, and the surroundings in which it is built: grid, velocity
field and gravity. Optional abilities are defined in `capabilities`."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from math import fsum
from typing import NamedTuple

import numpy as np

from pellucid.contact.contact_body import ContactBody
from pellucid.energy import AngularMomentum, Totals, kinetic_energies
from pellucid.errors import RunStopped, UnknownName
from pellucid.findings import Named, absent
from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.grid.points import FAULTS, LOST, Fault
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.parts.capabilities import SLOWER_LOADS, Membrane, NodalSupport
from pellucid.parts.constraint import ConstrainedPoints
from pellucid.step.limit import NO_LIMIT, StepLimit


class Placement(NamedTuple):
    """Input for building a body from its model (`BodyModel.build`): grid, velocity field and gravity. A case without a grid
    has no velocity field."""

    grid_case: GridCase | None  # table [grid] of the case
    velocity_field: VelocityField | None  # grid nodes that the body shares with other bodies of its field
    velocity_transfer: VelocityTransfer  # transfer of velocities between points and grid, such as FLIP
    gravity: tuple[float, float, float]  # acceleration of gravity [m/s²], applied by bodies with their own nodes
    n_loads: int  # number of channels of external forces

    def on_grid(self) -> tuple[GridCase, VelocityField]:
        """Return the table of the grid and the velocity field for a body that needs both; the model of the body must have
        checked before that the case has a grid."""
        if self.grid_case is None or self.velocity_field is None:
            raise ValueError("this body needs a grid, and the case has none")
        return self.grid_case, self.velocity_field


__all__ = ["Body", "NodalSupport", "Placement", "in_metres"]


def in_metres(place: np.ndarray) -> str:
    """Return a position [m], shape (3,), as text for errors."""
    return f"({', '.join(f'{value:.6g}' for value in place.tolist())}) m"


class Body(ConstrainedPoints, ABC):
    """A body of a simulation, on the grid or with its own nodes."""

    name: str
    energy_kind: str
    """Kind of stored energy: "internal" or "strain"."""
    totals: Totals
    """Sums over the body at the end of the step, and its largest stable time step."""
    arrays: dict[str, np.ndarray]
    """State of the points or nodes, first axis n; `id` is the number of a point in the order of seeding or of the mesh."""
    element_arrays: Mapping[str, np.ndarray] = {}
    """State of the elements, in the order of the mesh; empty for most bodies."""
    relaxes = False
    """True while the body is relaxed to equilibrium."""
    load_rate = 1.0
    """Simulated time per step time over the coming step, which scales the rate of the loads; it differs from 1 in steady
    states."""
    may_leave = False
    """True if points of the body can leave through faces of the grid."""

    @cached_property
    def is_surface(self) -> bool:
        """True if the body is a membrane, which has two sides."""
        return isinstance(self, Membrane)

    @property
    def n_points(self) -> int:
        """Number of material points or nodes."""
        return len(self.arrays["mass"])

    @property
    def n_told(self) -> int:
        """Number of points of the body in messages and summaries: all points, including points that left the grid; if
        points can enter the body, only the points present."""
        return self.n_points

    @property
    def n_stress_points(self) -> int:
        """Number of points at which stresses are computed; the computing time of a step depends on this number."""
        return self.n_points

    @property
    def mass(self) -> float:
        """Mass of the body [kg], independent of the storage order of the points to the last bit."""
        return fsum(self.arrays["mass"])

    def order(self) -> np.ndarray | slice:
        """Return the storage indices of the points that have not left the grid, in the order of their numbers (mesh, surface or
        seeding).

        User code always sees points in this order.
        """
        return np.argsort(self.arrays["id"])

    def stored_array(self, name: str) -> np.ndarray:
        """Return the array with this name for all points that have not left the grid, of all processes, in storage order."""
        return self.arrays[name]

    def volumes(self) -> np.ndarray:
        """Return the current volumes of the points [m³], shape (n,), in storage order."""
        return self.stored_array("volume")

    # the step

    def step_limit(self) -> StepLimit:
        """Return the largest stable time step for the current state, with the reason."""
        if self.totals.rate <= 0.0:
            return NO_LIMIT
        return StepLimit(1.0 / self.totals.rate, "wave", "fastest signal in the body")

    def fastest(self) -> float:
        """Return the largest speed of the points or nodes [m/s]."""
        velocity = self.arrays["velocity"]
        return float(np.sqrt(np.max(np.sum(velocity * velocity, axis=1), initial=0.0)))

    def begin(self, dt: float) -> None:
        """Prepare for the conditions of a step dt [s]: clear the external forces of the previous step, if the body stores
        them."""

    def angular_momentum(self, about: np.ndarray) -> AngularMomentum:
        """Return the angular momentum of the points about a position `about` [m], shape (3,), as a vector of shape (3,) [N m s]
        with the sum of the magnitudes of its contributions."""
        m, velocity = self.stored_field("mass")[:, None], self.stored_field("velocity")
        arm = self.stored_field("position") - about
        size = m[:, 0] * np.sqrt(np.sum(arm * arm, axis=1) * np.sum(velocity * velocity, axis=1))
        return AngularMomentum(np.sum(m * np.cross(arm, velocity), axis=0), float(np.sum(size)))

    def come_to_rest(self) -> None:
        """Set the velocity of all points or nodes to zero."""
        for name in ("velocity", "affine"):
            if name in self.arrays:
                self.arrays[name].fill(0.0)
        totals = self.totals
        totals.kinetic = totals.affine = totals.half_power = totals.momentum_size = 0.0
        totals.momentum = np.zeros(3)

    @abstractmethod
    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the point, if the body found an invalid state in step `n_steps`, which ended at `time`
        [s]."""

    def state_warning(self) -> str | None:
        """Return a warning for the user about the current state, or None; called from time to time."""
        return None

    def complete(self) -> None:
        """Prepare all data that depend on the conditions. Called once, when all conditions are known, before the first step."""
        if self.constraint is not None:
            self.renew_totals()  # the step limit of the body may have changed

    @abstractmethod
    def renew_totals(self) -> None:
        """Compute the totals (sums of mass, momentum and energies, and the step limit) of the current state, after conditions
        changed the step limit."""

    # checkpoint

    @abstractmethod
    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return every array on which the next step depends, by name, for a checkpoint."""

    @abstractmethod
    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the state from arrays of `state_arrays`, bit for bit."""

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Start from the arrays of this body in an earlier run, in the order of point numbers, before conditions act.

        Raises KeyError with the name of a missing array.
        """
        for name in self.arrays.keys() - {"id"}:
            self.arrays[name][...] = state[name][self.arrays["id"]]
        self.renew_totals()

    # contact

    @property
    def on_grid(self) -> ContactBody | None:
        """Interface of the body's points for contact on the nodes of the grid; None without such contact."""
        return None

    @property
    def contact_body(self) -> ContactBody | None:
        """The object that takes part in contact on the nodes of the grid: the body itself, or its surface."""
        return self.on_grid

    # results

    @property
    @abstractmethod
    def field_names(self) -> list[str]:
        """Names of the fields in results: `id`, `position`, `velocity`, `mass`, `density`, `stress` and others."""

    constant_fields: Sequence[str] = ("id", "mass")
    """Names of the fields that never change."""

    @abstractmethod
    def field(self, name: str) -> np.ndarray:
        """Return a field of the points that have not left the grid, in the order of their numbers; units in
        `pellucid.state.FIELDS`.

        Raises `UnknownName`, see `no_field`.
        """

    def stored_field(self, name: str) -> np.ndarray:
        """Return the field with this name for the points that have not left the grid, in storage order; units in
        `pellucid.state.FIELDS`."""
        return self.field(name)

    def no_field(self, name: str) -> UnknownName:
        """Return the error for a field name that the body does not have."""
        return UnknownName(absent(f"body {self.name} has no field", name, self.field_names))

    def cells(self) -> Cells:
        """Return the cells (points, lines, triangles or tetrahedra) that results draw, with the point numbers of `frame`; for
        most bodies only the points."""
        return Cells.of_points(self.n_points)

    def places(self) -> np.ndarray:
        """Return the positions of all points or nodes [m], shape (n, 3), in the order of their numbers."""
        return np.asarray(self.arrays["position"][np.argsort(self.arrays["id"])])

    def frame(self) -> dict[str, np.ndarray]:
        """Return the fields of all points in the order of their numbers, by name; units in `pellucid.state.FIELDS`."""
        return Named(f"body {self.name} has no field", {name: np.array(self.field(name)) for name in self.field_names})

    def facts(self) -> Mapping[str, float]:
        """Return numbers that describe the state of the body for the summary of a run, by name, in SI units."""
        return {}

    def kinetic_energies(self) -> np.ndarray:
        """Return the kinetic energy of each point [J], shape (n,)."""
        return kinetic_energies(self.arrays["mass"], self.arrays["velocity"])

    def whereabouts(self, p: int) -> str:
        """Return the location of the point with the storage index p as text for an error."""
        return f"at {in_metres(self.arrays['position'][p])}"

    def fault(self, code: int, p: int) -> Fault:
        """Return the meaning of a fault code (see `pellucid.grid.points`) for the point with the storage index p, and a
        remedy."""
        return FAULTS[code]

    def stop(self, code: int, p: int, n_steps: int, time: float) -> None:
        """Raise `RunStopped` for a fault code (see `pellucid.grid.points`) of the point with the storage index p, in step
        `n_steps` at the time `time` [s]."""
        state = {name: array[p].tolist() for name, array in self.arrays.items()}
        fault = self.fault(int(code), p)
        leave = ", or let it leave through an [[outflow]]" if fault is FAULTS[LOST] and self.may_leave else ""
        raise RunStopped(
            f"step {n_steps}, time {time:.6g} s: point {state['id']} of body `{self.name}` {self.whereabouts(p)}: "
            f"{fault.meaning}; {SLOWER_LOADS if self.relaxes else fault.remedy + leave}",
            step=n_steps,
            time=time,
            body=self.name,
            point=state["id"],
            state=state,
        )
