"""Bodies of different velocity fields that meet."""

import json
import warnings

import numpy as np
import pytest
from membranes import sheet
from pressed_oocytes import FORCES, RADIUS, THICKNESS, WAYS, force_on_plate, pressed_oocyte
from small_cases import SOLID, advance, box, case, simulation

import pellucid
from pellucid.case import Case
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.contact.touch import OverlappingStart
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

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
    sim = collision(kind, scheme, functions)
    start, before = sim.budget.kinetic, sim.bodies[0].totals.momentum
    taken = [0.0]
    while sim.time < 3.0:
        sim.step()
        taken.append(sim.budget.sums["contact_work"])
    assert sim.budget.conservation()["momentum"] < 1e-12
    impulse = sim.budget.reactions()["touch"]
    assert sim.bodies[0].totals.momentum - before == pytest.approx(impulse, abs=1e-12 * np.abs(impulse).max())
    assert impulse[2] < -0.5 * np.abs(before[2])
    # what the overlap stored comes back, less what dampers and friction took
    assert max(taken) <= 0.0
    assert min(taken) < -0.1 * start
    assert min(taken) < taken[-1] < -0.005 * start
    # edges that press into faces, of blocks of two cells; with USL light nodes strain points, and surfaces with them
    assert sim.parts.only(SurfacePairs).energy.unexplained < (0.1 if scheme == "usl" else 0.04) * start


@pytest.mark.parametrize(("cell", "most"), [(1.0, 0.03), (0.5, 0.01)])
def test_faces_that_meet_flush_give_back_what_they_stored(cell, most):
    """Less what dampers took; on half the cells of a block of two cells they miss a third of it."""
    one = box((2, 2, 1), (4, 4, 3), name="one", field="a", velocity=(0, 0, 0.4))
    two = box((2, 2, 3.1), (4, 4, 5.1), name="two", field="b", velocity=(0, 0, -0.4))
    counts = (round(7 / cell),) * 3
    sim = simulation(one, two, counts=counts, cell=cell, end=100.0, step=0.02 * cell, energy={"warn": 0.1, "stop": 1.0})
    start = sim.kinetic_energy()
    while sim.time < 3.2:
        sim.step()
    assert sim.bodies[1].totals.momentum[2] > 0.4 * 0.4 * sim.bodies[1].mass, "they part"
    assert abs(sim.parts.only(SurfacePairs).energy.held) < 1e-3 * start
    assert sim.budget.energies()["contact_work"] < -0.05 * start
    assert abs(sim.parts.only(SurfacePairs).energy.unexplained) < most * start


def test_the_same_bits_on_two_threads_and_after_a_restart():
    one, two, late = collision(), collision(threads=2), collision()
    for sim in (one, two):
        advance(sim, 20)
    late.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for sim in (one, two, late):
        advance(sim, 10)
    assert one.budget.reactions()["touch"][2] < 0.0
    for other in (two, late):
        assert other.budget.reactions()["touch"].tobytes() == one.budget.reactions()["touch"].tobytes()
        for name, array in one.state_arrays().items():
            assert other.state_arrays()[name].tobytes() == array.tobytes(), name


