"""Potential energy, forces and stiffness of a body with its own nodes at trial positions of the nodes, for its equilibria."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pellucid.bodies.own_nodes.motion import ForceParts, ForcesOnTheWay, Moved, NodalMotion, Tangent
from pellucid.bodies.own_nodes.stiffness import NodalStiffness
from pellucid.bodies.own_nodes.twists import loose_twists, neutral_twists, no_twists
from pellucid.contact.frozen import ContactSprings
from pellucid.linear.differences import GroupedDifferences
from pellucid.parts.elastic_system import Trial, VolumePressure

TANGENTS, SETTLED = 20, 1e-6  # most iterations for the tangent under loads that follow; their last relative change
DIFFERENCE = 1e-6  # displacement for differences of loads that follow, relative to the size of the body
ROUNDING = 1e-15  # of the energy over modulus and volume: laws subtract numbers of size 1


class Strained(NamedTuple):
    """A body at trial positions of its nodes."""

    stored: float  # stored energy [J]
    is_valid: bool  # False if the body is inverted at a point


class NodalSystem(ABC):
    """An `ElasticSystem` of a body with its own nodes; subclasses compute strains, internal forces and stiffness.

    rest, position: nodal positions at rest and at present [m], shape (n, 3); motion: equation of motion of the nodes;
    stiffness: modulus times volume of the body [J]; accepted: function of the body that is called after a new equilibrium,
    with the step of the time of the loads [s].
    """

    has_energy = True  # False if internal forces are not derivatives of the stored energy
    includes_load_stiffness = False  # True if the matrix includes the stiffness of loads that follow the deformation
    is_approximate = False
    settled = SETTLED  # relative change of the tangent under loads that follow at which it is accepted

    def __init__(
        self,
        rest: np.ndarray,
        position: np.ndarray,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
    ) -> None:
        self.rest, self._present, self._motion, self._accepted = rest, position, motion, accepted
        self.rounding, self.in_single = ROUNDING * stiffness, True
        self.position, self.increment = position.copy(), np.zeros_like(rest)
        self._external, self.has_potential = np.zeros_like(rest), True
        self._unpressed = np.zeros_like(rest)
        self.resistance = stiffness
        """Modulus times volume of the body [J]."""
        self._renew: Callable[[float], None] = lambda share: None
        self._follow, self._left_stable = False, True
        self._exert: Callable[[], None] | None = None
        self._springs: Callable[[], Sequence[ContactSprings]] = tuple
        self._dt = 0.0  # step of the time of the loads
        self._share = 0.0  # of the step at which the stiffness of loads is that of the tangent
        self._neutral = no_twists()  # motions as a whole on which forces do no work
        self._before, self._rates = motion.force_parts(), motion.prescribed_rates()
        self._external_before = motion.external_forces(self._before)
        self._leaving = Tangent(self.increment, self.increment)
        self._free, self._stored = motion.free, self._stored_energy()  # at the last equilibrium
        self._stiffness: NodalStiffness | None = None
        self._load_differences: GroupedDifferences | None = None
        self.tried = self.position.copy()
        """Positions of the last trial [m], shape (n, 3)."""

    @abstractmethod
    def _strain(self, position: np.ndarray) -> Strained:
        """Compute strains and internal forces, `internal` of the motion, for nodes at these positions [m], shape (n, 3)."""

    @abstractmethod
    def _stored_energy(self) -> float:
        """Return the stored energy in the state of the last strains [J]."""

    @abstractmethod
    def _new_stiffness(self) -> NodalStiffness:
        """Return the stiffness of the body in the state of its last strains, without factors."""

    def begin(self, dt: float) -> None:
        self.position[:], self._dt = self._present, dt
        self._stored, self._share = self._stored_energy(), 0.0
        self._before, self._rates = self._motion.force_parts(), self._motion.prescribed_rates()
        self._external_before = self._motion.external_forces(self._before)
        self.increment[:] = dt * self._motion.at_nodes(self._rates)

    def take_loads(self, renew: Callable[[float], None], follow: bool) -> None:
        self._renew, self._follow, self.has_potential = renew, follow, self.has_energy and not follow
        self._external[:] = self._motion.forces() - self._motion.internal

    @property
    def has_contact(self) -> bool:
        return self._exert is not None

    def take_contact(self, exert: Callable[[], None], springs: Callable[[], Sequence[ContactSprings]]) -> None:
        self._exert, self._springs = exert, springs

    def attempt(self, position: np.ndarray) -> Trial:
        self.tried[:] = position
        if self._follow:
            self._load_at(position, 1.0)
        return self.judge()

    def place(self, position: np.ndarray) -> None:
        self.tried[:] = position
        self._move_to(position)

    def judge(self) -> Trial:
        internal, position = self._motion.internal, self.tried
        if self._follow:
            self._external[:] = self._motion.forces() - internal
        energy, is_valid = self._strain(position)
        if self.has_potential:
            energy -= float(np.sum(self._external * (position - self.rest)))
        of_volume, pressed = self._pressed(position) if is_valid else (0.0, self._unpressed)
        energy, external = energy + of_volume, self._external + pressed
        residual = np.where(self._motion.free, internal + external, 0.0)
        with np.errstate(over="ignore", invalid="ignore"):
            size = float(np.sqrt(np.sum(internal * internal)) + np.sqrt(np.sum(external * external)))
        return Trial(energy, residual, size, is_valid and np.isfinite(energy) and np.isfinite(size))

    def _load_at(self, position: np.ndarray, share: float) -> None:
        """Move the nodes to these positions [m], shape (n, 3), and compute the loads there, at a share of the step."""
        self._move_to(position)
        self._renew(share)
        if self._exert is not None:
            self._exert()

    def _move_to(self, position: np.ndarray) -> None:
        self._present[:] = position
        if self.has_contact:
            self._motion.velocity[:] = (position - self.position) / self._dt  # of which friction uses the displacement

    def enclose(self, pressure: VolumePressure) -> None:
        raise ValueError("the body encloses no volume")

    def corrects(self, tolerance: float) -> bool:
        return False

    def _pressed(self, position: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the potential of pressures that depend on the enclosed volume [J], and their forces on the nodes [N], shape
        (n, 3)."""
        return 0.0, self._unpressed

    def _pressure_growth(self) -> np.ndarray:
        """Return by how much these forces grow in the step at the last trial positions [N], shape (n, 3)."""
        return self._unpressed

    def _arrive(self, leaving: Tangent, arriving: Tangent) -> None:  # noqa: B027
        """Apply these forces to the nodes at the present positions; leaving, arriving: ends of the way to them."""

    def _work_elsewhere(self) -> float:
        """Return the recorded work of these forces minus that which follows from the energies of the contents [J]."""
        return 0.0

    @property
    def has_factors(self) -> bool:
        return self._matrix().is_factored_for(self._motion.free)

    @property
    def shift(self) -> float:
        return self._matrix().shift

    def factor(self) -> None:
        self.in_single = self._matrix().renew(self._motion.free, self.tried, self.in_single, touching=self._springs())
        self._find_neutral()

    def _find_neutral(self) -> None:
        loose = loose_twists(self.tried, self._motion.free)
        self._neutral = neutral_twists(loose, self.tried, lambda position: self._external_at(position, 1.0))

    def unstable_direction(self) -> np.ndarray | None:
        if self.shift == 0.0 or not self._knows_stability:
            return None
        found = self._matrix().softest()
        if found is None or found.is_resisted:
            return None
        return np.asarray(found.displacement / np.abs(found.displacement).max())

    @property
    def _knows_stability(self) -> bool:
        """True if the factored matrix is that of the body and includes the stiffness of all loads exactly; that of contact is
        without the change of areas and normals."""
        return not (self.has_contact or self.is_approximate) and (not self._follow or self.includes_load_stiffness)

    def solve(self, force: np.ndarray) -> np.ndarray:
        return self._without_drift(self._matrix().solve(force))

    def follow(self, force: np.ndarray) -> np.ndarray:
        self._find_neutral()
        self._leaving, self._left_stable = self._tangent(force), self.shift == 0.0
        self._share = 1.0
        return self._leaving.moved

    def _tangent(self, force: np.ndarray) -> Tangent:
        """Return the displacements under loads on the nodes that grow by `force` [N], shape (n, 3), and the increments of
        prescribed displacements."""
        found = self._linear(force)
        if not self._follow or self.includes_load_stiffness or self.has_contact:
            return found
        last = float("inf")
        for _ in range(TANGENTS):  # the loads that follow the displacements are added to the others
            moved = found.moved
            found = self._linear(force + self._followed(moved))
            change = float(np.abs(found.moved - moved).max())
            if change <= self.settled * float(np.abs(found.moved).max()):
                break
            if not change < last:
                return self._linear(force)
            last = change
        return found

    def _linear(self, force: np.ndarray) -> Tangent:
        """Return the displacements under forces on the nodes [N], shape (n, 3), and the increments of prescribed ones."""
        moved, resisted = self._matrix().follow(force, self.increment)
        return Tangent(self._without_drift(moved), resisted)

    def _followed(self, displacement: np.ndarray) -> np.ndarray:
        """Return the change of the loads with displacements from the last trial positions [m], shape (n, 3), by differences."""
        size = float(np.abs(displacement).max())
        step = DIFFERENCE * float(np.ptp(self.rest, axis=0).max()) / size if size > 0.0 else 0.0
        if step == 0.0:
            return np.zeros_like(displacement)
        ahead, behind = (self._external_at(self.tried + way * displacement, self._share) for way in (step, -step))
        return np.asarray((ahead - behind) / (2.0 * step))

    def _external_at(self, position: np.ndarray, share: float) -> np.ndarray:
        """Return the external forces at a share of the step for nodes at these positions [N], shape (n, 3)."""
        if not self._follow:
            return self._external
        self._load_at(position, share)
        found = self._motion.external_forces(self._motion.force_parts())
        self._load_at(self.tried, 1.0)
        return found

    def _without_drift(self, displacement: np.ndarray) -> np.ndarray:
        """Remove from displacements [m], shape (n, 3), the motions of the body as a whole on which forces do no work: errors of
        the stiffness are larger than what resists them."""
        return self._neutral.without(displacement, self.tried) if len(self._neutral) else displacement

    def lowest_frequency(self) -> float | None:
        if not self._knows_stability:
            return None
        return self._matrix().lowest_frequency(self._motion.inertia)

    def aligned(self, position: np.ndarray) -> np.ndarray:
        if not len(self._neutral):
            return position
        return np.where(self._motion.free, self._neutral.aligned(position, self.position), position)

    def obstacle(self) -> str | None:
        found = self._motion.beyond_wall(self.tried)
        if found is None:
            return None
        node, axis = found
        return f"node {node} would pass a face of the grid normal to {'xyz'[axis]} that is a wall"

    def accept(self, position: np.ndarray, dt: float, jumped: bool) -> None:
        motion, displacement = self._motion, position - self.position
        self._present[:] = position
        leaving, arriving = self._ends_of_path(displacement)
        self._arrive(leaving, arriving)
        after = motion.force_parts()
        forces = ForcesOnTheWay(self._before, self._middle(leaving, arriving, after), after)
        motion.record_equilibrium(Moved(displacement, leaving, arriving, self._rates), forces, dt)
        if jumped or (self._motion.free != self._free).any():
            self._motion.lose_rest(self._stored_energy() - self._stored + self._work_elsewhere())
        self._free = self._motion.free
        self._accepted(dt)

    def _middle(self, leaving: Tangent, arriving: Tangent, after: ForceParts) -> ForceParts:
        """Return the forces in the middle of the way to the present positions, under the mean of the loads of both ends.
        leaving, arriving: ends of the way; after: forces at its end."""
        ends, position = [self._before, after], self._present.copy()
        if self._follow and not self.has_contact:
            self._present[:] = 0.5 * (self.position + position) + 0.125 * (leaving.moved - arriving.moved)
            for end, share in enumerate((0.0, 1.0)):
                self._renew(share)
                ends[end] = self._motion.force_parts()
            self._present[:] = position
            self._renew(1.0)
        return ForceParts(*(0.5 * (one + other) for one, other in zip(*ends, strict=True)))

    def _ends_of_path(self, displacement: np.ndarray) -> tuple[Tangent, Tangent]:
        """Return the directions in which the nodes leave the last equilibrium and arrive at the present one, for the
        displacement between both [m], shape (n, 3). Where the stiffness is not positive definite, the direction
        follows from the displacement. With contact the path is straight, because surfaces touch and separate on it."""
        if self.has_contact:
            straight = Tangent(displacement, np.zeros_like(displacement))
            return straight, straight
        leaving, arriving = self._leaving, self._tangent(self._grown())
        stable = self.shift == 0.0
        if not self._left_stable:
            other = arriving.moved if stable else displacement
            leaving = Tangent(2.0 * displacement - other, arriving.resisted)
        if not stable:
            arriving = Tangent(2.0 * displacement - leaving.moved, leaving.resisted)
        return leaving, arriving

    # paths along which the load factor is an unknown

    def scale_loads(self, factor: float) -> None:
        self._motion.scale_external(factor)

    def external_loads(self) -> np.ndarray:
        return np.where(self._motion.free, self._motion.external_forces(self._motion.force_parts()), 0.0)

    def factor_indefinite(self) -> None:
        self._matrix().renew_indefinite(self._motion.free, self.tried, self._load_stiffness())
        self._find_neutral()

    def _load_stiffness(self) -> np.ndarray | None:
        """Return the symmetric part of the stiffness of loads that follow the deformation, if the matrix does not include it,
        for each pair of linked nodes [N/m], shape (pairs, 3, 3); otherwise None."""
        if not self._follow or self.includes_load_stiffness:
            return None
        if self._load_differences is None:
            step = DIFFERENCE * float(np.ptp(self.rest, axis=0).max())
            self._load_differences = GroupedDifferences(self._matrix().links(), step)

        def loads(position: np.ndarray) -> np.ndarray:
            self._load_at(position, 1.0)
            return self._motion.external_forces(self._motion.force_parts())

        found = self._load_differences.find(loads, self.tried.copy())
        self._load_at(self.tried, 1.0)
        return found

    @property
    def unstable_modes(self) -> int:
        return self._matrix().unstable_modes

    def signed_frequency(self) -> float | None:
        return self._matrix().signed_frequency(self._motion.inertia)

    def accept_on_path(
        self, position: np.ndarray, leaving: np.ndarray, arriving: np.ndarray, load_middle: Callable[[], None], dt: float
    ) -> None:
        motion, displacement, none = self._motion, position - self.position, np.zeros_like(position)
        after = motion.force_parts()
        self._present[:] = 0.5 * (self.position + position) + 0.125 * (leaving - arriving)
        load_middle()
        middle = motion.force_parts()
        self._present[:] = position
        self._renew(1.0)
        moved = Moved(displacement, Tangent(leaving, none), Tangent(arriving, none), self._rates)
        motion.record_equilibrium(moved, ForcesOnTheWay(self._before, middle, after), dt)
        self._free = motion.free
        self._accepted(dt)

    def _grown(self) -> np.ndarray:
        """Return by how much the loads on the nodes grow in the step at their present positions [N], shape (n, 3)."""
        if not self._follow:
            return self._external - self._external_before + self._pressure_growth()
        self._renew(0.0)
        less = self._motion.external_forces(self._motion.force_parts())
        self._renew(1.0)
        return self._external - less + self._pressure_growth()

    def reject(self) -> None:
        self._present[:] = self.position
        if self.has_contact:
            self._motion.velocity.fill(0.0)  # those of the last trial
        self._strain(self.position)

    def _matrix(self) -> NodalStiffness:
        if self._stiffness is None:
            self._stiffness = self._new_stiffness()
        return self._stiffness
