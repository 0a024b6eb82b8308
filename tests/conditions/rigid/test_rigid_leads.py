"""Rigid bodies of which motions prescribe a part of the motion: the rest is free."""

import json

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, SLIP, advance, box, case

from pellucid.errors import CaseError
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation.simulation import Simulation

PLANE, SPACE = (8, 8, 1), (8, 8, 8)
FEW = {"warn": 0.5, "stop": 10.0}
WATER = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 20.0}}


def square(**more):
    """Of 2 m by 2 m, 4000 kg: a plate in the plane."""
    return box((3, 3, 0), (5, 5, 1), RATE_SOLID, (3, 3, 1), rigid=True, **more)


def brick(**more):
    """Of three different sides."""
    return box((3, 3, 3), (5, 4.5, 4), RATE_SOLID, (2, 2, 2), rigid=True, **more)


def led(*bodies, motion, counts=PLANE, threads=1, **more):
    table = [{"body": "block"} | one for one in ([motion] if isinstance(motion, dict) else motion)]
    found = case(*bodies, counts=counts, motion=table, energy=FEW, **({"end": 10.0, "step": 0.01} | more))
    return Simulation(found, threads=threads)


def inertia(body):
    """About the centre of mass [kg m²], shape (3, 3)."""
    m, x = body.arrays["mass"], body.arrays["position"]
    r = x - np.average(x, axis=0, weights=m)
    own = np.sum(m * body.arrays["volume"] ** (2.0 / 3.0 if np.ptp(x[:, 2]) > 0.0 else 1.0)) / 6.0  # of cubes, or of squares
    return (np.sum(m * np.sum(r * r, axis=1)) + own) * np.eye(3) - np.einsum("p,pi,pj->ij", m, r, r)


def centre(body):
    return np.average(body.arrays["position"], axis=0, weights=body.arrays["mass"])


def closes(sim, share=1e-9):
    errors = sim.budget.conservation()
    assert errors["momentum"] < 1e-12
    assert abs(errors["energy"]) < share


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_a_given_path_leaves_the_rotation_free(scheme, functions):
    """The body is exactly on its path, and turns at the angular velocity that it had."""
    path = {"name": "path", "hold": ["y"], "displacement": {"x": {"kind": "ramp", "distance": 1.5, "duration": 1.0}}}
    sim = led(square(angular_velocity=(0, 0, 3.0)), motion=path, scheme=scheme, functions=functions)
    body = sim.bodies[0]
    first = centre(body)
    advance(sim, 60)
    moved = centre(body) - first
    assert moved[:2] == pytest.approx((1.5 * 0.6**3 * 3.16, 0.0), abs=1e-13)  # s³ (10 - 15 s + 6 s²)
    assert body.arrays["angle"][0] == pytest.approx((0.0, 0.0, 1.8), abs=1e-9)
    assert sim.budget.reactions()["path"] == pytest.approx(sim.momentum(), abs=1e-9)
    closes(sim, 2e-8)


def test_a_given_path_of_one_axis_leaves_the_other_to_gravity():
    path = {"name": "path", "displacement": {"x": {"kind": "steady", "velocity": 0.5}}}
    sim = led(square(velocity=(0.5, 0, 0)), motion=path, gravity=(0, -1.0, 0))
    first = centre(sim.bodies[0])
    advance(sim, 100)
    assert centre(sim.bodies[0]) - first == pytest.approx((0.5, -0.5 * (1.0 + 0.01), 0.0), abs=1e-9)  # symplectic Euler
    closes(sim)


def test_a_given_rotation_leaves_the_path_free():
    """It turns past a whole turn, flies on as it did, and takes its angular momentum from the motion."""
    turn = {"name": "turn", "rotation": {"z": {"kind": "ramp", "angle": 450.0, "duration": 1.0}}}
    sim = led(square(velocity=(0.4, -0.3, 0.0)), motion=turn)
    body = sim.bodies[0]
    first, offset = centre(body), body.frame()["position"] - centre(body)
    advance(sim, 50)
    rate = (1.875 * 2.5 * np.pi) * (1.0 - (0.005 / 0.5) ** 2) ** 2  # half a step before the middle
    assert sim.budget.angular_reactions()["turn"][2] == pytest.approx(inertia(body)[2, 2] * rate, rel=1e-4)
    advance(sim, 50)
    assert centre(body) - first == pytest.approx((0.4, -0.3, 0.0), abs=1e-12)
    assert body.arrays["angle"][0, 2] == pytest.approx(2.5 * np.pi, abs=1e-13)
    turned = body.frame()["position"] - centre(body)
    assert turned == pytest.approx(offset @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), abs=1e-11)
    closes(sim)


