"""Rigid bodies bear on their edges and corners where these are, and friction holds them there."""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from small_cases import RATE_SOLID, box, case

from pellucid.contact.dead_stop import Dampers
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.results.storage.probes import carried_by
from pellucid.simulation.simulation import Simulation

G = 9.81
STICK, ROUGH = {"kind": "stick"}, {"kind": "coulomb", "friction": 2.0}
FLOOR = {"point": (0, 0.2, 0), "normal": (0, 1, 0)}
HELD = {"name": "held", "body": "floor", "hold": ["x", "y", "z"]}


def slope(angle):
    """Gravity on a slope [degrees] that falls along x."""
    return (G * np.sin(np.radians(angle)), -G * np.cos(np.radians(angle)), 0)


def block(lower, upper, name="block", **more):
    return box(lower, upper, RATE_SOLID, None, name=name, field=name, rigid=True, **more)


def floor(lower, upper):
    return box(lower, upper, RATE_SOLID, None, name="floor", field="floor")


def run(*bodies, end, counts=(24, 14, 1), cell=0.1, **more):
    thickness = 1.0 if counts[2] == 1 else None
    sim = Simulation(case(*bodies, counts=counts, cell=cell, functions="gimp", thickness=thickness, end=end, **more), threads=1)
    surface = sim.bodies[-1].contact_surface
    surface.begin()
    corners = np.unique(surface.faces[surface.faces >= 0])
    start = surface.place[corners].copy()
    while not sim.clock.finished(None):
        sim.step()
    surface.begin()
    return sim, start, surface.place[corners]


def turned(start, now):
    """Rotation vector between corners [rad]."""
    return Rotation.align_vectors(now - now.mean(axis=0), start - start.mean(axis=0))[0].as_rotvec()


