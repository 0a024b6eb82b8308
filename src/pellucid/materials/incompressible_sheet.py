"""Incompressible sheets, with the thickness λ₃ = 1/(λ₁λ₂) eliminated, including laws W = f(I - 3) of the first invariant.

I = λ₁² + λ₂² + 1/(λ₁λ₂)². A strip with free sides has the width λ^(-½) at the stretch λ, since neither its sides nor its
faces carry stress.
"""

from math import sqrt

from pellucid.jit import generic, point_function, pointwise
from pellucid.materials.law import Law, LawType
from pellucid.materials.surface_law import stretch_curvatures, stretch_energy, stretch_slopes
from pellucid.materials.wrinkling import natural_width


@generic
def of_first_invariant(law: Law, excess: float) -> tuple[float, float, float]:
    """Return the energy f per unit initial area [J/m²] of an incompressible sheet, and the derivatives f' and f'' with
    respect to the first invariant I = a² + b² + 1/(ab)² for the principal stretches a and b [N/m]; excess: I - 3."""


def incompressible(law: type[LawType]) -> type[LawType]:
    """Class decorator: mark a law as incompressible, so that the width of a strip with free sides follows from constant
    volume."""
    point_function(natural_width, law)(_natural_width)
    return law


def invariant_based(law: type[LawType]) -> type[LawType]:
    """Class decorator for an incompressible law that depends on the first invariant only: register its other functions,
    which follow from `of_first_invariant`."""
    point_function(stretch_energy, law)(_energy)
    point_function(stretch_slopes, law)(_slopes)
    point_function(stretch_curvatures, law)(_curvatures)
    return incompressible(law)


@pointwise
def invariant_excess(a: float, b: float) -> float:
    """Return I - 3, with the first invariant I = a² + b² + 1/(ab)² of an incompressible sheet with the principal stretches
    a, b, accurate also for small values."""
    x, y = (a - 1.0) * (a + 1.0), (b - 1.0) * (b + 1.0)
    J = a * b
    return (x * x + x * y + y * y + x * y * (x + y)) / (J * J)


@pointwise
def invariant_slopes(a: float, b: float) -> tuple[float, float]:
    """Return the slopes ∂I/∂a and ∂I/∂b of the first invariant I = a² + b² + 1/(ab)² for the principal stretches a, b."""
    J = a * b
    inverse = 1.0 / (J * J)
    return 2.0 * (a - inverse / a), 2.0 * (b - inverse / b)


@pointwise
def invariant_curvatures(a: float, b: float) -> tuple[float, float, float]:
    """Return the second derivatives ∂²I/∂a², ∂²I/∂b² and ∂²I/∂a∂b of the first invariant I = a² + b² + 1/(ab)² for the
    principal stretches a, b."""
    J = a * b
    inverse = 1.0 / (J * J)
    return 2.0 + 6.0 * inverse / (a * a), 2.0 + 6.0 * inverse / (b * b), 4.0 * inverse / J


def _natural_width(law, stretch):
    return 1.0 / sqrt(stretch)


def _energy(law, a, b):
    return of_first_invariant(law, invariant_excess(a, b))[0]


def _slopes(law, a, b):
    _, slope, _ = of_first_invariant(law, invariant_excess(a, b))
    one, two = invariant_slopes(a, b)
    return slope * one, slope * two


def _curvatures(law, a, b):
    _, slope, curvature = of_first_invariant(law, invariant_excess(a, b))
    one, two = invariant_slopes(a, b)
    first, second, mixed = invariant_curvatures(a, b)
    return slope * first + curvature * one * one, slope * second + curvature * two * two, slope * mixed + curvature * one * two
