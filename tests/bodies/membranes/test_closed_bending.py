"""Bending of closed membranes of triangles: energy, forces, reference, balance, and what is refused."""

from math import pi, sqrt

import numpy as np
import pytest

from pellucid.bodies.membrane_elements.mesh import hinges_of
from pellucid.bodies.membranes.bending_case import bending_rate
from pellucid.bodies.membranes.closed_bending import Bending
from pellucid.bodies.membranes.plate_bending import PlateBending
from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.geometry.meshes.enclosure import rims_of
from pellucid.geometry.surfaces.surface import Surface
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

RED_CELL = 1.929  # energy over 8πκ of the biconcave shape, by quadrature of its meridian


def icosphere(refinements):
    mesh = Surface(icosphere={"centre": [0, 0, 0], "radius": 1, "refinements": refinements}).mesh("triangles")
    return mesh.triangles, mesh.vertices


def bending(triangles, vertices, rigidity=1.0, reference=0.0):
    found = Bending(triangles, vertices, np.ones(len(vertices)), rigidity)
    found.reference[:] = reference
    return found


def red_cell(vertices):
    """The sphere's vertices moved onto the biconcave disc of Evans and Fung (1972)."""
    r = np.minimum(np.hypot(vertices[:, 0], vertices[:, 1]), 1.0)
    z = np.sqrt(1.0 - r**2) * (0.1036 + 1.0013 * r**2 - 0.5614 * r**4)
    return np.column_stack([vertices[:, :2], np.sign(vertices[:, 2]) * z])


def test_a_sphere_has_its_energy_and_errors_fall_with_the_square_of_the_edges():
    errors = []
    for refinements in (2, 3, 4):
        triangles, vertices = icosphere(refinements)
        errors.append(bending(triangles, vertices).energy(vertices) / (8.0 * pi) - 1.0)
    assert errors[-1] < 5e-4
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.2)


def test_a_red_cell_has_its_energy():
    triangles, vertices = icosphere(4)
    x = red_cell(vertices)
    assert bending(triangles, x).energy(x) / (8.0 * pi) == pytest.approx(RED_CELL, rel=1e-2)


def test_forces_are_the_slope_of_the_energy_and_add_up_to_nothing():
    rng = np.random.default_rng(1)
    triangles, vertices = icosphere(2)
    x = vertices * [1.3, 1.0, 0.7] + 0.02 * rng.normal(size=vertices.shape)
    bent, forces, way = bending(triangles, x, 1.7, 0.4), np.zeros_like(x), rng.normal(size=x.shape)
    bent.add_forces(x, forces)
    slope = (bent.energy(x + 1e-6 * way) - bent.energy(x - 1e-6 * way)) / 2e-6
    assert -np.sum(forces * way) == pytest.approx(slope, rel=1e-8)
    largest = np.abs(forces).max()
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * largest * len(x)
    assert np.abs(np.cross(x, forces).sum(axis=0)).max() < 1e-13 * largest * len(x)


def test_what_was_found_serves_as_long_as_nothing_changes():
    triangles, x = icosphere(2)
    bent = bending(triangles, x)

    def fresh(at):
        return bending(triangles, x, reference=bent.reference[0]).energy(at)

    assert bent.energy(x) == bent.energy(x) == fresh(x)
    x[:, 2] *= 0.7  # the same array
    assert bent.energy(x) == fresh(x)
    bent.reference[:] = 0.5
    assert bent.energy(x) == fresh(x)
    backwards = np.arange(len(x))[::-1]
    before = bent.energy(x)
    bent.bind(backwards)
    assert bent.energy(x[::-1].copy()) == pytest.approx(before, rel=1e-14)


