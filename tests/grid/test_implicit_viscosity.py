"""Fluids whose viscosity is solved for on the nodes: the equation, flows beside explicit ones, conservation, the same bits."""

import json

import numpy as np
import pytest
from small_cases import SLIP, SOLID, advance, assert_same_arrays, box, case, copied_state, finished

from pellucid.errors import RunStopped
from pellucid.grid import implicit_viscosity
from pellucid.grid.passes.gifts import scatter
from pellucid.running.forecast import foretell_case
from pellucid.set_up.flows import slipped_past
from pellucid.simulation.simulation import Simulation

H = 1.0 / 8
TAIT = {"kind": "tait", "sound_speed": 30.0, "carries_tension": True}
LIQUID = {"kind": "fluid", "density": 0.01, "viscosity": 1.0, "eos": TAIT}
IMPLICIT = LIQUID | {"implicit_viscosity": True}
WALLS = [{"where": "y-lower", "velocity": (0, 0, 0)}, {"where": "y-upper", "velocity": (0, 0, 0)}]
PUSH = [{"kind": "body-force", "body": "block", "acceleration": (800.0, 0, 0)}]


def plane(*bodies, counts=(4, 8, 1), lower=(0, -0.5, 0), threads=1, **more):
    table = {"periodic": ["x"], "support": WALLS} | more
    return Simulation(case(*bodies, counts=counts, cell=H, lower=lower, **table), threads=threads)


def slit(material=IMPLICIT, load=PUSH, end=0.03, **more):
    return plane(box((0, -0.5, 0), (0.5, 0.5, H), material, (2, 2, 1)), load=load, end=end, **more)


def vortices(material, n=32, **more):
    """Return a simulation of Taylor-Green vortices in a periodic box."""
    k = 2.0 * np.pi
    waves = [((0.5, -0.5, 0), (k, k, 0)), ((0.5, 0.5, 0), (k, -k, 0))]
    initial = [{"kind": "sine-wave", "amplitude": a, "wave_vector": w} for a, w in waves]
    body = box((0, 0, 0), (1, 1, 1 / n), material, (2, 2, 1), initial=initial)
    table = case(body, counts=(n, n, 1), cell=1.0 / n, periodic=["x", "y"], functions="quadratic-bspline", **more)
    return Simulation(table, threads=1)


def fading(sim):
    """The rate at which its velocities fade [1/s]."""
    begun = sim.kinetic_energy()
    finished(sim)
    return 0.5 * np.log(begun / sim.kinetic_energy()) / sim.time


def test_the_nodes_move_as_the_equation_says():
    """By the forces of a solution, from which they differ by its residual; a moved wall and a load act too."""
    sim = advance(slit(support=[WALLS[0], {"where": "y-upper", "velocity": (1.0, 0, 0)}]), 5)
    (viscosity,) = sim.parts.of(implicit_viscosity.ImplicitViscosity)
    rows = viscosity._rows
    inertia, target, solution, force = (
        getattr(rows, name).reshape(-1, 4)[:, :3] for name in ("inertia", "target", "solution", "viscous_force")
    )
    free = inertia > 0.0
    moved = np.divide(sim.dt * force, inertia, out=np.zeros_like(force), where=free)
    np.testing.assert_allclose((target + moved)[free], sim.grid.nodes.velocity[free], atol=1e-14)
    left = inertia * (solution - target) - sim.dt * force
    assert np.sqrt(np.sum(left[free] ** 2 / inertia[free])) < 1e-3 * np.sqrt(np.sum(inertia * (solution - target) ** 2))
    assert viscosity.rounds[0] > 5


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_the_preconditioner_is_the_diagonal(functions):
    """Of the operator, whose column is the force of a unit velocity of one node along an axis."""
    (viscosity,) = advance(slit(functions=functions), 1).parts.of(implicit_viscosity.ImplicitViscosity)
    rows = viscosity._rows
    rows.inverse[:] = 0.0
    viscosity._factors[0][:] = 1.0, 2.0 - 2.0 / 3.0  # μ and 2μ + λ
    scatter(viscosity._diagonals[0])
    for k in (*np.flatnonzero(rows.inertia)[::7], int(np.argmax(rows.inertia))):
        rows.direction[:] = rows.viscous_force[:] = 0.0
        rows.direction[k] = 1.0
        viscosity._map(viscosity._of_direction, 0.0)
        assert rows.viscous_force[k] == pytest.approx(-rows.inverse[k], rel=1e-12)
        assert rows.inverse[k] > 0.0


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_a_slit_flows_as_with_small_steps(functions):
    """Steps of 60 times the explicit limit; its energy and momentum are whole to rounding."""
    small, large = finished(slit(LIQUID, functions=functions)), finished(slit(functions=functions))
    assert small.n_steps > 30 * large.n_steps
    (mean, many), facts = ((sim.momentum()[0] / sim.bodies[0].mass) for sim in (small, large)), large.facts()
    assert many == pytest.approx(mean, rel=1e-3)
    nodes = [sim.grid.nodes.velocity[:, 0] for sim in (small, large)]
    assert nodes[1] == pytest.approx(nodes[0], abs=2e-3)
    assert abs(large.budget.conservation()["energy"]) < 1e-13
    assert large.budget.conservation()["momentum"] < 1e-13
    told = facts["implicit_viscosity"]["common"]
    assert 1 < told["rounds_mean"] <= told["rounds_largest"] < 20


