"""Conditions at nodes: their order, and walls with friction or that open, compared with the same rules in numpy."""

import numpy as np
import pytest
from small_cases import box, case

from pellucid import energy
from pellucid.conditions.constrained_nodes import constrain_nodes
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import FULL_DRIVE_FRACTION, ExternalAction, free_axes
from pellucid.grid.nodal_fields import allocate
from pellucid.grid.nodal_momentum import NodalMomentum
from pellucid.grid.velocity_field import VelocityField

DT, SMALL = 0.25, 1e-3
GRAVITY = (0.5, 0.0, -2.0)
FLOOR = {"where": "z-lower", "fix": "normal"}
ALONG = [0, 1]  # the axes of a floor


def heavy_nodes(*support, held=()):
    """A grid with masses, momenta and forces at random, none of them light; the numbers of the nodes on the floor."""
    tables = case(box((0, 0, 0), (4, 4, 4)), support=[*support, *held])
    grid, generator = Grid(tables.grid), np.random.default_rng(4)
    index, position = grid.where()
    nodes, n = grid.nodes, len(index)
    nodes.mass[index] = generator.uniform(0.5, 2.0, n)
    nodes.momentum[index] = generator.normal(size=(n, 3))
    nodes.force[index] = 4.0 * generator.normal(size=(n, 3))
    return grid, constrain_nodes(grid, tables.support), index[position[:, 2] == 0.0]


def momentum_of(nodes, walls, external=None):
    """Return the momentum equation of these nodes; without `external` only forces, gravity and walls act."""
    free = allocate(ExternalAction, 0)
    return NodalMomentum(nodes, np.array([0, len(nodes.mass)]), walls, GRAVITY, SMALL, flip=1.0, external=external or free)


def stepped(grid, walls):
    """Velocities before the step and after it without walls, and the works of it, with all masses still there."""
    nodes = grid.nodes
    full = nodes.mass > 0.0
    before = np.zeros_like(nodes.velocity)
    before[full] = nodes.momentum[full] / nodes.mass[full, None]
    free = before.copy()
    free[full] += DT * (nodes.force[full] / nodes.mass[full, None] + np.array(GRAVITY))
    momentum = momentum_of(nodes, walls)
    momentum.advance(DT)
    return before, free, momentum.works(DT)


def approach(share, goal, v):
    return v + share * (goal - v)


def test_conditions_act_in_one_order():
    """Support before all, then absorbing face, driven points, friction; everywhere by v + φ (goal - v). Works and heat are the
    change of kinetic energy, also where several conditions act on one node."""
    floor = FLOOR | {"friction": 0.9, "opens": False, "velocity": (0.75, -0.5, 0.25)}
    clamp = {"where": {"box": {"lower": (1, 1, 0), "upper": (3, 3, 3)}}, "fix": ["x"], "velocity": (0.3, 0.0, 0.0)}
    grid, walls, on_floor = heavy_nodes(floor, held=[clamp])
    nodes, generator = grid.nodes, np.random.default_rng(6)
    full, m = nodes.mass > 0.0, np.where(nodes.mass > 0.0, nodes.mass, 1.0)[:, None]
    actions = NodalActions(VelocityField("common", grid), 0)
    rates, driven = actions.absorption(), actions.driven()
    rates[full] = generator.uniform(0.0, 3.0, (full.sum(), 3)) * generator.choice([0.0, 1.0], (full.sum(), 3))
    shares = generator.choice([0.0, 0.4, 2.0], (len(m), 3))
    driven.mass[:] = full[:, None] * m * FULL_DRIVE_FRACTION * shares
    goals = generator.normal(size=driven.mass.shape)
    driven.momentum[:] = driven.mass * goals
    external = actions.external()
    mapped, push = nodes.momentum / m, DT * (nodes.force / m + np.array(GRAVITY))

    held = nodes.constrained > 0
    of_support = walls.velocity[nodes.constrained - 1, np.arange(3)]
    before = np.where(held & (walls.mirror[nodes.constrained - 1] == 1), of_support, mapped)
    half = 0.5 * DT * rates
    of_face, of_points = np.where(held, 0.0, half / (1.0 + half)), np.where(held, 0.0, np.minimum(1.0, shares))
    absorbed = approach(of_face, -before, before + push)
    led = np.where(held, of_support, approach(of_points, goals, absorbed))
    press, slides, belt = np.zeros(len(m)), ~held & (shares == 0.0), walls.velocity[0]
    press[on_floor] = 0.9 * np.maximum(-m[on_floor, 0] * push[on_floor, 2], 0.0)
    size = m[:, 0] * np.linalg.norm(np.where(slides, belt - led, 0.0), axis=1)
    rubs = np.where(size > press, press / np.where(size > 0.0, size, 1.0), 1.0 * (press > 0.0))[:, None]
    new = np.where(slides, approach(rubs, belt, led), led)

    momentum = momentum_of(nodes, walls, external)
    momentum.advance(DT)
    given = external.impulse * driven.mass
    work = momentum.works(DT)
    assert nodes.velocity[full] == pytest.approx(new[full], rel=1e-12, abs=1e-13)
    assert np.array_equal(nodes.velocity[held & full[:, None]], of_support[held & full[:, None]])
    followed = (of_points == 1.0) & full[:, None]
    assert nodes.velocity[followed] == pytest.approx(goals[followed], rel=1e-15)
    assert given == pytest.approx(np.where(full[:, None] & ~held & (shares > 0.0), m * (led - absorbed), 0.0), abs=1e-12)
    assert np.array_equal(free_axes(nodes, external), full[:, None] & ~held & (shares < 1.0))
    for several in (held & (rates > 0.0) & (shares > 0.0), (of_face > 0.0) & (of_points % 1.0 > 0.0)):
        assert several.any(), "the order matters at these"
    assert (rubs[on_floor] > 0.0).any()
    assert (slides & (rubs > 0.0) & (of_face > 0.0)).any()

    change = 0.5 * np.sum(nodes.mass[:, None] * (new**2 - before**2))
    works = work.works
    done = sum(works[column] for column in (energy.INTERNAL, energy.GRAVITY, energy.SUPPORT, energy.MOTION))
    lost = {column: works[column] for column in (energy.IMPACT, energy.FRICTION, energy.ABSORBED)}
    assert min(lost.values()) > 0.0
    assert change == pytest.approx(done - sum(lost.values()), rel=1e-12)
    assert works[energy.MOTION] == pytest.approx(np.sum(given * goals), rel=1e-12)
    rubbed = np.where(slides, m * (new - led), 0.0)[on_floor].sum(axis=0)
    assert work.reactions[0][:2] == pytest.approx(rubbed[:2], rel=1e-12)