def test_a_wheel_on_an_axle_is_turned_by_the_work_of_its_motion():
    """Set turning at once it takes twice the energy that it has then, as a body that is driven does."""
    wheel = {"name": "axle", "hold": ["x", "y"], "rotation": {"z": {"kind": "steady", "angular_velocity": "60 rpm"}}}
    sim = led(square(), motion=wheel)
    first = centre(sim.bodies[0])
    advance(sim, 20)
    energy = 0.5 * inertia(sim.bodies[0])[2, 2] * (2.0 * np.pi) ** 2
    found = sim.budget.energies()
    assert centre(sim.bodies[0]) == pytest.approx(first, abs=1e-13)
    assert found["kinetic"] == pytest.approx(energy, rel=1e-12)
    assert found["motion_work"] == pytest.approx(2.0 * energy, rel=1e-12)
    assert found["impact_heat"] + found["transfer_heat"] == pytest.approx(energy, rel=1e-12)
    closes(sim, 1e-12)


def test_two_motions_lead_one_body_and_have_reactions_of_their_own():
    motions = [
        {"name": "path", "hold": ["y"], "displacement": {"x": {"kind": "steady", "velocity": 0.5}}},
        {"name": "turn", "hold_rotation": ["z"]},
    ]
    sim = led(square(angular_velocity=(0, 0, 2.0)), motion=motions)
    spin = 2.0 * inertia(sim.bodies[0])[2, 2]
    advance(sim, 10)
    assert sim.budget.reactions()["path"] == pytest.approx((2000.0, 0.0, 0.0), abs=1e-9)
    assert sim.budget.angular_reactions()["turn"] == pytest.approx((0.0, 0.0, -spin), rel=1e-12)
    assert not sim.budget.reactions()["turn"].any()
    assert not sim.budget.angular_reactions()["path"].any()
    closes(sim, 1e-12)


def led_top(body_inertia, omega_z, spin, time):
    """Angles summed up, and rotation, of a body that turns freely about x and y and at a given rate about z."""
    from scipy.integrate import solve_ivp

    def change(_, state):
        R, momentum = state[:9].reshape(3, 3), state[9:11]
        turned = R @ body_inertia @ R.T
        free = np.linalg.solve(turned[:2, :2], momentum - turned[:2, 2] * omega_z)
        w = np.array([*free, omega_z])
        return np.concatenate([np.cross(w, R, axisb=0, axisc=0).ravel(), np.zeros(2), w])

    start = np.concatenate([np.eye(3).ravel(), (body_inertia @ spin)[:2], np.zeros(3)])
    done = solve_ivp(change, (0.0, time), start, rtol=1e-10, atol=1e-12)
    return done.y[11:, -1], done.y[:9, -1].reshape(3, 3)


def test_in_space_a_given_rotation_about_one_axis_and_two_free_ones():
    """Where the rest of the rotation is free, it goes as the equations of motion say, whatever the step: parts of it are of
    fourth order. The reference is integrated to 1e-10."""
    spin = np.array([0.5, 0.4, 1.0])
    turn = {"name": "turn", "hold": ["x", "y", "z"], "rotation": {"z": {"kind": "steady", "angular_velocity": 1.0}}}
    for step in (0.04, 0.01):
        sim = led(brick(angular_velocity=tuple(spin)), motion=turn, counts=SPACE, step=step)
        body = sim.bodies[0]
        exact, R = led_top(inertia(body), 1.0, spin, 1.0)
        offset = body.frame()["position"] - centre(body)
        advance(sim, round(1.0 / step))
        turned = body.frame()["position"] - centre(body)
        assert body.arrays["angle"][0] == pytest.approx(exact, abs=1e-9)
        assert turned == pytest.approx(offset @ R.T, abs=1e-9)
        closes(sim)


