"""Bodies of different velocity fields that meet."""

import numpy as np
import pytest
from membranes import sheet
from scenes import SOLID, advance, box, case, simulation

from pellucid.encounter import build_layers, refuse_overlaps
from pellucid.errors import CaseError
from pellucid.grid.velocity_transfer import Flip

STIFF = SOLID | {"young_modulus": 1e6}
G, CELL = 10.0, 0.1


def collision(kind="coulomb", scheme="musl", functions="trilinear", threads=1):
    """Two blocks that meet askew."""
    one = box((2, 2, 1), (4, 4, 3), name="one", field="a", velocity=(0.05, 0, 0.4))
    two = box((2.5, 1.5, 3.1), (4.5, 3.5, 5.1), name="two", velocity=(-0.1, 0.1, -0.4))
    touch = {"name": "touch", "between": ["one", "two"], "kind": kind} | ({"friction": 0.3} if kind == "coulomb" else {})
    grid = {"counts": (7, 7, 7), "functions": functions}
    return simulation(one, two, **grid, scheme=scheme, contact=[touch], end=100.0, step=0.02, threads=threads)


@pytest.mark.parametrize(
    ("kind", "scheme", "functions"),
    [
        ("coulomb", "musl", "trilinear"),
        ("frictionless", "usl", "trilinear"),
        ("stick", "usf", "trilinear"),
        ("coulomb", "musl", "quadratic-bspline"),
    ],
)
def test_momentum_goes_over_and_contact_takes_energy(kind, scheme, functions):
    scene = collision(kind, scheme, functions)
    start, before = scene.ledger.kinetic, scene.bodies[0].momentum()
    works = []
    for _ in range(60):
        scene.step()
        works.append(scene.contact.work)
    assert scene.conservation()["momentum"] < 1e-12
    impulse = scene.reactions()["touch"]
    assert scene.bodies[0].momentum() - before == pytest.approx(impulse, abs=1e-12 * np.abs(impulse).max())
    assert impulse[2] < -0.5 * np.abs(before[2])
    # a step in which forces turn what was parting can give back half of what they did in it: some 1e-4 of the energy
    assert max(works) < 1e-3 * start
    assert np.cumsum(works).max() <= 0.0
    assert -0.5 * start < sum(works) < -0.05 * start


def test_the_same_bits_on_two_threads_and_after_a_restart():
    one, two, late = collision(), collision(threads=2), collision()
    for scene in (one, two):
        advance(scene, 20)
    late.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for scene in (one, two, late):
        advance(scene, 10)
    assert one.reactions()["touch"][2] < 0.0
    for other in (two, late):
        assert other.reactions()["touch"].tobytes() == one.reactions()["touch"].tobytes()
        for name, array in one.state_arrays().items():
            assert other.state_arrays()[name].tobytes() == array.tobytes(), name


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5, 0.7])
def test_a_block_on_an_incline_slides_and_rests_as_coulomb_says(friction):
    """Tilted by 30°, whose tangent is 0.577. Quadratic B-splines; with trilinear functions cell crossings shake the block."""
    down, into = G * 0.5, G * np.sqrt(0.75)
    slab = box((0, 0, 0), (24 * CELL, CELL, 2 * CELL), STIFF, (2, 1, 2), name="slab", field="ground")
    block = box((3 * CELL, 0, 2 * CELL), (8 * CELL, CELL, 5 * CELL), STIFF, (2, 1, 2))
    rub = {"name": "rub", "between": ["block", "slab"], "kind": "coulomb", "friction": friction}
    scene = simulation(
        slab,
        block,
        counts=(24, 1, 8),
        cell=CELL,
        functions="quadratic-bspline",
        gravity=(down, 0, -into),
        contact=[rub],
        motion=[{"name": "fix", "body": "slab", "hold": ["x", "y", "z"]}],
        energy={"warn": 1e3, "stop": 1e4},  # of a block that rests, there is no energy to compare with
        end=1.0,
    )
    body = scene.bodies[1]
    mass, times, speeds = body.points.mass.sum(), [], []
    while scene.time < 0.25:
        scene.step()
        times.append(scene.time)
        speeds.append(body.momentum()[0] / mass)
    settled = np.array(times) > 0.05
    acceleration = np.polyfit(np.array(times)[settled], np.array(speeds)[settled], 1)[0]
    expected = down - friction * into
    if expected > 0.0:
        assert acceleration == pytest.approx(expected, rel=0.02)
        pull, _, push = scene.reactions()["rub"]
        # of the whole run: until slip begins the block holds with less
        assert -pull / push == pytest.approx(friction, rel=0.02, abs=1e-3)
    else:
        assert abs(acceleration) < 0.02 * down
        assert np.abs(speeds[-1]) < 0.01 * down * scene.time
    assert scene.conservation()["momentum"] < 1e-12
    weight = scene.bodies[0].points.mass.sum() * scene.time * scene.ledger.gravity
    carried = scene.reactions()["rub"] - weight
    assert scene.reactions()["fix"] == pytest.approx(carried, rel=1e-9), "the motion carries the slab and the block"


