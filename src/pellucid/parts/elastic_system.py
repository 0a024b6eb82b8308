"""Interfaces of a body whose equilibria, or motion in implicit time steps, are found with a factored stiffness: potential
energy, forces and stiffness at trial positions of its nodes."""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

import numpy as np

if TYPE_CHECKING:
    from pellucid.contact.frozen import ContactSprings


class Trial(NamedTuple):
    """Energy and forces of a body at trial positions of its nodes."""

    energy: float  # stored energy, minus the work of the loads since the state at rest if they have a potential [J]
    residual: np.ndarray  # (n, 3) forces on the nodes [N]; 0 for prescribed components
    size: float  # sum of the norms of all internal and all external nodal forces [N]
    is_valid: bool  # False if the body is inverted at a point or a value is not finite


LARGEST_FACTORS = 3e8
"""Largest number of entries of the factors of a stiffness, 2.4 GB: that of a compact solid of 2e4 nodes, or of 1.4e4 with an
averaged volume ratio; it grows with the power 1.5 of the number of nodes."""
FEW_NODES = sqrt(2.0 * LARGEST_FACTORS) / 4.0
"""Number of nodes up to which no factors are larger: not even a dense matrix of four unknowns per node is."""


class StiffnessSize(NamedTuple):
    """Size of the factored stiffness of a body, and effort of a factorisation."""

    unknowns: int  # number of displacement components of the nodes
    numbers: float  # number of entries of the factors
    operations: float  # number of multiplications and additions
    is_approximate: bool = False  # True if the factors are those of a simpler stiffness, in single precision


class Content(NamedTuple):
    """Contents of a membrane in a volume V."""

    energy: float  # potential Ψ(V) [J]
    pressure: float  # gauge pressure p = -dΨ/dV [Pa]
    stiffness: float  # -dp/dV [Pa/m³], not negative


class VolumeRates(NamedTuple):
    """Derivatives with respect to the share of a step, at one of its ends."""

    volume: float  # of the enclosed volume [m³]
    pressure: float  # of the gauge pressure [Pa]


class VolumePressure(Protocol):
    """A pressure in a membrane that depends on the enclosed volume."""

    row: int
    """Index of the pressure among the nodal arrays of loads of the body."""

    @property
    def sign(self) -> float:
        """1 if the normals of the membrane point out of the volume, else -1."""

    def begin_with(self, pressure: float) -> None:
        """Take the gauge pressure that balances the tension of the membrane at the start [Pa]."""

    def measure(self, places: np.ndarray, areas: np.ndarray) -> float:
        """Return the enclosed volume [m³]; places: positions of the nodes [m], areas: their vector areas along the normals
        [m²], shape (n, 3) each, in the order of the mesh."""

    def at(self, volume: float, share: float) -> Content:
        """Return the contents in a volume [m³] under the loads of the last equilibrium (share 0) or of the equilibrium that is
        sought (share 1)."""

    def start(self) -> None:
        """Start the search for an equilibrium."""

    def corrects(self, volume: float, tolerance: float) -> bool:
        """Correct the pressure where forces balance if the volume [m³] is not the given one, and return True; False if it is.
        tolerance: of the volume, relative to its change since the start."""

    def compliance(self, volume: float, share: float) -> tuple[float, float] | None:
        """Return two properties of the contents for a volume [m³] at the start (share 0) or end (share 1) of the step: the
        change of their volume in the step at constant pressure [m³], and the derivative -dV/dp [m³/Pa]. None if `at` has the
        stiffness of the contents; otherwise `at` is softer."""

    def travel(self, before: float, after: float, leaving: VolumeRates | None, arriving: VolumeRates | None) -> float:
        """Store the path of the volume from the last equilibrium to the present one, and return the gauge pressure in the
        middle of the step [Pa].

        before, after: volumes [m³]; leaving, arriving: derivatives at both ends, None at an unstable equilibrium.
        """

    def done(self) -> float | None:
        """Return the work that the gauge pressure did in the step as it follows from the energies of the contents [J]; None if
        the pressure is that of something outside."""


