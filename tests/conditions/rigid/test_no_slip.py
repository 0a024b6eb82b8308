"""The surface of a rigid body as seen from nodes, and the velocity profile of a fluid near it."""

import numpy as np
import pytest
from small_cases import SOLID, box, case

from pellucid.conditions.rigid.no_slip import NoSlip, Surface
from pellucid.grid.transfer import scatter_numbers, scatter_vectors
from pellucid.simulation.simulation import Simulation


def filled_below(height, functions):
    """A grid and the share of each node that a body below a height fills, by a fine sum over its points."""
    block = box((0, 0, 0), (8, 8, 0), SOLID, (1, 1, 1))
    grid = Simulation(case(block, counts=(8, 8, 1), functions=functions), threads=1).bodies[0].velocity_field.grid
    index, place = grid.where()
    z = np.arange(-40000, 40000) * 2e-4 + 1e-4
    width = {"trilinear": 1, "gimp": 1, "quadratic-bspline": 2, "cubic-bspline": 3}[functions] + 1
    kernel = np.zeros_like(z)  # a B-spline is a box convolved with itself
    kernel[np.abs(z) < 0.5] = 1.0
    spectrum = np.fft.fft(np.fft.ifftshift(kernel))
    kernel = np.fft.fftshift(np.fft.ifft(spectrum**width).real) * (2e-4) ** (width - 1)
    filled = np.zeros(grid.n_nodes)
    filled[index] = [np.sum(kernel[z + y < height]) * 2e-4 for y in place[:, 1]]
    return grid, filled, index, place


@pytest.mark.parametrize("functions", ["trilinear", "gimp", "quadratic-bspline", "cubic-bspline"])
def test_a_plane_face_is_found_between_nodes(functions):
    """To the width of the sum, with the normal."""
    grid, filled, index, place = filled_below(4.3, functions)
    near = place[(np.abs(place[:, 1] - 4.3) < 0.75) & (place[:, 0] > 2) & (place[:, 0] < 6)]
    no_slip = NoSlip(grid)
    window = no_slip.find_window(index)
    surface = no_slip.find_surface(window, filled[window.node], near)
    assert surface.distance == pytest.approx(near[:, 1] - 4.3, abs=2e-3)
    assert surface.normal == pytest.approx(np.tile([0.0, 1.0, 0.0], (len(near), 1)), abs=1e-9)
    assert surface.certainty == pytest.approx(np.ones(len(near)))


def test_a_quadratic_profile_goes_on_through_the_surface():
    grid, filled, index, place = filled_below(2.3, "quadratic-bspline")
    no_slip = NoSlip(grid)
    near = place[(np.abs(place[:, 1] - 2.3) < 0.75) & (place[:, 0] > 2) & (place[:, 0] < 6)]
    window = no_slip.find_window(index)
    surface = no_slip.find_surface(window, filled[window.node], near)

    def flow(y):
        return np.outer(0.7 * y - 0.1 * y * y, [1.0, 0.0, 0.0])

    at = [near + (height - surface.distance)[:, None] * surface.normal for height in no_slip.heights]
    relative = [flow(x[:, 1] - 2.3) for x in at]
    both = np.ones(len(near))
    goal = no_slip.continue_profile(surface, *relative, both)
    assert goal == pytest.approx(flow(surface.distance), abs=2e-3)
    velocity = np.zeros((grid.n_nodes, 3))
    velocity[index] = np.outer(place[:, 1], [0.5, 0.0, 0.0])
    found, known = no_slip.sample(window, velocity[window.node], np.ones(len(window.node)), at[0])
    assert known == pytest.approx(1.0)
    assert found[:, 0] == pytest.approx(0.5 * at[0][:, 1])
    assert not no_slip.sample(window, velocity[window.node], np.zeros(len(window.node)), at[0])[1].any()


