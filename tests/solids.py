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

    def viscous(self):
        return None

    def initial_velocity(self, position):
        return np.zeros_like(position)


def held(where, axes="xyz", velocity=(0.0, 0.0, 0.0)):
    """A support on the nodes that a function of their places selects: the support, from these places."""
    return lambda places: NodalSupport(where(places), ("x" in axes, "y" in axes, "z" in axes), velocity, None)


def solid(mesh, *supports, **settings):
    """A body whose conditions are known."""
    body = MeshlessSolid(Tissue(mesh, **settings), Placement(None, None, Flip(), (0.0, 0.0, 0.0), 0))
    body.add_supports([support(mesh.nodes) for support in supports])
    body.complete()
    return body


def advance_alone(body, steps, dt):
    """Several steps of a body in nothing."""
    for _ in range(steps):
        body.begin(dt)
        body.predict(dt)
        body.correct(remap=False)
        body.update(dt)


PULL = 0.01


def pulled_block(duration=0.3, **body):
    """The case of a block between a clamp and one that moves up by PULL over a duration [s]."""
    low, high = ((-1.0, -1.0, z - 1e-4, 1.0, 1.0, z + 1e-4) for z in (0.0, 0.1))
    block = {
        "name": "block",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": (0.0, 0.0, 0.0), "upper": (0.1, 0.1, 0.1), "cells": (3, 3, 3)}},
        "material": {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.49},
    }
    top = {"name": "top", "body": "block", "part": {"box": {"lower": high[:3], "upper": high[3:]}}, "hold": ["x", "y"]}
    rise = {"kind": "ramp", "distance": PULL, "duration": duration}
    return {
        "schema": 1,
        "title": "a test",
        "time": {"end": duration},
        "body": [block | body],
        "support": [{"name": "bottom", "where": {"box": {"lower": low[:3], "upper": low[3:]}}}],
        "motion": [top | {"displacement": {"z": rise}}],
    }
