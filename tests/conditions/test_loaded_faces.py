"""Pressures and tractions on faces of bodies with their own nodes: patches, resultants, moments, work, and what is refused."""

import numpy as np
import pytest
from algebra import rotation
from small_cases import RATE_SOLID, box

from pellucid.bodies.meshless_solid.solid import deformation_gradients
from pellucid.case import Case
from pellucid.materials.elastic import lame
from pellucid.materials.law import cauchy_stress, first_piola_kirchhoff
from pellucid.materials.neo_hookean import NeoHookean
from pellucid.simulation.simulation import Simulation

pytestmark = pytest.mark.usefixtures("gradients_in_doubles")

E, NU, EDGES = 3000.0, 0.3, (0.1, 0.12, 0.2)
LAW = NeoHookean(*lame(E, NU), 1000.0)
TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": E, "poisson_ratio": NU}
MESH = {"box": {"lower": (0.0, 0.0, 0.0), "upper": EDGES, "cells": (2, 2, 3)}}
BAR = {"name": "bar", "kind": "meshless-solid", "mesh": MESH, "material": TISSUE}
LOWER_FACES = [{"body": "bar", "where": {"normal": tuple(-np.eye(3)[axis])}, "fix": ["xyz"[axis]]} for axis in range(3)]
TOP = {"normal": (0, 0, 1), "within": 5}
UP = {"kind": "traction", "body": "bar", "where": TOP, "traction": (0.0, 0.0, 400.0)}
APPROXIMANTS = [
    {"kind": "cell-based-maximum-entropy"},
    {"kind": "cell-based-maximum-entropy", "rings": 3},
    {"kind": "local-maximum-entropy"},
    {"kind": "linear-simplex"},
]
STRAINED = np.eye(3) + np.array([[0.1, 0.05, 0.0], [0.0, -0.2, 0.1], [0.05, 0.0, 0.15]])
STRAINED = rotation(2) @ STRAINED


def made(*bodies, **more):
    table = {"schema": 1, "title": "a test", "time": {"end": 10.0}, "body": list(bodies) or [BAR]} | more
    return Simulation(Case.model_validate(table), threads=1)


def loads(simulation, displacement=None):
    """Reference places [m] and the forces of the loads [N] at the nodes, displaced from there."""
    (body,) = simulation.bodies
    start = body.arrays["position"].copy()
    body.arrays["position"] += 0.0 if displacement is None else displacement(start)
    body.begin(1e-3)
    simulation.stages.begin(5.0, 1e-3)
    return start, body.motion.loads.sum(axis=0)


def affine(F):
    return lambda x: x @ (F - np.eye(3)).T


def residual(simulation, F):
    """Forces that are left at the nodes where no support acts [N], of a uniform deformation."""
    (body,) = simulation.bodies
    loads(simulation, affine(F))
    body._find_forces()
    return body.motion.forces()[body.arrays["prescribed"] == 0]


def stretches(traction):
    """Of a bar with free sides under a nominal stress along z: Newton on P_xx = 0 and P_zz = t."""
    across, along = 1.0, 1.0
    for _ in range(50):

        def lacking(a, b):
            P = first_piola_kirchhoff(LAW, (a, 0.0, 0.0, 0.0, a, 0.0, 0.0, 0.0, b))
            return np.array([P[0], P[8] - traction])

        step, f = 1e-6, lacking(across, along)
        J = np.stack([(lacking(across + step, along) - f) / step, (lacking(across, along + step) - f) / step], axis=1)
        across, along = np.array((across, along)) - np.linalg.solve(J, f)
    return across, along


@pytest.mark.parametrize("approximant", APPROXIMANTS)
def test_a_bar_under_traction_is_in_uniform_tension(approximant):
    across, along = stretches(400.0)
    assert along > 1.1
    simulation = made(BAR | {"approximant": approximant}, support=LOWER_FACES, load=[UP])
    total = 400.0 * EDGES[0] * EDGES[1]
    assert residual(simulation, np.diag([across, across, along])) == pytest.approx(0.0, abs=1e-12 * total)


