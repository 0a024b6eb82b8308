"""Scatter and gather: mass, momentum, forces, and the patch test, for every grid function."""

import numpy as np
import pytest
from algebra import matrix, tensor
from small_cases import SOLID, box, place, simulation

from pellucid.approximants import GRID_FUNCTIONS

GRADIENT = np.array([[0.3, -0.2, 0.5], [0.1, -0.4, 0.2], [-0.6, 0.7, 0.2]])
DT = 0.125  # s
SPIN = np.array([[0.0, -0.3, 0.2], [0.3, 0.0, -0.7], [-0.2, 0.7, 0.0]])
every_function = pytest.mark.parametrize("functions", GRID_FUNCTIONS)


def filled(functions, counts=(3, 2, 4), lower=(-0.5, 0.25, 1.0), cell=0.5, **more):
    """A body that fills the grid; its points lie at random, some on walls, edges and corners."""
    upper = [a + n * cell for a, n in zip(lower, counts, strict=True)]
    sim = simulation(box(lower, upper), counts=counts, lower=lower, cell=cell, functions=functions, **more)
    body = sim.bodies[0]
    generator = np.random.default_rng(1)
    inside = generator.random((body.n_points, 3))
    for wall in (0.0, 1.0):
        inside[generator.random(inside.shape) < 0.15] = wall
    place(body, inside * (np.array(upper) - lower) + lower)
    body.arrays["velocity"][:] = generator.normal(size=(body.n_points, 3))
    body.arrays["stress"][:] = generator.normal(size=(body.n_points, 6))
    body.arrays["mass"] *= generator.uniform(0.5, 2.0, body.n_points)
    body.arrays["volume"] *= generator.uniform(0.5, 2.0, body.n_points)
    return sim


def scatter(sim):
    sim.stages.clear_nodes()
    for body in sim.bodies:
        body.particle_to_grid(inertia=True, force=True)
    return sim.grid.nodes


@every_function
def test_mass_and_momentum_arrive(functions):
    sim = filled(functions)
    nodes, points = scatter(sim), sim.bodies[0].points
    # sums of a few hundred numbers
    assert nodes.mass.sum() == pytest.approx(points.mass.sum(), rel=1e-14)
    scale = points.mass @ np.abs(points.velocity)
    assert np.abs(nodes.momentum.sum(axis=0) - points.mass @ points.velocity).max() < 1e-14 * scale.max()
    index, _ = sim.grid.where()
    assert nodes.mass.min() >= 0.0
    assert not np.delete(nodes.mass, index).any(), "nothing beyond the walls"


@every_function
def test_the_centre_of_mass_stays(functions):
    sim = filled(functions)
    nodes, points = scatter(sim), sim.bodies[0].points
    index, position = sim.grid.where()
    # linear functions are reproduced; positions are of order three
    assert nodes.mass[index] @ position == pytest.approx(points.mass @ points.position, rel=1e-13)


@every_function
def test_internal_forces_balance_and_do_the_work_of_the_stress(functions):
    """Σ f = 0, and Σ f x = -Σ V σ, which is symmetric: no resultant and no moment."""
    sim = filled(functions)
    nodes, points = scatter(sim), sim.bodies[0].points
    index, position = sim.grid.where()
    force = nodes.force[index]
    scale = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * scale
    virial = -sum(V * matrix(s) for V, s in zip(points.volume, points.stress, strict=True))
    # relative to the sum of the parts' sizes, positions of order three
    assert np.abs(force.T @ position - virial).max() < 1e-14 * scale * 3.0


@every_function
def test_uniform_stress_pushes_no_node_inside(functions):
    sim = simulation(box((0, 0, 0), (5, 5, 5)), counts=(5, 5, 5), functions=functions)
    sim.bodies[0].arrays["stress"][:] = (1.0, -2.0, 3.0, 0.5, -0.7, 0.9)
    force = scatter(sim).force
    index, position = sim.grid.where()
    inside = np.all((position > 1.5) & (position < 3.5), axis=1)
    assert inside.sum() == 8
    # eight to sixty-four points a node, each force of order one
    assert np.abs(force[index[inside]]).max() < 1e-13


@every_function
def test_patch(functions):
    """A linear field on the nodes: every point sees its gradient exactly, moves with it and strains by it."""
    for field in (GRADIENT, SPIN, np.diag([0.1, -0.2, 0.3])):
        sim, dt = filled(functions), 0.125
        body, nodes = sim.bodies[0], sim.grid.nodes
        index, position = sim.grid.where()
        for values in (nodes.velocity, nodes.strain_velocity):
            values[index] = position @ field.T + (1.0, -2.0, 3.0)
        before, volume = body.points.position.copy(), body.points.volume.copy()
        body.update_stress(dt, move=True)
        # velocities of order five in cells of half a metre: 5 / 0.5 * 1e-16, a few dozen terms
        found = body.arrays["deformation_gradient"]
        assert np.abs(found - tensor(np.eye(3) + dt * field)).max() < 2e-14
        assert np.abs(body.points.position - before - dt * (before @ field.T + (1.0, -2.0, 3.0))).max() < 1e-14
        assert body.points.volume == pytest.approx(volume * np.linalg.det(np.eye(3) + dt * field), rel=1e-13)