@pytest.mark.parametrize("opens", [False, True])
@pytest.mark.parametrize("belt", [(0.0, 0.0, 0.0), (0.75, -0.5, 0.25)])
def test_friction_is_at_most_its_share_of_what_presses(opens, belt):
    """At each node: it sticks to the wall, or the friction is μ P against the sliding; nothing where the wall pulls."""
    friction = 0.9
    grid, walls, floor = heavy_nodes(FLOOR | {"friction": friction, "opens": opens, "velocity": belt})
    nodes = grid.nodes
    before, free, work = stepped(grid, walls)
    m, wall = nodes.mass[floor], np.array(belt)
    gained = (free - before)[floor, 2]
    away = opens & (free[floor, 2] > wall[2])
    stopped = opens & ~away & (gained > 0.0)  # no mirror image: it would pull
    press = np.where(away, 0.0, -m * gained)
    press = np.where(stopped, m * (wall[2] - free[floor, 2]), press)
    slide = free[floor][:, ALONG] - wall[ALONG]
    size = m * np.linalg.norm(slide, axis=1)
    most = friction * np.maximum(press, 0.0)
    sticks = (most > 0.0) & (size <= most)
    assert sticks.any()
    assert (most > 0.0)[~sticks].any()
    assert (press <= 0.0).any()
    share = np.where(sticks, 1.0, most / size)
    expected = -m[:, None] * share[:, None] * slide
    assert nodes.velocity[floor][:, ALONG] == pytest.approx(free[floor][:, ALONG] + expected / m[:, None], rel=1e-12, abs=1e-13)
    assert (nodes.velocity[floor][sticks][:, ALONG] == wall[ALONG]).all()
    assert np.array_equal(nodes.velocity[floor], nodes.strain_velocity[floor])
    assert nodes.velocity[floor, 2] == pytest.approx(np.where(away, free[floor, 2], wall[2]), rel=1e-13)
    assert away.any() == opens
    # what the wall gives, and the work of it
    reaction = np.array([*expected.sum(axis=0), press.sum()])
    assert work.reactions[0] == pytest.approx(reaction, rel=1e-12)
    assert work.works[energy.SUPPORT] == pytest.approx(reaction @ wall, rel=1e-12)
    mean = 0.5 * (before[floor] + nodes.velocity[floor])[:, ALONG]
    assert work.works[energy.FRICTION] == pytest.approx(np.sum(expected * (wall[ALONG] - mean)), rel=1e-12)
    others = np.ones(len(nodes.mass), bool)
    others[floor] = False
    assert nodes.velocity[others] == pytest.approx(free[others], rel=1e-12)