@pytest.mark.parametrize("refinements", [1, 2])
def test_no_eigenfrequency_is_above_the_bound(refinements):
    triangles, x = icosphere(refinements)
    bent, stiffness = bending(triangles, x, 1.7), np.zeros((x.size, x.size))
    for k in range(x.size):
        step, forth, back = np.zeros(x.size), np.zeros_like(x), np.zeros_like(x)
        step[k] = 1e-5
        bent.add_forces(x + step.reshape(-1, 3), forth)
        bent.add_forces(x - step.reshape(-1, 3), back)
        stiffness[:, k] = (back - forth).ravel() / 2e-5
    assert np.allclose(stiffness, stiffness.T, atol=1e-6 * np.abs(stiffness).max())
    half = 0.5 * sqrt(np.linalg.eigvalsh(stiffness)[-1])
    assert 2.2 * half < bent.rate < 2.8 * half


@pytest.mark.parametrize("surface", ["closed", "with a rim"])
def test_the_bound_at_the_start_is_that_of_a_run(surface):
    triangles, vertices = icosphere(2)
    if surface == "with a rim":
        triangles = triangles[vertices[triangles].mean(axis=1)[:, 2] > -0.5]
        used, numbers = np.unique(triangles, return_inverse=True)
        triangles, vertices = numbers.reshape(-1, 3), vertices[used]
    rng = np.random.default_rng(3)
    x = vertices * [1.3, 1.0, 0.7] + 0.03 * rng.normal(size=vertices.shape)
    mass = rng.uniform(0.5, 2.0, len(x))
    bent = Bending(triangles, x, mass, 1.7) if surface == "closed" else PlateBending(triangles, x, mass, 1.7, 0.3)
    bent.add_forces(x, np.zeros_like(x))
    assert bending_rate(triangles, x, mass, 1.7, 0.3) == pytest.approx(bent.rate, rel=1e-12)


def test_nothing_bends_what_has_its_reference():
    triangles, vertices = icosphere(2)
    x = vertices * [1.0, 1.2, 0.8]
    bent, forces = bending(triangles, x), np.zeros_like(x)
    bent.reference[:] = bent.curvatures(x)
    assert bent.energy(x) < 1e-25
    bent.add_forces(x, forces)
    assert np.abs(forces).max() < 1e-12
    assert bending(triangles, vertices, reference=2.0).energy(vertices) < 1e-2 * 8.0 * pi


def test_hinges_and_rims():
    triangles = np.array([[0, 1, 2], [1, 0, 3]])
    assert hinges_of(triangles).tolist() == [[0, 1, 2, 3]]
    assert np.unique(rims_of(triangles).edges).tolist() == [0, 1, 2, 3]
    closed, _ = icosphere(1)
    assert len(hinges_of(closed)) == 3 * len(closed) // 2
    assert not len(rims_of(closed).edges)


CELL = """
schema = 1
title = "An ellipsoid that bending rounds"
[time]
end = 0.4
courant = 0.7
[[body]]
name = "cell"
kind = "membrane-elements"
elements = "triangles"
surface = { ellipsoid = { centre = [2, 2, 2], radii = [1.2, 1, 0.8], refinements = 2 } }
thickness = 0.01
material = { kind = "neo-hookean-membrane", density = 100, young_modulus = 10, poisson_ratio = 0.3 }
bending = { rigidity = 0.05 }
[[probe]]
name = "bent"
body = "cell"
quantity = "bending_energy"
reduce = "sum"
"""
ON_GRID = """
[grid]
lower = [0, 0, 0]
upper = [4, 4, 4]
cell = 0.4
[[body]]
name = "stone"
shape = { sphere = { centre = [3.6, 3.6, 3.6], radius = 0.2 } }
material = { kind = "neo-hookean", density = 100, young_modulus = 100, poisson_ratio = 0.3 }
"""


@pytest.mark.parametrize("more", ["", ON_GRID], ids=["own nodes", "grid"])
def test_the_energy_balance_closes(more):
    sim = Simulation(loads(CELL + more).with_settings({"time.end": 1.0}), threads=1)
    begun = sim.budget.energies()["bending"]
    for state in sim:
        assert abs(state.budget.conservation()["energy"]) < 5e-3
    energies = sim.budget.energies()
    assert energies["bending"] < 0.97 * begun
    assert energies["bending"] == pytest.approx(sim.bodies[0].field("bending_energy").sum())
    assert np.abs(sim.momentum()).max() < 1e-12 * max(1.0, energies["kinetic"])