@every_function
def test_rigid_rotation_gives_no_strain(functions):
    sim = filled(functions)
    body, nodes = sim.bodies[0], sim.grid.nodes
    index, position = sim.grid.where()
    for values in (nodes.velocity, nodes.strain_velocity):
        values[index] = position @ SPIN.T
    body.update_stress(1e-3, move=True)
    stretching = matrix_of(body.arrays["deformation_gradient"]) - np.eye(3)
    assert np.abs(stretching + np.swapaxes(stretching, 1, 2)).max() < 1e-15  # rounding of 1 + dt L


def matrix_of(rows):
    return rows.reshape(-1, 3, 3)


@every_function
def test_a_linear_velocity_goes_through_the_nodes(functions):
    """What FLIP takes from nodes at rest changes nothing; what it takes from a uniform change is uniform."""
    sim = filled(functions)
    body, nodes = sim.bodies[0], sim.grid.nodes
    index, position = sim.grid.where()
    before = body.points.velocity.copy()
    nodes.velocity_increment[index] = position @ GRADIENT.T
    body.grid_to_particle(DT, remap=False)
    # positions and changes of order three
    assert np.abs(body.points.velocity - before - body.points.position @ GRADIENT.T).max() < 2e-14
    points = body.points
    assert body.totals.kinetic == pytest.approx(0.5 * (points.mass @ (points.velocity**2).sum(axis=1)), rel=1e-13)
    assert body.totals.momentum == pytest.approx(points.mass @ points.velocity, abs=1e-13 * body.totals.momentum_size)


@every_function
def test_momentum_mapped_anew_is_that_of_the_points(functions):
    sim = filled(functions)
    body, nodes = sim.bodies[0], sim.grid.nodes
    body.grid_to_particle(DT, remap=True)
    scale = body.points.mass @ np.abs(body.points.velocity)
    assert np.abs(nodes.momentum.sum(axis=0) - body.points.mass @ body.points.velocity).max() < 1e-14 * scale.max()


def test_apic_carries_affine_fields_exactly():
    sim = filled("quadratic-bspline", transfer="apic")
    body, nodes = sim.bodies[0], sim.grid.nodes
    index, position = sim.grid.where()
    for values in (nodes.velocity, nodes.strain_velocity):
        values[index] = position @ GRADIENT.T + (1.0, -2.0, 3.0)
    body.grid_to_particle(DT, remap=False)
    # gradients: velocities of order five over cells of half a metre, over a spread of the weights of at least 1e-4
    assert np.abs(body.arrays["affine"][:, :9] - tensor(GRADIENT)).max() < 1e-10
    expected = body.points.position @ GRADIENT.T + (1.0, -2.0, 3.0)
    assert np.abs(body.points.velocity - expected).max() < 1e-14 * 10
    mass = scatter(sim).mass[index]
    reached = mass > 0.0
    found = nodes.momentum[index][reached] / mass[reached, None]
    assert np.abs(found - nodes.velocity[index][reached]).max() < 1e-10


@pytest.mark.parametrize(
    ("functions", "counts"),
    [*(("trilinear", counts) for counts in [(1, 1, 3), (1, 3, 1), (3, 1, 1), (1, 2, 2)]), ("cubic-bspline", (1, 2, 2))],
)
def test_thin_axes_and_any_slab_axis(functions, counts):
    """The patch test with one-cell-thick axes, along which nothing changes, and along every axis of memory."""
    sim = filled(functions, counts=counts)
    gradient = GRADIENT * (np.array(counts) > 1)
    body, nodes = sim.bodies[0], sim.grid.nodes
    assert sim.grid.lattice.slab_axis == int(np.argmax(counts))
    index, position = sim.grid.where()
    for values in (nodes.velocity, nodes.strain_velocity):
        values[index] = position @ gradient.T
    body.update_stress(0.125, move=True)
    assert np.abs(body.arrays["deformation_gradient"] - tensor(np.eye(3) + 0.125 * gradient)).max() < 2e-14


def test_one_point_alone():
    sim = simulation(box((1.25, 1.25, 1.25), (1.75, 1.75, 1.75), SOLID, (1, 1, 1)))
    body = sim.bodies[0]
    assert body.n_points == 1
    nodes = scatter(sim)
    index, position = sim.grid.where()
    reached = nodes.mass[index] > 0.0
    assert reached.sum() == 8
    assert nodes.mass[index] == pytest.approx(np.where(reached, body.points.mass[0] / 8.0, 0.0))
    assert position[reached].min(axis=0) == pytest.approx([1.0, 1.0, 1.0])
