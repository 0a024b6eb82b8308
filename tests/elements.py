"""Bodies of membrane elements for tests, on a grid without a simulation. Tests move their nodes directly or by steps."""

from types import SimpleNamespace

import numpy as np
from membranes import sheet
from small_cases import case

from pellucid.bodies.membrane_elements.on_own_nodes import MembraneElements
from pellucid.energy import FIRST_LOAD
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_transfer import Flip
from pellucid.parts.body import NodalSupport, Placement

DENSITY = 1000.0


def element_sheet(law="linear-membrane", points=(7, 7), **more):
    """Return the table of a square sheet of membrane elements with edges of 1 m about the origin, see `membranes.sheet`."""
    return sheet(law, points=points, kind="membrane-elements") | more


def body_of(table, mesh=None, counts=(16, 16, 16), cell=0.25, lower=(-2.0, -2.0, -2.0), gravity=(0.0, 0.0, 0.0)):
    """Build the body of a table in a velocity field of its own, with one channel of loads; mesh: a mesh that replaces the
    mesh of the table."""
    whole = case(table, counts=counts, cell=cell, lower=lower)
    body = whole.body[0]
    if mesh is not None:
        keys = (
            "name",
            "material",
            "thickness",
            "contact_reach",
            "hourglass",
            "bending",
            "tension",
            "inflation",
            "area_stiffness",
            "volume_stiffness",
            "is_kept",
            "initial_velocity",
        )
        body = SimpleNamespace(**{key: getattr(body, key) for key in keys}, mesh=lambda: Mesh(mesh.vertices.copy(), *mesh[1:]))
    field = OwnNodesField("own", Grid(whole.grid))
    return MembraneElements(body, Placement(whole.grid, field, Flip(), gravity, n_loads=1))


def distorted(mesh, amount, seed=0, across=0.0):
    """Return a plane mesh, z = constant, with its inner nodes moved in the plane at random by at most `amount` [m], and all
    nodes normal to it by at most `across` [m]."""
    generator = np.random.default_rng(seed)
    shift = generator.uniform(-1.0, 1.0, mesh.vertices.shape) * (amount, amount, 0.0)
    shift[rim(mesh)] = 0.0
    shift[:, 2] = across * generator.uniform(-1.0, 1.0, len(shift))
    return Mesh(mesh.vertices + shift, mesh.quads, mesh.triangles)


def rim(mesh):
    """Return a mask of the nodes on the bounding rectangle of a plane sheet, z = constant."""
    plane = mesh.vertices[:, :2]
    return np.any((plane - plane.min(axis=0) < 1e-9) | (plane.max(axis=0) - plane < 1e-9), axis=1)


def bring(body, target, dt=1.0):
    """Move the nodes, in the order of the mesh, to `target` [m] in one step [s]."""
    body.arrays["velocity"][:] = (target - body.arrays["position"]) / dt
    body.update(dt)
    body.check(0, 0.0)


def places(body):
    """Return a copy of the node positions of a body [m], shape (n, 3)."""
    return body.arrays["position"].copy()


def forces(body):
    """Return the internal forces on the nodes of a body at their present positions [N], shape (n, 3)."""
    force = np.zeros((body.n_points, 3))
    body.surface.add_internal_forces(body.arrays["position"], force)
    return force


def step(body, dt, pressure=0.0):
    """Advance a body by one step dt [s] without contact, under a pressure [Pa]."""
    body.velocity_field.clear()
    body.begin(dt)
    if pressure:
        body.add_pressure(pressure, FIRST_LOAD)
    body.predict(dt)
    body.correct(remap=False)
    body.update(dt)
    body.check(0, 0.0)


def supported(places, axes, velocity=(0.0, 0.0, 0.0)):
    """Return a support that holds the nodes `places`, shape (n,), along some axes, such as "xz"; velocity [m/s]."""
    return NodalSupport(places, tuple(axis in axes for axis in "xyz"), velocity, None)


def wall(body, axis, end, velocity=(0.0, 0.0, 0.0)):
    """Return the support of a face of the grid that no node of a body may cross; at the start it holds no node."""
    return NodalSupport(np.zeros(body.n_points, bool), (False, False, False), velocity, (axis, end))


def global_stress(body):
    """Return the Cauchy stresses at the nodes of a body as matrices [Pa], shape (n, 3, 3)."""
    xx, yy, zz, yz, xz, xy = body.frame()["stress"].T
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)


def rotation(axis, angle):
    """Return the rotation matrix about an axis by an angle [rad], shape (3, 3)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def single_element(table, kind):
    """Build a body of one distorted element with edges of about 1 m; kind: "quadrilaterals" or "triangles"."""
    numbers = np.random.default_rng(2)
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) + numbers.uniform(-0.2, 0.2, (4, 3)) * (1, 1, 0)
    none = [np.zeros((0, n), int) for n in (4, 3)]
    quad, triangle = Mesh(corners, np.array([[0, 1, 2, 3]]), none[1]), Mesh(corners[:3], none[0], np.array([[0, 1, 2]]))
    return body_of(table, quad if kind == "quadrilaterals" else triangle, counts=(4, 4, 4), cell=4.0, lower=(-8,) * 3)


def bring_to(body, stretches, steps=20):
    """Stretch a body along x and y by two ratios, in several steps."""
    start = places(body)
    for k in range(1, steps + 1):
        bring(body, start * (*np.power(stretches, k / steps), 1.0))


def fastest_frequency(body):
    """Return the largest eigenfrequency of a body of elements [1/s], from the stiffness matrix by differences of the nodal
    forces."""
    position, kept = places(body), {name: array.copy() for name, array in body.element_arrays.items()}

    def forces_at(shift):
        for name, array in kept.items():
            body.element_arrays[name][...] = array
        body.surface.strain(position + shift, shift, 1.0, body.totals)
        body.arrays["position"][:] = position + shift
        return forces(body).ravel()

    shifts = 1e-6 * np.eye(position.size).reshape(-1, *position.shape)
    stiffness = np.array([forces_at(-shift) - forces_at(shift) for shift in shifts]) / 2e-6
    return np.sqrt(np.linalg.eigvals(stiffness / np.repeat(body.arrays["mass"], 3)).real.max())
