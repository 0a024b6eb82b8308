"""Meshless solids for tests: bodies without a case, and cases of a cube."""

from typing import NamedTuple

import numpy as np

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.bodies.meshless_solid.body import MeshlessSolid
from pellucid.case import Case
from pellucid.geometry.meshes.points import spatial_order
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.grid.velocity_transfer import Flip
from pellucid.materials.elastic import lame
from pellucid.materials.neo_hookean import NeoHookean
from pellucid.parts.body import NodalSupport, Placement


class Tissue(NamedTuple):
    """Model of a meshless solid with the attributes that the body reads, without a case."""

    mesh: SimplexMesh
    kind: str = "cell-based-maximum-entropy"
    essential: str = "direct"
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

    def initial_stress_at(self, position):
        return None


def held(where, axes="xyz", velocity=(0.0, 0.0, 0.0)):
    """Return a function that builds a support from node positions; `where` selects the supported nodes by their positions."""
    return lambda places: NodalSupport(where(places), ("x" in axes, "y" in axes, "z" in axes), velocity, None)


def solid(mesh, *supports, **settings):
    """Return a complete meshless solid on a mesh, with supports (see `held`) and settings of `Tissue`."""
    body = MeshlessSolid(Tissue(mesh, **settings), Placement(None, None, Flip(), (0.0, 0.0, 0.0), 0))
    body.add_supports([support(mesh.nodes) for support in supports])
    body.complete()
    return body


def advance_alone(body, steps, dt):
    """Advance a body by several steps dt [s] without grid, contact or simulation."""
    for _ in range(steps):
        body.begin(dt)
        body.predict(dt)
        body.correct(remap=False)
        body.update(dt)


TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.49}
EDGE = 0.1
PULL = 0.01


def block_of(material=TISSUE, cells=(3, 3, 3), **more):
    """Return the table of a body that is a cube with the edge EDGE [m]."""
    mesh = {"box": {"lower": (0.0, 0.0, 0.0), "upper": (EDGE, EDGE, EDGE), "cells": cells}}
    return {"name": "block", "kind": "meshless-solid", "mesh": mesh, "material": material} | more


def block(material=TISSUE, cells=(3, 3, 3), body=None, **more):
    """Return the case of the cube of `block_of`; body: further keys of the body."""
    table = {"schema": 1, "title": "a test", "time": {"end": 0.4}, "body": [block_of(material, cells) | (body or {})]}
    return Case.model_validate(table | more)


def layer(z):
    """Return the region of the nodes at a height z [m]."""
    return {"box": {"lower": (-1.0, -1.0, z - 1e-4), "upper": (1.0, 1.0, z + 1e-4)}}


def thrown(material):
    """Return the case of a cube that is clamped at its lower face and starts with a velocity: kinetic energy turns into
    strain energy, and partly back."""
    wave = {"kind": "sine-wave", "amplitude": (0.3, 0.0, 0.3), "wave_vector": (0.0, 0.0, 15.0)}
    foot = [{"name": "foot", "where": layer(0.0)}]
    return block(material, body={"initial": [wave]}, support=foot, time={"end": 0.04, "courant": 0.225})


def pulled_block(duration=0.3, end=None, **body):
    """Return the table of a case in which the upper face of a clamped cube moves up by PULL over a duration [s]."""
    rise = {"kind": "ramp", "distance": PULL, "duration": duration}
    return {
        "schema": 1,
        "title": "a test",
        "time": {"end": end or duration},
        "body": [block_of() | body],
        "support": [{"name": "bottom", "where": layer(0.0)}],
        "motion": [{"name": "top", "body": "block", "part": layer(EDGE), "hold": ["x", "y"], "displacement": {"z": rise}}],
    }


def displacement(simulation):
    """Return the displacements of the nodes of the first body [m], shape (n, 3)."""
    body = simulation.bodies[0]
    return body.arrays["position"] - body.mesh.nodes
