"""Impulses that conditions give the nodes after their momentum was advanced."""

import numpy as np

from pellucid.energy import FIRST_LOAD, GRAVITY, INTERNAL, StepWork
from pellucid.grid.lattice import Nodes
from pellucid.grid.momentum import FIRM, NOTHING, ExternalAction


def add_impulses(
    nodes: Nodes,
    external: ExternalAction,
    gravity: tuple[float, float, float],
    impulse: np.ndarray,
    dt: float,
    done: StepWork,
) -> float:
    """Change the velocities of the nodes by impulses [N s], shape (n, 3), after a step dt [s]; their work [J].

    Works are those along the mean of the velocities before and after the step, so that what others did changes too: that, and
    the impulse, is added to `done`. Constrained directions, those wholly led by driven points, and nodes without mass take
    nothing.
    """
    mass = nodes.mass[:, None]
    free = (mass >= NOTHING) & (nodes.constrained == 0)
    if len(external.driven_mass):
        free &= external.driven_mass < FIRM * mass
    given = np.where(free, impulse, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(free, impulse / mass, 0.0)
        old = np.where(free, nodes.momentum / mass, 0.0)
    strained = np.where(nodes.strain_velocity == nodes.velocity, change, 0.0)  # else a light node, which must not strain points
    for velocity, more in ((nodes.velocity, change), (nodes.velocity_increment, change), (nodes.strain_velocity, strained)):
        velocity += more
    further = 0.5 * dt * strained  # by which the mean velocity moves the nodes
    done.works[INTERNAL] += np.sum(nodes.force * further)
    done.works[GRAVITY] += np.sum(mass * further * np.array(gravity))
    for column, load in enumerate(external.loads, start=FIRST_LOAD):
        done.works[column] += np.sum(load * further) if len(load) else 0.0
    done.impulse[:] += given.sum(axis=0)
    return float(np.sum(0.5 * given * (old + nodes.strain_velocity)))
