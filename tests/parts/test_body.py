"""What every body must answer, whatever its kind: over all that are registered, in a field with others and alone in one."""

from math import fsum

import numpy as np
import pytest
from elements import element_sheet
from membranes import THICKNESS, sheet
from small_cases import advance, box, case, simulation

from pellucid.bodies.models import BODIES
from pellucid.contact.contact_body import WarnsOfContact
from pellucid.energy import FIRST_LOAD, INTERNAL
from pellucid.errors import RunStopped, UnknownName
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import Supports
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip
from pellucid.parts.assembly import AssembledBody
from pellucid.parts.body import Placement
from pellucid.parts.capabilities import Membrane, TakesPressure
from pellucid.parts.families import GridBody, NodalBody

# soft, for steps as long as the block's
SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e3, "poisson_ratio": 0.3}
TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.45}
SAMPLES = {
    "material-points": box((-0.5, -0.25, -0.25), (0.5, 0.5, 0.25)),
    "membrane-points": sheet(points=(13, 13), material=SKIN),
    "membrane-elements": element_sheet(points=(7, 7), material=SKIN),
    "meshless-solid": {
        "name": "block",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": (-0.5, -0.25, -0.25), "upper": (0.5, 0.5, 0.25), "cells": (4, 3, 2)}},
        "material": TISSUE,
    },
}
MASS = dict.fromkeys(("material-points", "meshless-solid"), 375.0) | dict.fromkeys(
    ("membrane-points", "membrane-elements"), 1000.0 * THICKNESS
)
GRID = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
VELOCITY = (0.6, -0.3, 0.2)
MODELS = {kind: case(table, **GRID).body[0] for kind, table in SAMPLES.items()}
# in a velocity field with others, and alone in one where that makes it a body with its own nodes
KINDS = [(kind, alone) for kind, model in MODELS.items() for alone in (False, True) if model.owns_nodes(alone) == alone]
every_kind = pytest.mark.parametrize(("kind", "alone"), KINDS, ids=[f"{kind}{'-alone' * alone}" for kind, alone in KINDS])


def in_flight(kind, alone, **more):
    """A sample that flies, and a block far away: in its velocity field, or in one of its own."""
    far = box(
        (-1.75, -1.75, -1.5), (-1.25, -1.25, -1.0), per_cell=(1, 1, 1), name="far", field="another" if alone else "common"
    )
    settings = GRID | {"step": 1e-3, "end": 10.0} | more
    return simulation(SAMPLES[kind] | {"velocity": VELOCITY}, far, **settings)


def by_itself(kind, alone, gravity=(0.0, 0.0, 0.0)):
    """A sample at rest without a simulation, with two channels of loads, and its velocity field."""
    whole = case(SAMPLES[kind], **GRID)
    field = (OwnNodesField if alone else VelocityField)("common", Grid(whole.grid))
    actions = NodalActions(field, 2)
    actions.take_loads()
    field.set_actions(Supports(np.zeros((1, 3)), np.ones(1, np.int64)), actions.external(), gravity, small_mass=0.0, flip=1.0)
    body = whole.body[0].with_others(whole.body).build(Placement(whole.grid, field, Flip(), gravity, n_loads=2))
    body.complete()
    return body, field


def stepped(body, field, dt, act):
    """What acted over a step, in which `act` is what conditions do."""
    field.clear()
    body.begin(dt)
    field.clear_external()
    act()
    if isinstance(body, GridBody):
        body.particle_to_grid(inertia=True, force=True)
    else:
        body.predict(dt)
    field.advance(dt)
    if isinstance(body, GridBody):
        work = field.works(dt)
        body.grid_to_particle(dt, remap=False)
        return work
    body.correct(remap=False)
    return body.work()


def test_every_kind_has_a_sample():
    own = {kind: model for kind, model in BODIES.entries.items() if model.__module__.startswith("pellucid.")}  # not of users
    apart = {"fluid-film"}  # without inertia: nothing that moves freely, which these tests are about
    assert set(SAMPLES) == {kind for kind, model in own.items() if model.moves} - apart, "what does not move has its own tests"
    assert {kind for kind, _ in KINDS} == set(SAMPLES)


