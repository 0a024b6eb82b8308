"""Prony series: relaxation, slow and fast strain, oscillation, and what branches store and dissipate."""

import numpy as np
import pytest
from algebra import matrix, rotation, tensor
from pydantic import ValidationError
from samples import BRANCHES, DECOUPLED, SPECIAL, TISSUE, material_of

from pellucid.materials.law import (
    cauchy_stress,
    dissipated_energy,
    energy,
    isochoric_energy,
    isochoric_stress,
    signal_speed,
    stored_energy,
    update,
)
from pellucid.materials.prony_states import MOST, branch_energy, overstress
from pellucid.tensors import IDENTITY

STILL = (0.0,) * 9
RHO = 1100.0


def series(branches=BRANCHES, elastic=DECOUPLED):
    return material_of("prony", {"density": RHO, "elastic": elastic, "branches": branches})


ELASTIC = {"decoupled-neo-hookean": DECOUPLED, "ogden": {"kind": "ogden", **SPECIAL["ogden"]}, "tissue": TISSUE}
every_elastic = pytest.mark.parametrize("elastic", ELASTIC.values(), ids=ELASTIC)


def moved(material, path, dt, state=None, start=None):
    """The states after steps along a path of deformation gradients."""
    state, before = state or material.initial_state(), np.eye(3) if start is None else start
    law, states = material.law(), []
    for F in path:
        L = (F @ np.linalg.inv(before) - np.eye(3)) / dt
        state = update(law, state, RHO / np.linalg.det(F), tensor(L), dt, 0.01)
        states.append(state)
        before = F
    return states


def extension(stretch):
    """A stretch that keeps the volume."""
    return np.diag([stretch, stretch**-0.5, stretch**-0.5])


@every_elastic
@pytest.mark.parametrize("steps", [1, 50])
def test_relaxation_after_a_sudden_large_strain(elastic, steps):
    """The isochoric stress falls as 1 + Σ β exp(-t/τ) times that at rest, the pressure stays: exactly, in steps of any size."""
    material = series(elastic=elastic)
    F = rotation(2) @ np.diag([1.7, 0.6, 1.1]) @ rotation(3)
    law = material.law()
    rest = np.array(cauchy_stress(law.elastic, tensor(F)))
    isochoric = np.array(isochoric_stress(law.elastic, tensor(F))) / np.linalg.det(F)
    state, time = moved(material, [F], 1e-9)[-1], 0.7
    for _ in range(steps):
        state = update(law, state, RHO, STILL, time / steps, 0.01)
    share = sum(b["share"] * np.exp(-time / b["relaxation_time"]) for b in BRANCHES)
    # the sudden step takes 1e-9 s: 5e-8 of the shorter relaxation time
    assert np.array(state.stress) == pytest.approx(rest + share * isochoric, abs=1e-7 * abs(rest).max())


def test_what_a_sudden_strain_stores_is_lost_while_the_stress_relaxes():
    """Σ β W_iso at first, then Σ β W_iso exp(-t/τ); the rest is dissipated, and none of the strain energy at rest."""
    material = series()
    law, F = material.law(), extension(1.8)
    path = [extension(stretch) for stretch in np.linspace(1.0, 1.8, 2001)[1:]]
    state = moved(material, path, 1e-12)[-1]
    W = isochoric_energy(law.elastic, tensor(F)) / RHO
    # trapezoids of 2000 steps
    assert branch_energy(state) == pytest.approx(0.7 * W, rel=1e-6)
    lost = [dissipated_energy(law, state, RHO)]
    total = branch_energy(state) + lost[0]
    assert lost[0] == pytest.approx(0.0, abs=1e-4 * W)
    for k in range(1, 21):
        state = update(law, state, RHO, STILL, 0.05, 0.01)
        left = sum(b["share"] * np.exp(-0.05 * k / b["relaxation_time"]) for b in BRANCHES)
        assert branch_energy(state) == pytest.approx(left * W, rel=1e-6)
        lost.append(dissipated_energy(law, state, RHO))
        assert branch_energy(state) + lost[-1] == pytest.approx(total, rel=1e-13)
        assert stored_energy(law, state, RHO) == pytest.approx(energy(law.elastic, tensor(F)) / RHO + left * W, rel=1e-6)
    assert np.all(np.diff(lost) > 0.0)


STRETCH = (lambda t: 1.0 + 0.6 * np.sin(3.0 * t) ** 2, 0.9)  # there and some of the way back


