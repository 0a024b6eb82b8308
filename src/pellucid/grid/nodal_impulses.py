"""Impulses that conditions apply to the nodes after the momentum update."""

import numpy as np

from pellucid.grid.lattice import Nodes
from pellucid.grid.momentum import FULL_DRIVE_FRACTION, MASS_EPS, ExternalAction


def add_impulses(
    nodes: Nodes, external: ExternalAction, impulse: np.ndarray, node: np.ndarray | slice = slice(None)
) -> np.ndarray:
    """Change the velocities of all nodes, or of the nodes with the indices `node`, by impulses [N s], shape (n, 3). Return
    the impulses that were applied, same shape.

    nodes, external: nodal arrays and actions, see `AdvancedNodes`. No impulse is applied along constrained directions,
    along directions with motion fully prescribed by driven points (points with a prescribed motion), or to nodes without
    mass.
    """
    mass = nodes.mass[node, None]
    free = (mass >= MASS_EPS) & (nodes.constrained[node] == 0)
    if len(external.driven_mass):
        free &= external.driven_mass[node] < FULL_DRIVE_FRACTION * mass
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(free, impulse / mass, 0.0)
    # else a light node, which must not strain points
    strained = np.where(nodes.strain_velocity[node] == nodes.velocity[node], change, 0.0)
    nodes.velocity[node] += change
    nodes.velocity_increment[node] += change
    nodes.strain_velocity[node] += strained
    return np.where(free, impulse, 0.0)
