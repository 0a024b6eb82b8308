"""Impulses that conditions give the nodes after their momentum was advanced."""

import numpy as np

from pellucid.grid.lattice import Nodes
from pellucid.grid.momentum import FULL_DRIVE_FRACTION, MASS_EPS, ExternalAction


def add_impulses(nodes: Nodes, external: ExternalAction, impulse: np.ndarray) -> np.ndarray:
    """Change the velocities of the nodes by impulses [N s], shape (n, 3); those that they took, of the same shape.

    Constrained directions, those wholly led by driven points, and nodes without mass take nothing.
    """
    mass = nodes.mass[:, None]
    free = (mass >= MASS_EPS) & (nodes.constrained == 0)
    if len(external.driven_mass):
        free &= external.driven_mass < FULL_DRIVE_FRACTION * mass
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(free, impulse / mass, 0.0)
    strained = np.where(nodes.strain_velocity == nodes.velocity, change, 0.0)  # else a light node, which must not strain points
    for velocity, more in ((nodes.velocity, change), (nodes.velocity_increment, change), (nodes.strain_velocity, strained)):
        velocity += more
    return np.where(free, impulse, 0.0)