def reference(share, tau, time, mu):
    """Overstress difference q₁ - q₃ [Pa] and Υ [J/m³] of a branch of a neo-Hookean solid along STRETCH, by quadrature in the
    reference configuration: Q = β ∫ exp(-(t-s)/τ) dS, and the mean of the energies of the past."""
    from scipy.integrate import quad

    def stress(stretch):  # of S, along the pull and across it
        C = np.array([stretch**2, 1.0 / stretch])
        return mu * (1.0 - (C[0] + 2.0 * C[1]) / 3.0 / C)

    def energy_above(one, other):  # W(C) - W(C_s) - ½ S_s : (C - C_s)
        C, past = (np.array([x**2, 1.0 / x, 1.0 / x]) for x in (one, other))
        S = stress(other)[[0, 1, 1]]
        return 0.5 * mu * (C.sum() - past.sum()) - 0.5 * S @ (C - past)

    path, now = STRETCH[0], STRETCH[0](time)
    options = {"epsabs": 1e-9 * mu, "epsrel": 1e-10, "limit": 200}
    past = [quad(lambda s, k=k: np.exp((s - time) / tau) / tau * stress(path(s))[k], 0.0, time, **options)[0] for k in (0, 1)]
    Q = share * (stress(now) - past)  # at rest before: S = 0
    C = np.array([now**2, 1.0 / now])
    before = np.exp(-time / tau) * energy_above(now, 1.0)
    rest = quad(lambda s: np.exp((s - time) / tau) / tau * energy_above(now, path(s)), 0.0, time, **options)[0]
    return C[0] * Q[0] - C[1] * Q[1], share * (before + rest)


def test_overstress_and_energy_along_a_large_strain_and_their_order():
    path, time = STRETCH
    material = series(BRANCHES[:1])
    mu = material.elastic.moduli()[0]
    exact = reference(0.4, 0.5, time, mu)
    errors = []
    for steps in (50, 100, 200):
        dt = time / steps
        state = moved(material, [extension(path(dt * k)) for k in range(1, steps + 1)], dt)[-1]
        q = overstress(state)
        errors.append([q[0] - q[2] - exact[0], branch_energy(state) * RHO - exact[1]])
    errors = abs(np.array(errors)) / np.abs(exact)
    assert errors[-1].max() < 2e-4
    order = np.log2(errors[:-1] / errors[1:])
    assert order == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("elastic", [DECOUPLED, ELASTIC["ogden"]])
def test_nothing_is_won_along_any_path(elastic):
    """What is dissipated never falls by more than the error of a step, and is never below 0."""
    material = series(elastic=elastic)
    law, state = material.law(), material.initial_state()
    numbers = np.random.default_rng(5)
    F, lost = np.eye(3), [0.0]
    for _ in range(40):
        L = numbers.uniform(-12.0, 12.0, (3, 3))
        L -= np.trace(L) / 3.0 * np.eye(3)
        L += 4.0 * (np.linalg.inv(F) - np.eye(3))  # back towards rest
        for _ in range(20):
            F = (np.eye(3) + 1e-3 * L) @ F
            state = update(law, state, RHO, tensor(L), 1e-3, 0.01)
            lost.append(dissipated_energy(law, state, RHO))
            assert branch_energy(state) > 0.0
    assert np.diff(lost).min() > -1e-3 * np.diff(lost).max()
    assert lost[-1] > 0.0


def test_a_steady_small_oscillation():
    """G' = G (1 + Σ β ω²τ²/(1+ω²τ²)), G'' = G Σ β ωτ/(1+ω²τ²); a cycle loses π G'' γ₀²."""
    material, amplitude, steps, cycles, omega = series(), 1e-4, 2000, 8, 4.0
    law, G = material.law(), material.elastic.moduli()[0]
    dt = 2.0 * np.pi / omega / steps
    time = dt * np.arange(cycles * steps + 1)
    state, states = material.initial_state(), []
    for rate in np.diff(amplitude * np.sin(omega * time)) / dt:
        L = (0.0, 0.5 * rate, 0.0, 0.5 * rate, 0.0, 0.0, 0.0, 0.0, 0.0)
        state = update(law, state, RHO, L, dt, 0.01)
        states.append(state)
    last, phase = np.array([state.stress[5] for state in states[-steps:]]), omega * time[-steps:]
    storage, loss = 2.0 / steps * last @ np.sin(phase), 2.0 / steps * last @ np.cos(phase)
    terms = [(b["share"], omega * b["relaxation_time"]) for b in BRANCHES]
    expected = (
        G * (1.0 + sum(beta * x * x / (1.0 + x * x) for beta, x in terms)),
        G * sum(beta * x / (1.0 + x * x) for beta, x in terms),
    )
    # strain follows its sine by chords, 1e-6, and the start has faded to exp(-2π 7/(ωτ)), 3e-10
    assert storage == pytest.approx(expected[0] * amplitude, rel=1e-5)
    assert loss == pytest.approx(expected[1] * amplitude, rel=1e-4)
    lost = dissipated_energy(law, states[-1], RHO) - dissipated_energy(law, states[-steps - 1], RHO)
    assert lost == pytest.approx(np.pi * expected[1] * amplitude**2 / RHO, rel=1e-4)


