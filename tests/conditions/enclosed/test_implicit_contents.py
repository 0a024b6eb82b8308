"""Contents of membranes whose pressure is solved for together with the implicit pressure of the liquid around them."""

import numpy as np
import pytest
from small_cases import SLIP, advance, assert_resumes, assert_same_arrays, box, case, copied_state, finished

from pellucid.conditions.enclosed.active import ActiveEnclosed
from pellucid.simulation.simulation import Simulation

SYRUP = {"kind": "fluid", "density": 0.01, "viscosity": 1.0, "implicit_pressure": True}
SYRUP |= {"eos": {"kind": "tait", "sound_speed": 100.0, "carries_tension": True}}  # ρc² = 100
SOFT = {
    "name": "capsule",
    "kind": "membrane-elements",
    "surface": {"icosphere": {"centre": [0.5, 0.5, 0.5], "radius": 0.3, "refinements": 3}},
    "thickness": 0.001,
    "material": {"kind": "surface-neo-hookean-membrane", "density": 1.0, "shear_modulus": 0.01},
}


def in_syrup(modulus, pressure=1.0, threads=1, **more):
    """A soft capsule in a closed box of liquid with implicit pressure; a liquid in it presses outwards at the start."""
    contents = {"name": "drop", "body": "capsule"}
    contents |= {"liquid": {"bulk_modulus": modulus, "density": 0.01, "pressure": pressure}}
    cube = box((0, 0, 0), (1, 1, 1), SYRUP, (2, 2, 2))
    how = {"counts": (8, 8, 8), "cell": 0.125, "functions": "quadratic-bspline", "scheme": "usl", "transfer": "flip"}
    how |= {"support": SLIP, "enclosed": [contents], "step": 0.005, "end": 0.1}
    how |= {"energy": {"warn": 1.0, "stop": 2.0}}  # the pressure starts with a jump, whose energy implicit Euler loses
    return Simulation(case(cube, SOFT, **how | more), threads=threads)


@pytest.mark.parametrize("modulus", [100.0, 900.0])
def test_with_an_implicit_pressure_contents_stiffen_the_liquid_without_a_limit_of_the_step(modulus):
    """In equilibrium the pressure of the contents, p₀ - K ε for the growth ε of the volume V, compresses the liquid outside
    and stretches that inside: p₀ = ε (K + ρc² (1 + V/(1 - V))). The layer of cells in which the liquid sees both sides changes
    the second term by a share of its width over the radius."""
    sim = in_syrup(modulus)
    (contents,) = sim.parts.of(ActiveEnclosed)
    start, explicit = (
        contents._now.volume,
        0.5 * np.sqrt(modulus / contents._now.volume * contents._space.mobility(contents._now)),
    )
    assert sim.step_limit()[0].step > 5.0 / explicit
    finished(sim)
    growth = contents._now.volume / start - 1.0
    resists = 1.0 / growth - modulus
    assert resists == pytest.approx(100.0 / (1.0 - start), rel=0.2)
    assert contents.contents.pressure(contents._now.volume) == pytest.approx(1.0 - modulus * growth, rel=0.01)
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_an_implicit_pressure_of_contents_has_the_same_bits_on_threads_and_after_a_checkpoint():
    one, two = (advance(in_syrup(900.0, threads=threads), 4) for threads in (1, 2))
    assert_same_arrays(copied_state(one), copied_state(two))
    assert_resumes(in_syrup(900.0), in_syrup(900.0), 4, 3)
