"""The loop over points: what it reads, gathers, keeps and sums, what it does where points have faults, and ways around it."""

import os
import subprocess
import sys
from typing import Any, NamedTuple

import numpy as np
import pytest
from small_cases import box, place, simulation

from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.moving import Stay, displacement, move_points, moving
from pellucid.grid.passes.points_pass import Declaration, Found, at_point, gathered, pass_points
from pellucid.grid.points import INVERTED, LOST, NOT_FINITE, OK, RATE, STORED, VECTORS, ByIndex
from pellucid.grid.stencil import gather
from pellucid.jit import point_function
from pellucid.tensors import ZERO_VECTOR

COUNTS = 3, 2, 4


class Read(NamedTuple):
    position: Any
    mass: Any
    fault: Any


class Kept(NamedTuple):
    position: Any
    volume: Any


class Drift(NamedTuple):
    """Points move with the nodes; volumes become dt; masses are summed, x the maximum."""


@point_function(gathered, Drift)
def _velocity(rule, about, lattice, nodes, p, known):
    return gather(about, lattice, nodes.velocity)


@point_function(at_point, Drift)
def _drift(task, lattice, dt, p, known, g):
    x, y, z = p.position
    return Found(Kept((x + dt * g[0], y + dt * g[1], z + dt * g[2]), dt), (p.mass,), x, p.fault)


class Push(NamedTuple):
    """Points move along x by as much as each is told."""

    by: np.ndarray


@point_function(displacement, Push)
def _push(rule, mapped, p, dt):
    return rule.by[p], 0.0, 0.0


@pytest.fixture
def drifting():
    """A body at random places with a uniform nodal velocity along x of 1 m/s, and the pass with faults to be set."""
    sim = simulation(box((0, 0, 0), COUNTS), counts=COUNTS)
    body, random = sim.bodies[0], np.random.default_rng(5)
    place(body, random.uniform(0.1, 0.9, (body.n_points, 3)) * COUNTS)
    body.arrays["mass"][:] = random.uniform(0.5, 2.0, body.n_points)
    sim.grid.nodes.velocity[:] = (1.0, 0.0, 0.0)
    faults = np.zeros(body.n_points)
    declared = Declaration(gathers=ZERO_VECTOR, sums=(STORED,), largest=RATE, places=True)
    points = body.points
    read, kept = Read(points.position, points.mass, faults), Kept(points.position, points.volume)
    return body, faults, pass_points(Drift(), declared, body.mapped.content, read, kept)


def test_points_move_and_are_summed(drifting):
    body, _, task = drifting
    before, slabs = body.arrays["position"].copy(), body.storage.slabs
    each_point(task, 0.01)
    # three roundings of places of some cells
    assert body.arrays["position"] == pytest.approx(before + np.array([0.01, 0.0, 0.0]), abs=4e-15)
    assert np.all(body.arrays["volume"] == 0.01)
    assert slabs.sums[:, STORED].sum() == pytest.approx(body.arrays["mass"].sum(), rel=1e-14)
    assert slabs.sums[:, RATE].max() == before[:, 0].max()
    assert not slabs.fault.any()
    assert not slabs.left_slab.any()
    assert 0 < slabs.sums[:, VECTORS].sum() <= body.n_points


@pytest.mark.parametrize("others", [{}, {1: LOST}])
def test_what_would_turn_over_keeps_what_it_had(drifting, others):
    """And comes before points that left the grid, which others may have let go."""
    body, faults, task = drifting
    before = {name: body.arrays[name].copy() for name in ("position", "volume")}
    faults[7] = INVERTED
    for point in others:
        body.arrays["position"][point, 0] = before["position"][point, 0] = COUNTS[0] - 0.001
    each_point(task, 0.01)
    for name, array in before.items():
        assert np.all(body.arrays[name][7] == array[7])
        assert np.all(np.delete(body.arrays[name] != array, 7, axis=0).reshape(body.n_points - 1, -1)[:, 0])
    found = body.storage.slabs.fault[body.storage.slabs.fault[:, 0] != OK]
    assert (INVERTED, 7) in [tuple(row) for row in found]


@pytest.mark.parametrize(("step", "fault"), [(5.0, LOST), (np.inf, NOT_FINITE), (np.nan, NOT_FINITE)])
def test_places_that_are_none_are_faults(drifting, step, fault):
    body, _, task = drifting
    each_point(task, step)
    codes = body.storage.slabs.fault[np.diff(body.storage.slabs.first) > 0, 0]
    assert np.all(codes == fault)
    if fault == LOST:
        assert body.storage.slabs.of_lost[:, STORED].sum() == pytest.approx(body.arrays["mass"].sum(), rel=1e-14)