@pytest.mark.parametrize("approximant", APPROXIMANTS)
def test_pressure_on_all_faces_is_a_uniform_pressure_within(approximant):
    """A free body, squeezed and turned: the pressure of its law at that volume balances at every node."""
    s = 0.9
    p = -cauchy_stress(LAW, (s, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s))[0]
    assert p > 1000.0
    simulation = made(BAR | {"approximant": approximant}, pressure=[{"body": "bar", "value": p}])
    left = residual(simulation, s * rotation(1))
    assert left == pytest.approx(0.0, abs=1e-11 * p * EDGES[0] * EDGES[1])


def test_a_constrained_patch_changes_the_functions_and_not_the_balance():
    """The functions about it are others, in the forces within and in the shares of the faces alike."""
    s = 0.9
    p = -cauchy_stress(LAW, (s, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s))[0]
    patch = {"body": "bar", "where": TOP | {"box": {"lower": (0, 0, 0), "upper": (0.05, 0.06, 0.2)}}, "fix": ["z"]}
    loaded = [made(support=support, pressure=[{"body": "bar", "value": p}]) for support in ([], [patch])]
    free, constrained = (loads(simulation)[1] for simulation in loaded)
    scale = p * EDGES[0] * EDGES[1]
    assert abs(free - constrained).max() > 1e-3 * scale
    assert residual(made(support=[patch], pressure=[{"body": "bar", "value": p}]), s * rotation(1)) == pytest.approx(
        0.0, abs=1e-11 * scale
    )


@pytest.mark.parametrize("approximant", APPROXIMANTS)
def test_resultant_and_moment_of_a_traction(approximant):
    """A linear displacement finds the exact work too: ∫ t·u dA."""
    t = np.array((30.0, -50.0, 400.0))
    start, force = loads(made(BAR | {"approximant": approximant}, load=[UP | {"traction": tuple(t)}]))
    total, middle = EDGES[0] * EDGES[1] * t, np.array((0.05, 0.06, 0.2))
    scale = np.linalg.norm(total)
    assert force.sum(axis=0) == pytest.approx(total, abs=1e-12 * scale)
    assert np.cross(start, force).sum(axis=0) == pytest.approx(np.cross(middle, total), abs=1e-12 * 0.2 * scale)
    assert np.sum(force * (start @ STRAINED.T)) == pytest.approx(total @ STRAINED @ middle, abs=1e-12 * 0.2 * scale)
    on_top = np.isclose(start[:, 2], EDGES[2])
    assert force[~on_top] == pytest.approx(0.0, abs=1e-11 * scale), "nodes off the face have no part in it"


@pytest.mark.parametrize("approximant", APPROXIMANTS)
def test_resultant_and_moment_of_a_pressure_follow_an_affine_deformation(approximant):
    """-p cof(F) N A at the middle of the deformed face."""
    simulation = made(BAR | {"approximant": approximant}, pressure=[{"body": "bar", "value": 7.0, "where": TOP}])
    start, force = loads(simulation, affine(STRAINED))
    area = np.linalg.det(STRAINED) * np.linalg.inv(STRAINED).T @ (0.0, 0.0, EDGES[0] * EDGES[1])
    middle, scale = STRAINED @ (0.05, 0.06, 0.2), 7.0 * np.linalg.norm(area)
    assert force.sum(axis=0) == pytest.approx(-7.0 * area, abs=1e-12 * scale)
    moment = np.cross(start @ STRAINED.T, force).sum(axis=0)
    assert moment == pytest.approx(np.cross(middle, -7.0 * area), abs=1e-12 * 0.2 * scale)


def bent(x):
    """Bending by 45 degrees over the length: far from affine."""
    angle, radius = np.pi / 4.0 * x[:, 2] / EDGES[2], EDGES[2] / (np.pi / 4.0)
    return np.stack([(radius + x[:, 0]) * np.cos(angle) - radius, x[:, 1], (radius + x[:, 0]) * np.sin(angle)], axis=1) - x


