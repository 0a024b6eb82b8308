"""Runs on periodic grids: what moves by whole cells does the same, and flows whose ends are known."""

import json

import numpy as np
import pytest
from small_cases import SOLID, advance, box

from pellucid.case import Case
from pellucid.contact import implicit
from pellucid.contact.pairs import ContactPairs
from pellucid.simulation.simulation import Simulation

LIQUID = {
    "kind": "fluid",
    "density": 1.0,
    "viscosity": 0.05,
    "eos": {"kind": "tait", "sound_speed": 5.0, "carries_tension": True},
}
LIPID = {"kind": "lipid-film", "density": 0.05, "viscosity": 0.1, "stiffness": 4.0, "bending_rigidity": 0.001}
MEMBRANE = {"kind": "linear-membrane", "density": 1.0, "young_modulus": 50.0, "poisson_ratio": 0.3}
SOFT = SOLID | {"density": 1.0, "young_modulus": 50.0}
N = 16
H = 1.0 / N
DRIFT = (0.5, 0.7, 0.0)


def periodic(*bodies, n=N, axes="xy", upper=(1.0, 1.0, 0.0), functions="quadratic-bspline", threads=1, end=1.0, **more):
    grid = {"lower": (0, 0, 0), "upper": upper, "cell": 1.0 / n, "functions": functions, "periodic": list(axes)}
    case = {"title": "a test", "grid": grid, "time": {"end": end}, "body": bodies} | more
    return Simulation(Case.model_validate(case), threads=threads)


def vortices(at=(0.0, 0.0), drift=DRIFT, size=0.2):
    """Those of Taylor and Green, from a place on, in a drift."""
    k, half = 2.0 * np.pi, 0.5 * size
    waves = [((half, -half, 0), (k, k, 0)), ((half, half, 0), (k, -k, 0))]
    upper = (at[0] + 1.0, at[1] + 1.0, 0.0)
    initial = [
        {"kind": "sine-wave", "amplitude": a, "wave_vector": k, "phase": -(k[0] * at[0] + k[1] * at[1])} for a, k in waves
    ]
    return box((*at, 0.0), upper, LIQUID, (2, 2, 1), "liquid", velocity=drift, initial=initial)


def tube(at, kind, **more):
    x, y = more.pop("centre", (0.5, 0.5))
    ends = [(at[0] + x, at[1] + y, z) for z in (0.0, 0.5 * H)]
    surface = {"tube": {"start": ends[0], "end": ends[1], "radius": more.pop("radius", 0.2), "points": (48, 2)}}
    return {"kind": kind, "name": "skin", "surface": surface, "thickness": 0.01, "material": MEMBRANE, "velocity": DRIFT} | more


def film(at):
    ellipse = {"radius": 0.25, "radius_y": 0.15, "centre": (at[0] + 0.5, at[1] + 0.5, 0.0), "nodes": 40}
    return {"kind": "fluid-film", "name": "film", "shape": {"ellipse": ellipse}, "material": LIPID, "velocity": DRIFT}


def disc(at, centre, name, velocity):
    sphere = {"centre": (at[0] + centre[0], at[1] + centre[1], 0.0), "radius": 0.17}
    body = {"name": name, "field": name, "shape": {"sphere": sphere}, "material": SOFT, "velocity": velocity}
    return body | {"points_per_cell": (3, 3, 1)}


def discs(at):
    """That fly at each other and touch."""
    return disc(at, (0.3, 0.5), "one", (1.0, 0.2, 0.0)), disc(at, (0.68, 0.55), "two", (-1.0, 0.2, 0.0))


def nets(at, kind):
    """Two that fly at each other and at a disc."""
    one = tube(at, kind, name="net", field="net", centre=(0.3, 0.5), radius=0.17, velocity=(1.0, 0.2, 0.0))
    two = one | tube(at, kind, centre=(0.68, 0.55), radius=0.17, velocity=(-1.0, 0.2, 0.0))
    two |= {"name": "other", "field": "other"}
    return one, two, disc(at, (0.5, 0.85), "disc", (0.0, -0.5, 0.0))


BODIES = {
    "fluid": lambda at: [vortices(at)],
    "membrane points": lambda at: [vortices(at), tube(at, "membrane-points")],
    "elements": lambda at: [vortices(at), tube(at, "membrane-elements")],
    "film": lambda at: [vortices(at), film(at)],
    "solids in contact": discs,
    "nets in contact": lambda at: nets(at, "membrane-elements"),
    "contact on nodes": lambda at: nets(at, "membrane-points"),
}


@pytest.mark.parametrize("bodies", BODIES)
def test_bodies_moved_by_cells_do_the_same(bodies, monkeypatch):
    """Some across the seams as they start, or later.

    Forces of contact are solved to rounding: iterations that end at the residual of a step make more of rounding errors.
    """
    monkeypatch.setattr(implicit, "RESIDUAL", implicit.EXACTLY)
    monkeypatch.setattr(implicit, "ITERATIONS", 2000)
    found = []
    for cells in ((0, 0), (5, 0), (6, -7)):
        at = H * np.array([*cells, 0.0])
        sim = advance(periodic(*BODIES[bodies](at[:2].tolist())), 25)
        states = [
            (body.stored_array("position"), body.stored_array("velocity"), body.stored_array("id")) for body in sim.bodies
        ]
        found.append([(x[np.argsort(i)] - at, v[np.argsort(i)]) for x, v, i in states])
        assert sim.budget.conservation()["momentum"] < 1e-13
    assert (len(sim.parts.only(ContactPairs)) > 0) == (bodies == "contact on nodes")
    if "contact" in bodies:
        assert np.abs(found[0][0][1][:, 0] - 1.0).max() > 0.2
    for other in found[1:]:
        for one, two in zip(found[0], other, strict=True):
            assert one[0] == pytest.approx(two[0], abs=1e-12)
            assert one[1] == pytest.approx(two[1], abs=1e-11)