def tipped(width, height, angle, end):
    """Angle [rad] about its lower edge of a block that begins at rest on a slope [degrees]."""

    def rates(_, state):
        leaning = np.radians(angle) + state[0]
        torque = 0.5 * G * (height * np.sin(leaning) - width * np.cos(leaning))
        return [state[1], torque / ((width**2 + height**2) / 3.0)]

    return solve_ivp(rates, (0.0, end), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[0, -1]


def lower_edge(corners, x):
    return np.flatnonzero((np.abs(corners[:, 0] - x) < 1e-9) & (np.abs(corners[:, 1] - 0.2) < 1e-9))


def run_cylinder(cylinder, end, gravity):
    """A rigid cylinder of rubber on a rough floor; its displacement [m] and angle about z [rad] at the end."""
    body = block((0, 0, 0), (1, 1, 1)) | {"shape": {"cylinder": cylinder}}
    walls = [FLOOR | ROUGH]
    sim = Simulation(
        case(body, counts=(20, 24, 8), cell=0.05, functions="gimp", end=end, gravity=gravity, wall=walls), threads=1
    )
    while not sim.clock.finished(None):
        sim.step()
    arrays = sim.bodies[0].arrays
    return sim, (arrays["position"] - arrays["start"]).mean(axis=0), arrays["angle"][0, 2]


def test_a_cylinder_tips_about_its_rim():
    """On four cells across its end. The rim bears on an arc, which grows as it sinks; while the pressure goes to it the angle
    gains up to 3 %."""
    radius, height, end = 0.1, 0.8, 0.25
    sim, _, angle = run_cylinder({"centre": (0.4, 0.6, 0.2), "radius": radius, "height": height, "axis": "y"}, end, slope(30))

    def rates(_, state):
        leaning = np.radians(30) + state[0]
        torque = G * (0.5 * height * np.sin(leaning) - radius * np.cos(leaning))
        return [state[1], torque / (1.25 * radius**2 + height**2 / 3.0)]

    exact = solve_ivp(rates, (0.0, sim.time), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert -angle == pytest.approx(exact, rel=0.03)


@pytest.mark.slow
def test_a_cylinder_rolls_on_its_round_side():
    """Its rims do not brake it: they move along themselves. Rolling on facets of points costs some 1 %."""
    radius, end = 0.2, 0.4
    sim, moved, angle = run_cylinder({"centre": (0.3, 0.4, 0.2), "radius": radius, "height": 0.2, "axis": "z"}, end, slope(10))
    exact = G * np.sin(np.radians(10)) * sim.time**2 / 3.0
    assert moved[0] == pytest.approx(exact, rel=0.02)
    assert -angle * radius == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize(
    ("on", "depth"),
    [("floor", 1), ("wall", 4), *(pytest.param(*one, marks=pytest.mark.slow) for one in [("wall", 1), ("floor", 4)])],
)
@pytest.mark.parametrize("kind", [STICK, ROUGH])
def test_a_block_tips_about_its_lower_edge(on, depth, kind):
    """On two cells across its width. While the pressure goes to the edge it sinks by up to 0.2 mm and gains 0.5 % in angle."""
    z = (0.1, 0.3) if depth > 1 else (0, 0)
    body = block((0.8, 0.2, z[0]), (1.0, 1.0, z[1]))
    more = {"wall": [FLOOR | kind]} if on == "wall" else {"motion": [HELD], "contact": [{"between": ["block", "floor"]} | kind]}
    bodies = (body,) if on == "wall" else (floor((0.1, 0.1, 0), (1.9, 0.2, 0.1 * depth)), body)
    sim, start, now = run(*bodies, end=0.3, counts=(20, 14, depth), gravity=slope(30), **more)
    assert -turned(start, now)[2] == pytest.approx(tipped(0.2, 0.8, 30, sim.time), rel=0.01)
    edge = lower_edge(start, 1.0)
    assert np.abs(now[edge] - start[edge]).max() < 2e-4
    energy = sim.parts.only(SurfacePairs).energy
    assert abs(energy.unexplained) < 1e-3 * sim.kinetic_energy()


@pytest.mark.parametrize(("angle", "width", "height", "cell"), [(20, 0.2, 0.8, 0.1), (40, 0.4, 0.8, 0.07), (38, 0.4, 0.6, 0.1)])
def test_it_tips_on_slopes_that_lie_askew_to_the_grid(angle, width, height, cell):
    """Slopes, shapes and cells of other sizes; near the slope on which it stays, where small torques count, within 2 %."""
    rotate = {"axis": (0, 0, 1), "angle": -angle, "centre": (1.0, 0.9, 0)}
    body = block((0.8, 0.6, 0), (0.8 + width, 0.6 + height, 0))
    plane = floor((0.3, 0.4, 0), (1.7, 0.6, 0))
    for each in (body, plane):
        each["shape"]["rotate"] = rotate
    contact = [{"between": ["block", "floor"]} | ROUGH]
    counts = (round(2.1 / cell), round(2.1 / cell), 1)
    sim, start, now = run(plane, body, end=0.3, counts=counts, cell=cell, motion=[HELD], contact=contact, gravity=(0, -G, 0))
    assert -turned(start, now)[2] == pytest.approx(tipped(width, height, angle, sim.time), rel=0.02)
    assert np.abs(now[1] - start[1]).max() < 2e-4


@pytest.mark.parametrize(("depth", "end"), [(4, 0.3), *(pytest.param(1, end, marks=pytest.mark.slow) for end in (0.6, 2.0))])
def test_a_broader_block_stays(depth, end):
    """On a slope of 30 degrees, beyond which a block of this shape tips at 33.7."""
    z = (0.1, 0.3) if depth > 1 else (0, 0)
    body, plane = block((0.8, 0.2, z[0]), (1.0, 0.5, z[1])), floor((0.1, 0.1, 0), (1.9, 0.2, 0.1 * depth))
    contact = [{"between": ["block", "floor"]} | ROUGH]
    sim, start, now = run(plane, body, end=end, counts=(20, 8, depth), motion=[HELD], contact=contact, gravity=slope(30))
    assert np.abs(now - start).max() < 3e-4
    assert sim.kinetic_energy() < 1e-9 * sim.budget.at_stake


def fallen(start, pivot, end):
    """Rotation vector of a cube with corners at a place, which falls about a fixed point."""
    arm = start.mean(axis=0) - pivot
    side = np.ptp(np.linalg.norm(start - start[0], axis=1)) / np.sqrt(3.0)
    inertia = (side**2 / 6.0 + arm @ arm) * np.eye(3) - np.outer(arm, arm)  # of a unit of mass

    def rates(_, state):
        turn, spin = Rotation.from_quat(state[:4]), state[4:]
        matrix = turn.as_matrix()
        now = matrix @ inertia @ matrix.T
        torque = np.cross(matrix @ arm, (0.0, -G, 0.0))
        quaternion = 0.5 * np.append(state[3] * spin + np.cross(spin, state[:3]), -spin @ state[:3])
        return [*quaternion, *np.linalg.solve(now, torque - np.cross(spin, now @ spin))]

    found = solve_ivp(rates, (0.0, end), [0, 0, 0, 1, 0, 0, 0], rtol=1e-9, atol=1e-11).y[:, -1]
    return Rotation.from_quat(found[:4]).as_rotvec()


@pytest.mark.parametrize("stands_on", ["edge", "corner"])
@pytest.mark.parametrize("on", ["wall", pytest.param("floor", marks=pytest.mark.slow)])
def test_a_cube_falls_over_its_edge_or_corner_as_a_rigid_body(stands_on, on):
    """Tilted by 5 degrees out of balance, in space."""
    about = {"edge": [((0, 0, 1), 50.0)], "corner": [((0, 0, 1), 45.0), ((1, 0, 0), 35.26439), ((1, 0, 0.5), 5.0)]}[stands_on]
    rotate = [{"axis": axis, "angle": angle} for axis, angle in about]
    cube = block((0.4, 0.4, 0.4), (0.8, 0.8, 0.8))
    cube["shape"]["rotate"] = rotate
    lowest = case(cube, counts=(12, 12, 12), cell=0.1).body[0].shape.geometry().bounds()[0][1]
    cube["shape"]["box"] = {"lower": (0.4, 0.6 - lowest, 0.4), "upper": (0.8, 1.0 - lowest, 0.8)}
    if on == "wall":
        bodies, more = (cube,), {"wall": [FLOOR | STICK]}
    else:
        plane = floor((0, 0.1, 0), (1.2, 0.2, 1.2))
        bodies, more = (plane, cube), {"motion": [HELD], "contact": [{"between": ["block", "floor"]} | STICK]}
    sim, start, now = run(*bodies, end=0.25, counts=(12, 12, 12), gravity=(0, -G, 0), **more)
    on_floor = np.flatnonzero(start[:, 1] < start[:, 1].min() + 1e-6)
    exact = fallen(start, start[on_floor].mean(axis=0), sim.time)
    assert turned(start, now) == pytest.approx(exact, abs=0.01 * np.linalg.norm(exact))
    # the corner alone sinks by 0.4 mm, 4e-3 of a cell
    assert np.abs(now[on_floor] - start[on_floor]).max() < 5e-4


def test_a_plank_tips_over_the_edge_of_a_table():
    """The table bears at its own edge, where the plank has none."""
    table, plank = floor((0.1, 0.1, 0), (1.0, 0.4, 0)), block((0.7, 0.4, 0), (1.5, 0.5, 0))
    contact = [{"between": ["block", "floor"]} | STICK]
    sim, start, now = run(table, plank, end=0.2, counts=(20, 10, 1), motion=[HELD], contact=contact, gravity=(0, -G, 0))
    inertia = (0.8**2 + 0.1**2) / 12.0 + 0.1**2 + 0.05**2
    exact = solve_ivp(
        lambda _, y: [y[1], G * (0.1 * np.cos(y[0]) + 0.05 * np.sin(y[0])) / inertia], (0.0, sim.time), [0.0, 0.0], rtol=1e-9
    ).y[0, -1]
    assert -turned(start, now)[2] == pytest.approx(exact, rel=0.015)


@pytest.mark.slow
def test_one_rigid_body_tips_on_another():
    """Which lies on a rough wall: momentum goes through both."""
    slab, tall = block((0.5, 0.2, 0), (1.5, 0.4, 0), name="slab"), block((0.9, 0.4, 0), (1.1, 1.2, 0))
    contact = [{"between": ["block", "slab"]} | ROUGH]
    sim, start, now = run(
        slab, tall, end=0.3, counts=(20, 15, 1), wall=[FLOOR | STICK | {"bodies": ["slab"]}], contact=contact, gravity=slope(30)
    )
    assert -turned(start, now)[2] == pytest.approx(tipped(0.2, 0.8, 30, sim.time), rel=0.02)
    assert sim.bodies[0].arrays["angle"][0, 2] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_a_block_that_falls_back_on_its_side_comes_to_rest():
    """From 20 degrees: it does not rock on."""
    body, plane = block((0.8, 0.2, 0), (1.2, 0.6, 0)), floor((0.1, 0.1, 0), (1.9, 0.2, 0))
    body["shape"]["rotate"] = {"axis": (0, 0, 1), "angle": 20.0, "centre": (0.8, 0.2, 0)}
    contact = [{"between": ["block", "floor"], "kind": "coulomb", "friction": 0.5}]
    sim, _, now = run(plane, body, end=0.6, counts=(20, 10, 1), motion=[HELD], contact=contact, gravity=(0, -G, 0))
    assert np.sort(now[:, 1])[:2] == pytest.approx([0.2, 0.2], abs=1e-4)
    assert sim.kinetic_energy() < 1e-9 * sim.budget.at_stake


def test_a_plate_without_end_bears_edges_too():
    """Along a periodic axis, over whose seam the plate goes on."""
    body, plane = block((0.8, 0.2, 0.1), (1.0, 1.0, 0.3)), floor((0, 0, 0), (2.0, 0.2, 0.4))
    contact = [{"between": ["block", "floor"]} | STICK]
    sim, _, _ = run(plane, body, end=0.3, counts=(20, 13, 4), periodic=["z"], motion=[HELD], contact=contact, gravity=slope(30))
    assert -sim.bodies[1].arrays["angle"][0, 2] == pytest.approx(tipped(0.2, 0.8, 30, sim.time), rel=0.01)


def test_a_run_in_contact_goes_on_bit_for_bit():
    def tilted():
        body, plane = block((0.8, 0.2, 0), (1.2, 0.6, 0)), floor((0.1, 0.1, 0), (1.9, 0.2, 0))
        body["shape"]["rotate"] = {"axis": (0, 0, 1), "angle": 2.0, "centre": (0.8, 0.2, 0)}
        more = {"counts": (20, 10, 1), "cell": 0.1, "functions": "gimp", "thickness": 1.0, "gravity": (0, -G, 0)}
        contact = [{"between": ["block", "floor"], "kind": "coulomb", "friction": 0.5}]
        return Simulation(case(plane, body, motion=[HELD], contact=contact, end=1.0, **more), threads=1)

    whole = tilted()
    for _ in range(150):
        whole.step()
    kept = {name: array.copy() for name, array in whole.state_arrays().items()}
    numbers, other = json.loads(json.dumps(whole.state_numbers())), tilted()
    other.restore(kept, numbers)
    for _ in range(50):
        whole.step()
        other.step()
    again = other.state_arrays()
    for name, array in whole.state_arrays().items():
        assert np.array_equal(array, again[name]), name


def test_forces_push_alone_and_friction_limits_what_holds():
    """Of two corners beneath a tall block that is pushed along: one pulls, so that the other bears alone, and slips or not."""
    arms = np.array([[-0.1, -0.4], [0.1, -0.4]])
    rows = np.array([(nx, ny, 4.0 * (x * ny - y * nx)) for nx, ny in ((0, 1), (1, 0)) for x, y in arms], float)
    speed = np.array([0.1, 0.1, -1.0, -1.0])
    for friction in (2.0, 0.05):
        # the components along the surface come in pairs: the second one of each point, across the plane, changes nothing
        six = np.vstack([rows, np.zeros((2, 3))])
        dampers = Dampers(np.full(6, 1e6), six, np.append(speed, [0.0, 0.0]), np.zeros(6), 1e-3)
        force = dampers.solve(friction, 2)
        after = np.append(speed, [0.0, 0.0]) - 1e-3 * six @ (six.T @ force)
        assert (force[:2] >= 0.0).all()
        assert (np.abs(force[2:4]) <= friction * force[:2] * (1.0 + 1e-9)).all()
        for n in range(2):
            assert force[n] == 0.0 or after[n] == pytest.approx(0.0, abs=2e-3)
            assert force[n] > 0.0 or after[n] < 1e-12


def test_a_probe_follows_a_corner_of_a_rigid_body():
    """By the motion of the body, and not as the point nearest to it."""
    start = np.array([(0.0, 0.0, 0.5), (1.0, 0.0, 0.5), (1.0, 2.0, 0.5), (0.0, 2.0, 0.5)])
    turn = Rotation.from_rotvec((0.0, 0.0, -0.3)).as_matrix()
    now = start @ turn.T + (0.1, 0.2, 0.0)
    assert carried_by(start, now, np.array([1.2, -0.1, 0.0])) == pytest.approx(
        turn @ (1.2, -0.1, 0.0) + (0.1, 0.2, 0.0), abs=1e-12
    )