def test_the_profile_about_a_cylinder_is_exact():
    """That of steady shear flow about a turning cylinder of five cells, 1/r - r."""
    radius = 5.0
    distance = np.array([-1.0, -0.3, 0.4, 1.2])
    normal, along = np.array([[1.0, 0.0, 0.0]] * 4), np.array([0.0, 1.0, 0.0])
    surface = Surface(distance, normal, np.ones(4), 1.0 / radius)
    grid = filled_below(4.3, "quadratic-bspline")[0]

    def flow(d):
        return np.outer(radius / (radius + d) - (radius + d) / radius, along)

    no_slip = NoSlip(grid)
    near, far = (flow(np.full(4, height)) for height in no_slip.heights)
    assert no_slip.continue_profile(surface, near, far, np.ones(4)) == pytest.approx(flow(distance), abs=1e-12)


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.3, 0.2), (0.5, 0.5)])
def test_the_surface_of_a_disc_of_points_is_found_from_all_nodes_that_it_reaches(place):
    """Also from those that hardly a point reaches: in the mean within .03 of a cell, with a spread of .09 from points a
    third of a cell apart."""
    centre = np.array([8.0 + place[0], 8.0 + place[1], 0.0])
    disc = {"cylinder": {"centre": centre.tolist(), "radius": 5.0}}
    body = {"name": "disc", "shape": disc, "points_per_cell": (3, 3, 1), "material": SOLID}
    body = Simulation(case(body, counts=(16, 16, 1), functions="quadratic-bspline"), threads=1).bodies[0]
    grid, filled = body.velocity_field.grid, np.zeros((body.velocity_field.grid.n_nodes, 3))
    points = body.on_grid
    scatter_vectors(points.n_slabs, points.mapped, np.outer(body.arrays["volume"], [1.0, 0.0, 0.0]), filled)
    filled = filled[:, 0] / grid.cell_volume
    no_slip, reached = NoSlip(grid), np.flatnonzero(filled > 1e-12)
    arm = grid.find_positions(reached) - centre
    radius = np.hypot(arm[:, 0], arm[:, 1])
    outside = radius > 4.5
    window = no_slip.find_window(reached)
    surface = no_slip.find_surface(window, filled[window.node], grid.find_positions(reached))
    error = (surface.distance - (radius - 5.0))[outside]
    assert abs(error.mean()) < 0.03
    assert error.std() < 0.09
    assert surface.curvature == pytest.approx(1 / 5.0, rel=0.1)
    assert np.sum(surface.normal * arm, axis=1)[outside] == pytest.approx(radius[outside], rel=0.03)


def surface_of_disc(is_quarter):
    """The surface of a disc or of its quarter between planes of symmetry, by the place of the node."""
    middle = 0.0 if is_quarter else 10.0
    centre = [middle, middle, 0.0]
    disc = {"name": "disc", "shape": {"cylinder": {"centre": centre, "radius": 5.3}}, "points_per_cell": (3, 3, 1)}
    disc |= {"material": SOLID} | ({"cut_at": ["x-lower", "y-lower"]} if is_quarter else {})
    planes = [{"where": ["x-lower", "y-lower"], "fix": "normal"}] if is_quarter else []
    n = 10 if is_quarter else 20
    made = case(disc, counts=(n, n, 1), functions="quadratic-bspline", support=planes)
    body = Simulation(made, threads=1).bodies[0]
    grid, filled = body.velocity_field.grid, np.zeros((body.velocity_field.grid.n_nodes, 3))
    points = body.on_grid
    scatter_numbers(points.n_slabs, points.mapped, np.outer(body.arrays["volume"], [1.0, 0.0, 0.0]), filled)
    no_slip, reached = NoSlip(grid), np.flatnonzero(filled[:, 0] > 1e-12)
    place = grid.find_positions(reached)
    window = no_slip.find_window(reached)
    surface = no_slip.find_surface(window, filled[window.node, 0] / (grid.cell_volume * window.share), place)
    plane = np.zeros(len(reached), bool)
    found = no_slip.curvatures_of(window, reached, surface.normal, surface.certainty, surface.distance, plane)
    return place - centre, surface, found


def test_the_surface_of_a_disc_that_planes_of_symmetry_cut():
    """Distances and normals at a quarter of a disc are those at the whole disc, also on the planes. Only the volumes of points
    differ, by 4e-5."""
    (place, surface, found), (of_whole, whole, _) = surface_of_disc(True), surface_of_disc(False)
    radius = np.hypot(place[:, 0], place[:, 1])
    at = [int(np.argmin(np.abs(of_whole - here).sum(axis=1))) for here in place]
    assert of_whole[at] == pytest.approx(place, abs=1e-9)
    outer = radius > 4.8
    assert np.abs(surface.distance - (radius - 5.3))[outer].max() < 0.2
    assert surface.distance[outer] == pytest.approx(whole.distance[at][outer], abs=1e-3)
    assert surface.normal[outer] == pytest.approx(whole.normal[at][outer], abs=1e-3)
    near = (np.abs(surface.distance) < 0.5) & (place[:, :2].min(axis=1) > 0.5)
    assert found[near].mean() == pytest.approx(1.0 / 5.3, rel=0.15)


def test_the_shape_of_a_rigid_body_moves_with_it():
    oil = {"kind": "fluid", "density": 1.0, "viscosity": 1.0}
    oil |= {"eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}}
    liquid = box((0, 0, 0), (12, 8, 0), oil, (2, 2, 1), name="oil", outside=["block"])
    block = box((4, 3, 0), (7, 5, 0), SOLID, (2, 2, 1), rigid=True, velocity=(0.5, 0.0, 0.0))
    how = {"functions": "quadratic-bspline", "transfer": "apic", "end": 100.0}
    sim = Simulation(case(liquid, block, counts=(12, 8, 1), **how), threads=1)
    for _ in range(5):
        sim.step()
    before = sim.bodies[1].arrays["position"].mean(axis=0)
    sim.step()
    lower, upper = sim.bodies[1].constraint.nodes.region.bounds()
    assert before[0] > 5.51
    assert 0.5 * (lower + upper)[:2] == pytest.approx(before[:2], abs=1e-9)
