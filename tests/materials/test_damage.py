"""Elastodamage of membranes: softening, unloading, failure, what is dissipated."""

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.materials.damage import DamageCase, DamageRecord, Undamaged, dissipate, has_failed, stiffness, weaken
from pellucid.materials.linear_membrane import LinearMembraneMaterial
from pellucid.materials.membrane import initial_shape, largest_strain, plane_response, stretched
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembraneMaterial

ZONA = {"elastic_limit": 0.05937, "stiffness_loss": 10.0, "rate": 10.0, "failure_strain": 0.06}
ELASTIC = {"density": 1100.0, "young_modulus": 17.9e3, "poisson_ratio": 0.49}
LAWS = {
    "linear": LinearMembraneMaterial(**ELASTIC, damage=ZONA),
    "neo-hookean": NeoHookeanMembraneMaterial(**ELASTIC, damage=ZONA),
}


def law(**changes):
    return DamageCase(**(ZONA | changes)).law()


def record():
    return DamageRecord(*(np.zeros(1) for _ in DamageRecord._fields))


def test_stiffness_is_never_negative_and_only_falls():
    values = [stiffness(law(), w) for w in np.concatenate([np.linspace(0.0, 0.02, 2001), np.logspace(-2, 3, 50)])]
    assert values[0] == 1.0
    assert min(values) == 0.0
    assert np.all(np.diff(values[:2001]) <= 0.0)


def test_the_zona_is_without_stiffness_just_before_it_fails():
    """S_L (1 - ln(1 - 1/c₀)/c₁) = 0.0599955: the factor 2 that the paper prints would give 0.0596745."""
    none = 0.05937 * (1.0 - np.log(1.0 - 1.0 / 10.0) / 10.0)
    assert none == pytest.approx(0.0599955, abs=5e-8)
    # the slope there is -c₁ (c₀ - 1)/S_L = -1516
    assert weaken(law(), record(), 0, none - 1e-9)[0] == pytest.approx(1516e-9, rel=1e-3)
    assert weaken(law(), record(), 0, none + 1e-9)[0] == 0.0


def test_no_damage_below_the_elastic_limit():
    state = record()
    for strain in (-1.0, 0.0, 0.05, 0.05937):
        assert weaken(law(), state, 0, strain) == (1.0, 1.0)
    assert state.damage[0] == 0.0


def test_the_strain_stays_on_the_damage_surface_and_damage_never_falls():
    """ε_max - S_L (1 + ω) ≤ 0, with equality where ω grows."""
    state, S = record(), 0.05937
    reached = 0.0
    for strain in 0.0594 + 5e-4 * np.sin(np.linspace(0.0, 30.0, 400)):
        before = state.damage[0]
        weaken(law(), state, 0, strain)
        reached = max(reached, strain)
        assert state.damage[0] >= before
        assert strain - S * (1.0 + state.damage[0]) <= 1e-16
        assert state.damage[0] == pytest.approx(max(reached / S - 1.0, 0.0), abs=1e-14)


def test_unloading_follows_the_secant():
    state = record()
    left, kept = weaken(law(), state, 0, 0.0597)
    assert 0.0 < left < 1.0
    assert kept == left
    for strain in (0.04, 0.0, -0.02, 0.0597):
        assert weaken(law(), state, 0, strain) == (left, 1.0)


def test_failure_is_for_good():
    state = record()
    assert not has_failed(law(), state, 0)
    weaken(law(), state, 0, 0.06)
    assert not has_failed(law(), state, 0), "beyond the failure strain, not at it"
    assert weaken(law(), state, 0, 0.060001) == (0.0, 0.0)
    assert has_failed(law(), state, 0)
    weaken(law(), state, 0, 0.0)
    assert has_failed(law(), state, 0)


def test_a_law_that_keeps_some_stiffness_loses_it_at_failure():
    tough = law(stiffness_loss=0.5, failure_strain=0.5)
    assert weaken(tough, record(), 0, 0.49)[0] == pytest.approx(0.5, abs=1e-9)
    assert weaken(tough, record(), 0, 0.51)[0] == 0.0


@pytest.mark.parametrize("material", LAWS.values(), ids=LAWS)
def test_work_is_what_can_be_had_back_and_what_damage_took(material):
    """Pulled along one axis to failure: dissipated energy is -∫ dk W, and all of the work at last."""
    elastic, damage = material.law(1.0), law(rate=1.0, stiffness_loss=0.9, failure_strain=0.2)
    state, shape, old, work, elastic_work, expected, whole = record(), initial_shape(elastic), 0.0, 0.0, 0.0, 0.0, 1.0
    steps, D = 20_000, (1.0, 0.0, 0.0)
    dt = 0.19 / steps
    for _ in range(steps):
        shape = stretched(elastic, shape, D, dt)
        left, kept = weaken(damage, state, 0, largest_strain(elastic, shape))
        stress = plane_response(elastic, shape)[0]
        # per unit of current mass at a density that stays: what is compared is the split, not the work itself
        elastic_work += dt * stress
        work += 0.5 * dt * (old + left * stress)
        old = left * stress
        dissipate(damage, state, 0, work, kept)
        expected += (whole - left) * elastic_work
        whole = left
    assert 0.0 < left < 1.0
    # all sums are of the first order in the step or better
    assert state.dissipated_energy[0] == pytest.approx(expected, rel=1e-3)
    assert work - state.dissipated_energy[0] == pytest.approx(left * elastic_work, rel=1e-3)
    _, kept = weaken(damage, state, 0, 0.21)
    dissipate(damage, state, 0, work, kept)
    assert state.dissipated_energy[0] == work


@pytest.mark.parametrize("seed", range(4))
def test_the_largest_strain_is_the_principal_one(seed):
    numbers = np.random.default_rng(seed)
    a, b, c = numbers.uniform(-0.05, 0.05, 3)
    found = largest_strain(LAWS["linear"].law(1.0), (a, b, c, 0.0))
    assert found == pytest.approx(np.linalg.eigvalsh([[a, c], [c, b]])[-1], abs=1e-15)
    F = np.eye(2) + numbers.uniform(-0.4, 0.4, (2, 2))
    found = largest_strain(LAWS["neo-hookean"].law(1.0), tuple(F.ravel()))
    assert found == pytest.approx(np.log(np.linalg.svd(F, compute_uv=False)[0]), abs=1e-14)


def test_without_damage_nothing_changes():
    material = LinearMembraneMaterial(**ELASTIC)
    assert material.damage_law() == Undamaged()
    assert weaken(Undamaged(), record(), 0, 1e9) == (1.0, 1.0)
    assert not has_failed(Undamaged(), record(), 0)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"failure_strain": 0.05}, "failure_strain = 0.05 is not above elastic_limit = 0.05937"),
        ({"elastic_limit": 0.0}, "greater than 0"),
        ({"stiffness_loss": -1.0}, "greater than 0"),
        ({"rate": 0.0}, "greater than 0"),
    ],
)
def test_impossible_parameters(changes, text):
    with pytest.raises(ValidationError, match=text):
        DamageCase(**(ZONA | changes))