class Searched(Protocol):
    """Forces on the nodes of a body as functions of their positions, and a stiffness, for a search where the forces balance."""

    @property
    def rest(self) -> np.ndarray:
        """Positions of the nodes from which displacements are measured [m], shape (n, 3)."""

    has_potential: bool
    """True if the forces have a potential, so that they balance where the energy has a minimum."""
    is_approximate: bool
    """True if the factored stiffness is only an approximation, which needs more iterations. Whether an equilibrium is stable is
    then not known."""

    @property
    def rounding(self) -> float:
        """Rounding error of the energy [J]."""

    def attempt(self, position: np.ndarray) -> Trial:
        """Return energy and forces at positions of the nodes [m], shape (n, 3)."""

    def factor(self) -> None:
        """Compute and factor the stiffness at the last trial positions. Raises LinAlgError if no addition to the diagonal
        makes it positive definite."""

    def solve(self, force: np.ndarray) -> np.ndarray:
        """Return, with the last factors, the displacements of the free components under forces [N], shape (n, 3) both."""


class ElasticSystem(Searched, Protocol):
    """Potential energy, forces and stiffness of a body with its own nodes, displaced from its state at rest; loads depend on
    the positions of the nodes only, and have a potential if they do not depend on the deformation."""

    @property
    def position(self) -> np.ndarray:
        """Positions of the nodes at the last equilibrium [m], shape (n, 3)."""

    @property
    def increment(self) -> np.ndarray:
        """Increments of the prescribed displacements to the equilibrium that is sought [m], shape (n, 3); 0 for free
        components."""

    @property
    def tried(self) -> np.ndarray:
        """Positions of the nodes in the last trial [m], shape (n, 3)."""

    @property
    def has_factors(self) -> bool:
        """True if the stiffness was factored for the components that are prescribed now."""

    @property
    def has_contact(self) -> bool:
        """True if contact forces act. The stiffness is then factored in each load step, because that of contact changes where
        surfaces touch or separate; whether an equilibrium is stable is not known."""

    @property
    def shift(self) -> float:
        """Stiffness that was added to the diagonal of the last factored matrix, as a fraction of the diagonal: 0 if the body
        was stable there."""

    def begin(self, dt: float) -> None:
        """Store the present state as the last equilibrium, and the increments of the prescribed displacements in a step dt [s]
        of the time of the loads. Called when the prescribed velocities of this step are set."""

    def take_loads(self, renew: Callable[[float], None], follow: bool) -> None:
        """Take the present external forces as the loads of the equilibrium that is sought.

        renew: function that computes the loads at a share of the step, 0 to 1, for the present positions of the nodes, without
        contact; follow: True if loads depend on these positions.
        """

    def corrects(self, tolerance: float) -> bool:
        """Correct the pressures of given volumes at the last trial positions, where forces balance, and return True if the
        search must go on; tolerance: of the volumes, relative to their changes since the start."""

    def follow(self, force: np.ndarray) -> np.ndarray:
        """Return the displacements under forces [N] with the last factors, including the increments of the prescribed
        displacements [m], shape (n, 3)."""

    def unstable_direction(self) -> np.ndarray | None:
        """Return the displacement that the body resists least, with the largest component 1, if the last factored state is
        unstable; None if it is stable, or if this is not known."""

    def lowest_frequency(self) -> float | None:
        """Return the lowest natural frequency of small vibrations about the last factored state [Hz]; None if it is unstable,
        if the body can move as a whole, or if the stiffness of its loads is not known."""

    def aligned(self, position: np.ndarray) -> np.ndarray:
        """Return positions [m], shape (n, 3), without the motion of the body as a whole since the last equilibrium, as far as
        loads and supports leave it open."""

    def obstacle(self) -> str | None:
        """Return, as a clause, why the body cannot be at the last trial positions: a node would be behind a wall. None if it
        can."""

    def accept(self, position: np.ndarray, dt: float, jumped: bool) -> None:
        """Move the nodes to positions [m], shape (n, 3), at which `attempt` was called last, and compute works and reactions
        of the step dt [s] of the time of the loads.

        jumped: True if the equilibria on the way were unstable. Then, and after a release of supports, the energy that the
        body loses is a heat of damping: in time, the body would vibrate until damping stops it.
        """

    def reject(self) -> None:
        """Restore the last equilibrium."""