def test_pressure_all_round_has_no_resultant_however_it_is_deformed():
    _, force = loads(made(pressure=[{"body": "bar", "value": 7.0}]), bent)
    assert abs(force).sum() > 0.1 * 7.0 * EDGES[1] * EDGES[2]
    assert force.sum(axis=0) == pytest.approx(0.0, abs=1e-12 * abs(force).sum())


def test_its_moment_then_vanishes_with_the_mesh():
    """Of a bent bar: the shares are those of the field, the areas those of flat faces."""
    moments = []
    for n in (1, 3):
        mesh = {"box": MESH["box"] | {"cells": (2 * n, 2 * n, 4 * n)}}
        start, force = loads(made(BAR | {"mesh": mesh}, pressure=[{"body": "bar", "value": 7.0}]), bent)
        about = np.cross(start + bent(start), force).sum(axis=0)
        moments.append(np.linalg.norm(about) / (EDGES[2] * abs(force).sum()))
    assert moments[0] < 1e-4
    assert moments[1] < 0.3 * moments[0]  # a ninth, had the coarse mesh its order already


def test_linear_functions_have_no_moment_at_all():
    simulation = made(BAR | {"approximant": {"kind": "linear-simplex"}}, pressure=[{"body": "bar", "value": 7.0}])
    start, force = loads(simulation, bent)
    about = np.cross(start + bent(start), force).sum(axis=0)
    assert about == pytest.approx(0.0, abs=1e-12 * EDGES[2] * abs(force).sum())


def swung(step, end, **more):
    """A run with a fixed step."""
    simulation = made(time={"end": end, "step": step}, energy={"warn": 5.0, "stop": 9.0}, **more)
    for _ in range(round(end / step)):
        simulation.step()
    return simulation


def test_a_traction_rises_and_its_work_is_in_the_balance():
    """A bar that starts to swing: kinetic and strain energy are the work of the load, but for the step, in first order."""
    lacking = []
    for step in (4e-3, 2e-3):
        simulation = swung(step, 0.2, support=LOWER_FACES, load=[UP | {"traction": (0, 0, 40.0), "rise": 0.3}])
        energies = simulation.budget.energies()
        assert energies["support_work"] == 0.0, "planes of symmetry do not move"
        assert abs(energies["transfer_error"]) < 1e-14 * energies["load_work"], "the works are the change of kinetic energy"
        assert simulation.budget.conservation()["momentum"] < 1e-12
        lacking.append(energies["kinetic"] + energies["strain"] - energies["load_work"])
    assert abs(lacking[1]) < 0.02 * energies["load_work"]
    assert lacking[0] / lacking[1] == pytest.approx(2.0, abs=0.2)


def test_the_work_of_a_pressure_is_that_of_the_volume():
    """-∫ p dV of a free body, with the volume of its points, to first order in the step; with it the balance closes to second
    order, since velocities half a step ahead are counted."""
    p, whole, lacking = 100.0, np.prod(EDGES), []
    for step in (2e-3, 1e-3):
        simulation = swung(step, 0.03, pressure=[{"body": "bar", "value": p}])
        (body,) = simulation.bodies
        J = np.linalg.det(deformation_gradients(body.solid, len(body.mesh.cells))).ravel()
        weights = np.repeat(body.mesh.volumes / 4.0, 4)
        work = simulation.budget.energies()["load_work"]
        assert work > 1e-3 * p * whole
        assert simulation.momentum() == pytest.approx(0.0, abs=1e-12 * simulation.budget.momentum_scale)
        lacking.append((work - p * (whole - J @ weights), abs(simulation.budget.energy_error())))
    ratios = [coarse / fine for coarse, fine in zip(*lacking, strict=True)]
    assert ratios == [pytest.approx(2.0, abs=0.3), pytest.approx(4.0, abs=0.6)]


