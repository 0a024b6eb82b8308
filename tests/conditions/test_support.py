"""Walls of the grid that rub, stick and open, and what they do to bodies."""

import numpy as np
import pytest
from elements import element_sheet
from small_cases import RATE_SOLID, SLIP, advance, box, simulation

import pellucid
from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.running.launch import resume_case
from pellucid.simulation.simulation import Simulation

SLOPE = (4.905, -8.4957, 0.0)  # gravity where the floor is a slope of 30 degrees [m/s²]
RAMP = """
[gravity_amplitude]
times = [0, 0.2]
shares = [0, 1]
"""
ON_SLOPE = """
schema = 1
title = "A block on a slope"
gravity = [4.905, -8.4957, 0]

[grid]
lower = [0, 0, 0]
upper = [6, 1, 0]
cell = 0.05
functions = "trilinear"

[time]
end = 0.8

[[body]]
name = "block"
shape = { box = { lower = [0.5, 0, 0], upper = [1.0, 0.25, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "linear-elastic", density = 2000, young_modulus = 1e7, poisson_ratio = 0.3 }

[[support]]
name = "slope"
where = "y-lower"
fix = "normal"
friction = 0.3
"""


def wall(side="z-lower", **more):
    return {"name": "wall", "where": side, "fix": "normal"} | more


def block(**more):
    return box((1, 1, 0), (3, 3, 2), RATE_SOLID, **more)


def mean(sim, field):
    return sim.bodies[0].frame()[field].mean(axis=0)


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_a_block_slides_down_a_slope(functions, tmp_path):
    """v = g (sin 30° - μ cos 30°) t: what friction takes is μ times what presses, however the block hops on its way."""
    found = loads(ON_SLOPE.replace("trilinear", functions).replace("0.8", "0.4"), "slope.toml")
    run = pellucid.run(found, out=tmp_path, report=False, threads=1)
    velocity = run.fields("block")["velocity"][:, 0].mean()
    assert velocity == pytest.approx((4.905 - 0.3 * 8.4957) * 0.4, rel=0.005)
    history = run.history
    assert np.abs(history["energy_error"]).max() < 5e-3
    assert history["transfer_error"][-1] == pytest.approx(0.0, abs=1e-9)
    # the wall is at rest: all that it takes is heat, of some 200 J
    assert history["support_work"][-1] == 0.0
    expected = history["gravity_work"][-1] - history["kinetic_energy"][-1]
    assert history["friction_heat"][-1] == pytest.approx(expected, rel=0.03)
    assert run.summary["conservation"]["momentum"] < 1e-14


@pytest.mark.parametrize("friction", ["friction = 0.7", "stick = true"])
def test_a_block_stays_on_a_slope(friction, tmp_path):
    """Below the angle of friction it shears and goes no further: by 1.2 ρ g H²/3G in the mean, if it were long."""
    found = loads(ON_SLOPE.replace("friction = 0.3", friction) + RAMP, "slope.toml")
    run = pellucid.run(found, out=tmp_path, report=False, threads=1)
    gone = run.fields("block")["position"][:, 0] - run.fields("block", 0.0)["position"][:, 0]
    shear = 2000.0 * 4.905 * 0.25**2 / (3.0 * 1e7 / 2.6)
    assert shear == pytest.approx(5.3e-5, rel=0.01)
    assert 0.9 * shear < gone.mean() < shear + 1e-4
    assert np.abs(run.fields("block")["velocity"]).max() < 2e-3
    assert np.abs(run.history["energy_error"]).max() < 1e-5


def test_a_block_slips_where_gravity_comes_at_once(tmp_path):
    """It hops, and slips where it presses less than it weighs. It does not ride up: its lowest points stay where they were."""
    text = ON_SLOPE.replace("friction = 0.3", "friction = 0.7").replace("points_per_cell", "damping = 20\npoints_per_cell")
    run = pellucid.run(loads(text, "slope.toml"), out=tmp_path, report=False, threads=1)
    gone = run.fields("block")["position"] - run.fields("block", 0.0)["position"]
    assert 5e-3 < gone[:, 0].mean() < 0.056
    assert abs(run.fields("block")["position"][:, 1].min() - 0.0125) < 2e-4
    assert np.abs(run.history["energy_error"]).max() < 2e-3


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_runs_go_on_with_the_same_bits(scheme, tmp_path):
    """Walls keep something of the last step: usf strains with it."""
    text = ON_SLOPE.replace("trilinear", "quadratic-bspline").replace("end = 0.8", f'end = 0.06\nscheme = "{scheme}"')
    found = loads(text, "slope.toml")
    whole = pellucid.run(found, out=tmp_path / "whole", report=False, threads=1)
    pellucid.run(found, out=tmp_path / "parts", report=False, until=0.031, threads=2)
    parts = resume_case(tmp_path / "parts", report=False, threads=2)
    for field in ("position", "velocity", "stress"):
        assert (whole.fields("block")[field] == parts.fields("block")[field]).all()
    assert whole.summary["energies"] == parts.summary["energies"]


