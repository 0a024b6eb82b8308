"""Supports on nodes, and what they do to bodies."""

import numpy as np
import pytest
from elements import element_sheet
from small_cases import RATE_SOLID, SLIP, advance, box, case, simulation

import pellucid
from pellucid.case import loads
from pellucid.conditions.constrained_nodes import ActiveSupports, constrain_nodes
from pellucid.conditions.support import Support
from pellucid.errors import CaseError
from pellucid.grid.lattice import Grid
from pellucid.running.launch import resume_case


def held(*support, counts=(3, 4, 5)):
    """Positions, constrained directions (numbers of supports) and wall velocities."""
    tables = case(box((0, 0, 0), counts), counts=counts, support=support)
    grid = Grid(tables.grid)
    walls = constrain_nodes(grid, tables.support)
    index, position = grid.where()
    return position, grid.nodes.constrained[index], walls


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_faces(axis, side):
    position, hold, walls = held({"where": f"{'xyz'[axis]}-{side}", "velocity": (1, 2, 3)})
    on_face = position[:, axis] == (0 if side == "lower" else (3, 4, 5)[axis])
    assert np.all(hold[on_face] == 1)
    assert not hold[~on_face].any()
    assert walls.velocity.tolist() == [[1, 2, 3], [0, 0, 0]]


def test_normal_holds_one_direction():
    position, hold, _ = held({"where": "y-upper", "fix": "normal"})
    on_face = position[:, 1] == 4
    assert np.all(hold[on_face] == (0, 1, 0))
    assert not hold[~on_face].any()


def test_boxes_include_their_faces_and_later_supports_count():
    inside = {"where": {"box": {"lower": (1, 1, 1), "upper": (2, 2, 2)}}, "fix": ["z"]}
    position, hold, _ = held({"where": "all-nodes", "fix": ["y", "z"]}, inside)
    within = np.all((position >= 1) & (position <= 2), axis=1)
    assert within.sum() == 8
    assert np.all(hold[within] == (0, 1, 2))
    assert np.all(hold[~within] == (0, 1, 1))


def test_a_box_between_nodes_is_an_error_that_names_the_support():
    between = {"where": {"box": {"lower": (1.2, 1.2, 1.2), "upper": (1.8, 1.8, 1.8)}}}
    with pytest.raises(CaseError, match=r"support\.1\.where") as caught:
        held({"where": "x-lower"}, between)
    assert "at least one cell" in str(caught.value)


def test_thin_axes_are_held_and_do_not_count_for_boxes():
    flat = {"where": {"box": {"lower": (0, 0, 0.3), "upper": (1, 1, 0.6)}}, "fix": ["x"]}
    position, hold, walls = held(flat, counts=(3, 3, 1))
    assert np.all(hold[:, 2] == 2)
    assert walls.velocity[1].tolist() == [0, 0, 0]
    corner = (position[:, 0] <= 1) & (position[:, 1] <= 1)
    assert np.all((hold[:, 0] == 1) == corner)


def test_normal_needs_a_face():
    with pytest.raises(ValueError, match="needs a face"):
        Support(where="all-nodes", fix="normal")
    with pytest.raises(ValueError, match="`fix` is empty"):
        Support(where="x-lower", fix=())


# what supports do to bodies


def block(**more):
    return box((0, 0, 0), (2, 2, 2), RATE_SOLID, **more)


@pytest.mark.parametrize(
    ("support", "velocity"),
    [
        ([{"where": "x-lower"}], (-0.2, 0.1, 0.05)),
        (SLIP, (-0.2, 0.1, 0.05)),
        ([{"where": "x-lower", "fix": ["x"], "velocity": (0.2, 0, 0)}], (0, 0, 0)),
        ([{"where": {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1)}}, "velocity": (0, 0.1, 0)}], (0, 0, 0.1)),
        ([{"where": "all-nodes", "fix": ["y"]}], (0.1, 0.2, 0.1)),
    ],
    ids=["fixed", "slip", "moving", "box", "all nodes"],
)
@pytest.mark.parametrize("transfer", ["flip", "pic"])
def test_momentum_changes_by_the_impulse_of_the_supports(support, velocity, transfer):
    body = block(velocity=velocity)
    sim = advance(simulation(body, counts=(5, 4, 4), support=support, end=10.0, transfer=transfer), 25)
    assert np.abs(sim.budget.impulse).max() > 1.0
    # sums of some hundred products in each of 25 steps
    assert sim.budget.conservation()["momentum"] < 1e-14
    assert sim.momentum() - sim.budget.initial_momentum == pytest.approx(sim.budget.impulse, abs=1e-11)