def test_in_space_two_given_rotations_with_the_third_held_take_the_torque_of_the_top():
    """A body that turns about z at a constant rate, with its axes of inertia askew: the torque is ω × I ω, and does no work."""
    askew = brick(angular_velocity=(0, 0, 2.0))
    askew["shape"]["rotate"] = {"axis": [1, 0, 0], "angle": 30.0}
    turn = {
        "name": "turn",
        "hold": ["x", "y", "z"],
        "hold_rotation": ["x", "y"],
        "rotation": {"z": {"kind": "steady", "angular_velocity": 2.0}},
    }
    sim = led(askew, motion=turn, counts=SPACE, step=0.002)
    body, omega = sim.bodies[0], np.array([0.0, 0.0, 2.0])
    assert abs(inertia(body)[1, 2]) > 100.0
    advance(sim, 100)
    before, torque = sim.budget.angular_reactions()["turn"], np.cross(omega, inertia(body) @ omega)
    advance(sim, 1)
    given = (sim.budget.angular_reactions()["turn"] - before) / 0.002
    assert given == pytest.approx(torque, abs=0.005 * np.abs(torque).max())
    energies = sim.budget.energies()
    assert abs(energies["motion_work"]) < 1e-6 * energies["kinetic"]
    closes(sim)


def test_a_body_that_is_led_wholly_behaves_as_a_driven_one():
    """In water, which both push. Driven points hold every node that they reach, the rigid body those up to half a cell outside
    its surface: of two cells alone, the driven block pushes by a seventh more water."""
    found = {}
    for rigid in (False, True):
        block = box((3, 3, 0), (5, 5, 1), RATE_SOLID, (2, 2, 1), rigid=rigid)
        water = box((0, 0, 0), (8, 8, 1), WATER, (2, 2, 1), name="water", outside=["block"])
        swing = {"name": "swing", "hold": ["x"], "displacement": {"y": {"kind": "sine", "amplitude": 0.4, "period": 2.0}}}
        if rigid:
            swing["hold_rotation"] = ["z"]
        sim = led(block, water, motion=swing, support=SLIP[:4])
        advance(sim, 60)
        assert sim.budget.conservation()["momentum"] < 1e-12
        found[rigid] = np.array([sim.bodies[1].totals.momentum[1], sim.budget.reactions()["swing"][1]])
        assert sim.bodies[0].frame()["position"][0, 1] - 3.25 == pytest.approx(0.4 * np.sin(0.6 * np.pi), abs=1e-13)
        assert sim.bodies[0].constraint.top_speed == pytest.approx(0.4 * np.pi)
    assert found[True] == pytest.approx(found[False], rel=0.16)
    assert abs(found[True][0]) < abs(found[False][0])
    assert abs(found[True][0]) > 1000.0


@pytest.mark.parametrize("held", [[], ["z"]])
def test_a_led_body_presses_another_one_away(held):
    """A hammer on a rail strikes a free block: what this gains the hammer's motion gives."""
    hammer = box((1, 3, 0), (3, 5, 1), RATE_SOLID, (2, 2, 1), rigid=True, field="hammer")
    free = box((3.2, 3, 0), (4.2, 5, 1), RATE_SOLID, (2, 2, 1), name="free", rigid=True, field="free")
    push = {"name": "push", "hold": ["y"], "displacement": {"x": {"kind": "ramp", "distance": 1.5, "duration": 1.0}}}
    sim = led(hammer, free, motion=push | {"hold_rotation": held}, step=None)
    while sim.time < 1.2:
        sim.step()
    assert sim.bodies[1].totals.momentum[0] > 2000.0
    assert sim.budget.reactions()["push"][0] == pytest.approx(sim.momentum()[0], abs=1e-9)
    closes(sim)