def test_the_force_of_a_contact_in_a_history_adds_up_to_the_change_of_momentum(tmp_path):
    one = box((2, 2, 1), (4, 4, 3), name="one", field="a", velocity=(0.05, 0, 0.4))
    two = box((2.5, 1.5, 3.1), (4.5, 3.5, 5.1), name="two", velocity=(-0.1, 0.1, -0.4))
    touch = {"name": "touch", "between": ["one", "two"], "kind": "coulomb", "friction": 0.3}
    axes = {axis: {"component": axis} for axis in "xyz"}
    probe = [{"name": f"force_{axis}", "quantity": "reaction", "condition": "touch"} | more for axis, more in axes.items()]
    probe += [
        {"name": f"v_{axis}", "body": "one", "quantity": "velocity", "reduce": "mean"} | more for axis, more in axes.items()
    ]
    whole = case(one, two, counts=(7, 7, 7), end=1.0, step=0.02, contact=[touch], probe=probe, output={"history": 0.05})
    run = pellucid.run(whole, out=tmp_path / "run", report=False)
    seen, mass = run.history, 8.0 * SOLID["density"]
    assert len(seen["time"]) > 10
    assert np.abs(seen["force_z"]).max() > 1000.0
    for axis in "xyz":  # a row holds the mean force since the row before; all points have the same mass
        impulse = np.sum(seen[f"force_{axis}"][1:] * np.diff(seen["time"]))
        assert mass * (seen[f"v_{axis}"][-1] - seen[f"v_{axis}"][0]) == pytest.approx(impulse, abs=1e-9 * mass)


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5, 0.7])
def test_a_block_on_an_incline_slides_and_rests_as_coulomb_says(friction):
    """Tilted by 30°, whose tangent is 0.577. Gravity grows over 0.1 s: all at once it would shake the block, which then sticks
    and slips in turns. Quadratic B-splines; with trilinear functions cell crossings shake it."""
    down, into = G * 0.5, G * np.sqrt(0.75)
    slab = box((0, 0, 0), (24 * CELL, 2 * CELL, CELL), STIFF, (2, 2, 1), name="slab", field="ground")
    block = box((3 * CELL, 2 * CELL, 0), (8 * CELL, 5 * CELL, CELL), STIFF, (2, 2, 1))
    rub = {"name": "rub", "between": ["block", "slab"], "kind": "coulomb", "friction": friction}
    sim = simulation(
        slab,
        block,
        counts=(24, 8, 1),
        cell=CELL,
        functions="quadratic-bspline",
        gravity=(down, -into, 0),
        gravity_amplitude={"times": [0.0, 0.1], "shares": [0.0, 1.0]},
        contact=[rub],
        motion=[{"name": "fix", "body": "slab", "hold": ["x", "y", "z"]}],
        energy={"warn": 1e3, "stop": 1e4},  # of a block that rests, there is no energy to compare with
        end=1.0,
    )
    body = sim.bodies[1]
    mass, times, speeds, pulled = body.mass, [], [], 0.0
    while sim.time < 0.3:
        began = sim.time
        sim.step()
        pulled += (sim.time - began) * min(began / 0.1, 1.0)
        times.append(sim.time)
        speeds.append(body.totals.momentum[0] / mass)
    settled = np.array(times) > 0.1
    acceleration = np.polyfit(np.array(times)[settled], np.array(speeds)[settled], 1)[0]
    expected = down - friction * into
    if expected > 0.0:
        assert acceleration == pytest.approx(expected, rel=0.02)
        pull, push, _ = sim.budget.reactions()["rub"]
        # of the whole run: until slip begins the block holds with less
        assert -pull / push == pytest.approx(friction, rel=0.02, abs=1e-3)
    else:
        assert abs(acceleration) < 0.02 * down
        assert np.abs(speeds[-1]) < 0.01 * down * sim.time
    assert sim.budget.conservation()["momentum"] < 1e-12
    weight = sim.bodies[0].mass * pulled * sim.budget.gravity
    carried = sim.budget.reactions()["rub"] - weight
    assert sim.budget.reactions()["fix"] == pytest.approx(carried, rel=1e-9), "the motion carries the slab and the block"


