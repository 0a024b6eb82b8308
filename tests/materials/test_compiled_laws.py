"""Every law and equation of state compiles, and the compiled functions are the plain ones."""

import numpy as np
import pytest
from samples import INVISCID, RATES, SOLIDS, TISSUES, USERS, every_hyperelastic, fluid

from pellucid.jit import kernel
from pellucid.materials.law import (
    artificial_heating,
    cauchy_stress,
    diffusivity,
    dissipated_energy,
    energy,
    first_piola_kirchhoff,
    point_pressure,
    signal_speed,
    stored_energy,
    update,
    wave_speed,
)

CELL, DT = 0.01, 1e-3
SHOCKED = {"quadratic": 2.0, "linear": 1.0}
RHEOLOGIES = (
    {"kind": "carreau-yasuda", "zero_viscosity": 0.056, "infinite_viscosity": 0.0035, "time": 1.9, "exponent": 0.22},
    {"kind": "bingham", "plastic_viscosity": 1.0, "yield_stress": 2.0, "time": 100.0},
    {"kind": "casson", "plastic_viscosity": 1.0, "yield_stress": 2.0, "time": 100.0},
)
# each equation of state once, each energy update once: the combinations compile alike
LAWS = {
    **SOLIDS,
    **TISSUES,
    **USERS,
    **{name: fluid(name, viscosity=3.0, artificial_viscosity=SHOCKED) for name in INVISCID},
    "iterated": fluid("mie-gruneisen", viscosity=3.0, artificial_viscosity=SHOCKED, energy_update="iterated"),
    **{table["kind"]: fluid("tait", rheology=table) for table in RHEOLOGIES},
    "explicit": fluid("ideal-gas", viscosity=3.0, artificial_viscosity=SHOCKED, energy_update="explicit"),
}


def step(law, state, density, L, dt, cell):
    after = update(law, state, density, L, dt, cell)
    stored, pressure = stored_energy(law, after, density), point_pressure(law, after, density)
    heating, lost = artificial_heating(law, after, density, L, cell), dissipated_energy(law, after, density)
    speed = signal_speed(law, after, density, L, cell)
    return after, stored, pressure, heating, lost, speed, diffusivity(law, density)


def response(law, F):
    return energy(law, F), cauchy_stress(law, F), first_piola_kirchhoff(law, F), wave_speed(law, F)


compiled, compiled_response = kernel()(step), kernel()(response)


def flat(found):
    """All numbers of nested tuples."""
    return [x for item in found for x in flat(item)] if isinstance(found, tuple) else [float(found)]


@pytest.mark.parametrize("material", LAWS.values(), ids=LAWS)
def test_compiled_laws_are_the_plain_ones(material):
    law, state, density = material.law(), material.initial_state(), material.density
    for rate in (*RATES.values(), RATES["squeeze"]):
        density /= 1.0 + DT * (rate[0] + rate[4] + rate[8])
        arguments = (law, state, density, rate, DT, CELL)
        plain = step(*arguments)
        # fused multiplications round differently; a stiff liquid's pressure is a small difference of 1e9 Pa
        assert flat(compiled(*arguments)) == pytest.approx(flat(plain), rel=1e-9, abs=1e-5)
        state = plain[0]
    assert np.all(np.isfinite(flat(plain)))


@every_hyperelastic
def test_compiled_responses_are_the_plain_ones(material):
    law, F = material.law(), (1.2, 0.1, -0.2, 0.3, 0.9, 0.1, 0.0, -0.1, 1.1)
    assert flat(compiled_response(law, F)) == pytest.approx(flat(response(law, F)), rel=1e-12, abs=1e-9)