@pytest.mark.parametrize(
    "walls",
    [{"friction": 0.4}, {"friction": 0.4, "opens": False}, {"stick": True}, {"opens": True}],
    ids=["rubs", "rubs and holds", "sticks", "opens"],
)
def test_works_are_the_change_of_kinetic_energy(walls):
    """Of nodes that walls stop as clamps do, let go or rub on; where they are mirrored, what they bring does not count."""
    sides = [{"where": side, "fix": "normal"} | walls for side in ("x-lower", "y-upper", "z-lower")]
    grid, supports, _ = heavy_nodes(*sides)
    nodes = grid.nodes
    before, _, work = stepped(grid, supports)
    start = np.where((nodes.constrained > 0) & (nodes.velocity_increment == 0.0), 0.0, before)  # mirrored
    change = 0.5 * np.sum(nodes.mass[:, None] * (nodes.velocity**2 - start**2))
    works = work.works
    done = works[energy.INTERNAL] + works[energy.GRAVITY] + works[energy.SUPPORT]
    assert change == pytest.approx(done - works[energy.IMPACT] - works[energy.FRICTION], rel=1e-12)
    given = np.sum(nodes.mass[:, None] * nodes.velocity_increment, axis=0)
    forces = DT * (nodes.force.sum(axis=0) + nodes.mass.sum() * np.array(GRAVITY))
    assert given == pytest.approx(forces + work.reactions.sum(axis=0), rel=1e-12)


def test_what_sticks_does_not_strain_along_the_wall():
    """Velocities of the momentum mapped again: none at nodes that stuck, those of the momentum where they slid."""
    grid, walls, floor = heavy_nodes(FLOOR | {"friction": 0.4})
    nodes = grid.nodes
    mapped = nodes.momentum.copy()
    momentum = momentum_of(nodes, walls)
    momentum.advance(DT)
    stuck = (nodes.velocity[floor][:, ALONG] == 0.0).all(axis=1)
    open_nodes = nodes.velocity[floor, 2] > 0.0
    nodes.momentum[:] = mapped
    momentum.project(DT)
    assert 0 < stuck.sum() < len(floor)
    assert 0 < open_nodes.sum() < len(floor)
    expected = mapped[floor] / nodes.mass[floor, None]
    expected[stuck, :2] = 0.0
    expected[~open_nodes, 2] = 0.0
    assert nodes.strain_velocity[floor] == pytest.approx(expected, rel=1e-14)


def test_a_node_that_was_let_go_is_held_again():
    grid, walls, floor = heavy_nodes(FLOOR | {"opens": True})
    nodes, momentum = grid.nodes, momentum_of(grid.nodes, walls)
    for speed, gap, is_held in ((1e3, 0.0, False), (-1e3, 0.0, True), (-1e3, 0.1, False), (-1e3, -0.1, True)):
        nodes.momentum[floor], walls.walls.gap[floor, 2] = speed, gap
        momentum.advance(DT)
        assert (nodes.constrained[floor, 2] == (1 if is_held else 0)).all()
        assert (nodes.velocity[floor, 2] == 0.0).all() == is_held


def test_a_node_that_is_caught_is_stopped_and_then_mirrored():
    """As it is caught it loses its velocity to the wall; from then on the wall gives only what forces press."""
    grid, walls, floor = heavy_nodes(FLOOR | {"opens": True})
    nodes, momentum = grid.nodes, momentum_of(grid.nodes, walls)
    nodes.constrained[floor] = 0
    nodes.force[floor] = (0.0, 0.0, -1.0)
    m = nodes.mass[floor]
    pressed = np.sum(DT * (1.0 + 2.0 * m))
    for caught in (True, False):
        nodes.momentum[floor] = m[:, None] * np.array((0.0, 0.0, -3.0))
        momentum.advance(DT)
        work = momentum.works(DT)
        brought = np.sum(3.0 * m) if caught else 0.0
        assert work.reactions[0, 2] == pytest.approx(pressed + brought, rel=1e-12)
        assert work.works[energy.IMPACT] == pytest.approx(1.5 * brought, rel=1e-12)


def test_nodes_of_hardly_any_mass_stick_too():
    grid, walls, floor = heavy_nodes(FLOOR | {"stick": True})
    nodes = grid.nodes
    nodes.mass[floor], nodes.force[floor] = 0.1 * SMALL, (1.0, 2.0, -1.0)
    nodes.momentum[floor] *= 0.1 * SMALL
    stepped(grid, walls)
    assert not nodes.velocity[floor].any()
    assert not nodes.strain_velocity[floor].any()


def test_what_another_support_holds_does_not_slide():
    """A corner: along the normal of another wall there is no friction; where a clamp holds all, there is none at all."""
    side = {"where": "x-lower", "fix": "normal"}
    clamp = {"where": {"box": {"lower": (3, 0, 0), "upper": (4, 4, 0)}}}
    grid, walls, floor = heavy_nodes(FLOOR | {"stick": True, "opens": False}, held=[side, clamp])
    index, position = grid.where()
    stepped(grid, walls)
    place = np.zeros((grid.n_nodes, 3))
    place[index] = position
    corner, clamped = floor[place[floor, 0] == 0.0], floor[place[floor, 0] >= 3.0]
    assert not walls.walls.stuck[corner, 0].any()
    assert walls.walls.stuck[corner, 1].any()
    assert not walls.walls.stuck[clamped].any()
    assert not walls.walls.held[clamped].any()


def test_without_such_walls_nothing_is_kept_of_nodes():
    _, walls, _ = heavy_nodes(FLOOR, held=[{"where": "x-lower", "fix": "normal", "friction": 0.0, "opens": False}])
    assert all(not len(array) for array in walls.walls)