def test_three_fields_that_meet_in_one_place():
    """Two blocks that glide down on a floor towards each other: at the nodes between them all three meet."""
    floor = box((1, 1, 1), (7, 3, 2), name="floor", field="a")
    left = box((1.5, 1, 2), (3.5, 3, 4), name="left", field="b", velocity=(0.4, 0, -0.2))
    right = box((4.1, 1, 2), (6.1, 3, 4), name="right", velocity=(-0.4, 0, -0.2))
    pairs = [("floor", "left"), ("floor", "right"), ("left", "right")]
    contact = [{"name": "-".join(pair), "between": pair, "kind": "coulomb", "friction": 0.3} for pair in pairs]
    # impact of soft blocks on a coarse grid costs energy, which is not what is looked at
    sim = simulation(
        floor, left, right, counts=(8, 4, 6), contact=contact, step=0.01, end=10.0, energy={"warn": 1e3, "stop": 1e4}
    )
    advance(sim, 100)
    assert sim.budget.conservation()["momentum"] < 1e-12
    low, one, two = (body.points.position for body in sim.bodies)
    # contact gives way as a layer of cells of both: by v/c cells at the pressure ρ c v/2 of bodies that meet at a speed v
    speed = np.sqrt(1.346 * SOLID["young_modulus"] / SOLID["density"])
    assert two[:, 0].min() - one[:, 0].max() - 0.5 > -0.8 / speed
    # the floor twice as deep where the blocks tip on their edges as they meet
    assert min(one[:, 2].min(), two[:, 2].min()) - low[:, 2].max() - 0.5 > -2.0 * 0.2 / speed
    push = sim.budget.reactions()
    assert push["left-right"][0] < -100.0
    assert max(push["floor-left"][2], push["floor-right"][2]) < -100.0
    gains = push["left-right"] - push["floor-left"], -push["left-right"] - push["floor-right"]
    for body, way, gain in zip(sim.bodies[1:], (1.0, -1.0), gains, strict=True):
        start = body.mass * np.array((0.4 * way, 0.0, -0.2))
        assert body.totals.momentum - start == pytest.approx(gain, abs=1e-11 * np.abs(start).max())


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
    sim = simulation(still, flying, counts=(10, 10, 10), functions=functions, contact=[touch], step=0.02, end=10.0)
    while not sim.budget.reactions().get("touch", np.zeros(3)).any():
        sim.step()
        assert sim.time < 3.0, "it passed through"
    body, surface = sim.bodies[1].points, sim.bodies[0].arrays["position"]
    width = 0.25 if first == "material-points" else half
    return (side * body.position @ n - 0.5 * np.cbrt(body.volume)).min() - (side * surface @ n).max() - width


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
    gap = gap_at_first_push(first, half, tilt, shift, side, functions)
    assert -0.25 < gap < 0.0  # a step of 0.02 cells after the surfaces met at the latest: a volume is not met early


SPEED = 0.02
LOUD = {"warn": 1e3, "stop": 1e4}


def built(table):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        return Simulation(Case.model_validate(table), threads=1), [str(warning.message) for warning in caught]


@pytest.mark.parametrize(
    ("plate", "offset", "clear"),
    [
        ("wall", None, 0.5e-6),  # half of the thickness
        ("wall", 0.0, 0.5e-6),
        ("wall", None, -3.7e-6),  # the plate starts within the contact distance: contact acts 3.7 um later
        pytest.param("sheet", None, 0.5e-6, marks=pytest.mark.slow),
        ("sheet", None, -3.7e-6),
    ],
)
def test_the_force_on_a_pressed_sphere_is_exact(plate, offset, clear):
    """Within 5 % at five displacements since the faces touched, or since the start.

    The mesh is coarse: eight divisions along a quarter of a great circle.
    """
    reach = 0.5 * THICKNESS if offset is None else offset
    given = {} if offset is None else {"contact_offset": offset}
    reach += 0.5e-6 if plate == "sheet" else 0.0  # half of its thickness
    sim, told = built(pressed_oocyte(RADIUS + reach + clear, SPEED, plate=plate, **given))
    depth = max(-clear, 0.0)
    assert [overlap.depth for overlap in sim.parts.only(SurfacePairs).start_overlaps] == pytest.approx(
        [depth] if depth else [], rel=1e-9
    )
    assert len(told) == len(sim.parts.only(SurfacePairs).start_overlaps)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the size of the elements
        way, force = force_on_plate(sim, SPEED)
    found = np.interp(WAYS + max(clear, 0.0), way, force)
    assert found == pytest.approx(FORCES, rel=0.05)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