@pytest.mark.parametrize("friction", [{}, {"friction": 0.5}, {"stick": True}])
@pytest.mark.parametrize(("pull", "speed"), [(0.0, 0.5), (-0.5, 0.5), (0.25, 0.0)])
@pytest.mark.parametrize("scheme", ["musl", "usf"])
def test_what_moves_away_from_a_wall_that_opens_is_free(friction, pull, speed, scheme):
    """A block that is thrown up, or that gravity pulls up."""
    sim = simulation(
        block(velocity=(0.25, 0.0, speed)),
        support=[wall(opens=True, **friction)],
        gravity=(0.0, 0.0, pull),
        counts=(8, 4, 6),
        scheme=scheme,
        end=10.0,
    )
    while sim.time < 0.5:
        sim.step()
    assert mean(sim, "velocity") == pytest.approx([0.25, 0.0, speed + pull * sim.time], abs=1e-12)
    assert not sim.budget.reactions()["wall"].any()
    assert abs(sim.bodies[0].arrays["stress"]).max() < 1e-8


def test_a_wall_that_rubs_holds_what_moves_away_only_if_asked_to():
    for opens, speed in ((None, 0.5), (False, 0.0)):
        sim = simulation(
            block(velocity=(0.0, 0.0, 0.5)), support=[wall(friction=0.5, opens=opens)], counts=(4, 4, 6), end=10.0, courant=0.2
        )
        lowest = np.argmin(sim.bodies[0].frame()["position"][:, 2])
        start = sim.bodies[0].frame()["position"][lowest, 2]
        advance(sim, 20)
        gone = sim.bodies[0].frame()["position"][lowest, 2] - start
        assert gone == pytest.approx(speed * sim.time, abs=0.3 * 0.5 * sim.time if opens is False else 1e-12)


def test_a_wall_that_opens_never_pulls():
    """A block falls on it and jumps off again: in no step does the wall pull."""
    sim = simulation(block(velocity=(0.0, 0.0, -0.1)), support=[wall(opens=True)], counts=(4, 4, 8), end=100.0, courant=0.1)
    given = [0.0]
    for _ in range(900):
        sim.step()
        given.append(float(sim.budget.reactions()["wall"][2]))
    assert min(np.diff(given)) >= 0.0
    assert given[-1] == given[-100]
    assert 0.05 < mean(sim, "velocity")[2] < 0.1
    assert sim.budget.conservation()["momentum"] < 1e-14


@pytest.mark.parametrize("transfer", ["flip", "pic", "apic"])
@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_a_belt_takes_a_block_along(scheme, transfer):
    """Pressed on a wall that moves along itself, the block is accelerated by μ g, and then moves with it."""
    belt, friction, gravity = 0.05, 0.4, 0.1
    sim = simulation(
        block(),
        support=[wall(friction=friction, velocity=(belt, 0, 0))],
        gravity=(0.0, 0.0, -gravity),
        counts=(8, 4, 4),
        scheme=scheme,
        transfer=transfer,
        functions="quadratic-bspline",
        end=10.0,
    )
    while sim.time < 0.5 * belt / (friction * gravity):
        sim.step()
    mass = sim.bodies[0].mass
    reaction = sim.budget.reactions()["wall"]
    assert 0.94 < reaction[0] / (friction * reaction[2]) < 1.0  # some nodes move with the belt already
    assert mean(sim, "velocity")[0] == pytest.approx(reaction[0] / mass, rel=1e-9)
    assert sim.budget.energies()["support_work"] == pytest.approx(reaction[0] * belt, rel=1e-9)
    while sim.time < 4.0 * belt / (friction * gravity):
        sim.step()
    energies = sim.budget.energies()
    assert mean(sim, "velocity")[0] == pytest.approx(belt, rel=0.15)
    # sliding, half of what the belt does is heat, less what moves with the belt at once
    assert 0.4 < energies["friction_heat"] / (0.5 * mass * belt**2) < 1.0
    assert abs(energies["transfer_error"]) < 1e-12 * energies["support_work"]
    assert abs(sim.budget.energy_error()) < 0.02
    assert sim.budget.conservation()["momentum"] < 1e-13


