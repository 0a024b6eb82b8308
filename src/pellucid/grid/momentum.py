"""The nodes' equation of motion, with supports."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import prange

from pellucid.grid.lattice import Nodes
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.reductions import ordered_sum

CHUNK = 4096
FIRM = 0.05  # share of driven points in the mass of a node that they hold firmly
NOTHING = 1e-290  # kg; a node below this carries no point
INTERNAL, GRAVITY, SUPPORT, LOAD, ABSORBED, GRIP, GRIP_LOSS, MASS, WORKS = range(9)
ABSORBING, LOADING, EXTRA_ROWS = range(3)  # rows of impulses behind those of the supports


class Supports(NamedTuple):
    """What holds nodes; `Nodes.hold` counts its rows from 1."""

    velocity: np.ndarray  # (supports, 3) [m/s]
    mirror: np.ndarray  # (supports,) 1 for a wall, beside which a body goes on as its mirror image, 0 for a grip within it


class ExternalAction(NamedTuple):
    """What acts on nodes from outside beside gravity and supports; arrays have no rows where there is no such thing.

    Prescribed motions grip the nodes that driven points reach: firmly where these give a node a share FIRM of its mass, below
    that in proportion. A grip that closed at once, as soon as the function of a driven point reaches a node, would knock at
    every cell that a body crosses; one that stayed in proportion would give way to a lasting force.
    """

    load: np.ndarray  # (n, 3) external force [N]
    absorption: np.ndarray  # (n, 3) rate at which an absorbing face takes momentum [1/s]
    driven_mass: np.ndarray  # (n, 3) mass of driven points [kg]
    driven_momentum: np.ndarray  # (n, 3) their momentum with the prescribed velocity [kg m/s]
    impulse: np.ndarray  # (n, 3) impulse of the grips on unit driven mass over the step [m/s]


def no_external_action() -> ExternalAction:
    """Neither loads nor absorbing faces nor prescribed motions."""
    return external_action_with((), 0)


def external_action_with(parts: Sequence[str], n_nodes: int) -> ExternalAction:
    """What acts from outside, all zero; only the parts that are named have rows."""
    return ExternalAction(*(np.zeros((n_nodes if name in parts else 0, 3)) for name in ExternalAction._fields))


class StepWork(NamedTuple):
    """What the nodes did over a step."""

    internal: float  # dt Σ f·v̄ of the internal forces [J]
    gravity: float  # [J]
    support: float  # work of the supports' reactions on moving supports [J]
    load: float  # work of external forces [J]
    absorbed: float  # energy that left through absorbing faces [J]
    grip: float  # work of prescribed motions on the nodes [J]
    grip_loss: float  # part of it that is lost in the inelastic impact of nodes on driven points [J]
    mass: float  # on the nodes [kg]
    impulses: np.ndarray  # (supports, 3) impulses of the reactions [N s]
    absorbed_impulse: np.ndarray  # (3,) of absorbing faces [N s]
    load_impulse: np.ndarray  # (3,) of external forces [N s]


def no_work(n_supports: int) -> StepWork:
    """Nothing done."""
    return StepWork(
        internal=0.0,
        gravity=0.0,
        support=0.0,
        load=0.0,
        absorbed=0.0,
        grip=0.0,
        grip_loss=0.0,
        mass=0.0,
        impulses=np.zeros((n_supports, 3)),
        absorbed_impulse=np.zeros(3),
        load_impulse=np.zeros(3),
    )


def total_work(works: Sequence[StepWork]) -> StepWork:
    """The sum of what several sets of nodes did."""
    return StepWork(*(sum(parts[1:], start=parts[0]) for parts in zip(*works, strict=True)))


@kernel()
def _advance_chunk(bundle, chunk, dt, small, flip):
    nodes, walls, mirror, gravity, outside, work = bundle.content
    mass, momentum, force, velocity = nodes.mass, nodes.momentum, nodes.force, nodes.velocity
    velocity_increment, strain_velocity, constrained = nodes.velocity_increment, nodes.strain_velocity, nodes.constrained
    loaded, absorbing, driven = len(outside.load) > 0, len(outside.absorption) > 0, len(outside.driven_mass) > 0
    internal = fall = pushed = total = lifted = absorbed = gripped = lost = 0.0
    extra = WORKS + 3 * len(walls)
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        if m < NOTHING:
            for d in range(3):
                velocity[I, d] = velocity_increment[I, d] = strain_velocity[I, d] = 0.0
            continue
        total += m
        for d in range(3):
            s = constrained[I, d]
            mapped = momentum[I, d] / m
            # a wall's nodes have its velocity before the step too: then points beside a wall keep their velocity, as they do
            # beside their mirror image; points in a grip take the velocity of the grip
            v = walls[s - 1, d] if s > 0 and mirror[s - 1] else mapped
            f = force[I, d]
            load = outside.load[I, d] if loaded else 0.0
            light = v + dt * gravity[d]
            new = light + dt * (f + load) / m
            taken = given = goal = 0.0
            if absorbing and s == 0:
                half = 0.5 * dt * outside.absorption[I, d]  # of the mean velocity over the step: stable for any step
                taken = m * ((new - half * v) / (1.0 + half) - new)
                new += taken / m
                light = (light - half * v) / (1.0 + half)
            if driven and s == 0:
                outside.impulse[I, d] = 0.0
                if outside.driven_mass[I, d] > 0.0:
                    firmness = min(1.0, outside.driven_mass[I, d] / (FIRM * m))
                    goal = outside.driven_momentum[I, d] / outside.driven_mass[I, d]
                    given = m * firmness * (goal - new)
                    new += firmness * (goal - new)
                    light += firmness * (goal - light)
                    outside.impulse[I, d] = given / outside.driven_mass[I, d]
            if s > 0:
                wall = walls[s - 1, d]
                impulse = m * (wall - new)
                if mirror[s - 1]:  # FLIP hands on the change of velocity, PIC the velocity itself
                    impulse += m * (1.0 - flip) * (wall - mapped)
                pushed += impulse * wall
                work[chunk, WORKS + 3 * (s - 1) + d] += impulse
                new = wall
            velocity_increment[I, d] = new - v
            velocity[I, d] = new
            # f/m of a node that hardly any mass reaches has no bound. Points feel it in proportion to their weight, which
            # bounds it by f over their own mass and keeps momentum; gradients do not, so it must not strain them
            strain_velocity[I, d] = new if m > small or s > 0 else light
            mean = 0.5 * (v + strain_velocity[I, d])
            internal += dt * f * mean
            fall += dt * m * gravity[d] * mean
            lifted += dt * load * mean
            absorbed -= taken * mean
            gripped += given * goal
            lost += given * (goal - mean)
            work[chunk, extra + 3 * ABSORBING + d] += taken
            work[chunk, extra + 3 * LOADING + d] += dt * load
    work[chunk, INTERNAL] = internal
    work[chunk, GRAVITY] = fall
    work[chunk, SUPPORT] = pushed
    work[chunk, LOAD] = lifted
    work[chunk, ABSORBED] = absorbed
    work[chunk, GRIP] = gripped
    work[chunk, GRIP_LOSS] = lost
    work[chunk, MASS] = total


@kernel(parallel=True)
def _advance(chunks, bundle, dt, small, flip):
    for chunk in prange(chunks):
        _advance_chunk(bundle, chunk, dt, small, flip)


@kernel()
def _project_chunk(bundle, chunk):
    nodes, walls, _, _, outside, _ = bundle.content
    mass, momentum, strain_velocity, constrained = nodes.mass, nodes.momentum, nodes.strain_velocity, nodes.constrained
    driven = len(outside.driven_mass) > 0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        for d in range(3):
            s = constrained[I, d]
            if s > 0:
                strain_velocity[I, d] = walls[s - 1, d]
            else:
                v = momentum[I, d] / m if m >= NOTHING else 0.0
                if driven and m >= NOTHING and outside.driven_mass[I, d] > 0.0:
                    goal = outside.driven_momentum[I, d] / outside.driven_mass[I, d]
                    v += min(1.0, outside.driven_mass[I, d] / (FIRM * m)) * (goal - v)
                strain_velocity[I, d] = v


@kernel(parallel=True)
def _project(chunks, bundle):
    for chunk in prange(chunks):
        _project_chunk(bundle, chunk)


class NodalMomentum:
    """Moves the nodes of one velocity field.

    supports: their velocities [m/s] are read at every step, and so is `outside`; small_mass [kg]: nodes with less do not
    strain points by their internal forces; flip: share of FLIP in the transfer to the points.
    """

    def __init__(
        self,
        nodes: Nodes,
        supports: Supports,
        gravity: tuple[float, float, float],
        small_mass: float,
        flip: float,
        outside: ExternalAction | None = None,
    ) -> None:
        self.small_mass = small_mass
        self.flip = flip
        self._chunks = (len(nodes.mass) + CHUNK - 1) // CHUNK
        self._work = np.zeros((self._chunks, WORKS + 3 * (len(supports.velocity) + EXTRA_ROWS)))
        self._bundle = Bundle(nodes, supports.velocity, supports.mirror, gravity, outside or no_external_action(), self._work)

    def advance(self, dt: float) -> StepWork:
        """p + dt (f + m g) on every node, then the supports; fills velocity, change and strain_velocity."""
        self._work.fill(0.0)
        _advance(self._chunks, self._bundle, dt, self.small_mass, self.flip)
        sums = ordered_sum(self._work)
        impulses = sums[WORKS:].reshape(-1, 3)
        first = len(impulses) - EXTRA_ROWS
        return StepWork(
            internal=float(sums[INTERNAL]),
            gravity=float(sums[GRAVITY]),
            support=float(sums[SUPPORT]),
            load=float(sums[LOAD]),
            absorbed=float(sums[ABSORBED]),
            grip=float(sums[GRIP]),
            grip_loss=float(sums[GRIP_LOSS]),
            mass=float(sums[MASS]),
            impulses=impulses[:first],
            absorbed_impulse=impulses[first + ABSORBING],
            load_impulse=impulses[first + LOADING],
        )

    def project(self) -> None:
        """Velocities p/m of the mapped momentum, with supports, into `strain_velocity`."""
        _project(self._chunks, self._bundle)
