from typing import Literal, get_args

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from pellucid.references.solids import stretched

Form = Literal["coupled", "decoupled"]
YOUNG, POISSON = 3000.0, 0.49


def energy(form: Form, a: float, s: float) -> float:
    mu, lam = YOUNG / 2 / (1 + POISSON), YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
    trace, J = 2 * a**2 + s**2, a**2 * s
    if form == "coupled":
        return mu / 2 * (trace - 3) - mu * np.log(J) + lam / 2 * np.log(J) ** 2
    return mu / 2 * (J ** (-2 / 3) * trace - 3) + YOUNG / 6 / (1 - 2 * POISSON) * (J - 1) ** 2


@pytest.mark.parametrize("form", get_args(Form))
@pytest.mark.parametrize("stretch", [0.5, 0.8, 0.99, 1.3, 1.5])
def test_sides_are_free_where_the_energy_is_least(form: Form, stretch: float) -> None:
    least = minimize_scalar(lambda a: energy(form, a, stretch), bounds=(0.5, 1.6), method="bounded", options={"xatol": 1e-9})
    state = stretched(form, YOUNG, POISSON, stretch)
    assert state.lateral == pytest.approx(least.x, abs=1e-7)  # a minimum is flat: half the digits
    assert state.energy == pytest.approx(energy(form, state.lateral, stretch), rel=1e-12)


@pytest.mark.parametrize("form", get_args(Form))
def test_stress_is_the_slope_of_the_energy(form: Form) -> None:
    step = 1e-5
    above, below = (stretched(form, YOUNG, POISSON, 0.8 + side * step).energy for side in (1, -1))
    assert stretched(form, YOUNG, POISSON, 0.8).stress == pytest.approx((above - below) / (2 * step), rel=1e-8)


@pytest.mark.parametrize("form", get_args(Form))
def test_small_strains_are_hookes(form: Form) -> None:
    state = stretched(form, YOUNG, POISSON, 1.0 + 1e-6)
    assert state.stress == pytest.approx(YOUNG * 1e-6, rel=1e-5)
    assert state.lateral - 1.0 == pytest.approx(-POISSON * 1e-6, rel=1e-5)