def test_the_report_names_both_and_the_depth():
    sim, (text,) = built(pressed_oocyte(RADIUS + 0.3e-6, contact_offset="4 um"))
    assert text == (
        "body zona and wall plate start 3.7e-06 m closer to each other than the contact distance of 4e-06 m (`contact_offset` "
        "of each membrane, default: half of the thickness): this overlap exerts no force until they have separated once, so "
        "contact starts 3.7e-06 m late. To have contact act from the start, move one of the two away by 3.7e-06 m, or set a "
        "smaller `contact_offset`."
    )
    (fact,) = sim.facts()["start_overlaps"]
    assert fact == {"between": ["body zona", "wall plate"], "depth": pytest.approx(3.7e-6), "distance": pytest.approx(4e-6)}
    assert json.loads(json.dumps(fact)) == fact


def test_without_thickness_there_is_no_contact_distance():
    """Contact of a sheet with vanishing thickness acts at the mid-surface, as with `contact_offset = 0`."""
    thin = {"thickness": 1e-12, "material": {"kind": "linear-membrane", "density": 1e9, "young_modulus": 1e13}}
    thin["material"]["poisson_ratio"] = 0.3
    bodies = [sheet(field="sheet", kind="membrane-elements", **thin, **more) for more in ({}, {"contact_offset": 0.0})]
    wall = {"point": (0, 0, 0.04), "normal": (0, 0, -1), "velocity": (0, 0, -1.0)}
    forces = []
    for body in bodies:
        sim = simulation(body, counts=(8, 8, 8), cell=0.25, lower=(-1, -1, -1), wall=[wall], end=0.05, energy=LOUD)
        assert not sim.parts.only(SurfacePairs).start_overlaps
        advance(sim, 60)
        forces.append(sim.bodies[0].arrays["velocity"][:, 2])
    assert forces[0].min() < -0.1, "the wall came up to it, and pushes"
    assert forces[0] == pytest.approx(forces[1], abs=1e-6)


PLATE = box((0, 0, 2), (4, 4, 3), name="plate", field="plate")
LED = [{"name": "hold", "body": "plate", "hold": ["x", "y", "z"]}]


def meshless(top):
    mesh = {"box": {"lower": (1, 1, 0.5), "upper": (3, 3, top), "cells": (4, 4, 3)}}
    material = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
    return {"name": "tissue", "kind": "meshless-solid", "field": "tissue", "mesh": mesh, "material": material}


def membrane(top):
    table = sheet(edges=((2, 0, 0), (0, 2, 0)), field="tissue", kind="membrane-elements", thickness=0.2) | {"name": "tissue"}
    table["surface"]["rectangle"]["corner"] = (1, 1, top - 0.1)
    return table


def points(top):
    return box((1, 1, top - 1.5), (3, 3, top), SOLID, name="tissue", field="tissue")


def led_sheet():
    table = sheet(edges=((4, 0, 0), (0, 4, 0)), field="plate", kind="membrane-elements", thickness=0.1) | {"name": "plate"}
    table["surface"]["rectangle"]["corner"] = (0, 0, 2.05)
    return table


