"""What only numba finds in a law of a user: told with the function and its line."""

import linecache
from typing import Literal, NamedTuple

import numba
import numpy as np
import pytest
from small_cases import SOLID, box, case

from pellucid.compilation.reporting import laws_blamed, why_not_compiled
from pellucid.errors import CaseError
from pellucid.jit import implementation_of, point_function
from pellucid.materials.hyperelastic import hyperelastic
from pellucid.materials.law import cauchy_stress, energy, signal_speed, wave_speed
from pellucid.materials.neo_hookean import NeoHookean, NeoHookeanMaterial

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


@hyperelastic
class Noted(NamedTuple):
    lam: float
    mu: float
    rho0: float


for operation in (energy, cauchy_stress, wave_speed):
    point_function(operation, Noted)(implementation_of(operation, NeoHookean))


@point_function(signal_speed, Noted)
def _signal_speed(law, state, density, L, length):
    return float(f"{law.mu:.3f}")  # plain Python can


class NotedMaterial(NeoHookeanMaterial):
    kind: Literal["noted"] = "noted"

    def law(self):
        return Noted(1.0, 1.0, 1.0)


def test_the_function_and_its_line_are_named():
    material = NotedMaterial(density=1.0, young_modulus=1.0, poisson_ratio=0.3)
    line = _signal_speed.__code__.co_firstlineno + 2
    why = why_not_compiled(material)
    assert why.startswith("`signal_speed` of the law Noted cannot be compiled: ")
    assert why.endswith(f"at {__file__}:{line} (`{linecache.getline(__file__, line).strip()}`)")


@pytest.fixture
def making_an_array():
    mine = implementation_of(signal_speed, Noted)

    @point_function(signal_speed, Noted)
    def _speed(law, state, density, L, length):
        speeds = np.zeros(2)
        speeds[0] = law.mu
        return speeds[0]

    yield _speed.__code__.co_firstlineno + 2
    point_function(signal_speed, Noted)(mine)


def test_arrays_that_a_law_makes_are_told_with_their_line(making_an_array):
    why = why_not_compiled(NotedMaterial(density=1.0, young_modulus=1.0, poisson_ratio=0.3))
    assert "\x1b" not in why
    assert why.endswith(f"zeros>) found for signature, at {__file__}:{making_an_array} (`speeds = np.zeros(2)`)")


def test_laws_that_compile_are_not_blamed():
    built = case(box((1, 1, 1), (3, 3, 3), SOLID))
    assert why_not_compiled(built.body[0].material) == ""
    with pytest.raises(numba.TypingError, match="of our own"), laws_blamed(built):
        raise numba.TypingError("of our own")


def test_a_run_that_cannot_be_compiled_is_an_error_of_its_material():
    built = case(box((1, 1, 1), (3, 3, 3), SOLID))
    material = NotedMaterial(density=1.0, young_modulus=1.0, poisson_ratio=0.3)
    body = built.body[0].model_copy(update={"material": material})
    blamed = laws_blamed(built.model_copy(update={"body": (body,)}))
    with pytest.raises(CaseError, match="`signal_speed` of the law Noted cannot be compiled") as refused, blamed:
        raise numba.TypingError("deep inside")
    assert refused.value.problems[0].key == f"body.{body.name}.material"