def test_three_fields_that_meet_in_one_place():
    """Two blocks that glide down on a floor towards each other: at the nodes between them all three meet."""
    floor = box((1, 1, 1), (7, 3, 2), name="floor", field="a")
    left = box((1.5, 1, 2), (3.5, 3, 4), name="left", field="b", velocity=(0.4, 0, -0.2))
    right = box((4.1, 1, 2), (6.1, 3, 4), name="right", velocity=(-0.4, 0, -0.2))
    pairs = [("floor", "left"), ("floor", "right"), ("left", "right")]
    contact = [{"name": "-".join(pair), "between": pair, "kind": "coulomb", "friction": 0.3} for pair in pairs]
    # impact of soft blocks on a coarse grid costs energy, which is not what is looked at
    scene = simulation(
        floor, left, right, counts=(8, 4, 6), contact=contact, step=0.01, end=10.0, energy={"warn": 1e3, "stop": 1e4}
    )
    advance(scene, 100)
    assert scene.conservation()["momentum"] < 1e-12
    low, one, two = (body.points.position for body in scene.bodies)
    # beyond half the distance of points, by no more than the distance at which surfaces touch
    assert two[:, 0].min() - one[:, 0].max() - 0.5 > -0.1
    assert min(one[:, 2].min(), two[:, 2].min()) - low[:, 2].max() - 0.5 > -0.1
    push = scene.reactions()
    assert push["left-right"][0] < -100.0
    assert max(push["floor-left"][2], push["floor-right"][2]) < -100.0
    gains = push["left-right"] - push["floor-left"], -push["left-right"] - push["floor-right"]
    for body, way, gain in zip(scene.bodies[1:], (1.0, -1.0), gains, strict=True):
        start = body.points.mass.sum() * np.array((0.4 * way, 0.0, -0.2))
        assert body.momentum() - start == pytest.approx(gain, abs=1e-11 * np.abs(start).max())


def sheet_and_block(speed, **more):
    """A sheet of elements beneath a block that flies at it with `speed` [m/s]."""
    still = sheet(edges=((3, 0, 0), (0, 3, 0)), points=(10, 10), kind="membrane-elements", field="own")
    still["surface"]["rectangle"]["corner"] = (3.5, 3.5, 5.0)
    still["material"]["young_modulus"] = 1e4
    block = box((4, 4, 5.1), (6, 6, 7.1), velocity=(0.2, 0, -speed))
    touch = {"name": "touch", "between": ["sheet", "block"], "kind": "coulomb", "friction": 0.3}
    quiet = {"warn": 1e3, "stop": 1e4}  # impact on a coarse grid costs energy, which is not what is looked at
    return simulation(still, block, counts=(10, 10, 10), contact=[touch], step=0.01, end=10.0, energy=quiet, **more)


RIM = {"box": {"lower": [3.0, 3.0, 4.5], "upper": [4.0, 7.0, 5.5]}}  # holds two rows of the sheet's nodes


