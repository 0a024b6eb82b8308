"""Impulses that conditions apply to the nodes after the momentum update."""

import numpy as np

from pellucid.grid.lattice import Nodes
from pellucid.grid.momentum import FULL_DRIVE_FRACTION, MASS_EPS, ExternalAction
from pellucid.jit import kernel


def add_impulses(nodes: Nodes, external: ExternalAction, impulse: np.ndarray, node: np.ndarray | None = None) -> np.ndarray:
    """Change the velocities of all nodes, or of the nodes with the indices `node`, by impulses [N s], shape (n, 3). Return
    the impulses that were applied, same shape.

    nodes, external: nodal arrays and actions, see `AdvancedNodes`. No impulse is applied along constrained directions,
    along directions with motion fully prescribed by driven points (points with a prescribed motion), or to nodes without
    mass.
    """
    listed = np.arange(len(nodes.mass)) if node is None else node
    given = np.empty_like(impulse)
    velocities = nodes.velocity, nodes.velocity_increment, nodes.strain_velocity
    _add_impulses(listed, impulse, given, nodes.mass, nodes.constrained, external.driven_mass, *velocities)
    return given


@kernel()
def _add_impulses(listed, impulse, given, mass, constrained, driven_mass, velocity, velocity_increment, strain_velocity):
    for e in range(len(listed)):
        I = listed[e]
        m = mass[I]
        for d in range(3):
            given[e, d] = 0.0
            driven = len(driven_mass) > 0 and driven_mass[I, d] >= FULL_DRIVE_FRACTION * m
            if m < MASS_EPS or constrained[I, d] != 0 or driven:
                continue
            change, given[e, d] = impulse[e, d] / m, impulse[e, d]
            if strain_velocity[I, d] == velocity[I, d]:  # else a light node, which must not strain points
                strain_velocity[I, d] += change
            velocity[I, d] += change
            velocity_increment[I, d] += change