def test_vortices_fade_as_implicit_euler_says():
    """By ln(1 + λΔt)/Δt in place of λ, beside what the grid makes of that with small steps."""
    rate = 2.0 * 100.0 * (2.0 * np.pi) ** 2
    known = fading(vortices(LIQUID, end=1e-4)) / rate
    sim = vortices(IMPLICIT | {"eos": LIQUID["eos"] | {"sound_speed": 300.0}}, end=2e-4, step=2e-5)
    found = fading(sim)
    assert found == pytest.approx(known * np.log(1.0 + rate * 2e-5) / 2e-5, rel=0.01)
    energies = sim.budget.energies()
    heat = energies["fluid_viscous_heat"] + energies["implicit_viscous_heat"]
    stored = sim.bodies[0].totals.stored
    assert abs(sim.budget.conservation()["energy"]) < 1e-13
    assert energies["fluid_viscous_heat"] > 0.9 * heat > 0.0
    assert np.abs(sim.momentum()).max() < 1e-17
    assert stored > 0.0


def test_the_heat_is_what_the_stress_does_along_the_solution():
    """A shear that is there from the start loses no more: viscosity changes nothing in it."""
    flow = [{"kind": "velocity-gradient", "x": (0, 1.0, 0)}]
    walls = [WALLS[0] | {"velocity": (-0.5, 0, 0)}, WALLS[1] | {"velocity": (0.5, 0, 0)}]
    body = box((0, -0.5, 0), (0.5, 0.5, H), IMPLICIT, (2, 2, 1), initial=flow)
    sim = advance(plane(body, support=walls), 20)
    energies, volume = sim.budget.energies(), 0.5
    assert energies["fluid_viscous_heat"] == pytest.approx(volume * sim.time, rel=1e-3)
    assert abs(energies["implicit_viscous_heat"]) < 1e-3 * energies["fluid_viscous_heat"]
    stress = sim.bodies[0].field("stress")
    assert stress[:, 5] == pytest.approx(1.0, rel=2e-3)
    assert np.abs(sim.bodies[0].field("pressure") + stress[:, :3].mean(axis=1)).max() < 1e-9


def test_a_rigid_rotation_feels_none():
    body = box((-0.25, -0.25, 0), (0.25, 0.25, H), IMPLICIT, (2, 2, 1), angular_velocity=(0, 0, 3.0))
    sim = plane(body, counts=(8, 8, 1), lower=(-0.5, -0.5, 0), periodic=[], support=[], transfer="apic")
    sim.bodies[0].arrays["affine"][:, [1, 3]] = -3.0, 3.0
    begun = sim.kinetic_energy()
    advance(sim, 1)
    assert sim.budget.energies()["fluid_viscous_heat"] < 1e-20 * begun
    assert sim.facts()["implicit_viscosity"]["common"]["rounds_largest"] == 0


def test_threads_and_a_checkpoint_change_no_bit():
    one, two = (advance(slit(threads=threads), 6) for threads in (1, 2))
    assert_same_arrays(copied_state(one), copied_state(two))
    numbers, arrays, resumed = json.loads(json.dumps(one.state_numbers())), copied_state(one), slit()
    resumed.restore(arrays, numbers)
    advance(one, 6)
    advance(resumed, 6)
    assert_same_arrays(copied_state(one), copied_state(resumed))
    assert one.budget.energies() == resumed.budget.energies()
    assert one.facts() == resumed.facts()


def test_a_run_goes_on_from_another_with_or_without_it():
    """From frames, whose stress is the whole one, and which lack that of viscosity."""
    one = advance(slit(), 6)
    body = one.bodies[0]
    arrays = {name: body.field(name) for name in ("id", *body.arrays) if name != "viscous_stress"}
    for material in (IMPLICIT, LIQUID):
        two = Simulation(slit(material).case, threads=1, start={"block": arrays})
        assert two.momentum() == pytest.approx(one.momentum())
        advance(two, 2)
        assert abs(two.budget.conservation()["energy"]) < 1e-12


