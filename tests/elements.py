"""Membrane elements for tests: on a grid of their own, without a simulation, their nodes moved by hand or by steps."""

from types import SimpleNamespace

import numpy as np
from membranes import sheet
from scenes import case

from pellucid.bodies.membrane_elements.on_own_nodes import MembraneElements
from pellucid.geometry.mesh import Mesh
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_transfer import Flip

DENSITY = 1000.0


def element_sheet(law="linear-membrane", points=(7, 7), **more):
    """A sheet of elements of 1 m about the origin, as `membranes.sheet`."""
    return sheet(law, points=points, kind="membrane-elements") | more


def body_of(table, mesh=None, counts=(16, 16, 16), cell=0.25, lower=(-2.0, -2.0, -2.0)):
    """The body on a grid of its own; with another mesh where one is given."""
    whole = case(table, counts=counts, cell=cell, lower=lower)
    body = whole.body[0]
    if mesh is not None:
        keys = ("name", "material", "thickness", "hourglass", "velocity")
        body = SimpleNamespace(**{key: getattr(body, key) for key in keys}, mesh=lambda: Mesh(mesh.vertices.copy(), *mesh[1:]))
    return MembraneElements(body, whole.grid, Grid(whole.grid, own_nodes=True), Flip())


def distorted(mesh, amount, seed=0, across=0.0):
    """The mesh with its inner nodes moved at random in its plane, z = constant, by at most `amount` [m]; all `across` it."""
    generator = np.random.default_rng(seed)
    shift = generator.uniform(-1.0, 1.0, mesh.vertices.shape) * (amount, amount, 0.0)
    shift[rim(mesh)] = 0.0
    shift[:, 2] = across * generator.uniform(-1.0, 1.0, len(shift))
    return Mesh(mesh.vertices + shift, mesh.quads, mesh.triangles)


def rim(mesh):
    """Which nodes lie on the bounding rectangle of a sheet with z = constant."""
    plane = mesh.vertices[:, :2]
    return np.any((plane - plane.min(axis=0) < 1e-9) | (plane.max(axis=0) - plane < 1e-9), axis=1)


def bring(body, target, dt=1.0):
    """Move the nodes, in the order of the mesh, to `target` [m] in one step [s]."""
    body.sort_if_needed()
    number = body.arrays["id"]
    body.arrays["velocity"][:] = (target[number] - body.arrays["position"]) / dt
    body.update_stress(dt, move=True)
    body.check(0, 0.0)


def places(body):
    """Positions in the order of the mesh."""
    return in_order(body, body.arrays["position"])


def in_order(body, values):
    """What is stored at nodes, in the order of the mesh."""
    return values[np.argsort(body.arrays["id"])]


def forces(body):
    """Internal forces [N] in the order of the mesh."""
    body.begin(0.0)
    return in_order(body, body._internal)


def step(body, dt, pressure=0.0):
    """One step without contact."""
    body.sort_if_needed()
    body.begin(dt)
    if pressure:
        body.press(np.zeros((0, 3)), pressure)
    body.update_velocities(remap=False)
    body.update_stress(dt, move=True)
    body.check(0, 0.0)


def global_stress(body):
    """Stresses of the nodes as matrices, shape (n, 3, 3)."""
    xx, yy, zz, yz, xz, xy = body.frame()["stress"].T
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)


def rotation(axis, angle):
    """Rotation about an axis, shape (3, 3)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
