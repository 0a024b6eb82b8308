"""Contact at single nodes, against plain formulas."""

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from small_cases import box, case

from pellucid.approximants import grid_functions
from pellucid.contact.impulses import CHUNK, SLIP, STICK, Friction
from pellucid.contact.pairs import ContactPair, ContactPairs
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import Supports
from pellucid.grid.velocity_field import VelocityField
from pellucid.step.part import StepParts

N = CHUNK + 50  # so that works are sums of two chunks


def two_fields(kind, friction=0.0, held=()):
    """N nodes of random masses, velocities and normals; those of the second field are held along the axes `held`."""
    generator = np.random.default_rng(3)
    whole = case(box((0, 0, 0), (1, 1, 1)), counts=(9, 9, 9))
    grids = (Grid(whole.grid), Grid(whole.grid))
    fields = tuple(VelocityField(name, grid) for name, grid in zip("ab", grids, strict=True))
    for field in fields:
        free = NodalActions(field, 0).external()
        field.set_actions(Supports(np.zeros((2, 3)), np.ones(2, np.int64)), free, (0.0, 0.0, 0.0), small_mass=0.0, flip=1.0)
    functions = grid_functions("trilinear", (2, 2, 2), grids[0].thin)
    bodies = [[SimpleNamespace(functions=functions, is_surface=False, n_points=0, contact_response=None)]] * 2
    pair = ContactPair(fields, tuple(bodies), Friction(kind, friction), "touch")
    for grid in grids:
        nodes = grid.nodes
        nodes.mass[:N] = generator.uniform(0.1, 10.0, N)
        nodes.velocity[:N] = generator.normal(size=(N, 3))
        nodes.strain_velocity[:N] = nodes.velocity[:N]
    for axis in held:
        grids[1].nodes.constrained[:N, axis] = 1
        grids[1].nodes.velocity[:N, axis] = 0.0
    normal = generator.normal(size=(N, 3))
    pair.detection.node, pair.detection.normal = np.arange(N), normal / np.linalg.norm(normal, axis=1)[:, None]
    pair.detection.find = lambda: None
    pair.detect()
    return grids, pair


def resolved(grids, pair):
    """Masses, normals and velocities before and after, and what it came to."""
    before = [grid.nodes.velocity[:N].copy() for grid in grids]
    pairs = ContactPairs([pair], 1, 0)
    pairs.stop_approach()
    for grid, old in zip(grids, before, strict=True):
        grid.nodes.mean_velocity[:N] = 0.5 * (old + grid.nodes.velocity[:N])
    pairs.after_momentum()
    work = pairs.done
    return [grid.nodes.mass[:N] for grid in grids], before, [grid.nodes.velocity[:N] for grid in grids], work


def test_bodies_that_are_too_coarse_where_they_touch_are_warned_of():
    _, pair = two_fields(SLIP)
    pair.detection.normal[::2] = 0.0
    seen = []
    pair.bodies = [SimpleNamespace(), SimpleNamespace(contact_warning=lambda nodes: seen.append(nodes) or "it is too coarse")]
    assert StepParts([ContactPairs([pair], 1, 0)]).warnings(inf) == {"part 0: coarse surface": "it is too coarse"}
    assert seen[0].tolist() == list(range(1, N, 2))


@pytest.mark.parametrize(("kind", "friction"), [(STICK, 0.0), (SLIP, 0.0), (SLIP, 0.3), (SLIP, 100.0)])
def test_impulses_are_those_of_coulomb(kind, friction):
    grids, pair = two_fields(kind, friction)
    (a, b), (v, w), after, _ = resolved(grids, pair)
    n, reduced, u = pair.detection.normal, a * b / (a + b), v - w
    approach = np.sum(u * n, axis=1)
    across = u - approach[:, None] * n
    slip = np.linalg.norm(across, axis=1)
    part = np.ones(N) if kind != SLIP else np.minimum(1.0, friction * np.abs(approach) / slip)
    touching = approach > 0.0
    impulse = -(touching * reduced)[:, None] * (approach[:, None] * n + part[:, None] * across)
    # a dozen roundings of numbers near 10
    assert after[0] - v == pytest.approx(impulse / a[:, None], abs=1e-13)
    assert after[1] - w == pytest.approx(-impulse / b[:, None], abs=1e-13)
    assert 10 < touching.sum() < N


@pytest.mark.parametrize("friction", [0.0, 0.3, 100.0])
@pytest.mark.parametrize("held", [(), (2,), (0, 2), (0, 1, 2)])
def test_held_nodes_stay_and_friction_keeps_its_cone_and_makes_no_energy(held, friction):
    grids, pair = two_fields(SLIP, friction, held)
    (a, b), (v, w), (v_new, w_new), work = resolved(grids, pair)
    n = pair.detection.normal
    assert not w_new[:, list(held)].any()
    impulse = a[:, None] * (v_new - v)
    pressed = np.abs(impulse).max(axis=1) > 0.0
    assert 10 < pressed.sum() < N
    approach = np.sum((v_new - w_new) * n, axis=1)
    assert np.abs(approach[pressed]).max() < 1e-13
    push = -np.sum(impulse * n, axis=1)
    rub = np.linalg.norm(impulse + push[:, None] * n, axis=1)
    assert push.min() >= 0.0
    assert np.all(rub <= friction * push + 1e-12)
    kinetic = [0.5 * a * (q * q).sum(axis=1) + 0.5 * b * (r * r).sum(axis=1) for q, r in ((v, w), (v_new, w_new))]
    assert np.all(kinetic[1] - kinetic[0] < 1e-13)
    # what the support took is what the second field lacks
    second = b[:, None] * (w_new - w)
    assert work.work.reactions[0] == pytest.approx((impulse + second).sum(axis=0), abs=1e-11)
    assert work.impulses["touch"] == pytest.approx(impulse.sum(axis=0), abs=1e-12)


def approach_of(grids, normal):
    u = grids[0].nodes.velocity[:N] - grids[1].nodes.velocity[:N]
    return np.sum(u * normal, axis=1)


def test_impulses_found_anew_take_back_what_was_too_much():
    """Nodes that were pushed too hard come back to the impulse that just stops them, and to none where they part anyway."""
    (grids, pair), (others, once) = two_fields(SLIP), two_fields(SLIP)
    once.resolve(anew=False)
    pair.apply_impulses(-0.7 * pair.detection.normal)
    pair.resolve(anew=False)
    assert np.abs(pair.impulses - once.impulses).max() > 0.1, "more on top takes nothing back"
    pair.resolve(anew=True)
    assert pair.impulses == pytest.approx(once.impulses, abs=1e-11)
    for grid, other in zip(grids, others, strict=True):
        assert grid.nodes.velocity[:N] == pytest.approx(other.nodes.velocity[:N], abs=1e-11)
