"""Laws of membranes whose in-plane shape is the in-plane deformation gradient F, (11, 12, 21, 22), from the initial axes of
a point to its local frame."""

from math import log, sqrt

from pellucid.jit import point_function, pointwise
from pellucid.materials.law import LawType
from pellucid.materials.membrane import (
    InPlane,
    Shape,
    initial_shape,
    largest_strain,
    shape_of,
    smoothed,
    stretched,
    stretched_midway,
    turned_to,
)
from pellucid.materials.wrinkling import natural_width, unwrinkled


def by_gradient(law: type[LawType]) -> type[LawType]:
    """Class decorator: register the point functions of a law whose stress is computed from the in-plane deformation gradient
    F. The width of a wrinkled strip follows from `natural_width`, if the law defines it."""
    point_function(initial_shape, law)(_undeformed)
    point_function(stretched, law)(_stretched)
    point_function(stretched_midway, law)(_stretched_midway)
    point_function(shape_of, law)(_shape_of)
    point_function(smoothed, law)(_as_it_is)
    point_function(largest_strain, law)(_largest_strain)
    point_function(unwrinkled, law)(_unwrinkled)
    return law


@pointwise
def left_stretch_squared(F: Shape) -> InPlane:
    """Return the left Cauchy-Green tensor b = F Fᵀ in the local frame of a point, for the in-plane deformation gradient F."""
    return F[0] * F[0] + F[1] * F[1], F[2] * F[2] + F[3] * F[3], F[0] * F[2] + F[1] * F[3]


@pointwise
def larger_principal(s: InPlane) -> float:
    """Return the larger principal value of a symmetric in-plane tensor (11, 22, 12)."""
    half = 0.5 * (s[0] - s[1])
    return 0.5 * (s[0] + s[1]) + sqrt(half * half + s[2] * s[2])


def _undeformed(law):
    return (1.0, 0.0, 0.0, 1.0)


def _stretched(law, shape, D, dt):
    F = shape
    # F = (I + dt D) F in the frame, which has taken the rotation
    return (
        F[0] + dt * (D[0] * F[0] + D[2] * F[2]),
        F[1] + dt * (D[0] * F[1] + D[2] * F[3]),
        F[2] + dt * (D[2] * F[0] + D[1] * F[2]),
        F[3] + dt * (D[2] * F[1] + D[1] * F[3]),
    )


def _stretched_midway(law, shape, D, dt):
    # F = (I - ½ dt D)⁻¹ (I + ½ dt D) F: with A = (I - ½ dt D)⁻¹ D, which commutes with D, it is (I + dt A) F
    half = 0.5 * dt
    spread = D[0] * D[1] - D[2] * D[2]
    scale = 1.0 / (1.0 - half * (D[0] + D[1]) + half * half * spread)
    return stretched(law, shape, (scale * (D[0] - half * spread), scale * (D[1] - half * spread), scale * D[2]), dt)


def _shape_of(law, axes, major, minor):
    U11, U22, U12 = turned_to(axes[0], axes[1], axes[2], major, minor)
    return (U11, U12, U12, U22)


def _as_it_is(law, shape, major, minor):
    return major, minor


def _largest_strain(law, shape):
    F = shape
    # the larger singular value of F is the sum of the radii of its turning and its reflecting part
    turning = sqrt((F[0] + F[3]) * (F[0] + F[3]) + (F[2] - F[1]) * (F[2] - F[1]))
    reflecting = sqrt((F[0] - F[3]) * (F[0] - F[3]) + (F[1] + F[2]) * (F[1] + F[2]))
    return log(0.5 * (turning + reflecting))


def _unwrinkled(law, shape):
    F = shape
    b = left_stretch_squared(F)
    major, area = larger_principal(b), F[0] * F[3] - F[1] * F[2]
    if major <= 1.0:
        return (1.0, 0.0, 0.0, 1.0), 1.0 / area
    stretch = sqrt(major)
    width = natural_width(law, stretch)
    if area * area >= width * width * major:
        return shape, 1.0
    v11, v22, v12 = turned_to(b[0], b[1], b[2], stretch, width)
    return (v11, v12, v12, v22), stretch * width / area