def test_the_order_of_an_index_is_as_good(drifting):
    """Points that are stored in the order of their mesh get the same, each in its own place."""
    body, faults, task = drifting
    order = np.random.default_rng(1).permutation(body.n_points)
    stored = {name: np.empty_like(array) for name, array in body.arrays.items()}
    for name, array in body.arrays.items():
        stored[name][order] = array
    points = body.points._replace(**{name: stored[name] for name in body.points._fields})
    mapped = body.mapped.content._replace(points=points, index=ByIndex(order))
    declared = Declaration(gathers=ZERO_VECTOR, sums=(STORED,), largest=RATE, places=True)
    read, kept = Read(points.position, points.mass, faults), Kept(points.position, points.volume)
    each_point(task, 0.01)
    sums = body.storage.slabs.sums.copy()
    each_point(pass_points(Drift(), declared, mapped, read, kept), 0.01)
    assert np.array_equal(body.storage.slabs.sums, sums)
    assert np.array_equal(stored["position"][order], body.arrays["position"])


def test_rules_move_points_one_by_one(drifting):
    """What was found before stays: a fault of the step, and that points left their slabs."""
    body, _, _ = drifting
    by, before = np.zeros(body.n_points), body.arrays["position"].copy()
    by[3] = 9.0
    push = moving(body.mapped.content, Push(by))
    move_points(push, 1.0)
    assert body.arrays["position"][3, 0] == before[3, 0] + 9.0
    assert np.all(np.delete(body.arrays["position"] == before, 3, axis=0))
    slab = np.searchsorted(body.storage.slabs.first, 3, side="right") - 1
    assert tuple(body.storage.slabs.fault[slab]) == (LOST, 3)
    body.storage.slabs.fault[slab] = INVERTED, 0
    move_points(moving(body.mapped.content, Stay()), 1.0)
    assert tuple(body.storage.slabs.fault[slab]) == (INVERTED, 0)


def test_what_does_not_fit_is_refused(drifting):
    body, faults, _ = drifting
    points, mapped = body.points, body.mapped.content
    read, kept = Read(points.position, points.mass, faults), Kept(points.position, points.volume)
    with pytest.raises(ValueError, match="first that a pass reads is the position"):
        pass_points(Drift(), Declaration(), mapped, (points.mass,), kept)
    with pytest.raises(ValueError, match="new places keeps is the position"):
        pass_points(Drift(), Declaration(places=True), mapped, read, (points.volume,))
    with pytest.raises(ValueError, match=r"with 192 rows, not int64 of shape \(10,\)"):
        pass_points(Drift(), Declaration(), mapped, read, (np.zeros(10, int),))


def test_more_than_was_declared_is_an_error(drifting):
    """And not a write beyond the columns."""
    body, faults, _ = drifting
    points = body.points
    read, kept = Read(points.position, points.mass, faults), Kept(points.position, points.volume)
    for declared in (Declaration(gathers=ZERO_VECTOR), Declaration(gathers=0.0, sums=(STORED,))):
        with pytest.raises(Exception, match=r"numbers were given, but \d were declared"):
            each_point(pass_points(Drift(), declared, body.mapped.content, read, kept), 0.0)


def test_faults_of_passes_that_give_no_new_places_are_reported(drifting):
    body, faults, _ = drifting
    faults[5] = NOT_FINITE
    read, kept = Read(body.points.position, body.points.mass, faults), Kept(body.arrays["position"].copy(), body.points.volume)
    declared = Declaration(gathers=ZERO_VECTOR, sums=(STORED,))
    each_point(pass_points(Drift(), declared, body.mapped.content, read, kept), 0.0)
    slab = np.searchsorted(body.storage.slabs.first, 5, side="right") - 1
    assert tuple(body.storage.slabs.fault[slab]) == (NOT_FINITE, 5)


UNWRITTEN = """
import numpy as np
from pellucid.jit import memory
memory.numbers = lambda length: np.full(length, 5e-324)  # what a stack may hold: addresses are such numbers
from pellucid.case.spec import Case
from pellucid.simulation.simulation import Simulation
material = {"kind": "fluid", "density": 1.0, "eos": {"kind": "tait", "sound_speed": 10.0}}
body = {"name": "block", "shape": {"box": {"lower": [0, 0, 0], "upper": [0.7, 1, 1]}}, "points_per_cell": [3, 1, 1]}
case = {
    "schema": 1,
    "title": "block",
    "grid": {"lower": [0, 0, 0], "upper": [2, 2, 1], "cell": 1.0, "functions": "quadratic-bspline"},
    "time": {"end": 1.0, "transfer": "flip"},
    "body": [{**body, "material": material, "velocity": [0.5, 0.3, 0]}],
}
sim = Simulation(Case.model_validate(case), threads=1)
with np.errstate(under="raise"):
    sim.step()
"""


def test_no_vector_reads_what_nothing_has_written():
    """Lanes beyond the last point of a block do not count, but processors are slow with denormal numbers: passes over points in
    disorder took three times as long. Without the compiler, where numpy raises an error for each such number."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", UNWRITTEN], env=environment, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done.stderr
