"""The interface of a body to the clock, the balance and results; what else it may offer is in `capabilities`."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from math import fsum

import numpy as np

from pellucid.contact.contact_body import ContactBody
from pellucid.energy import AngularMomentum, Totals, kinetic_energies
from pellucid.errors import RunStopped, UnknownName
from pellucid.findings import absent
from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.points import FAULTS, LOST, Fault
from pellucid.named import Named
from pellucid.parts.capabilities import Membrane, NodalSupport
from pellucid.parts.constraint import ConstrainedPoints
from pellucid.parts.placement import Placement
from pellucid.parts.relaxable import SLOWER_LOADS
from pellucid.parts.step_limit import NO_LIMIT, StepLimit

__all__ = ["Body", "NodalSupport", "Placement", "in_metres"]


def in_metres(place: np.ndarray) -> str:
    """A place [m] as errors tell it."""
    return f"({', '.join(f'{value:.6g}' for value in place.tolist())}) m"


class Body(ConstrainedPoints, ABC):
    """A body of a simulation, of either family."""

    name: str
    energy_kind: str
    """What it stores: "internal" or "strain" energy."""
    totals: Totals
    """Sums over the body at the end of the step, and its largest stable step."""
    arrays: dict[str, np.ndarray]
    """State of its points or nodes, first axis n; `id` is their number in the order of seeding or of the mesh."""
    element_arrays: Mapping[str, np.ndarray] = {}
    """State of its elements, in the order of the mesh; most bodies have none."""
    relaxes = False
    """True if it is being brought to rest in equilibrium."""
    load_rate = 1.0
    """How fast the loads change over the coming step, in simulated time over that of the step: another in steady states."""
    may_leave = False
    """True if its points could leave through faces of the grid."""

    @cached_property
    def is_surface(self) -> bool:
        """True if it is a membrane, which has two sides."""
        return isinstance(self, Membrane)

    @property
    def n_points(self) -> int:
        """Number of points or nodes."""
        return len(self.arrays["mass"])

    @property
    def n_told(self) -> int:
        """Number of points that results tell of: all, those included that left, but where others may come in their place."""
        return self.n_points

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

    def stored_array(self, name: str) -> np.ndarray:
        """An array of all points that have not left, in the order in which they are stored, of all processes."""
        return self.arrays[name]

    def volumes(self) -> np.ndarray:
        """Volumes of the points [m³], shape (n,), in the order in which they are stored."""
        return self.stored_array("volume")

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

    def begin(self, dt: float) -> None:
        """Before the conditions of a step dt [s]: forget the external forces of the last one, if the body keeps them."""

    def angular_momentum(self, about: np.ndarray) -> AngularMomentum:
        """Angular momentum of its points about a place [m], shape (3,)."""
        m, velocity = self.stored_field("mass")[:, None], self.stored_field("velocity")
        arm = self.stored_field("position") - about
        size = m[:, 0] * np.sqrt(np.sum(arm * arm, axis=1) * np.sum(velocity * velocity, axis=1))
        return AngularMomentum(np.sum(m * np.cross(arm, velocity), axis=0), float(np.sum(size)))

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

    @property
    def contact_body(self) -> ContactBody | None:
        """What others meet of it on the nodes of the grid: itself, or its surface."""
        return self.on_grid

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

    def frame(self) -> dict[str, np.ndarray]:
        """The fields of all points in the order of their numbers; units in `pellucid.state.FIELDS`."""
        return Named(f"body {self.name} has no field", {name: np.array(self.field(name)) for name in self.field_names})

    def facts(self) -> Mapping[str, float]:
        """Numbers about its state by name, which the summary of a run shows, in SI units."""
        return {}

    def kinetic_energies(self) -> np.ndarray:
        """Of each point [J], shape (n,)."""
        return kinetic_energies(self.arrays["mass"], self.arrays["velocity"])

    def whereabouts(self, p: int) -> str:
        """Where point p is, for an error."""
        return f"at {in_metres(self.arrays['position'][p])}"

    def fault(self, code: int, p: int) -> Fault:
        """Meaning and remedy of a fault (of `pellucid.grid.points`) at point p."""
        return FAULTS[code]

    def stop(self, code: int, p: int, n_steps: int, time: float) -> None:
        """Raise `RunStopped` for a fault (of `pellucid.grid.points`) at point p."""
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
