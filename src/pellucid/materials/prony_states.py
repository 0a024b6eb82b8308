"""States of points with a Prony series of one or more branches, and their update in a step.

Kernels need every component of a state and every branch written out, so the code is generated for each number of branches.
"""

from math import exp, expm1
from typing import Any, NamedTuple

from pellucid.jit import generic, point_function, pointwise
from pellucid.materials.law import Law, volumetric_stress
from pellucid.materials.point_state import PointState, point_state
from pellucid.tensors import Symmetric, Tensor, add, determinant, deviator, double_dot, rotate, scale

MOST = 6  # branches

Step = tuple[Tensor, Symmetric, Symmetric, Symmetric, float]
"""F̄, the isochoric deformation gradient of a step; change in the isochoric Kirchhoff stress of the hyperelastic solid [Pa];
strain rates at the start and end of the step [1/s]; duration of the step [s]."""


@generic
def relaxed(state: PointState, law: Law, F: Tensor, isochoric: Symmetric, step: Step) -> PointState:
    """Return the state of a point of a material with a Prony series after a step that ends at the deformation gradient F;
    isochoric: isochoric Kirchhoff stress of the hyperelastic solid at F [Pa]; step: data of the step, see `Step`."""


@generic
def overstress(state: PointState) -> Symmetric:
    """Return the sum Σ q of the overstresses of the branches [Pa]."""


@generic
def branch_energy(state: PointState) -> float:
    """Return the sum Σ Υ of the energies stored in the branches per unit mass [J/kg]."""


@pointwise
def branch(q: Symmetric, stored: float, share: float, time: float, rho0: float, step: Step) -> tuple[Symmetric, float, float]:
    """Return the overstress q [Pa] and the stored energy Υ per unit mass [J/kg] of a branch after a step, and the work per
    unit mass done on the branch in this step [J/kg].

    q, stored: overstress and stored energy before the step; share, time: share and relaxation time [s] of the branch; rho0:
    initial density [kg/m³]; step: data of the step, see `Step`.
    """
    carry, change, before, after, dt = step
    x = dt / time
    fade, mean = exp(-x), (-expm1(-x) / x if x > 0.0 else 1.0)
    new = add(scale(fade, rotate(carry, q)), scale(share * mean, change))
    work = 0.5 * dt * (double_dot(deviator(q), before) + double_dot(deviator(new), after)) / rho0
    return new, fade * stored + mean * work, work


@pointwise
def total_stress(law: Any, J: float, isochoric: Symmetric, q: Symmetric) -> Symmetric:
    """Return the Cauchy stress σ [Pa] at the volume ratio J, from the isochoric Kirchhoff stress of the hyperelastic solid
    [Pa] and the sum of the overstresses, q = Σ q_k [Pa]; law: parameters of the material."""
    s = scale(1.0 / J, add(isochoric, deviator(q)))
    mean = volumetric_stress(law.elastic, J)
    return (s[0] + mean, s[1] + mean, s[2] + mean, s[3], s[4], s[5])


STATE = """
class {name}(NamedTuple):
    stress: Symmetric
    deformation_gradient: Tensor
    dissipated_energy: float
    {energies}
    {stresses}


def relaxed(state, law, F, isochoric, step):
    {steps}
    return {name}(total_stress(law, determinant(F), isochoric, {sum_q}), F, state.dissipated_energy + {lost}, {all_u}, {all_q})


def overstress(state):
    return {overstress}


def branch_energy(state):
    return {energy}
"""
"""Source template of a state with n branches: kernels need every component and every branch written out."""


def _state(n: int) -> Any:
    """Declare and return the class for the states of points of a law with n branches (terms of the Prony series)."""
    numbers = range(1, n + 1)
    name = f"PronyState{n}"
    own = {f"overstress_energy_{k}": ("J/kg", f"energy that branch {k} of the Prony series stores") for k in numbers}
    own |= {f"overstress_{k}": ("Pa", f"Kirchhoff overstress of branch {k} of the Prony series") for k in numbers}
    source = STATE.format(
        name=name,
        energies="\n    ".join(f"overstress_energy_{k}: float" for k in numbers),
        stresses="\n    ".join(f"overstress_{k}: Symmetric" for k in numbers),
        steps="\n    ".join(
            f"q{k}, u{k}, w{k} = branch(state.overstress_{k}, state.overstress_energy_{k}, law.shares[{k - 1}], "
            f"law.times[{k - 1}], law.rho0, step)"
            for k in numbers
        ),
        sum_q=_nested([f"q{k}" for k in numbers]),
        lost=" + ".join(f"(w{k} + state.overstress_energy_{k} - u{k})" for k in numbers),
        all_u=", ".join(f"u{k}" for k in numbers),
        all_q=", ".join(f"q{k}" for k in numbers),
        overstress=_nested([f"state.overstress_{k}" for k in numbers]),
        energy=" + ".join(f"state.overstress_energy_{k}" for k in numbers),
    )
    names: dict[str, Any] = {given.__name__: given for given in (NamedTuple, add, branch, determinant, total_stress)} | {
        "Symmetric": Symmetric,
        "Tensor": Tensor,
        "__name__": __name__,
    }
    exec(source, names)
    state = point_state(**own)(names[name])
    for operation in (relaxed, overstress, branch_energy):
        point_function(operation, state)(names[operation.__name__])
    return state


def _nested(terms: list[str]) -> str:
    """Return source text that adds the tensors in `terms`, which are source texts too, by nested calls of the function
    `add`."""
    return terms[0] if len(terms) == 1 else f"add({terms[0]}, {_nested(terms[1:])})"


STATES: dict[int, Any] = {n: _state(n) for n in range(1, MOST + 1)}
"""Types of states, by the number of branches."""
