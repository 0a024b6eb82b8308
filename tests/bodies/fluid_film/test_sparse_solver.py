import numpy as np
import pytest
from film_surfaces import loop, sphere

from pellucid.bodies.fluid_film.assembly import Assembly, ElementRows, rows
from pellucid.bodies.fluid_film.forces import Drag, FilmPhysics, Tension, forms, turning
from pellucid.bodies.fluid_film.solvers import Border, IncompatibleLoad, SparseSolver, System
from pellucid.jit import set_threads

TRIANGLES, PLACES = sphere(2)
SURFACE, X = loop((TRIANGLES, PLACES * (1.0, 0.9, 1.2)))
N = len(X)


def system(drag=0.0, x=X, known=None, seed=1, dilatational=2.0):
    physics = FilmPhysics(1.0, dilatational, 0.3, 0.0, Drag(drag, drag))
    o = SURFACE.operators(x)
    flat = np.zeros_like(o.area)
    parts = forms(o, physics, Tension(flat, flat), 0.01)
    random = np.random.default_rng(seed)
    force = random.normal(size=(N, 3))
    if drag == 0.0:
        motions = rigid(x)
        force -= (motions.T @ (motions @ force.ravel())).reshape(N, 3)
    area = np.bincount(TRIANGLES.ravel(), np.repeat(o.area.sum(axis=1) / 3.0, 3), N)
    known = np.zeros((N, 3), bool) if known is None else known
    velocity = np.where(known, 0.7, 0.0)
    guess = 0.1 * random.normal(size=(N, 3))
    free = turning(o) if drag == 0.0 else None
    return System(x, area, parts.resistance, parts.stiffness, force, force, guess, known, velocity, free, 1e-11), o


def rigid(x):
    motions = [np.tile(axis, (N, 1)) for axis in np.eye(3)] + [np.cross(axis, x) for axis in np.eye(3)]
    return np.linalg.qr(np.array(motions).reshape(6, -1).T)[0].T


def dense(squares):
    whole = np.zeros((3 * N, 3 * N))
    places = (3 * SURFACE.nodes[:, :, None] + np.arange(3)).reshape(len(TRIANGLES), -1)
    for square in (square.of_components(3) for square in squares):
        elements = np.einsum("er,era,erb->eab", square.factor, square.rows, square.rows)
        np.add.at(whole, (places[:, :, None], places[:, None, :]), elements)
    return whole


def volume_border(o, rate):
    row = np.zeros((N, 3))
    np.add.at(row, SURFACE.nodes, o.volume_rate().sum(axis=1))
    return Border(row, rate)


def solver():
    return SparseSolver(SURFACE.nodes, np.zeros((N, 3), bool), PLACES)


def test_matrices_and_sums_are_those_of_the_elements():
    s, _ = system(0.5)
    assembly = Assembly(SURFACE.nodes, N, 3)
    A, whole = assembly.matrix(s.resistance + s.stiffness), dense(s.resistance + s.stiffness)
    assert np.abs(A.toarray() - whole).max() < 1e-14 * np.abs(whole).max()
    assert np.abs((A - A.T).toarray()).max() < 1e-14 * np.abs(whole).max()
    v = np.random.default_rng(2).normal(size=(N, 3))
    felt = assembly.gathered(
        [ElementRows(f.rows, f.factor * assembly.rates(f, v)) for f in (r.of_components(3) for r in s.resistance)]
    )
    assert np.allclose(felt.ravel(), dense(s.resistance) @ v.ravel(), atol=1e-12)


def test_only_rigid_motions_meet_no_resistance():
    s, _ = system()
    values = np.linalg.eigvalsh(dense(s.resistance))
    assert np.all(np.abs(values[:6]) < 1e-13 * values[-1])
    assert values[6] > 1e-5 * values[-1]


