"""Meshless solids for tests, without a case."""

from typing import NamedTuple

import numpy as np

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.bodies.meshless_solid.body import MeshlessSolid
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.geometry.spatial_order import spatial_order
from pellucid.grid.velocity_transfer import Flip
from pellucid.materials.elastic import lame
from pellucid.materials.neo_hookean import NeoHookean
from pellucid.parts.body import NodalSupport, Placement


class Tissue(NamedTuple):
    """What a meshless solid asks of its model."""

    mesh: SimplexMesh
    kind: str = "cell-based-maximum-entropy"
    essential_conditions: str = "direct"
    name: str = "tissue"
    place: str = "mesh"
    points_per_cell: int = 4
    consistent: bool = True
    averages_volume: bool = False
    density: float = 1000.0
    damping: float = 0.0

    @property
    def approximant(self):
        return NODAL_APPROXIMANTS.entries[self.kind]()

    def mesh_in_order(self):
        order = spatial_order(self.mesh.nodes[self.mesh.cells].mean(axis=1))
        return SimplexMesh(self.mesh.nodes, self.mesh.cells[order])

    def law(self):
        return NeoHookean(*lame(3000.0, 0.3), self.density)

    def initial_velocity(self, position):
        return np.zeros_like(position)


def held(where, axes="xyz", velocity=(0.0, 0.0, 0.0)):
    """A support on the nodes that a function of their places selects."""
    return NodalSupport(where, ("x" in axes, "y" in axes, "z" in axes), velocity, None)


def solid(mesh, *supports, **settings):
    """A body whose conditions are known."""
    body = MeshlessSolid(Tissue(mesh, **settings), Placement(None, None, Flip(), (0.0, 0.0, 0.0), 0))
    body.add_supports(supports)
    body.complete()
    return body


def advance_alone(body, steps, dt):
    """Several steps of a body in nothing."""
    for _ in range(steps):
        body.begin(dt)
        body.predict(dt)
        body.correct(remap=False)
        body.update(dt)