def test_slow_strain_is_elastic_and_fast_strain_stiffer():
    material = series()
    law = material.law()
    for duration, factor in ((1e4, 1.0), (1e-6, 1.7)):
        path = [extension(stretch) for stretch in np.linspace(1.0, 1.5, 201)[1:]]
        state = moved(material, path, duration / 200)[-1]
        rest = np.array(cauchy_stress(law.elastic, state.deformation_gradient))
        # τ over the duration, and the duration over τ
        assert np.array(state.stress) == pytest.approx(factor * rest, rel=2e-4, abs=2e-4 * abs(rest).max())


@pytest.mark.parametrize("seed", range(4))
def test_signals_are_no_slower_than_waves_about_a_strained_state(seed):
    """From differences of the first Piola stress over no time, after a large strain and some relaxation."""
    material = series(elastic=ELASTIC["ogden"])
    law, step = material.law(), 1e-6
    F = np.eye(3) + np.random.default_rng(seed).uniform(-0.4, 0.4, (3, 3))
    state = moved(material, [F], 0.01)[-1]
    state = update(law, state, RHO, STILL, 0.05, 0.01)
    density, fastest = RHO / np.linalg.det(F), 0.0

    def traction(m, n, sign):
        L = sign * np.outer(m, n)
        now = np.eye(3) + step * L
        stress = update(law, state, density / np.linalg.det(now), tensor(L / 1e-9 * step), 1e-9, 0.01).stress
        return np.linalg.det(now) * matrix(stress) @ np.linalg.inv(now).T @ n

    for k in range(20):
        n = rotation(k)[0]
        acoustic = np.array([(traction(m, n, 1.0) - traction(m, n, -1.0)) / (2.0 * step) for m in np.eye(3)])
        fastest = max(fastest, np.linalg.eigvals(acoustic).real.max() / density)
    found = signal_speed(law, state, density, STILL, 0.01)
    assert np.sqrt(fastest) <= found * (1.0 + 1e-6)
    assert found < 1.6 * np.sqrt(fastest)


def test_the_wave_speeds_are_those_of_a_sudden_load():
    material = series()
    mu, kappa = material.elastic.moduli()
    assert material.wave_speeds() == pytest.approx(
        (np.sqrt((kappa + 4.0 / 3.0 * 1.7 * mu) / RHO), np.sqrt(1.7 * mu / RHO)), rel=1e-12
    )
    assert signal_speed(material.law(), material.initial_state(), RHO, STILL, 0.01) == material.wave_speeds()[0]


@pytest.mark.parametrize("n", range(1, MOST + 1))
def test_any_number_of_branches(n):
    """Equal branches are one with the sum of their shares."""
    many, one = series([{"share": 0.6 / n, "relaxation_time": 0.2}] * n), series([{"share": 0.6, "relaxation_time": 0.2}])
    path = [extension(1.0 + 0.05 * k) for k in range(1, 11)]
    found, expected = moved(many, path, 0.05)[-1], moved(one, path, 0.05)[-1]
    assert found.stress == pytest.approx(expected.stress, rel=1e-12, abs=1e-9)
    assert found.dissipated_energy == pytest.approx(expected.dissipated_energy, rel=1e-12)
    assert branch_energy(found) == pytest.approx(branch_energy(expected), rel=1e-12)
    assert found._fields[3 + n :] == tuple(f"overstress_{k}" for k in range(1, n + 1))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"branches": []}, "at least 1 item"),
        ({"branches": [{"share": 0.1, "relaxation_time": 1.0}] * (MOST + 1)}, "at most 6 items"),
        ({"branches": [{"share": 0.0, "relaxation_time": 1.0}]}, "greater than 0"),
        ({"branches": [{"share": 0.1, "relaxation_time": 0.0}]}, "greater than 0"),
        (
            {"elastic": {"kind": "neo-hookean", "young_modulus": 1.0, "poisson_ratio": 0.3}},
            "'neo-hookean'.*expected.*'decoupled-neo-hookean', 'mooney-rivlin', 'ogden', 'holzapfel-gasser-ogden'",
        ),
    ],
)
def test_impossible_parameters(changes, words):
    with pytest.raises(ValidationError, match=words):
        material_of("prony", {"density": RHO, "elastic": DECOUPLED, "branches": BRANCHES} | changes)


def test_at_rest_nothing_changes():
    material = series()
    state = update(material.law(), material.initial_state(), RHO, STILL, 0.0, 0.01)
    assert state == material.initial_state()
    assert energy(material.law().elastic, IDENTITY) == 0.0