def test_a_restart_chooses_the_same_faces_and_goes_on_bit_for_bit():
    more = {"load": [UP], "pressure": [{"body": "bar", "value": 30.0, "where": TOP}]}
    whole, again = swung(2e-3, 0.02, **more), made(time={"end": 0.02, "step": 2e-3}, **more)
    kept = {name: np.copy(array) for name, array in whole.state_arrays().items()}, whole.state_numbers()
    again.restore(*kept)
    for simulation in (whole, again):
        for _ in range(5):
            simulation.step()
    (one,), (other,) = whole.bodies, again.bodies
    assert one.arrays["position"].tobytes() == other.arrays["position"].tobytes()
    assert abs(one.arrays["position"] - one.mesh.nodes).max() > 1e-4
    assert whole.budget.energies() == again.budget.energies()


def test_a_steady_bar_has_the_stress_of_its_traction():
    """Cauchy's: the nominal stress over the area that is left."""
    named = [face | {"name": axis} for face, axis in zip(LOWER_FACES, "xyz", strict=True)]
    simulation = made(support=named, load=[UP], steady={"tolerance": 1e-8})
    while not simulation.clock.finished(None):
        simulation.step()
    (body,), (across, along) = simulation.bodies, stretches(400.0)
    stress = np.zeros(6)
    stress[2] = 400.0 / across**2
    assert body.field("stress") == pytest.approx(np.tile(stress, (body.n_points, 1)), abs=1e-5 * stress[2])
    expected = body.mesh.nodes * (across, across, along)
    assert body.field("position") == pytest.approx(expected, abs=1e-6 * EDGES[2])
    mean_force = simulation.budget.reactions()["z"] / simulation.time
    assert mean_force == pytest.approx([0.0, 0.0, -400.0 * EDGES[0] * EDGES[1]], abs=1e-6)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"load": [UP | {"where": {"set": "top"}}]}, "the mesh of body bar has no named sets"),
        ({"load": [UP | {"where": {"sphere": {"centre": (0, 0, 0), "radius": 0.01}}}]}, "no face of body bar lies in it"),
        ({"load": [UP | {"body": "bor"}]}, "no body has this name; available names: bar"),
        ({"load": [UP | {"rise": -1.0}]}, "greater than or equal to 0|at least 0"),
        ({"load": [UP | {"traction": "3 m"}]}, "Pa"),
        ({"pressure": [{"body": "bar", "value": 1.0, "where": {"normal": (1, 1, 1), "within": 1}}]}, "no face of body bar"),
    ],
)
def test_loads_without_faces_are_refused(more, words):
    with pytest.raises(ValueError, match=words):
        made(**more)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"load": [UP | {"body": "lump"}]}, "body lump has no faces with its own nodes"),
        ({"pressure": [{"body": "lump", "value": 1.0}]}, "is not a membrane and has no mesh"),
    ],
)
def test_bodies_without_faces_are_told(more, words):
    grid = {"lower": (-0.1, -0.1, -0.1), "upper": (0.3, 0.3, 0.3), "cell": 0.05}
    with pytest.raises(ValueError, match=words):
        made(box((0, 0, 0), (0.1, 0.1, 0.1), RATE_SOLID, name="lump"), grid=grid, **more)


def test_faces_in_a_region_are_chosen_anew_in_each_step():
    half = {"box": {"lower": (0.0, 0.0, 0.19), "upper": (0.05, 0.12, 0.21)}}
    simulation = made(pressure=[{"body": "bar", "value": 100.0, "where": half, "choose": "each-step"}])
    _, force = loads(simulation)
    assert force.sum(axis=0) == pytest.approx([0.0, 0.0, -100.0 * 0.05 * 0.12], abs=1e-12)
    _, force = loads(simulation, lambda x: np.array([0.02, 0.0, 0.0]))
    assert force.sum(axis=0) == pytest.approx([0.0, 0.0, -100.0 * 0.5 * 0.05 * 0.12], abs=1e-12), "one triangle of two"