@pytest.mark.parametrize("walls", [{"friction": 0.3}, {"stick": True}, {"opens": True}], ids=["rubs", "sticks", "opens"])
def test_fluids_beside_such_walls_keep_their_energy(walls):
    """Water falls in a basin whose walls are all alike: kinetic and internal energy, work and heat add up to rounding."""
    water = {"kind": "fluid", "density": 1000.0, "viscosity": 1.0, "eos": {"kind": "tait", "sound_speed": 30.0}}
    basin = [side | walls for side in SLIP]
    sim = simulation(
        box((0, 0, 0), (3, 3, 1), water), counts=(8, 6, 1), support=basin, gravity=(0.0, -9.81, 0.0), end=10.0, threads=2
    )
    advance(sim, 150)
    energies = sim.budget.energies()
    assert abs(sim.budget.energy_error()) < 1e-14
    assert (energies.get("friction_heat", 0.0) > 0.1 * energies["gravity_work"]) == ("opens" not in walls)
    assert sim.budget.conservation()["momentum"] < 1e-14


@pytest.mark.parametrize("walls", [{}, {"friction": 0.3}, {"stick": True}, {"opens": True}])
def test_contact_beside_such_walls(walls):
    """Two blocks meet in a corner; contact, which takes a part of their energy, and walls make the whole change of momentum
    and energy. They meet at a thirtieth of the speed of sound: at a tenth they overlap by a third of a cell, on cells of half
    a block."""
    corner = [side | walls for side in SLIP if side["where"] != "y-upper"]
    one = box((0, 0, 0), (2, 2, 1), RATE_SOLID, name="one", field="one", velocity=(-0.1, -0.06, 0))
    other = box((2, 0, 0), (4, 3, 1), RATE_SOLID, name="other", field="other", velocity=(-0.13, -0.1, 0))
    sim = simulation(one, other, counts=(8, 6, 1), support=corner, gravity=(0.0, -0.1, 0.0), end=100.0, energy={"warn": 0.1})
    start = sim.kinetic_energy()
    advance(sim, 200)
    assert sim.budget.energies()["contact_work"] < -1e-3 * start
    assert abs(sim.budget.energies()["transfer_error"]) < 1e-10
    assert sim.budget.conservation()["momentum"] < 1e-14


@pytest.mark.parametrize("more", [{"friction": 0.3}, {"fix": ("x", "y")}])
def test_a_support_of_several_faces_is_one_on_each(more):
    """The same bits as of two, whose reactions of one name add up; of bodies on the grid and with nodes of their own."""
    walls = [wall("y-lower", **more), wall("x-lower", **more)]
    ends = []
    for support in (walls, [walls[0] | {"where": ("y-lower", "x-lower")}]):
        solid, sheet = (
            box((-1, -1, 0), (1, 1, 1), RATE_SOLID, velocity=(-0.1, -0.06, 0)),
            element_sheet(velocity=(-1.0, -0.1, 0)),
        )
        sim = simulation(solid, sheet, lower=(-1, -1, -2), counts=(6, 6, 6), support=support, end=100.0)
        advance(sim, 40)
        ends.append((sim.bodies[0].frame(), sim.bodies[1].frame(), sim.budget.reactions()["wall"]))
    for one, other in zip(*ends, strict=True):
        np.testing.assert_equal(one, other)
    assert np.all(ends[0][2][:2] > 0.0)


def test_such_walls_let_go_at_their_time_and_others_stay_as_they_are():
    """A floor that sticks is gone after 0.5 s; a wall that let a block go does not hold it again by that."""
    support = [wall("z-lower", stick=True, until=0.5), wall("x-lower", opens=True, name="side")]
    sim = simulation(
        box((0, 1, 0), (2, 3, 2), RATE_SOLID, velocity=(0.2, 0.0, 0.0)),
        lower=(0, 0, 0),
        support=support,
        gravity=(0.0, 0.0, 0.1),
        counts=(6, 4, 6),
        scheme="usf",
        step=0.02,
        end=10.0,
    )
    advance(sim, 30)
    nodes = sim.grid.nodes
    index, position = sim.grid.where()
    side = index[(position[:, 0] == 0.0) & (nodes.mass[index] > 0.0)]
    assert len(side)
    assert not nodes.constrained[side].any()
    assert mean(sim, "velocity")[0] == pytest.approx(0.2, rel=1e-9)