@every_kind
def test_family_mass_and_identity(kind, alone):
    body = in_flight(kind, alone).bodies[0]
    assert isinstance(body, NodalBody if alone else GridBody)
    assert body.name == SAMPLES[kind]["name"]
    assert body.energy_kind in ("internal", "strain")
    assert body.mass == pytest.approx(MASS[kind], rel=1e-12)
    assert fsum(body.field("mass")) == body.mass
    assert body.n_points == len(body.arrays["id"]) > 40
    assert np.array_equal(np.sort(body.arrays["id"]), np.arange(body.n_points))
    assert all(len(array) == body.n_points for array in body.arrays.values())
    assert body.volumes()[body.order()] == pytest.approx(body.field("mass") / body.field("density"), rel=1e-12)
    assert body.volumes().sum() == pytest.approx(MASS[kind] / 1000.0, rel=1e-12)


@every_kind
@pytest.mark.parametrize("n_steps", [0, 8])
def test_totals_are_the_sums_over_the_points(kind, alone, n_steps):
    sim = in_flight(kind, alone)
    body = sim.bodies[0]
    body.arrays["velocity"][:] += np.random.default_rng(1).normal(scale=0.05, size=(body.n_points, 3))
    body.renew_totals()
    advance(sim, n_steps)
    mass, v = body.arrays["mass"], body.arrays["velocity"]
    totals = body.totals
    assert totals.momentum == pytest.approx(mass @ v, rel=1e-13)
    assert totals.momentum_size == pytest.approx(mass @ np.linalg.norm(v, axis=1), rel=1e-13)
    assert totals.kinetic == pytest.approx(0.5 * mass @ np.sum(v * v, axis=1), rel=1e-13)
    assert body.kinetic_energies().sum() == pytest.approx(totals.kinetic, rel=1e-13)
    assert body.field("kinetic_energy") == pytest.approx(body.kinetic_energies()[body.order()], rel=1e-13)
    stored = body.field("stored_energy").sum()
    assert stored == pytest.approx(totals.stored, rel=1e-12)
    assert (stored > 0.0) == (n_steps > 0)
    assert all(0.0 <= part <= totals.stored for part in totals.parts.values())
    assert totals.rate > 0.0


@every_kind
def test_points_fly_on_in_frames_that_are_in_the_order_of_ids(kind, alone):
    """Through several cells and sortings: each is where it started from, and as far on as all."""
    sim = in_flight(kind, alone, step=0.02)
    body = sim.bodies[0]
    start = body.frame()
    advance(sim, 20)
    frame = body.frame()
    assert list(frame) == list(start) == body.field_names
    assert np.array_equal(frame["id"], np.arange(body.n_points))
    assert np.array_equal(frame["mass"], start["mass"])
    # twenty steps, each with the rounding of sums over a few dozen terms
    assert frame["position"] - start["position"] == pytest.approx(
        np.tile(0.4 * np.array(VELOCITY), (body.n_points, 1)), abs=1e-12
    )
    assert frame["velocity"] == pytest.approx(np.tile(VELOCITY, (body.n_points, 1)), abs=1e-12)
    back = np.argsort(body.arrays["id"])
    assert np.array_equal(back, np.arange(body.n_points)[body.order()])
    for name in body.field_names:
        assert np.array_equal(frame[name], body.field(name)), name
        assert np.array_equal(frame[name], body.stored_field(name)[back]), name
    assert {"id", "position", "velocity", "mass", "density"} <= set(frame)
    assert np.array_equal(body.places(), frame["position"])
    assert np.array_equal(body.arrays["id"], frame["id"]) == alone, "points on the grid are sorted, own nodes keep their order"
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert sim.budget.conservation()["mass"] == 0.0


@every_kind
def test_a_field_that_is_not_there_is_told_with_those_that_are(kind, alone):
    body = in_flight(kind, alone).bodies[0]
    words = rf"body {body.name} has no field `velocty`; available: .*position.*\n    did you mean `velocity`\?"
    for ask in (body.field, body.frame().__getitem__):
        with pytest.raises(UnknownName, match=words):
            ask("velocty")


