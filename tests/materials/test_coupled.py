"""Laws that state W(I₁, I₂, J) alone: derived functions against those written by hand, and bounds that are close."""

from typing import NamedTuple

import numpy as np
import pytest
from algebra import tensor
from samples import USERS
from test_hyperelastic import acoustic_speed, directions_of, gradient

from pellucid.jit import point_function
from pellucid.jit.elementary import log
from pellucid.materials.hyperelastic import hyperelastic
from pellucid.materials.law import cauchy_stress, coupled_energy, energy, wave_speed
from pellucid.materials.neo_hookean import NeoHookean
from pellucid.tensors import IDENTITY, largest_row_sum, left_cauchy_green


@hyperelastic
class ByEnergy(NamedTuple):
    lam: float
    mu: float
    rho0: float


@point_function(coupled_energy, ByEnergy)
def _energy(law, first, second, J):
    return 0.5 * law.mu * first - law.mu * log(J) + 0.5 * law.lam * log(J) * log(J)


@pytest.mark.parametrize("seed", range(6))
def test_derived_functions_equal_those_written_by_hand(seed):
    """The neo-Hookean law of the package, where its bound does not cut off a negative stiffness."""
    F, values = tensor(gradient(seed)), (5e4, 6e3, 1100.0)
    derived, by_hand = ByEnergy(*values), NeoHookean(*values)
    assert energy(derived, F) == pytest.approx(energy(by_hand, F), rel=1e-12)
    assert cauchy_stress(derived, F) == pytest.approx(cauchy_stress(by_hand, F), abs=1e-12 * 5e4)
    assert wave_speed(derived, F) == pytest.approx(wave_speed(by_hand, F), rel=1e-12)
    assert largest_row_sum(left_cauchy_green(F)) > 0.0


@pytest.mark.parametrize(("name", "most"), [("ciarlet-geymonat", 1.25), ("foam", 1.25)])
def test_bounds_of_the_wave_speed_are_close(name, most):
    """At stretches from 0.8 to 1.2; a bound that is too high would only shorten the steps."""
    law = USERS[name].law()
    for seed in range(8):
        F = gradient(seed, 0.2)
        fastest = acoustic_speed(law, F, directions_of(F))
        assert fastest <= wave_speed(law, tensor(F)) * (1.0 + 1e-7) <= most * fastest


def test_moduli_at_rest_are_those_of_the_parameters():
    """λ + 2μ and μ from the energy of `foam` and of Ciarlet and Geymonat, whose μ is 2 (c₁ + c₂) and λ + 4 c₂ at rest."""
    foam, other = USERS["foam"], USERS["ciarlet-geymonat"]
    for material, mu, lam in ((foam, foam.mu, foam.lam), (other, 2.0 * (other.c1 + other.c2), other.lam + 4.0 * other.c2)):
        assert material.moduli() == pytest.approx((mu, lam + 2.0 / 3.0 * mu), rel=1e-12)
        assert wave_speed(material.law(), IDENTITY) == pytest.approx(np.sqrt((lam + 2.0 * mu) / material.density), rel=1e-12)