def test_momentum_stays_and_threads_change_no_bit():
    """On a grid whose rows of slabs meet across a seam."""
    one, two = (advance(periodic(vortices(), n=24, threads=threads), 40) for threads in (1, 2))
    assert len(one.bodies[0].storage.slabs.layers) == 4
    assert np.abs(one.momentum() - [0.5, 0.7, 0.0]).max() < 1e-14
    assert abs(one.budget.conservation()["energy"]) < 1e-13
    for name, array in one.bodies[0].arrays.items():
        assert np.array_equal(array, two.bodies[0].arrays[name]), name


def test_vortices_fade_as_those_of_taylor_and_green():
    """Their energy as exp(-4νk² t), with errors of second order."""
    errors = []
    for n in (16, 32):
        sim, exact = periodic(vortices(drift=(0, 0, 0)), n=n, end=0.5), 4.0 * 0.05 * (2.0 * np.pi) ** 2
        begun = sim.kinetic_energy()
        while not sim.clock.finished(None):
            sim.step()
        errors.append(abs(np.log(begun / sim.kinetic_energy()) / sim.time / exact - 1.0))
    assert errors[1] < 0.04
    assert 1.8 < np.log2(errors[0] / errors[1]) < 2.2


def slit(load, n=16, end=0.8, **more):
    """A viscous fluid of density and viscosity 1 between walls at y = ±½."""
    fluid = LIQUID | {"viscosity": 1.0, "eos": LIQUID["eos"] | {"sound_speed": 10.0}}
    body = box((0, -0.5, 0), (4.0 / n, 0.5, 0), fluid, (3, 3, 1), "water")
    grid = {"lower": (0, -0.5, 0), "upper": (4.0 / n, 0.5, 0), "cell": 1.0 / n, "functions": "trilinear", "periodic": ["x"]}
    walls = [{"where": f"y-{side}", "velocity": (velocity, 0, 0)} for side, velocity in more.pop("walls", WALLS_AT_REST)]
    case = {"title": "a test", "grid": grid, "time": {"end": end}, "body": [body], "load": load, "support": walls} | more
    return Simulation(Case.model_validate(case), threads=1)


WALLS_AT_REST = [("lower", 0.0), ("upper", 0.0)]
DRIVE = {"kind": "mean-velocity", "body": "water", "name": "drive", "axis": "x", "velocity": 2 / 3, "response": 0.02}


def profile(sim):
    """At the end: how far from the middle points are, and their velocities along x, shape (n,) each."""
    while not sim.clock.finished(None):
        sim.step()
    body = sim.bodies[0]
    return body.arrays["position"][:, 1], body.arrays["velocity"][:, 0]


def test_a_driven_slit_has_the_profile_of_poiseuille():
    y, u = profile(slit([{"kind": "body-force", "body": "water", "acceleration": (8, 0, 0)}]))
    assert u == pytest.approx(1.0 - 4.0 * y**2, abs=0.01)


def test_walls_that_move_shear_the_fluid_between():
    """Seen at the nodes: the start at once leaves motions of points within cells, which nothing resists."""
    sim = slit([], end=1.0, walls=[("lower", -0.5), ("upper", 0.5)])
    profile(sim)
    index, position = sim.grid.where()
    assert sim.grid.nodes.velocity[index, 0] == pytest.approx(position[:, 1], abs=1e-3)


def test_a_force_holds_the_mean_velocity():
    sim = slit([DRIVE], end=0.9)
    while sim.time < 0.8:
        sim.step()
    before, time = sim.budget.reactions()["drive"][0], sim.time
    y, u = profile(sim)
    assert sim.momentum()[0] / sim.bodies[0].mass == pytest.approx(2 / 3, rel=1e-6)
    assert u == pytest.approx(1.0 - 4.0 * y**2, abs=0.01)
    force = (sim.budget.reactions()["drive"][0] - before) / (sim.time - time)
    assert force == pytest.approx(8.0 * sim.bodies[0].mass, rel=0.01)
    assert abs(sim.budget.conservation()["energy"]) < 1e-12
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert sim.budget.energies()["driving_work"] > 0.0


def test_a_checkpoint_holds_what_the_force_has_learnt():
    whole = advance(slit([DRIVE]), 30)
    numbers, arrays = json.loads(json.dumps(whole.state_numbers())), {k: a.copy() for k, a in whole.state_arrays().items()}
    resumed = slit([DRIVE])
    resumed.restore(arrays, numbers)
    advance(whole, 20)
    advance(resumed, 20)
    for name, array in whole.state_arrays().items():
        assert np.array_equal(array, resumed.state_arrays()[name]), name
    assert whole.budget.energies() == resumed.budget.energies()
