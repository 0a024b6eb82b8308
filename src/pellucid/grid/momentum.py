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
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.reductions import ordered_sum

CHUNK = 1024  # nodes that a thread takes at a time
FIRM = 0.05  # share of driven points in the mass of a node from which it wholly follows their motion
NO_FORCES = np.zeros((0, 4))
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
    absorbed: np.ndarray  # (n, 3) impulse of absorbing faces over the step [N s]
    driven_mass: np.ndarray  # (n, 3) mass of driven points [kg]
    driven_momentum: np.ndarray  # (n, 3) their momentum with the prescribed velocity [kg m/s]
    impulse: np.ndarray  # (n, 3) impulse of prescribed motions on unit driven mass over the step [m/s]


class AdvancedNodes(NamedTuple):
    """The nodes of a velocity field and what acts on them, as kernels take them."""

    nodes: Nodes
    supports: Supports
    gravity: np.ndarray  # (3,) what acts of it [m/s²]
    external: ExternalAction
    load: np.ndarray  # (n, 3) the sum of the external forces [N]; no rows where there are none
    apart: np.ndarray  # (n, 3) internal forces of the bodies that keep heat [N]; no rows where these are with all others
    work: np.ndarray  # (chunks, ...) rows of works as `pellucid.energy` lays them out


@pointwise
def following(external, I, d, m):
    """How far node I of mass m [kg] follows the driven points that reach it, 0 to 1."""
    return min(1.0, external.driven_mass[I, d] / (FIRM * m))


@pointwise
def driven_velocity(external, I, d):
    """The velocity of the driven points that reach node I [m/s]."""
    return external.driven_momentum[I, d] / external.driven_mass[I, d]


@kernel(inner=True)
def _advance_chunk(chunk, field, dt, small, flip):
    nodes, walls, mirror, gravity = field.nodes, field.supports.velocity, field.supports.mirror, field.gravity
    external, work = field.external, field.work
    mass, momentum, force, velocity = nodes.mass, nodes.momentum, nodes.force, nodes.velocity
    velocity_increment, strain_velocity, constrained = nodes.velocity_increment, nodes.strain_velocity, nodes.constrained
    loaded, absorbing, driven = len(field.load) > 0, len(external.absorption) > 0, len(external.driven_mass) > 0
    total_load = field.load
    pushed = lost = 0.0
    first = FIRST_LOAD + len(external.loads) + 1  # of the impulses
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        if m < NOTHING:
            for d in range(3):
                velocity[I, d] = velocity_increment[I, d] = strain_velocity[I, d] = 0.0
            continue
        over_m = 1.0 / m
        for d in range(3):
            s = constrained[I, d]
            mapped = momentum[I, d] * over_m
            # a wall's nodes have its velocity before the step too: then points beside a wall keep their velocity, as they do
            # beside their mirror image; points in a clamp take the velocity of the clamp
            v = walls[s - 1, d] if s > 0 and mirror[s - 1] else mapped
            load = total_load[I, d] if loaded else 0.0
            light = v + dt * gravity[d]
            new = light + dt * (force[I, d] + load) * over_m
            if absorbing and s == 0:
                half = 0.5 * dt * external.absorption[I, d]  # of the mean velocity over the step: stable for any step
                slowed = (new - half * v) / (1.0 + half)
                external.absorbed[I, d] = m * (slowed - new)
                new = slowed
                light = (light - half * v) / (1.0 + half)
            if driven and s == 0:
                external.impulse[I, d] = 0.0
                if external.driven_mass[I, d] > 0.0:
                    follow, goal = following(external, I, d, m), driven_velocity(external, I, d)
                    external.impulse[I, d] = m * follow * (goal - new) / external.driven_mass[I, d]
                    new += follow * (goal - new)
                    light += follow * (goal - light)
            if s > 0:
                wall = walls[s - 1, d]
                impulse = m * (wall - new)
                lost += 0.5 * m * (wall - v) * (wall - v)
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
    work[chunk, SUPPORT] = pushed
    work[chunk, IMPACT] = lost


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
def _add_apart_chunk(chunk, field):
    force, apart = field.nodes.force, field.apart
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(apart))):
        for d in range(3):
            force[I, d] += apart[I, d]


@kernel()
def _advance(chunks, field, dt, small, flip):
    if len(field.apart) > 0:
        parallel_for(_add_apart_chunk, chunks, field)
    if len(field.load) > 0:  # apart: loops over the channels within the momentum equation would slow down all nodes
        parallel_for(_sum_loads_chunk, chunks, field)
    parallel_for(_advance_chunk, chunks, field, dt, small, flip)