def test_a_wheel_that_is_turned_drives_the_plate_below_it():
    """Coulomb friction: the plate gains μ times what presses it, and the torque on the axle is that of this force."""
    shape = {"cylinder": {"centre": (4, 3.5, 0), "radius": 1.5, "axis": "z", "height": 1.0}}
    wheel = {"name": "block", "field": "wheel", "rigid": True, "shape": shape, "points_per_cell": (4, 4, 1)}
    plate = box((0.5, 1, 0), (11.5, 2, 1), RATE_SOLID, (2, 2, 1), name="plate", field="plate", rigid=True)
    turn = {"name": "axle", "hold": ["x"], "rotation": {"z": {"kind": "steady", "angular_velocity": -2.0}}}
    rail = {"name": "rail", "body": "plate", "hold": ["y"], "hold_rotation": ["z"]}
    contact = [{"between": ["block", "plate"], "kind": "coulomb", "friction": 0.5, "name": "tread"}]
    more = {"contact": contact, "gravity": (0, -1.0, 0), "counts": (12, 8, 1), "step": None}
    sim = led(wheel | {"material": RATE_SOLID}, plate, motion=[turn, rail], **more)
    while sim.time < 0.5:
        sim.step()
    forward, pressed, _ = sim.budget.reactions()["tread"]
    assert forward == pytest.approx(0.5 * pressed, rel=0.02)
    assert sim.bodies[1].totals.momentum[0] == pytest.approx(-forward, rel=1e-12)  # but for rounding over all steps
    assert sim.budget.reactions()["axle"][0] == pytest.approx(-forward, rel=1e-12)
    spin = -2.0 * inertia(sim.bodies[0])[2, 2]
    assert sim.budget.angular_reactions()["axle"][2] - spin == pytest.approx(
        -1.5 * forward, rel=0.05
    )  # it touches over a width
    closes(sim)


def test_a_led_body_settles_where_its_motion_begins():
    """Time stands still for its motion, and what is free falls until a wall bears it."""
    path = {"name": "path", "displacement": {"x": {"kind": "steady", "velocity": 0.5}}, "hold_rotation": ["z"]}
    sim = led(square(), motion=path, gravity=(0, -1.0, 0), support=SLIP[:4], step=None)
    table = sim.case.to_data() | {"settle": {"share": 1e-6, "most_steps": 5000}}
    sim = Simulation(type(sim.case).model_validate(table), threads=1)
    sim.settle()
    assert centre(sim.bodies[0])[:2] == pytest.approx((4.0, 1.0), abs=1e-3)
    before = sim.time
    advance(sim, 5)
    assert centre(sim.bodies[0])[0] == pytest.approx(4.0 + 0.5 * (sim.time - before), abs=1e-12)


def test_what_leads_it_through_a_wall_wins():
    """A wall cannot stop what is prescribed; what is free it still stops."""
    down = {"name": "down", "displacement": {"y": {"kind": "ramp", "distance": -0.6, "duration": 1.0}}}
    block = box((4, 0.5, 0), (6, 2.5, 1), RATE_SOLID, (2, 2, 1), rigid=True, velocity=(3.0, 0.0, 0.0))
    sim = led(block, motion=down, support=SLIP[:4])
    advance(sim, 100)
    position = sim.bodies[0].arrays["position"]
    assert centre(sim.bodies[0])[1] == pytest.approx(0.9, abs=1e-13)
    assert position[:, 0].max() < 7.75 + 1e-9
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_probes_of_angle_angular_velocity_and_torque():
    motion = {"name": "turn", "body": "block", "rotation": {"z": {"kind": "steady", "angular_velocity": 8.0}}}
    probes = [
        {"name": "angle", "body": "block", "quantity": "angle", "component": "z"},
        {"name": "rate", "body": "block", "quantity": "angular_velocity", "component": "z"},
        {"name": "torque", "quantity": "torque", "condition": "turn", "component": "z"},
    ]
    found = case(square(), counts=PLANE, motion=[motion], probe=probes, energy=FEW, end=10.0, step=0.01)
    sim = Simulation(found, threads=1)
    reader = ProbeReader(found.probe)
    reader.start(sim.bodies)
    assert reader.units() == {"angle": "rad", "rate": "rad/s", "torque": "N m"}
    assert reader.read(sim.bodies, sim.budget.reactions(), sim.time, sim.budget.angular_reactions()) == [0.0, 0.0, 0.0]
    advance(sim, 100)
    reader = ProbeReader(found.probe, json.loads(json.dumps(reader.to_data())))  # as a checkpoint keeps it
    angle, rate, torque = reader.read(sim.bodies, sim.budget.reactions(), sim.time, sim.budget.angular_reactions())
    assert (angle, rate) == (pytest.approx(8.0, rel=1e-12), pytest.approx(8.0, rel=1e-12))
    assert torque == pytest.approx(8.0 * inertia(sim.bodies[0])[2, 2] / 1.0, rel=1e-12)