@pytest.mark.parametrize("gravity", [0.0, 0.5])
@pytest.mark.parametrize(
    ("part", "displacement"),
    [(None, None), (RIM, None), (None, {"kind": "steady", "velocity": 0.5}), (RIM, {"kind": "steady", "velocity": 0.5})],
)
def test_contact_with_nodes_of_elements_that_are_held_or_driven(part, displacement, gravity):
    motion = {"name": "hand", "body": "sheet"} | ({"part": part} if part else {})
    motion |= {"hold": ["x", "y"], "displacement": {"z": displacement}} if displacement else {"hold": ["x", "y", "z"]}
    scene = sheet_and_block(1.0, motion=[motion], gravity=(0, 0, -gravity))
    start = [body.momentum() for body in scene.bodies]
    advance(scene, 60)
    assert scene.conservation()["momentum"] < 1e-12
    gain = [body.momentum() - before for body, before in zip(scene.bodies, start, strict=True)]
    weight = [body.points.mass.sum() * scene.time * scene.ledger.gravity for body in scene.bodies]
    push, scale = scene.reactions(), np.abs(start[1]).max()
    assert push["touch"][2] < -0.1 * scale or part
    assert push["touch"][2] < 0.0
    assert gain[1] == pytest.approx(weight[1] - push["touch"], abs=1e-11 * scale)
    assert gain[0] == pytest.approx(weight[0] + push["touch"] + push["hand"], abs=1e-11 * scale)


def test_elements_that_a_support_holds_carry_what_falls_on_them():
    scene = sheet_and_block(1.0, support=[{"name": "rim", "where": RIM, "fix": ["x", "y", "z"]}], gravity=(0, 0, -0.5))
    start = [body.momentum() for body in scene.bodies]
    advance(scene, 60)
    assert scene.conservation()["momentum"] < 1e-12
    gain = scene.bodies[0].momentum() + scene.bodies[1].momentum() - sum(start)
    weight = sum(body.points.mass.sum() for body in scene.bodies) * scene.time * scene.ledger.gravity
    push = scene.reactions()
    assert push["touch"][2] < 0.0
    assert gain == pytest.approx(weight + push["rim"], abs=1e-11 * np.abs(start[1]).max())


@pytest.mark.parametrize("kind", ["neo-hookean", "linear-elastic"])
def test_a_ball_falls_on_a_clamped_membrane_and_is_thrown_back(kind):
    """From rest, until it has been thrown back: it does not sink in, and little energy goes astray."""
    thickness, radius, G = 0.1, 1.0, 1.0
    still = sheet(edges=((4, 0, 0), (0, 4, 0)), points=(9, 9), kind="membrane-elements", field="own", thickness=thickness)
    still["surface"]["rectangle"]["corner"] = (2.0, 2.0, 4.0)
    still["material"]["young_modulus"] = 2e6
    sphere = {"sphere": {"centre": [4, 4, 4 + 0.5 * thickness + radius], "radius": radius}}
    material = SOLID | {"kind": kind, "young_modulus": 1e5}
    ball = box((0, 0, 0), (1, 1, 1), material, per_cell=(3, 3, 3), name="ball") | {"shape": sphere}
    rows = {
        "a": ((1.9, 1.9), (2.1, 6.1)),
        "b": ((5.9, 1.9), (6.1, 6.1)),
        "c": ((2.4, 1.9), (5.6, 2.1)),
        "d": ((2.4, 5.9), (5.6, 6.1)),
    }
    motion = [
        {"name": name, "body": "sheet", "hold": ["x", "y", "z"], "part": {"box": {"lower": [*low, 3.9], "upper": [*high, 4.1]}}}
        for name, (low, high) in rows.items()
    ]
    touch = {"name": "touch", "between": ["sheet", "ball"]}
    scene = simulation(still, ball, counts=(8, 8, 8), contact=[touch], motion=motion, gravity=(0, 0, -G), end=10.0)
    mass, least, deepest = scene.bodies[1].points.mass.sum(), np.inf, np.inf
    while scene.time < 1.2:
        scene.step()
        skin, points = (body.points.position for body in scene.bodies)
        over = points[:, None, :2] - skin[None, :, :2]
        nearest = np.argmin(np.sum(over * over, axis=2), axis=1)
        least = min(least, (points[:, 2] - skin[nearest, 2]).min())
        deepest = min(deepest, scene.bodies[1].momentum()[2] / mass)
    velocity, push = scene.bodies[1].momentum()[2], scene.reactions()["touch"][2]
    assert deepest < -0.4 < 0.2 < velocity / mass, "it fell, and goes up again"
    assert velocity == pytest.approx(-push - mass * G * scene.time, rel=1e-9)
    # points lie half their distance within the ball, and the membrane, which has half its thickness, is looked at in its nodes
    assert least > 0.5 / 3 - 0.05
    assert scene.conservation()["momentum"] < 1e-12
    # 1.8 % on this grid, of which trilinear functions lose most where points of the ball cross cells
    assert abs(scene.conservation()["energy"]) < 0.025


