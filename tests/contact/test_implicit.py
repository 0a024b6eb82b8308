"""Normal forces that are implicit in the step: the system that they solve, unilateral contact, stability and energy."""

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import nnls

from pellucid.contact.images import Feet
from pellucid.contact.implicit import Block, NormalForces
from pellucid.contact.overlap import Overlap


class Nodes:
    """Nodes with masses [kg] and velocities [m/s] in which points have shares."""

    def __init__(self, shares, mass, velocity):
        self.shares, self.mass, self.velocity = sparse.csr_array(shares), mass, velocity

    def velocities(self, dt, pushed):
        change = 0.0 if pushed is None else dt * (self.shares.T @ pushed) / self.mass[:, None]
        return self.shares @ (self.velocity + change)

    def answers(self, dt):
        return np.tile(dt / self.mass[:, None], (1, 3))


class Surface:
    """As much of a surface as the solution uses."""

    rigid_mass = np.inf

    def __init__(self, response, place, rigid_rows=None):
        self.response, self.place, self.velocity = response, place, np.zeros_like(place)
        self._rows = rigid_rows
        if rigid_rows is not None:
            self.rigid_mass = 1.0

    def mobility_rows(self, place, force):
        return self._rows * force[:, 2:]


class Whole:
    """A surface without images."""

    def fold(self, force):
        return force


def soft(rng, n_points, n_nodes):
    shares = rng.random((n_points, n_nodes)) ** 4
    shares /= shares.sum(axis=1, keepdims=True)
    return Nodes(shares, 0.5 + rng.random(n_nodes), rng.standard_normal((n_nodes, 3)))


def overlap_of(one, rng, n):
    normal = np.tile([0.0, 0.0, 1.0], (n, 1)) + 0.2 * rng.standard_normal((n, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    depth = 0.1 * rng.standard_normal(n)
    return Overlap(one, np.arange(n), depth, normal, np.ones(n), np.zeros((n, 3)))


@pytest.mark.parametrize("other", ["wall", "solid", "rigid"])
def test_forces_are_those_of_the_overlap_at_the_end_of_the_step(other):
    """f = k d' where d' > 0, and none elsewhere, by non-negative least squares: no force pulls.

    With A = 1/k + Δt² G = L Lᵀ they minimize |Lᵀ f - L⁻¹ d*|² for f ≥ 0.
    """
    rng, n, dt = np.random.default_rng(7), 12, 0.1
    one = Surface(soft(rng, n, 8), rng.random((n, 3)))
    overlap, k = overlap_of(one, rng, n), 200.0 * (0.5 + rng.random(n))
    rows = np.einsum("ij,ik->ijk", one.response.shares.toarray(), overlap.normal).reshape(n, -1)
    mobility = rows @ np.diag(np.repeat(1.0 / one.response.mass, 3)) @ rows.T
    approach = -np.einsum("ij,ij->i", one.response.shares @ one.response.velocity, overlap.normal)
    block = Block(overlap, k, np.zeros(n))
    described = {id(one): Whole()}
    if other != "wall":
        m = 9
        share = rng.random((n, m))
        share /= share.sum(axis=1, keepdims=True)
        feet = Feet(np.arange(n + 1) * m, np.tile(np.arange(m), n), share.ravel())
        response = soft(rng, m, 5) if other == "solid" else None
        second = Surface(response, rng.random((m, 3)), None if other == "solid" else rng.standard_normal((n, 6)))
        block = block._replace(other=second, feet=feet)
        described[id(second)] = Whole()
        if response is not None:
            of_other = np.einsum("ij,ik->ijk", share @ response.shares.toarray(), overlap.normal).reshape(n, -1)
            mobility += of_other @ np.diag(np.repeat(1.0 / response.mass, 3)) @ of_other.T
            approach += np.einsum("ij,ij->i", share @ response.shares.toarray() @ response.velocity, overlap.normal)
        else:
            turns = second.mobility_rows(second.place, -overlap.normal)
            mobility += turns @ turns.T
    ahead = overlap.depth + dt * approach
    whole = np.diag(1.0 / k) + dt**2 * mobility
    lower = np.linalg.cholesky(whole)
    exact, _ = nnls(lower.T, np.linalg.solve(lower, ahead))
    (found,) = NormalForces([block], dt, described, {}).solve()
    assert 2 < np.count_nonzero(exact) < n
    assert found.press == pytest.approx(exact, abs=0.02 * exact.max())
    assert found.after == pytest.approx(ahead - dt**2 * mobility @ found.press, abs=1e-12)
    again = NormalForces([block._replace(given=found.press)], dt, described, {}).solve()[0]
    assert again.press == pytest.approx(found.press, abs=2e-3 * exact.max())


def bar_on_wall(courant, n=16, gap=0.0, load=0.0, steps=None, drag=0.0, k=300.0):
    """Lumped bar of n elements, ρ = c = h = 1, that falls on a wall; the mean velocity that is left, its energy, the forces."""
    dt, mass = courant, np.r_[0.5, np.ones(n - 1), 0.5]
    u, v = np.full(n + 1, gap), np.full(n + 1, -0.01 if load == 0.0 else 0.0)
    shares, found, energy = np.eye(1, n + 1), [], 0.0
    for _ in range(steps or round(2.6 * n / dt)):
        strain = np.diff(u)
        force = np.r_[strain, 0.0] - np.r_[0.0, strain] - load * np.eye(1, n + 1, n)[0] - drag * mass * v
        free = v + dt * force / mass
        velocity = np.zeros((n + 1, 3))
        velocity[:, 2] = free
        one = Surface(Nodes(shares, mass, velocity), np.zeros((1, 3)))
        overlap = Overlap(one, np.zeros(1, int), -u[:1], np.array([[0.0, 0.0, 1.0]]), np.ones(1), np.zeros((1, 3)))
        (push,) = NormalForces([Block(overlap, np.array([k]), np.zeros(1))], dt, {id(one): Whole()}, {}).solve()
        before, v = v, free + dt * np.r_[push.press, np.zeros(n)] / mass
        energy = 0.5 * np.sum(mass * before * v) + 0.5 * np.sum(strain**2)
        u = u + dt * v
        found.append(push.press[0])
    return np.sum(mass * v) / np.sum(mass), energy, np.array(found), u


@pytest.mark.parametrize("courant", [0.2, 0.5, 0.9])
def test_a_bar_strikes_a_wall_as_its_waves_do(courant):
    """Exact: the force is ρ c v until the wave is back, then nothing, and the bar leaves with its velocity.

    The end node stops within a step, which takes its energy: 1/32 of that of the bar. Springs that explicit steps bear let the
    force swing by 5 to 190 % of itself, by the step and the place where the end comes to lie.
    """
    for gap in (0.0005, 0.0013, 0.0021):
        left, energy, force, _ = bar_on_wall(courant, gap=gap)
        moving = 0.5 * 16 * 0.01**2
        assert left == pytest.approx(0.01, rel=0.06)
        assert energy == pytest.approx(moving * (1.0 - 1.0 / 32), rel=0.02)
        there = force[round(4 / courant) : round(26 / courant)]
        assert there == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize("courant", [0.2, 0.5, 0.9])
def test_a_pressed_bar_gives_way_by_the_spring_alone(courant):
    *_, force, u = bar_on_wall(courant, n=2, load=0.01, steps=round(400 / courant), drag=0.2)
    assert force[-1] == pytest.approx(0.01, rel=1e-3)
    assert u[0] == pytest.approx(-0.01 / 300.0, rel=1e-2)
    assert u[-1] - u[0] == pytest.approx(-0.02, rel=1e-3)