def test_supports_are_a_part_of_the_step_that_reports_their_impulses_by_name():
    """Impulses of one name add up, here those of two faces."""
    walls = {"name": "walls", "where": ["x-lower", "y-lower"], "fix": "normal"}
    support = [walls, {"where": "z-lower", "fix": "normal"}, {"name": "lid", "where": "z-upper", "fix": "normal"}]
    sim = advance(simulation(block(velocity=(-0.2, -0.1, -0.05)), counts=(4, 4, 4), support=support, end=10.0), 5)
    (supports,) = sim.parts.of(ActiveSupports)
    assert [one.where for one in supports.supports] == ["x-lower", "y-lower", "z-lower", "z-upper"]
    x, y, z = sim.budget.impulse
    assert min(x, y, z) > 0.1
    reactions = sim.budget.reactions()
    assert sorted(reactions) == ["lid", "walls"]
    assert reactions["walls"] == pytest.approx([x, y, 0.0], rel=1e-12)
    assert not reactions["lid"].any()


@pytest.mark.parametrize("transfer", ["flip", "pic"])
@pytest.mark.parametrize("where", ["all-nodes", {"box": {"lower": (0, 0, 0), "upper": (3, 3, 3)}}], ids=["all nodes", "box"])
def test_points_in_a_grip_have_its_velocity(where, transfer):
    """And move with it: what is written for a velocity is what moves the points."""
    grip = {"where": where, "velocity": (0.5, 0.0, -0.25)}
    body = box((0.5, 0.5, 0.5), (1.5, 1.5, 1.5), RATE_SOLID, velocity=(0.0, 1.0, 0.0))
    sim = simulation(body, counts=(5, 4, 4), lower=(0, 0, 0), support=[grip], end=10.0, step=0.01, transfer=transfer)
    start = sim.bodies[0].frame()["position"]
    frame = advance(sim, 10).bodies[0].frame()
    assert np.abs(frame["position"] - start - 0.1 * np.array((0.5, 0.0, -0.25))).max() < 1e-12
    # the change of velocity that the nodes hand on is that of the points where these move together
    assert np.abs(frame["velocity"] - (0.5, 0.0, -0.25)).max() < 1e-12
    assert sim.budget.conservation()["momentum"] < 1e-13


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_a_symmetry_plane_is_a_mirror(scheme):
    """Half a bar that pulsates beside a symmetry plane moves as the half of the whole bar, bit for bit but for rounding."""
    sims = []
    for lower, counts in ((-3, (6, 1, 1)), (0, (3, 1, 1))):
        wave = {"amplitude": (0.2, 0, 0), "wave_vector": (0.8, 0, 0), "phase": 0.0}
        bar = box((max(lower, -2), 0, 0), (2, 0, 0), RATE_SOLID, (2, 1, 1), velocity_wave=wave)
        plane = [{"where": "x-lower", "fix": "normal"}] if lower == 0 else []
        sims.append(advance(simulation(bar, counts=counts, lower=(lower, 0, 0), support=plane, scheme=scheme, end=10.0), 60))
    whole, half = (sim.bodies[0].frame() for sim in sims)
    right = whole["position"][:, 0] > 0.0
    for field in ("position", "velocity", "stress"):
        scale = np.abs(whole[field]).max()
        # a few dozen roundings a step, for sixty steps
        assert np.abs(whole[field][right] - half[field]).max() < 1e-12 * scale, field
    assert sims[1].budget.kinetic == pytest.approx(0.5 * sims[0].budget.kinetic, rel=1e-12)


def test_slip_walls_let_tangential_motion_pass():
    floor = {"where": "z-lower", "fix": "normal"}
    sim = simulation(block(velocity=(0.5, -0.25, 0.0)), counts=(5, 5, 5), lower=(-1, -2, 0), support=[floor], end=10.0)
    before = sim.bodies[0].frame()["position"]
    advance(sim, 30)
    frame = sim.bodies[0].frame()
    # rounding of a few dozen terms a step, and of stresses of 1e4 Pa times the same
    assert np.abs(frame["velocity"] - (0.5, -0.25, 0.0)).max() < 1e-13
    assert np.abs(frame["position"] - before - sim.time * np.array((0.5, -0.25, 0.0))).max() < 1e-13


def test_a_moving_wall_sends_a_wave_and_works():
    """A slab hit by a wall at 0.1 m/s: the layer that the wave has passed moves with the wall, half its energy is strain."""
    wall = {"where": "x-lower", "fix": ["x"], "velocity": (0.1, 0, 0)}
    slab = box((0, 0, 0), (12, 1, 1), RATE_SOLID, (2, 1, 1))
    sim = simulation(slab, counts=(16, 1, 1), support=[wall], end=10.0, courant=0.2)
    start = sim.bodies[0].frame()["position"][:, 0]
    while sim.time < 2.0:
        sim.step()
    frame = sim.bodies[0].frame()
    front = np.sqrt(1.3462e4 / 1000.0) * sim.time  # λ + 2μ = 1.3462 E
    # a grid of cells of 1 m smears the front over some four of them, and the velocities behind it swing by Gibbs' share
    assert np.abs(frame["velocity"][start > front + 3.0]).max() < 0.02 * 0.1
    assert frame["velocity"][start < front - 3.0, 0].mean() == pytest.approx(0.1, rel=0.05)
    energies, expected = sim.budget.energies(), 0.5 * 1000.0 * front * 0.01
    assert energies["kinetic"] == pytest.approx(expected, rel=0.1)
    assert energies["strain"] == pytest.approx(expected, rel=0.1)
    assert energies["support_work"] == pytest.approx(2.0 * expected, rel=0.1)
    assert sim.budget.conservation()["energy"] == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("axis", range(3))
