"""The momentum equation of the nodes, with external actions and constraints."""

from typing import NamedTuple

import numpy as np

from pellucid.energy import (
    ABSORBED,
    FIRST_LOAD,
    GRAVITY,
    IMPACT,
    INTERNAL,
    MOTION,
    SUPPORT,
    StepWork,
    row_length,
    step_work,
)
from pellucid.grid.lattice import Nodes
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.reductions import ordered_sum

CHUNK = 4096
FIRM = 0.05  # share of driven points in the mass of a node from which it wholly follows their motion
NOTHING = 1e-290  # kg; no point reaches a node below this


class Supports(NamedTuple):
    """What constrains nodes; `Nodes.constrained` counts its rows from 1."""

    velocity: np.ndarray  # (supports, 3) [m/s]
    mirror: np.ndarray  # (supports,) 1 for a wall, beside which a body goes on as its mirror image, 0 for a clamp within it


class ExternalAction(NamedTuple):
    """External actions on nodes, beside gravity and supports; arrays of actions that are absent have no rows.

    Conditions ask for them: see `pellucid.grid.actions`.

    Prescribed motions constrain the nodes that driven points reach: wholly where these give a node a share FIRM of its mass,
    below that in proportion to the share. A constraint that was complete as soon as the function of a driven point reaches a
    node would give an impulse at every cell that a body crosses; one in proportion throughout would yield to a lasting force.
    """

    loads: np.ndarray  # (channels, n, 3) external forces [N], those of each channel apart
    absorption: np.ndarray  # (n, 3) rate at which an absorbing face takes momentum [1/s]
    driven_mass: np.ndarray  # (n, 3) mass of driven points [kg]
    driven_momentum: np.ndarray  # (n, 3) their momentum with the prescribed velocity [kg m/s]
    impulse: np.ndarray  # (n, 3) impulse of prescribed motions on unit driven mass over the step [m/s]


class AdvancedNodes(NamedTuple):
    """The nodes of a velocity field and what acts on them, as kernels take them."""

    nodes: Nodes
    supports: Supports
    gravity: tuple[float, float, float]  # [m/s²]
    external: ExternalAction
    load: np.ndarray  # (n, 3) the sum of the external forces [N]; no rows where there are none
    work: np.ndarray  # (chunks, ...) rows of works as `pellucid.energy` lays them out


@kernel(inner=True)
def _advance_chunk(chunk, field, dt, small, flip):
    nodes, walls, mirror, gravity = field.nodes, field.supports.velocity, field.supports.mirror, field.gravity
    external, work = field.external, field.work
    mass, momentum, force, velocity = nodes.mass, nodes.momentum, nodes.force, nodes.velocity
    velocity_increment, strain_velocity, constrained = nodes.velocity_increment, nodes.strain_velocity, nodes.constrained
    loaded, absorbing, driven = len(field.load) > 0, len(external.absorption) > 0, len(external.driven_mass) > 0
    total_load = field.load
    internal = fall = pushed = total = absorbed = moved = lost = 0.0
    columns = FIRST_LOAD + len(external.loads)
    first = columns + 1  # of the impulses
    other = first + 3 * len(walls)
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
            # beside their mirror image; points in a clamp take the velocity of the clamp
            v = walls[s - 1, d] if s > 0 and mirror[s - 1] else mapped
            f = force[I, d]
            load = total_load[I, d] if loaded else 0.0
            light = v + dt * gravity[d]
            new = light + dt * (f + load) / m
            taken = given = goal = 0.0
            if absorbing and s == 0:
                half = 0.5 * dt * external.absorption[I, d]  # of the mean velocity over the step: stable for any step
                taken = m * ((new - half * v) / (1.0 + half) - new)
                new += taken / m
                light = (light - half * v) / (1.0 + half)
            if driven and s == 0:
                external.impulse[I, d] = 0.0
                if external.driven_mass[I, d] > 0.0:
                    follow = min(1.0, external.driven_mass[I, d] / (FIRM * m))
                    goal = external.driven_momentum[I, d] / external.driven_mass[I, d]
                    given = m * follow * (goal - new)
                    new += follow * (goal - new)
                    light += follow * (goal - light)
                    external.impulse[I, d] = given / external.driven_mass[I, d]
            if s > 0:
                wall = walls[s - 1, d]
                impulse = m * (wall - new)
                if mirror[s - 1]:  # FLIP hands on the increment of velocity, PIC the velocity itself
                    impulse += m * (1.0 - flip) * (wall - mapped)
                pushed += impulse * wall
                work[chunk, first + 3 * (s - 1) + d] += impulse
                new = wall
            velocity_increment[I, d] = new - v
            velocity[I, d] = new
            # f/m of a node that hardly any mass reaches has no bound. Points feel it in proportion to their weight, which
            # bounds it by f over their own mass and keeps momentum; gradients do not, so it must not strain them
            strain_velocity[I, d] = new if m > small or s > 0 else light
            mean = 0.5 * (v + strain_velocity[I, d])
            internal += dt * f * mean
            fall += dt * m * gravity[d] * mean
            absorbed -= taken * mean
            moved += given * goal
            lost += given * (goal - mean)
            if taken != 0.0 or load != 0.0:  # of few nodes: memory is slow
                work[chunk, other + d] += taken + dt * load
    work[chunk, INTERNAL] = internal
    work[chunk, GRAVITY] = fall
    work[chunk, SUPPORT] = pushed
    work[chunk, ABSORBED] = absorbed
    work[chunk, MOTION] = moved
    work[chunk, IMPACT] = lost
    work[chunk, columns] = total