# bodies with nodes of their own


TISSUE = """
schema = 1
title = "A block of tissue on a slope"
gravity = [4.905, 0, -8.4957]

[grid]
lower = [0, 0, 0]
upper = [3, 0.6, 0.6]
cell = 0.05

[time]
end = 0.3

[[body]]
name = "block"
kind = "meshless-solid"
mesh = { box = { lower = [0.5, 0.1, 0], upper = [1.0, 0.4, 0.25], cells = [5, 3, 3] } }
material = { kind = "neo-hookean", density = 2000, young_modulus = 1e7, poisson_ratio = 0.3 }

[[support]]
name = "slope"
where = "z-lower"
fix = "normal"
friction = 0.3
"""


def tissue(**changes):
    """A simulation of that block with other lines."""
    text = TISSUE
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    return Simulation(loads(text, "tissue.toml"), threads=1)


def until(sim, end):
    start = mean(sim, "position")
    while sim.time < end:
        sim.step()
    return mean(sim, "position") - start


def test_a_meshless_solid_slides_down_a_slope():
    sim = tissue()
    until(sim, 0.3)
    assert mean(sim, "velocity")[0] == pytest.approx((4.905 - 0.3 * 8.4957) * 0.3, rel=0.01)
    reaction, energies = sim.budget.reactions()["slope"], sim.budget.energies()
    assert -reaction[0] == pytest.approx(0.3 * reaction[2], rel=0.01)
    assert abs(energies["transfer_error"]) < 1e-12 * energies["gravity_work"]
    assert abs(sim.budget.energy_error()) < 1e-6
    assert sim.budget.conservation()["momentum"] < 1e-14


@pytest.mark.parametrize("friction", ["friction = 0.7", "stick = true"])
def test_a_meshless_solid_stays_on_a_slope(friction):
    sim = tissue(friction=("friction = 0.3\n", friction + RAMP))
    gone = until(sim, 0.3)
    assert 3e-5 < gone[0] < 1.5e-4
    assert np.abs(mean(sim, "velocity")).max() < 2e-3
    assert sim.budget.conservation()["momentum"] < 1e-14


def test_a_meshless_solid_leaves_a_wall_that_opens():
    for line, held in (("opens = true", False), ("", True)):
        sim = tissue(friction=("friction = 0.3", line), gravity=("[4.905, 0, -8.4957]", "[0, 0, 3]"))
        gone = until(sim, 0.1)
        assert (gone[2] < 1e-3) == held
        assert held or gone[2] == pytest.approx(0.5 * 3.0 * 0.1**2, rel=0.03)
        assert sim.budget.reactions()["slope"].any() == held


def test_a_belt_takes_a_damped_meshless_solid_along():
    """The drag acts on what friction gives too: momentum and energy close all the same."""
    sim = tissue(
        belt=("friction = 0.3", "friction = 0.3\nvelocity = [1, 0, 0]"),
        gravity=("[4.905, 0, -8.4957]", "[0, 0, -9.81]"),
        drag=('kind = "meshless-solid"', 'kind = "meshless-solid"\ndamping = 5'),
    )
    until(sim, 0.1)
    reaction, energies = sim.budget.reactions()["slope"], sim.budget.energies()
    assert reaction[0] == pytest.approx(0.3 * reaction[2], rel=0.01)
    assert energies["support_work"] == pytest.approx(reaction[0], rel=0.01)
    assert energies["damping_heat"] > 0.0
    assert energies["friction_heat"] > energies["kinetic"]
    assert abs(sim.budget.energy_error()) < 1e-6
    assert sim.budget.conservation()["momentum"] < 1e-14


def test_a_membrane_rubs_on_a_wall_that_it_falls_on():
    """A sheet that flies along, and is pressed on the floor: it is slowed down by μ g."""
    sim = simulation(
        element_sheet(velocity=(1.0, 0.0, 0.0)),
        lower=(-2.0, -2.0, 0.0),
        counts=(8, 4, 4),
        support=[wall(friction=0.2)],
        gravity=(0.0, 0.0, -1.0),
        step=1e-3,
    )
    advance(sim, 1000)
    assert mean(sim, "velocity")[0] == pytest.approx(1.0 - 0.2 * sim.time, rel=1e-6)
    assert sim.budget.reactions()["wall"] == pytest.approx(sim.bodies[0].mass * np.array((-0.2, 0.0, 1.0)), rel=1e-6, abs=1e-9)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.energy_error()) < 1e-9