def test_thin_axes_stay_still_to_the_last_bit(axis):
    counts, velocity, turn = [4, 4, 4], [0.1, 0.1, 0.1], [0.0, 0.0, 0.0]
    counts[axis], velocity[axis], turn[axis] = 1, 0.0, 0.3
    sim = simulation(box([1.0] * 3, [3.0] * 3, velocity=velocity, angular_velocity=turn), counts=counts, end=10.0)
    before = sim.bodies[0].frame()["position"][:, axis]
    frame = advance(sim, 5).bodies[0].frame()
    assert np.array_equal(frame["position"][:, axis], before)
    assert not frame["velocity"][:, axis].any()


def test_a_support_lets_go_at_its_time():
    """Held until 0.1 s, then in free fall: v = g (t - 0.1 s), to a step."""
    hold = {"where": "all-nodes", "until": 0.1}
    sim = simulation(box((1, 1, 1), (3, 3, 3), RATE_SOLID), support=[hold], gravity=(0.0, 0.0, -2.0), step=1e-3)
    advance(sim, 100)
    assert not sim.bodies[0].arrays["velocity"].any()
    advance(sim, 200)
    assert np.allclose(sim.bodies[0].arrays["velocity"], (0.0, 0.0, -2.0 * 0.2), atol=2.0 * 1.1e-3)
    assert abs(sim.budget.conservation()["momentum"]) < 1e-12


def test_what_is_let_go_leaves_the_other_supports():
    hold = [{"where": "x-lower", "fix": "normal"}, {"where": "all-nodes", "until": 0.0}]
    sim = simulation(box((0, 1, 1), (2, 3, 3), RATE_SOLID), support=hold, gravity=(-1.0, 0.0, -1.0), step=1e-3)
    advance(sim, 5)
    index, position = sim.grid.where()
    constrained = sim.grid.nodes.constrained[index]
    assert (constrained[position[:, 0] == 0.0] == (1, 0, 0)).all()
    assert not constrained[position[:, 0] > 0.0].any()


def test_the_own_nodes_of_a_membrane_are_let_go():
    hold = {"where": "all-nodes", "until": 0.1}
    sim = simulation(element_sheet(), lower=(-2, -2, -2), support=[hold], gravity=(0.0, 0.0, -2.0), step=1e-3)
    advance(sim, 100)
    assert not sim.bodies[0].arrays["velocity"].any()
    advance(sim, 200)
    assert np.allclose(sim.bodies[0].arrays["velocity"], (0.0, 0.0, -2.0 * 0.2), atol=2.0 * 1.1e-3)
    assert sim.budget.conservation()["momentum"] < 1e-12


TISSUE = """
schema = 1
title = "A bar of tissue that is let go"
gravity = [0, 0, -2]

[time]
end = 0.04
courant = 0.1

[[body]]
name = "bar"
kind = "meshless-solid"
mesh = { box = { lower = [0, 0, 0], upper = [0.1, 0.1, 0.2], cells = [2, 2, 4] } }
approximant = { kind = "APPROXIMANT" }
material = { kind = "neo-hookean", density = 1000, young_modulus = 3000, poisson_ratio = 0.3 }

[[support]]
name = "foot"
where = { box = { lower = [0, 0, 0], upper = [0.1, 0.1, 0] } }

[[support]]
name = "grip"
where = { box = { lower = [0, 0, 0.2], upper = [0.1, 0.1, 0.2] } }
until = 0.01
"""


@pytest.mark.parametrize("approximant", ["cell-based-maximum-entropy", "moving-least-squares"])
def test_a_meshless_solid_is_let_go(approximant, tmp_path):
    """Its upper face stays until then and falls on; the other support holds; a run that goes on has the same bits."""
    found = loads(TISSUE.replace("APPROXIMANT", approximant), "bar.toml")
    whole = pellucid.run(found, out=tmp_path / "whole", report=False)
    pellucid.run(found, out=tmp_path / "parts", report=False, until=0.02)
    parts = resume_case(tmp_path / "parts", report=False)
    assert (whole.fields("bar")["position"] == parts.fields("bar")["position"]).all()
    start, held, end = (whole.fields("bar", time)["position"] for time in (0.0, 0.01, 0.04))
    top, foot = start[:, 2] == 0.2, start[:, 2] == 0.0
    assert np.abs(held - start)[top | foot].max() < 1e-12
    assert np.abs(end - start)[foot].max() < 1e-12
    # the tension that held it is let go: it falls faster than from rest, and comes up with what was never held
    fell = -(end - start)[top, 2].mean()
    assert 0.5 * 2.0 * 0.03**2 < fell < 0.5 * 2.0 * (0.04**2 - 0.01**2)
    assert np.abs(whole.history["energy_error"]).max() < 1e-6
