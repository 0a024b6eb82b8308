"""Driven points: what runs of them bring to the nodes and take, against sums point by point."""

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, box, case, place

from pellucid.case import Case
from pellucid.energy import IMPACT, MOTION
from pellucid.grid.transfer import gather_vectors, scatter_numbers, scatter_vectors
from pellucid.simulation.simulation import Simulation

DT = 0.01


def led(material=RATE_SOLID, motions=(), **more):
    table = case(box((0, 0, 0), (4, 4, 4), material), **more).to_data() | {"motion": list(motions)}
    return Simulation(Case.model_validate(table), threads=1)


def motion(name, displacement, **more):
    signals = {axis: {"kind": "steady", "velocity": speed} for axis, speed in displacement.items()}
    return {"name": name, "body": "block", "displacement": signals} | more


TWO = [
    motion("one", {"x": 0.3}, part={"box": {"lower": (0, 0, 0), "upper": (1, 4, 4)}}),
    motion("two", {"y": -0.2, "z": 0.5}, part={"box": {"lower": (2, 0, 0), "upper": (4, 4, 4)}}),
]
WHOLE = [motion("go", {"x": 0.1, "y": 0.1, "z": 0.1})]


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_runs_of_driven_points_add_what_single_points_add(functions):
    """Two motions along different axes and free points, all mixed in the cells, so that runs are short and long."""
    sim = led(motions=TWO, functions=functions, counts=(4, 4, 4))
    body, rng = sim.bodies[0], np.random.default_rng(3)
    place(body, 4.0 * rng.random((body.n_points, 3)) ** [3, 2, 1])  # crowded in one corner
    body.arrays["velocity"][:] = rng.normal(size=(body.n_points, 3))
    body.arrays["mass"] *= rng.uniform(0.5, 2.0, body.n_points)
    driven, before, m = body.arrays["driven"], body.arrays["velocity"].copy(), body.arrays["mass"][:, None]
    assert set(driven) == {0, 1, 2}
    goal = np.array([[0, 0, 0], [0.3, 0, 0], [0, -0.2, 0.5]])[driven]
    along = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 1]])[driven]
    field, led_by = body.velocity_field, body.constraint

    field.clear_external()
    led_by.begin(0.0, DT)
    mass, momentum = np.zeros((2, sim.grid.n_nodes, 3))
    scatter_numbers(body.n_slabs, body.mapped, m * along, mass)
    scatter_vectors(body.n_slabs, body.mapped, m * along * goal, momentum)
    assert field.external.driven_mass == pytest.approx(mass, rel=1e-13, abs=1e-13 * mass.max())
    assert field.external.driven_momentum == pytest.approx(momentum, rel=1e-12, abs=1e-12 * mass.max())

    field.external.impulse[:] = rng.normal(size=mass.shape)
    on_nodes = np.zeros_like(before)
    gather_vectors(body.n_slabs, body.mapped, field.external.impulse, on_nodes)
    for times in (1, 2):
        body.arrays["velocity"][:] = before
        (led_by.prescribe_velocities if times == 1 else led_by.prescribe_velocities_again)()
        assert np.array_equal(body.arrays["velocity"], np.where(along, goal, before))
        apart, done = along * (goal - before), led_by.work()
        assert done.works[MOTION] == pytest.approx(times * np.sum(m * apart * goal), rel=1e-12)
        assert done.works[IMPACT] == pytest.approx(times * np.sum(0.5 * m * apart**2), rel=1e-12)
        for number, name in enumerate(("one", "two"), start=1):
            taken = np.sum((m * (apart + along * on_nodes))[driven == number], axis=0)
            assert done.motions[name] == pytest.approx(times * taken, rel=1e-11, abs=1e-11 * m.sum())


def forces(sim):
    sim.stages.clear_nodes()
    sim.bodies[0].particle_to_grid(inertia=True, force=True)
    return sim.grid.nodes.force


def test_a_body_that_is_driven_as_a_whole_pushes_with_the_stress_that_it_began_with():
    """Nothing strains it: without stress its forces on the nodes are left out, until a state with stress is restored."""
    gas = led(GAS, motions=WHOLE, counts=(4, 4, 4))
    gas.step()
    assert not gas.bodies[0].constraint.strains
    assert np.abs(forces(gas)).max() == pytest.approx(1.0, rel=0.1), "a pressure of 1 Pa on a cell of 1 m"
    solid = led(motions=WHOLE, counts=(4, 4, 4))
    assert not forces(solid).any()
    state = {name: array.copy() for name, array in solid.state_arrays().items()}
    state["block/stress"][:, 0] = 1.0
    solid.restore(state, solid.state_numbers())
    assert forces(solid).any()