def test_bits_do_not_depend_on_threads_and_a_checkpoint_goes_on():
    turn = {"name": "turn", "displacement": {"x": {"kind": "steady", "velocity": 0.3}}, "hold_rotation": ["x"]}
    turn["rotation"] = {"z": {"kind": "sine", "angle": 40.0, "period": 0.5}}
    block = brick(angular_velocity=(0.2, 0.4, 0.0))
    one, two = (led(block, motion=turn, counts=SPACE, threads=threads, gravity=(0, 0, -0.1)) for threads in (1, 2))
    advance(one, 30)
    advance(two, 30)
    for name, array in one.bodies[0].arrays.items():
        assert np.array_equal(array, two.bodies[0].arrays[name])
    again = led(block, motion=turn, counts=SPACE, gravity=(0, 0, -0.1))
    numbers = json.loads(json.dumps(one.state_numbers()))
    again.restore({name: array.copy() for name, array in one.state_arrays().items()}, numbers)
    advance(again, 20)
    advance(two, 20)
    for name, array in again.bodies[0].arrays.items():
        assert np.array_equal(array, two.bodies[0].arrays[name])
    assert again.budget.angular_reactions()["turn"].tolist() == two.budget.angular_reactions()["turn"].tolist()


TURN = {"name": "turn", "rotation": {"z": {"kind": "ramp", "angle": 90, "duration": 1.0}}}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rotation": {"x": TURN["rotation"]["z"]}}, "one cell thick along z: bodies rotate about z only, not about x"),
        ({"hold_rotation": ["x"]}, "one cell thick along z: bodies rotate about z only, not about x"),
        ({"hold_rotation": ["z"]}, "z is in both `hold_rotation` and `rotation`; remove it from one"),
        ({"rotation": {}}, "prescribes no direction"),
        ({"part": {"box": {"lower": (3, 3, 0), "upper": (4, 4, 1)}}}, "is rigid: a motion moves it as a whole"),
        ({"displacement": {"z": {"kind": "steady", "velocity": 1.0}}}, "one cell thick along z: nothing moves along this axis"),
        ({"rotation": {"z": {"kind": "ramp", "angle": "3 m", "duration": 1.0}}}, r"\(rad\) is required"),
        ({"rotation": {"z": {"kind": "steady", "velocity": 3.0}}}, "angular_velocity"),
    ],
)
def test_motions_of_rigid_bodies_that_make_no_sense(change, words):
    with pytest.raises((CaseError, ValueError), match=words):
        led(square(), motion=TURN | change)


def test_a_number_is_led_once():
    with pytest.raises((CaseError, ValueError), match="the motion turn already prescribes body block about z"):
        led(square(), motion=[TURN, TURN | {"name": "other"}])


def test_only_rigid_bodies_turn():
    with pytest.raises((CaseError, ValueError), match="is not rigid: its points can only follow displacements"):
        led(square() | {"rigid": False}, motion=TURN)


def test_a_torque_is_that_of_a_motion_of_a_rigid_body():
    probe = [{"name": "t", "quantity": "torque", "condition": "go"}]
    motion = [{"name": "go", "body": "block", "hold": ["x"]}]
    with pytest.raises(
        (CaseError, ValueError),
        match=r"`torque` requires a \[\[motion\]\] of a rigid body, but `go` is not one; the case has no named motion",
    ):
        case(square() | {"rigid": False}, counts=PLANE, motion=motion, probe=probe)
    case(square(), counts=PLANE, motion=motion, probe=probe)


def test_a_torque_of_another_condition_names_the_motions_that_have_one():
    probe = [{"name": "t", "quantity": "torque", "condition": "wall"}]
    motion = [{"name": "go", "body": "block", "hold": ["x"]}]
    words = "`wall` is not one; available: go"
    with pytest.raises((CaseError, ValueError), match=words):
        case(square(), counts=PLANE, motion=motion, probe=probe)


def test_a_fluid_cannot_be_rigid():
    words = "body.0.rigid: a material of kind .fluid. flows, but a rigid body keeps its shape"
    with pytest.raises((CaseError, ValueError), match=words):
        case(square() | {"material": GAS}, counts=PLANE)


def test_angles_of_a_table_are_in_degrees(tmp_path):
    (tmp_path / "turn.csv").write_text("time,angle\n0,10\n0.5,55\n1,100\n", encoding="utf-8")
    turn = {"name": "turn", "rotation": {"z": {"kind": "table", "path": str(tmp_path / "turn.csv")}}}
    sim = led(square(), motion=turn)
    advance(sim, 100)
    assert sim.bodies[0].arrays["angle"][0, 2] == pytest.approx(0.5 * np.pi, abs=1e-13)