class BodySystem(ElasticSystem, Protocol):
    """An `ElasticSystem` of one body; `attempt` is `place`, new loads, and `judge`."""

    resistance: float
    """Modulus times volume of the body [J]."""
    in_single: bool
    """True as long as factors in single precision are accurate enough; part of the state of a run."""

    def enclose(self, pressure: VolumePressure) -> None:
        """Add a pressure in the body that depends on the enclosed volume."""

    def take_contact(self, exert: Callable[[], None], springs: "Callable[[], Sequence[ContactSprings]]") -> None:
        """Take the contact of the body, whose forces belong to the loads that follow the deformation.

        exert: function that adds the contact forces at the present positions of the nodes to the loads of all bodies; springs:
        function that returns the springs of the last contact forces on this body.
        """

    def place(self, position: np.ndarray) -> None:
        """Move the nodes to trial positions [m], shape (n, 3)."""

    def judge(self) -> Trial:
        """Return energy and forces at the trial positions under the present loads."""


class PathSystem(BodySystem, Protocol):
    """An `ElasticSystem` whose equilibria are followed along a path on which the loads are multiplied by an unknown factor
    (`pellucid.simulation.arc_length`)."""

    def scale_loads(self, factor: float) -> None:
        """Multiply the present loads on the nodes, with gravity, by a factor."""

    def external_loads(self) -> np.ndarray:
        """Return the present loads on the free components of the nodes, with gravity [N], shape (n, 3)."""

    def factor_indefinite(self) -> None:
        """Compute and factor the stiffness at the last trial positions, with that of the loads, also if it is not positive
        definite. Raises LinAlgError if it is singular."""

    @property
    def unstable_modes(self) -> int:
        """Number of negative eigenvalues of the stiffness at the last call of `factor_indefinite`."""

    def signed_frequency(self) -> float | None:
        """Return the lowest natural frequency [Hz] at the last call of `factor_indefinite`, negative if it is imaginary: -f for
        a disturbance that grows as exp(2π f t). None if it is not known."""

    def accept_on_path(
        self, position: np.ndarray, leaving: np.ndarray, arriving: np.ndarray, load_middle: Callable[[], None], dt: float
    ) -> None:
        """Move the nodes to positions [m], shape (n, 3), at which `attempt` was called last, and compute works and reactions of
        the step dt [s] of the time of the loads.

        leaving, arriving: derivatives of the positions at both ends with respect to the share of the path between both
        equilibria [m], shape (n, 3); load_middle: function that computes the loads in the middle of the path for the present
        positions.
        """


class MovingSystem(BodySystem, Protocol):
    """An `ElasticSystem` that also moves by its inertia, in implicit time steps (`pellucid.simulation.implicit`)."""

    velocity: np.ndarray
    """Velocities of the nodes [m/s], shape (n, 3)."""
    added: np.ndarray | None
    """Stiffness of inertia and drag that is added to the diagonal of the factored matrix [N/m], shape (n,)."""
    keeps_factors: bool
    """True if factors serve for several steps, and can be computed again from the positions of the nodes alone."""
    drag: float
    """Rate of the drag in the present step [1/s], set by `begin`: a force proportional to mass and velocity."""

    @property
    def inertia(self) -> np.ndarray:
        """Masses of the nodes [kg], shape (n,)."""

    @property
    def free(self) -> np.ndarray:
        """Mask of the components that are not prescribed, shape (n, 3)."""

    def attempt_step(self, middle: np.ndarray) -> Trial:
        """Return the forces of a step with positions `middle` at its midpoint [m], shape (n, 3); `Trial.energy` is 0. Their
        work in the step is the decrease of the stored energy, and they have no torque about these positions."""

    def factor_at(self, position: np.ndarray) -> None:
        """Compute and factor the stiffness at positions of the nodes [m], shape (n, 3). Raises LinAlgError as `factor`."""

    def arrive(self, middle: np.ndarray, dt: float) -> None:
        """Move the nodes over a step dt [s] to its end, and compute velocities, works and reactions; middle: positions in the
        middle of the step [m], shape (n, 3), at which `attempt_step` was called last."""


@runtime_checkable
class HasElasticSystem(Protocol):
    """A body whose equilibria can be found with a factored stiffness."""

    def elastic_system(self) -> PathSystem:
        """Return energy, forces and stiffness of the body."""


@runtime_checkable
class HasMovingSystem(Protocol):
    """A body that can move in implicit time steps."""

    def moving_system(self) -> MovingSystem:
        """Return energy, forces, stiffness and inertia of the body."""