@kernel(inner=True)
def _count_works_chunk(chunk, field, dt, small):
    nodes, external, gravity, work = field.nodes, field.external, field.gravity, field.work
    mass, force, velocity, velocity_increment = nodes.mass, nodes.force, nodes.velocity, nodes.velocity_increment
    loaded, absorbing, driven = len(field.load) > 0, len(external.absorption) > 0, len(external.driven_mass) > 0
    internal = fall = total = absorbed = moved = lost = 0.0
    columns = FIRST_LOAD + len(external.loads)
    others = columns + 1 + 3 * len(field.supports.velocity)
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m, energy = mass[I], 0.0
        if m < NOTHING:  # most of the nodes
            nodes.increment_energy[I] = nodes.mean_velocity[I, 0] = nodes.mean_velocity[I, 1] = nodes.mean_velocity[I, 2] = 0.0
            continue
        total += m
        for d in range(3):
            increment, s = velocity_increment[I, d], nodes.constrained[I, d]
            heavy = m > small or s > 0
            load = field.load[I, d] if loaded else 0.0
            if heavy:
                mean = mean_of_gravity = velocity[I, d] - 0.5 * increment
                energy += 0.5 * increment * increment
            else:
                mean, pull = nodes.momentum[I, d] / m, dt * gravity[d]
                mean_of_gravity = mean + 0.5 * pull
                energy += 0.5 * pull * pull
            if s > 0:
                mean = mean_of_gravity = field.supports.velocity[s - 1, d]
            elif driven and external.driven_mass[I, d] > 0.0:
                given, goal = external.impulse[I, d] * external.driven_mass[I, d], driven_velocity(external, I, d)
                follow = following(external, I, d, m)
                other = dt * (force[I, d] + m * gravity[d] + load)
                moved += given * goal
                lost += (given + follow * other) * (goal - mean)
                mean += follow * (goal - mean)
                mean_of_gravity = mean
            nodes.mean_velocity[I, d] = mean
            internal += dt * force[I, d] * mean
            fall += dt * m * gravity[d] * mean_of_gravity
            if absorbing and external.absorbed[I, d] != 0.0:
                absorbed -= external.absorbed[I, d] * mean
                work[chunk, others + d] += external.absorbed[I, d]
            if load != 0.0:
                work[chunk, others + d] += dt * load
                for k in range(len(external.loads)):
                    work[chunk, FIRST_LOAD + k] += dt * external.loads[k, I, d] * mean
        nodes.increment_energy[I] = energy
    work[chunk, INTERNAL] = internal
    work[chunk, GRAVITY] = fall
    work[chunk, ABSORBED] = absorbed
    work[chunk, MOTION] = moved
    work[chunk, IMPACT] += lost
    work[chunk, columns] = total


@kernel()
def _count_works(chunks, field, dt, small):
    parallel_for(_count_works_chunk, chunks, field, dt, small)


@kernel(inner=True)
def _sum_mapping_chunk(chunk, field, dt, small, sums):
    nodes, external, total, several = field.nodes, field.external, 0.0, len(field.apart) > 0
    driven = len(external.driven_mass) > 0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes.mass))):
        if nodes.mass[I] < NOTHING:
            continue
        for d in range(3):
            mean = nodes.mean_velocity[I, d]
            force = nodes.force[I, d] - field.apart[I, d] if several else nodes.force[I, d]
            old = mean
            if nodes.mass[I] > small or nodes.constrained[I, d] > 0:
                old = nodes.velocity[I, d] - nodes.velocity_increment[I, d]
            if driven and nodes.constrained[I, d] == 0 and external.driven_mass[I, d] > 0.0:  # as points were strained along it
                old += following(external, I, d, nodes.mass[I]) * (driven_velocity(external, I, d) - old)
            total += 0.5 * dt * force * (2.0 * mean - old - nodes.strain_velocity[I, d])
    sums[chunk, 0] = total


@kernel()
def _sum_mapping(chunks, field, dt, small, sums):
    parallel_for(_sum_mapping_chunk, chunks, field, dt, small, sums)