def test_each_velocity_field_is_solved_for_itself():
    """Two liquids, one upon the other, and a solid in the field of one, whose nodes have its mass."""
    lower = box((0, -0.5, 0), (0.5, 0, H), IMPLICIT, (2, 2, 1), name="one", velocity=(1, 0, 0))
    upper = box((0, 0, 0), (0.5, 0.25, H), IMPLICIT, (2, 2, 1), name="two", field="other", velocity=(-1, 0, 0))
    solid = box((0, 0.25, 0), (0.5, 0.375, H), SOLID | {"density": 1.0, "young_modulus": 100.0}, (2, 2, 1), field="other")
    with pytest.warns(UserWarning, match="solved before the contact with"):
        sim = plane(lower, upper, solid)
    advance(sim, 12)
    rounds = sim.facts()["implicit_viscosity"]
    assert rounds.keys() == {"common", "other"}
    assert all(0 < told["rounds_mean"] < 30 for told in rounds.values())
    assert sim.budget.conservation()["momentum"] < 1e-13
    assert abs(sim.budget.energies()["transfer_error"]) < 1e-13


def test_a_free_surface_with_nearly_empty_nodes_converges():
    """A block that falls and spreads, a thousand times the explicit limit."""
    honey = IMPLICIT | {"viscosity": 20.0}
    body = box((-0.24, -0.5, 0), (0.23, 0.11, H), honey, (2, 2, 1), velocity=(0, -2.0, 0))
    sim = plane(body, counts=(16, 8, 1), lower=(-1, -0.5, 0), periodic=[], support=SLIP[2:3], functions="quadratic-bspline")
    advance(sim, 40)
    assert sim.facts()["implicit_viscosity"]["common"]["rounds_largest"] < 60
    assert abs(sim.budget.conservation()["energy"]) < 1e-13


@pytest.mark.parametrize("more", [{"scheme": "usl"}, {"transfer": "pic"}, {"transfer": "apic"}])
def test_schemes_and_transfers_keep_energy_and_momentum(more):
    sim = advance(slit(**more), 10)
    assert abs(sim.budget.conservation()["energy"]) < 1e-13
    assert sim.budget.conservation()["momentum"] < 1e-13


def test_led_points_and_absorbing_faces_act_as_with_explicit_viscosity():
    """At steps for which the two hardly differ."""
    driver = box((0, -0.5, 0), (0.5, -0.25, H), LIQUID, (2, 2, 1), name="driver")
    moved = [{"name": "push", "body": "driver", "displacement": {"x": {"kind": "steady", "velocity": 1.0}}}]
    more = {"motion": moved, "absorbing": [{"body": "block", "where": "y-upper"}], "support": [], "step": 1e-5}
    found = []
    for material in (LIQUID, IMPLICIT):
        body = box((0, -0.25, 0), (0.5, 0.5, H), material, (2, 2, 1))
        sim = advance(plane(driver, body, **more), 60)
        found.append([sim.budget.energies()[name] for name in ("kinetic", "motion_work", "internal")])
        assert abs(sim.budget.conservation()["energy"]) < 1e-10
    assert found[1] == pytest.approx(found[0], rel=0.05)


def test_a_solve_that_does_not_converge_stops_the_run(monkeypatch):
    monkeypatch.setattr(implicit_viscosity, "MOST_ROUNDS", 1)
    error = "after 1 iterations the relative error of its forces is .*, above .*use a smaller time.step"
    text = f"step 1, time .* `common` did not converge: {error}"
    with pytest.raises(RunStopped, match=text):
        advance(slit(), 3)


def test_it_bounds_no_step_and_the_forecast_hints_at_it():
    explicit = foretell_case(slit(LIQUID).case)
    assert "(viscous)" in explicit[0]
    assert explicit[2].startswith("hint: body.block.material.implicit_viscosity = true would allow time steps 71 times as long")
    implicit = foretell_case(slit().case)
    assert "(wave)" in implicit[0]
    assert len(implicit) == 2
    fixed = 3e-3  # of the explicit limit 51 times
    assert slit(step=fixed).clock.case.step == fixed
    with pytest.raises(ValueError, match="kinematic viscosity"):
        slit(LIQUID, step=fixed)


def test_bodies_that_act_after_the_solve_are_warned_of():
    lower = box((0, -0.5, 0), (0.5, 0, H), IMPLICIT, (2, 2, 1), name="liquid")
    block = box((0.125, 0, 0), (0.375, 0.25, H), SOLID, (2, 2, 1), rigid=True)
    with pytest.warns(
        UserWarning, match="viscosity of body liquid is solved before the contact with block: with time steps much longer"
    ):
        plane(lower, block)
    assert not list(slipped_past(slit().case))


@pytest.mark.parametrize(
    ("change", "more", "text"),
    [
        ({"viscosity": 0.0}, {}, "implicit_viscosity = true, but the fluid has no viscosity; set `viscosity`"),
        ({"energy_update": "closed"}, {}, 'use "conservative" with implicit_viscosity'),
        ({}, {"scheme": "usf"}, "time.scheme: the implicit viscosity of body block determines its stress"),
        (
            {},
            {"support": [SLIP[2] | {"friction": 0.2}]},
            "support.0.friction: .* walls with friction or openings",
        ),
    ],
)
def test_what_does_not_fit_is_refused(change, more, text):
    with pytest.raises(ValueError, match=text):
        slit(IMPLICIT | change, **more)
