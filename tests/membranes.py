"""Sheets of membrane points for tests, on a grid without a simulation, strained by a given velocity gradient."""

import numpy as np
from small_cases import case

from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip
from pellucid.parts.body import Placement

E, NU, THICKNESS = 1e6, 0.3, 0.01
SURFACE_LAWS = {
    "surface-neo-hookean-membrane": {"shear_modulus": 1.0},
    "skalak-membrane": {"shear_modulus": 1.0, "area_coefficient": 1.0},
    "evans-skalak-membrane": {"shear_modulus": 1.0, "area_modulus": 10.0},
    "mooney-rivlin-membrane": {"shear_modulus": 1.0, "invariant_ratio": 0.2},
    "yeoh-membrane": {"shear_modulus": 1.0, "cubic_coefficient": 1.0 / 30.0},
    "ogden-membrane": {"shear_moduli": (0.8, 0.02, -0.1), "exponents": (1.3, 5.0, -2.0)},
    "arruda-boyce-membrane": {"rubber_modulus": 1.0, "links": 8.0},
    "holzapfel-gasser-ogden-membrane": {
        "shear_modulus": 1.0,
        "k1": 2.0,
        "k2": 0.8,
        "dispersion": 0.1,
        "fibre_direction": (1.0, 0.0, 0.0),
        "fibre_angle": 30.0,
    },
}
"""Parameters of every registered surface law except the density [N/m]."""


def sheet(law="linear-membrane", edges=((1, 0, 0), (0, 1, 0)), points=(11, 11), **more):
    """Return the table of a square sheet of membrane with edges of 1 m about the origin."""
    corner = -0.5 * np.array(edges[0]) - 0.5 * np.array(edges[1]) + (0.01, 0.02, 0.03)
    rectangle = {"corner": corner.tolist(), "first_edge": edges[0], "second_edge": edges[1], "points": points}
    material = {"kind": law, "density": 1000.0, "young_modulus": E, "poisson_ratio": NU}
    surface = {"rectangle": rectangle}
    return {"kind": "membrane-points", "name": "sheet", "surface": surface, "thickness": THICKNESS, "material": material} | more


def body_of(table):
    """Build the body of a table and its grid, without a simulation; return both."""
    whole = case(table, counts=(16, 16, 16), cell=0.25, lower=(-2.0, -2.0, -2.0))
    grid = Grid(whole.grid)
    field = VelocityField("common", grid)
    body = whole.body[0].build(Placement(whole.grid, field, Flip(), (0.0, 0.0, 0.0), 0))
    body.complete()
    return grid, body


def drive(grid, body, gradient, dt, steps):
    """Strain and move a body by a uniform velocity gradient [1/s], shape (3, 3), in steps of dt [s]."""
    index, position = grid.where()
    for _ in range(steps):
        velocity = position @ np.array(gradient).T
        grid.nodes.velocity[index] = grid.nodes.strain_velocity[index] = velocity
        body.storage.sort_if_needed()
        body.update_stress(dt, move=True)
        body.check(0, 0.0)


def neo_hookean_stretch(stretches, nu=NU):
    """Return the principal stresses in the plane [Pa] and the thickness stretch of a neo-Hookean sheet with two in-plane
    stretches.

    The thickness stretch, at which the normal stress vanishes, is found by bisection.
    """
    mu = E / (2.0 * (1.0 + nu))
    lam = 2.0 * mu * nu / (1.0 - 2.0 * nu)
    low, high = 0.1, 2.0
    for _ in range(200):
        third = 0.5 * (low + high)
        across = mu * (third**2 - 1.0) + lam * np.log(stretches[0] * stretches[1] * third)
        low, high = (third, high) if across < 0.0 else (low, third)
    J = stretches[0] * stretches[1] * third
    return [(mu * (s**2 - 1.0) + lam * np.log(J)) / J for s in stretches], third


def edge(name, x, y, hold="xyz", **more):
    """Return the table of a motion that holds the points within 0.01 m of an edge of the sheet along some axes; x, y:
    coordinates of the ends of the edge [m]."""
    lower, upper = (x[0] - 0.01, y[0] - 0.01, -1.0), (x[1] + 0.01, y[1] + 0.01, 1.0)
    return {"name": name, "body": "sheet", "part": {"box": {"lower": lower, "upper": upper}}, "hold": tuple(hold)} | more


RIM = [
    edge("left", (-0.5, -0.5), (-0.5, 0.5)),
    edge("right", (0.5, 0.5), (-0.5, 0.5)),
    edge("front", (-0.45, 0.45), (-0.5, -0.5)),
    edge("back", (-0.45, 0.45), (0.5, 0.5)),
]


def assert_stable_when_shaken(sim, steps=2000):
    """Give every point a random velocity, and assert that the kinetic energy does not grow beyond a few times the energy
    supplied."""
    velocity = sim.bodies[0].arrays["velocity"]
    velocity += np.random.default_rng(0).uniform(-1.0, 1.0, velocity.shape)
    given = 0.5 * sim.bodies[0].mass
    sim.step()
    sim.begin_balance()
    most = 0.0
    for _ in range(steps):
        sim.step()
        most = max(most, sim.budget.energies()["kinetic"])
    assert most < 3.0 * given