ALONE_IN_GRID = ON_GRID.partition("[[body]]")[0]


@pytest.mark.parametrize("more", ["", ALONE_IN_GRID, ON_GRID], ids=["no grid", "own nodes", "grid"])
def test_the_step_is_foretold_without_compilation(more, monkeypatch):
    """Also with the springs, and where both count: on its own nodes rates of waves and of bending add up, on the grid not."""
    keys = "area_stiffness = 0.5\nvolume_stiffness = 0.5\nbending ="
    case = loads(
        CELL.replace("bending =", keys).replace("rigidity = 0.05", "rigidity = 0.001") + more.replace("= 100, y", "= 1e4, y")
    )
    with monkeypatch.context() as compiles_nothing:
        compiles_nothing.setattr(Bending, "__init__", None)
        ahead = of_case(case)
    sim = Simulation(case, threads=1)
    assert ahead.step == pytest.approx(0.7 / sim.bodies[0].totals.rate, rel=1e-9)
    limit, name = sim.step_limit()
    assert (name, f"({limit.cause})" in ahead.why) == ("cell", True)


def test_a_fixed_step_is_held_against_the_nodes_that_bend():
    """Those of the membrane allow shorter steps than those of the grid would."""
    fixed = CELL.replace("courant = 0.7", "step = 0.02").replace("rigidity = 0.05", "rigidity = 0.5")
    loads(fixed + ON_GRID)
    with pytest.raises(CaseError, match="at the start, of body cell: shortest bending waves"):
        loads(fixed + ALONE_IN_GRID)


@pytest.mark.parametrize("more", ["", ON_GRID], ids=["own nodes", "grid"])
def test_a_resumed_run_tells_what_it_told_before_it_steps(more):
    keys = "area_stiffness = 50\nvolume_stiffness = 50\nbending ="
    case = loads(CELL.replace("bending =", keys) + more)
    one, other = Simulation(case, threads=1), Simulation(case, threads=1)
    for _ in range(10):
        one.step()
    other.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())

    def told(sim):
        body = sim.bodies[0]
        return {name: body.field(name).copy() for name in ("bending_energy", "stored_energy", "curvature", "strain_energy")}

    for name, values in told(one).items():
        assert np.array_equal(told(other)[name], values), name
    assert other.step_limit() == one.step_limit()
    for sim in (one, other):
        for _ in range(3):
            sim.step()
    assert all(np.array_equal(array, other.state_arrays()[name]) for name, array in one.state_arrays().items())


SPHERE = "{ icosphere = { centre = [0, 0, 0], radius = 1, refinements = REFINED } }"
BOX = "{ box = { lower = [0, 0, 0], upper = [1, 1, 1], points = [4, 4, 4] } }"


def test_what_cannot_bend_is_refused():
    ellipsoid = "{ ellipsoid = { centre = [2, 2, 2], radii = [1.2, 1, 0.8], refinements = 2 } }"
    with pytest.raises(CaseError, match="the membrane has quadrilaterals"):
        loads(CELL.replace('elements = "triangles"\n', "").replace(ellipsoid, BOX))
    with pytest.raises(CaseError, match=r"bending\.rigidity"):
        loads(CELL.replace("rigidity = 0.05", "rigidity = 0"))
    with pytest.raises(CaseError, match="its 80 triangles do not match the 320 triangles of the membrane"):
        loads(CELL.replace("rigidity = 0.05", f"rigidity = 0.05, shape = {SPHERE.replace('REFINED', '1')}"))
    both = f"rigidity = 0.05, spontaneous_curvature = 1, shape = {SPHERE.replace('REFINED', '2')}"
    with pytest.raises(CaseError, match="remove `spontaneous_curvature`"):
        loads(CELL.replace("rigidity = 0.05", both))
