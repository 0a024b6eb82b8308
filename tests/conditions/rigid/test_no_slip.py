"""The surface of a rigid body as seen from nodes, and the velocity profile of a fluid near it."""

import numpy as np
import pytest
from small_cases import SOLID, box, case

from pellucid.conditions.rigid.no_slip import NoSlip
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
    grid, filled, _, place = filled_below(4.3, functions)
    near = place[(np.abs(place[:, 1] - 4.3) < 0.75) & (place[:, 0] > 2) & (place[:, 0] < 6)]
    surface = NoSlip(grid).find_surface(filled, near)
    assert surface.distance == pytest.approx(near[:, 1] - 4.3, abs=2e-3)
    assert surface.normal == pytest.approx(np.tile([0.0, 1.0, 0.0], (len(near), 1)), abs=1e-9)
    assert surface.certainty == pytest.approx(np.ones(len(near)))


def test_a_quadratic_profile_goes_on_through_the_surface():
    grid, filled, index, place = filled_below(2.3, "quadratic-bspline")
    no_slip = NoSlip(grid)
    near = place[(np.abs(place[:, 1] - 2.3) < 0.75) & (place[:, 0] > 2) & (place[:, 0] < 6)]
    surface = no_slip.find_surface(filled, near)

    def flow(y):
        return np.outer(0.7 * y - 0.1 * y * y, [1.0, 0.0, 0.0])

    at = [near + (height - surface.distance)[:, None] * surface.normal for height in no_slip.heights]
    relative = [flow(x[:, 1] - 2.3) for x in at]
    both = np.ones(len(near), bool)
    goal = no_slip.continue_profile(surface, *relative, both)
    assert goal == pytest.approx(flow(surface.distance), abs=2e-3)
    velocity = np.zeros((grid.n_nodes, 3))
    velocity[index] = np.outer(place[:, 1], [0.5, 0.0, 0.0])
    found, known = no_slip.sample(velocity, np.ones(grid.n_nodes), at[0])
    assert known.all()
    assert found[:, 0] == pytest.approx(0.5 * at[0][:, 1])
    assert not no_slip.sample(velocity, np.zeros(grid.n_nodes), at[0])[1].any()