@kernel(inner=True)
def _project_chunk(chunk, field):
    nodes, walls, external = field.nodes, field.supports.velocity, field.external
    mass, momentum, strain_velocity, constrained = nodes.mass, nodes.momentum, nodes.strain_velocity, nodes.constrained
    driven = len(external.driven_mass) > 0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        over_m = 1.0 / m if m >= NOTHING else 0.0
        for d in range(3):
            s = constrained[I, d]
            if s > 0:
                strain_velocity[I, d] = walls[s - 1, d]
            else:
                v = momentum[I, d] * over_m
                if driven and m >= NOTHING and external.driven_mass[I, d] > 0.0:
                    v += following(external, I, d, m) * (driven_velocity(external, I, d) - v)
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
        apart: np.ndarray = NO_FORCES[:, :3],
    ) -> None:
        self.small_mass = small_mass
        self.flip = flip
        self._chunks = (len(nodes.mass) + CHUNK - 1) // CHUNK
        self._columns = FIRST_LOAD + len(external.loads)
        self._sums = np.zeros((self._chunks, row_length(self._columns, len(supports.velocity) + 1)))
        load = np.zeros((external.loads.shape[1] if len(external.loads) else 0, 3))
        self._full_gravity, self._gravity_share = np.array(gravity, float), 1.0
        self._gravity = self._full_gravity.copy()
        self._bundle = Bundle(AdvancedNodes(nodes, supports, self._gravity, external, load, apart, self._sums))

    def share_gravity(self, share: float) -> None:
        """Let a share of gravity act."""
        self._gravity_share, self._gravity[:] = share, share * self._full_gravity

    def advance(self, dt: float) -> None:
        """p + dt (f + m g) on every node, then the supports; fills velocity, velocity_increment and strain_velocity."""
        self._sums.fill(0.0)
        _advance(self._chunks, self._bundle, dt, self.small_mass, self.flip)

    def works(self, dt: float) -> StepWork:
        """Works of the step dt [s] and impulses of the supports, when nothing changes the velocities of the nodes any more.

        Forces do work along the mean of the velocities before and after the step, so that all works together are the change of
        kinetic energy of points that take these increments, but for what lumping loses of it (`transfer_heat`). Where a node is
        led by a support or driven points, they work along its velocity, and the impact of what arrives there is heat. Nodes of
        hardly any mass, where both are large and opposite, do without: there forces but gravity work along the velocity before
        the step, and of the increment only that by gravity is squared. Fills mean_velocity and increment_energy.
        """
        _count_works(self._chunks, self._bundle, dt, self.small_mass)
        done = step_work(ordered_sum(self._sums), self._columns)
        return done._replace(gravity_mass=self._gravity_share * done.gravity_mass)

    def strain_lag_work(self, dt: float) -> float:
        """Of what lumping took of the kinetic energy in a step dt [s], that which the stress of points without heat works less
        along `strain_velocity` than their forces did along the mean velocity [J]."""
        sums = np.zeros((self._chunks, 1))
        _sum_mapping(self._chunks, self._bundle, dt, self.small_mass, sums)
        return float(ordered_sum(sums)[0])

    def slowed_work(self, momentum: np.ndarray, dt: float) -> float:
        """Work that forces of points without heat would do over half a step dt [s] along what nodal velocities were slower at
        its start for the loss of this momentum [kg m/s], shape (n, 3); constrained nodes are not slower [J]."""
        nodes = self._bundle.nodes
        moves = (nodes.mass[:, None] >= NOTHING) & (nodes.constrained == 0)
        slower = np.divide(momentum, nodes.mass[:, None], out=np.zeros_like(momentum), where=moves)
        return self.half_work(slice(None), slower, dt)

    def half_work(self, node: np.ndarray | slice, increment: np.ndarray, dt: float) -> float:
        """Work in half a step dt [s] of forces of points without heat on velocity increments of nodes, shape (n, 3) [J]."""
        nodes, apart = self._bundle.nodes, self._bundle.apart
        force = nodes.force[node] - apart[node] if len(apart) else nodes.force[node]
        return 0.5 * dt * float(np.sum(force * increment))

    def impulse_velocity(self) -> np.ndarray:
        """The mean velocity along which impulses work that nodes got after their momentum was advanced [m/s]: that
        of forces, but where driven points lead a node in part, since the impulses came after these."""
        nodes, driven = self._bundle.nodes, self._bundle.external.driven_mass
        if not len(driven):
            return np.asarray(nodes.mean_velocity)
        led = (driven > 0.0) & (nodes.constrained == 0)
        return np.where(led, nodes.velocity - 0.5 * nodes.velocity_increment, nodes.mean_velocity)

    def project(self) -> None:
        """Velocities p/m of the mapped momentum, with supports, into `strain_velocity`."""
        _project(self._chunks, self._bundle)