@every_kind
def test_a_body_goes_on_from_its_arrays_bit_for_bit(kind, alone):
    def disturbed():
        sim = in_flight(kind, alone, step=4e-3, gravity=(0.0, 0.0, -5.0))
        for body in sim.bodies:
            body.arrays["velocity"][:] += np.random.default_rng(1).normal(scale=0.05, size=(body.n_points, 3))
            body.renew_totals()
        return sim

    one, late = disturbed(), disturbed()
    advance(one, 60)
    arrays, numbers = {name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers()
    body, other = one.bodies[0], late.bodies[0]
    kept = {name: array.copy() for name, array in body.state_arrays().items()}
    assert set(other.state_arrays()) == set(kept)
    other.restore(kept)
    for name, array in other.state_arrays().items():
        assert array.dtype == kept[name].dtype, name
        assert array.tobytes() == kept[name].tobytes(), name
    for name, values in body.frame().items():
        assert np.array_equal(other.frame()[name], values), name
    before, late = {name: array.tobytes() for name, array in arrays.items()}, disturbed()
    late.restore(arrays, numbers)
    for sim in (one, late):
        advance(sim, 20)
    for name, array in one.state_arrays().items():
        assert late.state_arrays()[name].tobytes() == array.tobytes(), name
    assert late.budget.energies() == one.budget.energies()
    assert one.bodies[0].totals.to_data() == late.bodies[0].totals.to_data()
    assert any(array.tobytes() != before[name] for name, array in one.state_arrays().items())


@every_kind
def test_the_work_of_gravity_is_the_kinetic_energy_of_a_fall(kind, alone):
    sim = in_flight(kind, alone, gravity=(0.5, 0.0, -2.0))
    start = sim.budget.energies()["kinetic"]
    advance(sim, 20)
    energies = sim.budget.energies()
    assert energies["gravity_work"] == pytest.approx(energies["kinetic"] - start, rel=1e-9)
    fallen = np.array(VELOCITY) + sim.time * np.array((0.5, 0.0, -2.0))
    assert sim.bodies[0].totals.momentum == pytest.approx(MASS[kind] * fallen, rel=1e-12)
    assert sim.budget.conservation()["momentum"] < 1e-12


@every_kind
def test_external_forces_give_their_impulse_and_their_work_in_the_column_of_their_channel(kind, alone):
    """m a on each point, from rest: the velocity a dt, exactly, and works ½ m a² dt² in shares of the two channels."""
    body, field = by_itself(kind, alone)
    a, dt = np.array((3.0, -2.0, 1.0)), 1e-3
    force = body.arrays["mass"][:, None] * a

    def act():
        body.add_external_force(0.25 * force, FIRST_LOAD)
        body.add_external_force(0.5 * force, FIRST_LOAD + 1)
        body.add_external_force(0.25 * force, FIRST_LOAD + 1)

    done = stepped(body, field, dt, act)
    assert body.arrays["velocity"] == pytest.approx(np.tile(dt * a, (body.n_points, 1)), rel=1e-9)
    assert done.impulse == pytest.approx(dt * MASS[kind] * a, rel=1e-12)
    work = 0.5 * MASS[kind] * (a @ a) * dt**2
    assert done.works[FIRST_LOAD:] == pytest.approx([0.25 * work, 0.75 * work], rel=1e-9)
    assert np.abs(np.delete(done.works, [FIRST_LOAD, FIRST_LOAD + 1])).max() == 0.0
    assert body.totals.kinetic == pytest.approx(work, rel=1e-9)
    assert not done.reactions.any()
    assert done.gravity_mass == pytest.approx(MASS[kind], rel=1e-12)
    again = stepped(body, field, dt, lambda: None)
    assert not again.impulse.any(), "forces act over one step"
    assert np.abs(again.works[INTERNAL]) < 1e-9 * work


@every_kind
def test_membranes_are_pressed_along_normals_volumes_are_not(kind, alone):
    body, field = by_itself(kind, alone)
    assert body.is_surface == (len(body.cells().triangles) + len(body.cells().quadrilaterals) > 0)
    assert body.is_surface == isinstance(body, Membrane) == isinstance(body, TakesPressure)
    if not body.is_surface:
        with pytest.raises(ValueError, match="body block lacks the capability `TakesPressure`"):
            AssembledBody(body, MODELS[kind], None).offers(TakesPressure)
        return
    assert body.pressed_areas() == pytest.approx(body.vector_areas()[body.order()], abs=1e-12)
    assert body.areal_density == pytest.approx(MASS[kind], rel=1e-12), "of a sheet of 1 m²"
    assert body.vector_areas().sum(axis=0) == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    done = stepped(body, field, 1e-3, lambda: body.add_pressure(7.0, FIRST_LOAD + 1))
    assert done.impulse == pytest.approx((0.0, 0.0, 7e-3), abs=1e-15)
    assert body.totals.momentum == pytest.approx((0.0, 0.0, 7e-3), abs=1e-15)
    assert done.works[FIRST_LOAD + 1] > 0.0 == done.works[FIRST_LOAD]


@every_kind
def test_what_is_prescribed_is_followed_and_its_impulse_is_the_change_of_momentum(kind, alone):
    name = SAMPLES[kind]["name"]
    motion = {"name": "go", "body": name, "hold": ["y"], "displacement": {"x": {"kind": "steady", "velocity": -0.5}}}
    sim = in_flight(kind, alone, motion=[motion])
    body = sim.bodies[0]
    start = body.frame()["position"]
    advance(sim, 20)
    moved = body.frame()["position"] - start
    assert moved[:, :2] == pytest.approx(np.tile((-0.5 * sim.time, 0.0), (body.n_points, 1)), abs=1e-13)
    assert moved[:, 2] == pytest.approx(0.2 * sim.time, abs=1e-12)
    gained = MASS[kind] * np.array((-0.5 - 0.6, 0.3, 0.0))
    assert sim.budget.reactions()["go"] == pytest.approx(gained, abs=1e-11 * MASS[kind])
    assert sim.budget.conservation()["momentum"] < 1e-12
    # brought from v to w at once: own nodes take the change of kinetic energy; on the grid the motion works m w (w - v), of
    # which ½ m (w - v)² is lost in the jerk
    energies, lost = sim.budget.energies(), 0.0 if alone else 0.5 * MASS[kind] * (1.1**2 + 0.3**2)
    change = 0.5 * MASS[kind] * (0.5**2 - 0.6**2 - 0.3**2)
    assert energies["motion_work"] == pytest.approx(change + lost, rel=1e-9)
    assert energies["impact_heat"] == pytest.approx(lost, rel=1e-9)


@every_kind
def test_a_support_on_all_nodes_holds_its_axes_and_takes_their_momentum(kind, alone):
    frame = {"name": "frame", "where": "all-nodes", "fix": ["x"], "velocity": (0.1, 9.0, 9.0)}
    sim = in_flight(kind, alone, support=[frame])
    body, far = sim.bodies
    advance(sim, 5)
    velocity = body.frame()["velocity"]
    assert velocity == pytest.approx(np.tile((0.1, *VELOCITY[1:]), (body.n_points, 1)), abs=1e-12)
    brake, push = -0.5 * MASS[kind], 0.1 * far.mass
    assert sim.budget.reactions()["frame"][0] == pytest.approx(brake + push, rel=1e-12)
    assert not sim.budget.reactions()["frame"][1:].any()
    assert sim.budget.conservation()["momentum"] < 1e-12
    # own nodes know what the jerk costs; on the grid it is an error of the transfer
    along = 0.5 * (0.6 + 0.1) if alone else 0.1
    assert sim.budget.energies()["support_work"] == pytest.approx(brake * along + push * 0.1, rel=1e-9)


@every_kind
def test_a_fault_names_the_body_and_the_point(kind, alone):
    sim = in_flight(kind, alone)
    body = sim.bodies[0]
    body.arrays["velocity"][17] = np.nan
    with pytest.raises(RunStopped, match=f"of body `{body.name}`.*not a finite number") as caught, np.errstate(all="ignore"):
        advance(sim, 3)
    place = caught.value.place
    assert place["body"] == body.name
    assert place["state"]["id"] == place["point"]


@every_kind
def test_on_the_grid_a_body_shows_its_points_to_contact(kind, alone):
    body, field = by_itself(kind, alone)
    there = body.on_grid
    assert there is not None
    assert (there.name, there.n_points, there.is_surface) == (body.name, body.n_points, body.is_surface)
    assert len(there.functions) == 3
    assert there.mapped.points.position is body.arrays["position"]
    assert there.mapped.nodes.mass is field.grid.nodes.mass
    assert there.n_slabs == len(there.mapped.slabs.first) - 1
    assert there.mapped.slabs.first[-1] == body.n_points
    if isinstance(there, WarnsOfContact):
        assert there.contact_warning(np.zeros(0, np.int64)) is None
    thickness, _, _ = there.half_width()
    # nodes of a volume lie on its surface, its material points half their cube within
    assert thickness == (0.5 * THICKNESS if body.is_surface else 0.0 if alone else -1.0)