@kernel(inner=True)
def _sum_loads_chunk(chunk, field):
    loads = field.external.loads
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(field.load))):
        for d in range(3):
            load = 0.0
            for k in range(len(loads)):
                load += loads[k, I, d]
            field.load[I, d] = load


@kernel(inner=True)
def _count_load_works_chunk(chunk, field, dt):
    """Works of external forces along the mean velocities of the advanced nodes."""
    nodes, walls, mirror, loads = field.nodes, field.supports.velocity, field.supports.mirror, field.external.loads
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(field.load))):
        m = nodes.mass[I]
        if m < NOTHING:
            continue
        for d in range(3):
            s = nodes.constrained[I, d]
            v = walls[s - 1, d] if s > 0 and mirror[s - 1] else nodes.momentum[I, d] / m
            mean = 0.5 * (v + nodes.strain_velocity[I, d])
            for k in range(len(loads)):
                field.work[chunk, FIRST_LOAD + k] += dt * loads[k, I, d] * mean


@kernel()
def _advance(chunks, field, dt, small, flip):
    if len(field.load) > 0:  # apart: loops over the channels within the momentum equation would slow down all nodes
        parallel_for(_sum_loads_chunk, chunks, field)
    parallel_for(_advance_chunk, chunks, field, dt, small, flip)
    if len(field.load) > 0:
        parallel_for(_count_load_works_chunk, chunks, field, dt)


@kernel(inner=True)
def _project_chunk(chunk, field):
    nodes, walls, external = field.nodes, field.supports.velocity, field.external
    mass, momentum, strain_velocity, constrained = nodes.mass, nodes.momentum, nodes.strain_velocity, nodes.constrained
    driven = len(external.driven_mass) > 0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        for d in range(3):
            s = constrained[I, d]
            if s > 0:
                strain_velocity[I, d] = walls[s - 1, d]
            else:
                v = momentum[I, d] / m if m >= NOTHING else 0.0
                if driven and m >= NOTHING and external.driven_mass[I, d] > 0.0:
                    goal = external.driven_momentum[I, d] / external.driven_mass[I, d]
                    v += min(1.0, external.driven_mass[I, d] / (FIRM * m)) * (goal - v)
                strain_velocity[I, d] = v


@kernel()
def _project(chunks, field):
    parallel_for(_project_chunk, chunks, field)


class NodalMomentum:
    """Advances the momentum of the nodes of one velocity field.

    supports: their velocities [m/s] are read at every step, and so is `external`; small_mass [kg]: nodes with less do not
    strain points by their internal forces; flip: share of FLIP in the transfer to the points.
    """

    def __init__(
        self,
        nodes: Nodes,
        supports: Supports,
        gravity: tuple[float, float, float],
        small_mass: float,
        flip: float,
        external: ExternalAction,
    ) -> None:
        self.small_mass = small_mass
        self.flip = flip
        self._chunks = (len(nodes.mass) + CHUNK - 1) // CHUNK
        self._columns = FIRST_LOAD + len(external.loads)
        self._sums = np.zeros((self._chunks, row_length(self._columns, len(supports.velocity) + 1)))
        load = np.zeros((external.loads.shape[1] if len(external.loads) else 0, 3))
        self._bundle = Bundle(AdvancedNodes(nodes, supports, gravity, external, load, self._sums))

    def advance(self, dt: float) -> StepWork:
        """p + dt (f + m g) on every node, then the supports; fills velocity, velocity_increment and strain_velocity."""
        self._sums.fill(0.0)
        _advance(self._chunks, self._bundle, dt, self.small_mass, self.flip)
        return step_work(ordered_sum(self._sums), self._columns)

    def project(self) -> None:
        """Velocities p/m of the mapped momentum, with supports, into `strain_velocity`."""
        _project(self._chunks, self._bundle)