@pytest.mark.parametrize("other", ["plate", "wall", "sheet"])
@pytest.mark.parametrize("body", [meshless, membrane, points])
def test_what_overlaps_at_the_start_is_not_thrown_off(body, other):
    """Nothing moves, since nothing pushes: no gravity, no motion."""
    settings = {"counts": (4, 4, 4), "end": 100.0, "energy": LOUD}
    table = body(2.06)
    if other == "wall":
        settings["wall"] = [{"name": "lid", "point": (0, 0, 2), "normal": (0, 0, -1)}]
        bodies = (table,)
    else:
        settings["motion"], bodies = LED, (table, PLATE if other == "plate" else led_sheet())
    with pytest.warns(UserWarning, match=r"body tissue .*0\.06 m"):
        sim = simulation(*bodies, **settings)
    (overlap,) = sim.parts.only(SurfacePairs).start_overlaps
    assert overlap.depth == pytest.approx(0.06, abs=0.001)
    assert set(overlap.between) == {"body tissue", "wall lid" if other == "wall" else "body plate"}
    advance(sim, 20)
    assert np.abs(sim.bodies[0].arrays["velocity"]).max() < 1e-9
    assert sim.budget.energies()["contact_work"] == pytest.approx(0.0, abs=1e-12)


def coming(velocity, sheet=False):
    """A membrane that starts 0.06 m within the distance at which it touches a plate or sheet, and moves."""
    table, other = membrane(2.06) | {"velocity": velocity}, led_sheet() if sheet else PLATE
    with pytest.warns(UserWarning, match="body tissue"):
        return simulation(table, other, counts=(4, 4, 4), motion=LED, step=1e-3, end=100.0, energy=LOUD)


@pytest.mark.parametrize("sheet", [False, True])
def test_it_presses_once_it_has_come_apart(sheet):
    apart = coming((0, 0, -1.0), sheet)
    start = apart.bodies[0].arrays["position"][0, 2]
    advance(apart, 100)  # 0.1 m
    assert apart.parts.only(SurfacePairs)._pairs[0].start_depth() == 0.0
    apart.bodies[0].arrays["velocity"][:] = (0.0, 0.0, 1.0)
    advance(apart, 100)
    assert apart.bodies[0].arrays["position"][:, 2].max() < start - 0.05, "stopped where contact acts"


@pytest.mark.parametrize("sheet", [False, True])
def test_a_run_goes_on_bit_for_bit_with_its_start_overlap(sheet):
    whole = advance(coming((0, 0, 0.5), sheet), 10)
    kept = {name: array.copy() for name, array in whole.state_arrays().items()}
    numbers = json.loads(json.dumps(whole.state_numbers()))
    again = coming((0, 0, 0.5), sheet)
    again.restore(kept, numbers)
    for sim in (whole, again):
        advance(sim, 10)
    assert np.array_equal(whole.bodies[0].arrays["velocity"], again.bodies[0].arrays["velocity"])
    assert whole.bodies[0].arrays["velocity"][:, 2].min() < 0.5, "the plate stopped it"


def test_bodies_that_continue_an_earlier_run_press_from_the_start_on():
    settings = {"counts": (4, 4, 4), "step": 1e-3, "end": 100.0, "energy": LOUD}
    whole = case(membrane(2.06), wall=[{"name": "lid", "point": (0, 0, 2), "normal": (0, 0, -1)}], **settings)
    with pytest.warns(UserWarning, match="body tissue and wall lid"):
        first = Simulation(whole, threads=1)
    sim = Simulation(whole, threads=1, start={"tissue": first.bodies[0].state_arrays()})
    assert not sim.parts.only(SurfacePairs).start_overlaps
    advance(sim, 5)
    assert sim.bodies[0].arrays["velocity"][:, 2].max() < -1e-3


def test_a_body_that_touches_itself_is_reported_by_its_name():
    text = OverlappingStart(("body bag",), 2e-4, 1e-3).text
    assert text.startswith("parts of body bag start up to 0.0002 m closer to each other than twice the contact offset")


def test_an_offset_beyond_the_sight_of_surfaces_is_refused():
    table = membrane(2.06) | {"contact_offset": 3.0}
    with pytest.raises(CaseError, match=r"body\.tissue\.contact_offset.*\n.*the contact distance of .* is 3 m") as caught:
        simulation(table, PLATE, counts=(4, 4, 4), motion=LED, end=1.0)
    assert "Set a smaller `contact_offset`" in str(caught.value)