# what cannot be

RIGID = "rigid = true\npoints_per_cell"


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("friction = 0.3", "friction = -0.3", "friction", ["support.slope.friction = -0.3", "at least 0"]),
        (
            "friction = 0.3",
            "friction = 0.3\nstick = true",
            "stick",
            ["support.slope.stick", "`friction` has no effect", "remove one"],
        ),
        (
            'fix = "normal"',
            'fix = ["y"]',
            "friction",
            ["slope.friction", "a clamp", 'set fix = "normal"', "remove friction"],
        ),
        ('fix = "normal"\nfriction = 0.3', "opens = true", "opens", ["support.slope.opens", "a clamp", "remove opens"]),
        ('fix = "normal"\nfriction = 0.3', "stick = true", "stick", ["support.slope.stick", "a clamp", "remove stick"]),
        ('"y-lower"', '"all-nodes"', "[[support]]", ["support.slope", "needs a face of the grid", '"x-lower"']),
        (
            '"y-lower"\nfix = "normal"',
            "{ box = { lower = [0, 0, 0], upper = [6, 0, 0] } }",
            "friction",
            ["support.slope.friction", "a face of the grid", "with a face as `where`"],
        ),
        ("points_per_cell", RIGID, "friction", ["support.slope.friction", "block is rigid", "[[wall]]"]),
        (
            "friction = 0.3",
            'friction = 0.3\n\n[[support]]\nname = "again"\nwhere = "y-lower"\nfix = "normal"\nstick = true',
            "stick",
            ["support.again.stick", "already sets friction or opening of y-lower", "set friction and opening once"],
        ),
        (
            "friction = 0.3",
            'friction = 0.3\n\n[[support]]\nname = "again"\nwhere = ["x-lower", "y-lower"]\nfix = "normal"\nstick = true',
            "stick",
            ["support.again.stick", "already sets friction or opening of y-lower", "set friction and opening once"],
        ),
        ('"y-lower"', '["y-lower", "y-lower"]', "where", ["support.slope.where.1", "y-lower is listed twice", "remove one"]),
        ('"y-lower"\nfix = "normal"\nfriction = 0.3', '["y-lower", "z-lower"]', "where", ["where.1", "one cell thick along z"]),
        ('"y-lower"', "[]", "where", ["support.slope.where", "`where` is empty", "remove the support"]),
        ('"y-lower"', '["y-lower", "boundary"]', "where", ["support.slope.where.1", 'one of "x-lower"']),
        (
            "friction = 0.3",
            "frictoin = 0.3",
            "frictoin",
            ["support.slope.frictoin", "did you mean `friction`?"],
        ),
    ],
)
def test_messages_of_walls_that_cannot_be(old, new, line, words):
    assert old in ON_SLOPE
    text = ON_SLOPE.replace(old, new)
    with pytest.raises(CaseError) as caught:
        loads(text, "slope.toml")
    message = str(caught.value)
    number = next(n for n, found in enumerate(text.splitlines(), start=1) if found.startswith(line))
    assert f"slope.toml:{number}: " in message
    for word in words:
        assert word in message


FILM = """
[[body]]
name = "film"
kind = "fluid-film"
field = "film"
shape = { ellipse = { centre = [3, 0.5, 0], radius = 0.2, nodes = 40 } }
material = { kind = "lipid-film", density = 1, viscosity = 1, dilatational_viscosity = 1, stiffness = 1 }
"""


def test_messages_of_walls_that_cannot_be_beside_a_film():
    with pytest.raises(CaseError, match=r"support\.slope\.friction") as caught:
        loads(ON_SLOPE + FILM, "slope.toml")
    assert "film has its own nodes, for which supports have no friction" in str(caught.value)


def test_messages_of_walls_that_cannot_be_beside_own_nodes():
    text = TISSUE.replace("friction = 0.3", "friction = 0.3\nopens = false")
    with pytest.raises(CaseError, match=r"support\.slope\.opens") as caught:
        loads(text, "tissue.toml")
    assert "bodies separate from a wall with friction" in str(caught.value)