def gap_at_first_push(first, half, tilt, shift, side, functions):
    """Distance of the surfaces [cells] when contact first acts between a sheet or slab and a block or ball that flies at it."""
    n, across = np.array([np.sin(tilt), 0, np.cos(tilt)]), np.array([np.cos(tilt), 0, -np.sin(tilt)])
    centre = 5.0 + shift * n
    if first == "material-points":
        extent = np.array([1.5, 1.5, half])
        still = box((centre - extent).tolist(), (centre + extent).tolist(), name="sheet", field="own")
    else:
        still = sheet(edges=((3 * across).tolist(), (0, 3, 0)), points=(10, 10), kind=first, field="own")
        still["surface"]["rectangle"]["corner"] = (centre - 1.5 * across - (0, 1.5, 0)).tolist()
        still["material"]["young_modulus"] = 1e4
    away = centre + side * (half + 2.6) * n
    if tilt:
        flying = box((0, 0, 0), (1, 1, 1), per_cell=(3, 3, 3)) | {"shape": {"sphere": {"centre": away.tolist(), "radius": 1.0}}}
    else:
        flying = box((away - 1.0).tolist(), (away + 1.0).tolist())
    flying["velocity"] = (-side * n).tolist()
    touch = {"name": "touch", "between": ["sheet", "block"]}
    scene = simulation(still, flying, counts=(10, 10, 10), functions=functions, contact=[touch], step=0.02, end=10.0)
    while not scene.reactions().get("touch", np.zeros(3)).any():
        scene.step()
        assert scene.time < 3.0, "it passed through"
    body, other = scene.bodies[1].points, scene.bodies[0].points
    width = 0.25 if first == "material-points" else half
    return (side * body.position @ n).min() - 0.5 * np.cbrt(body.volume.max()) - (side * other.position @ n).max() - width


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("shift", [0.13, 0.5])
@pytest.mark.parametrize(
    ("first", "half", "tilt", "functions"),
    [
        ("membrane-elements", 0.005, 0.0, "quadratic-bspline"),
        ("membrane-elements", 0.005, 0.3, "trilinear"),
        ("membrane-points", 0.005, 0.7, "trilinear"),
        ("material-points", 0.5, 0.0, "quadratic-bspline"),
    ],
)
def test_contact_begins_within_a_quarter_of_a_cell(first, half, tilt, functions, shift, side):
    assert abs(gap_at_first_push(first, half, tilt, shift, side, functions)) < 0.25


def test_bodies_that_overlap_at_the_start_are_refused():
    whole = case(box((0, 0, 0), (2, 2, 2), name="one", field="a"), box((1, 1, 1), (3, 3, 3), name="two"))
    with pytest.raises(CaseError) as error:
        refuse_overlaps(whole, build_layers(whole, Flip()))
    text = str(error.value)
    for words in ("body.one.shape", "inside body two", "which way out"):
        assert words in text