@pytest.mark.parametrize("drag", [0.0, 0.5])
@pytest.mark.parametrize("held", [False, True])
def test_velocities_under_a_constraint(drag, held):
    s, o = system(drag)
    borders = [volume_border(o, 0.2)] if held else []
    found = solver().solve(s, borders)
    A, S = dense(s.resistance + s.stiffness), dense(s.stiffness)
    right = s.force.ravel() + S @ s.guess.ravel()
    sides = [border.row.ravel() for border in borders]
    goals = [border.rate for border in borders]
    if drag == 0.0:  # no mean velocity and rotation
        sides += list(rigid(X) * np.repeat(s.area, 3))
        goals += [0.0] * 6
    k = len(sides)
    sides = np.array(sides).reshape(k, 3 * N)
    whole = np.block([[A, sides.T], [sides, np.zeros((k, k))]])
    exact = np.linalg.solve(whole, np.concatenate([right, goals]))
    assert np.allclose(found.velocity.ravel(), exact[: 3 * N], atol=1e-9 * np.abs(exact[: 3 * N]).max())
    assert np.allclose(found.border_forces, -exact[3 * N : 3 * N + len(borders)], rtol=1e-7)


def test_known_components_are_kept_and_leave_some_motions_free():
    known = np.zeros((N, 3), bool)
    known[[0, 7, 30], 2] = True  # a film that can still go along x and y and turn about z
    s, _ = system(0.0, known=known)
    s = s._replace(force=s.force * 0.0, load=s.load * 0.0, guess=s.guess * 0.0)
    found = solver().solve(s, []).velocity
    assert np.all(found[known] == 0.7)
    assert np.allclose(found[:, 2], 0.7, atol=1e-8)  # rigidly


def test_a_load_that_drives_a_free_motion_is_refused():
    s, _ = system()
    with pytest.raises(IncompatibleLoad):
        solver().solve(s._replace(force=s.force + 1.0, load=s.load + 1.0), [])


def test_an_old_factor_serves_and_what_goes_on_from_a_checkpoint_is_the_same_to_the_last_bit():
    one = solver()
    s, o = system(seed=1)
    one.solve(s, [volume_border(o, 0.1)])
    kept = {name: array.copy() for name, array in one.state_arrays().items()}
    later, o = system(x=X * (1.01, 0.99, 1.0), seed=2)
    borders = [volume_border(o, 0.1)]
    on = one.solve(later, borders)
    assert np.array_equal(one.state_arrays()["factored"], kept["factored"])  # the factor was not renewed
    other = solver()
    other.restore(kept)
    again = other.solve(later, borders)
    assert np.array_equal(on.velocity, again.velocity)
    assert np.array_equal(on.border_forces, again.border_forces)
    fresh = solver().solve(later, borders)
    assert np.allclose(on.velocity, fresh.velocity, atol=1e-9 * np.abs(fresh.velocity).max())


def test_factors_are_in_double_precision_where_single_does_not_serve():
    s, _ = system(0.5, dilatational=1e8)
    s = s._replace(accuracy=1e-7)
    exact = np.linalg.solve(dense(s.resistance + s.stiffness), s.force.ravel() + dense(s.stiffness) @ s.guess.ravel())
    one = solver()
    found = one.solve(s, []).velocity
    assert found.ravel() == pytest.approx(exact, abs=1e-5 * np.abs(exact).max())
    assert one.state_arrays()["double"][0] == 1
    one = solver()
    one.solve(system(0.5)[0], [])
    assert one.state_arrays()["double"][0] == 0


def test_the_same_bits_on_any_number_of_threads():
    s, o = system()
    results = []
    try:
        for threads in (1, 2, 4):
            set_threads(threads)
            results.append(solver().solve(s, [volume_border(o, 0.1)]).velocity)
    finally:
        set_threads(None)
    assert np.array_equal(results[0], results[1])
    assert np.array_equal(results[0], results[2])


def test_rows_take_factors_of_fewer_dimensions():
    o = SURFACE.operators(X)
    found = rows(o.strain, o.area[..., None])
    assert found.rows.shape == (len(TRIANGLES), 9, 36)
    assert np.array_equal(found.factor[:, ::3], o.area)
