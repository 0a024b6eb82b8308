"""Laws of membranes: plane stress in the tangent plane of a point, in a frame that rotates with the material.

In-plane tensors are 3-tuples (11, 22, 12). The *shape* of a point is a 4-tuple that describes its in-plane deformation: the
strain or the deformation gradient, as the law defines it. From the shape, a law computes the Cauchy stress in the frame and
the ratio of the thickness to its initial value. Source: Gan et al. 2011, section 2.1.
"""

from math import sqrt

import numpy as np

from pellucid.jit import default_function, generic, point_function, pointwise
from pellucid.materials.law import Law, LawType, energy

InPlane = tuple[float, float, float]
Shape = tuple[float, float, float, float]  # strain or deformation gradient in the plane, as the law defines it


@pointwise
def turned_to(a11, a22, a12, major, minor):
    """Return the symmetric in-plane tensor (11, 22, 12) with the principal directions of the tensor a = (a11, a22, a12) and
    the principal values `major` and `minor`."""
    half = 0.5 * (a11 - a22)
    radius = sqrt(half * half + a12 * a12)
    cosine, sine = (half / radius, a12 / radius) if radius > 0.0 else (1.0, 0.0)  # of twice the angle
    mean, difference = 0.5 * (major + minor), 0.5 * (major - minor)
    return mean + difference * cosine, mean - difference * cosine, difference * sine


@generic
def stretched(law: Law, shape: Shape, D: InPlane, dt: float) -> Shape:
    """Return the in-plane shape (strain or deformation gradient, as a 4-tuple) after a step dt [s] with the in-plane rate of
    deformation D [1/s] in the local frame."""


@generic
def stretched_midway(law: Law, shape: Shape, D: InPlane, dt: float) -> Shape:
    """Return the in-plane shape after a step like `stretched`, for a rate of deformation D computed in the geometry at the
    middle of the step: second order in dt."""


@generic
def shape_of(law: Law, axes: InPlane, major: float, minor: float) -> Shape:
    """Return the in-plane shape (strain or deformation gradient, as a 4-tuple) with the principal stretches `major` and
    `minor` along the principal directions of the symmetric tensor `axes` (11, 22, 12)."""


@generic
def smoothed(law: Law, shape: Shape, major: float, minor: float) -> tuple[float, float]:
    """Return the principal stretches that a membrane has after the wrinkles of an in-plane shape are flattened, from the
    principal stretches `major` and `minor` of this shape; for laws without wrinkling, `major` and `minor`."""


@generic
def plane_response(law: Law, shape: Shape) -> tuple[float, float, float, float]:
    """Return the stress in the local frame of a point [Pa] and the ratio of the thickness to its value at rest, (σ11, σ22,
    σ12, ratio), for a membrane without damage; shape: in-plane strain or deformation gradient (4-tuple)."""


@generic
def largest_strain(law: Law, shape: Shape) -> float:
    """Return the largest in-plane principal strain of a shape (in-plane strain or deformation gradient, as a 4-tuple); for
    laws of finite strain, the logarithmic strain."""


@generic
def plane_wave_speed(law: Law, shape: Shape, density: float) -> float:
    """Return the speed of the fastest in-plane wave [m/s] at a shape (in-plane strain or deformation gradient, as a
    4-tuple) and a density [kg/m³] from the stiffness alone, i.e. from the tangent of the Kirchhoff stress; tension, which
    increases the speed, is not included."""


@pointwise
def principal_tension(s11, s22, s12):
    """Return the larger in-plane principal value of the stress (s11, s22, s12) [Pa], or 0 if it is compressive."""
    larger = 0.5 * (s11 + s22) + sqrt(0.25 * (s11 - s22) * (s11 - s22) + s12 * s12)
    return larger if larger > 0.0 else 0.0


@pointwise
def fastest_wave(wave, tension, density):
    """Return the speed of the fastest small wave on a membrane [m/s]. wave: speed from the stiffness alone [m/s]; tension:
    largest principal stress [Pa]; density [kg/m³]."""
    return sqrt(wave * wave + tension / density)


def wave_in_shape(law: Law, shape: Shape, density: float) -> float:
    """Return the speed [m/s] of the fastest small wave on a membrane with this shape (in-plane strain or deformation
    gradient, as a 4-tuple) and density [kg/m³]."""
    s11, s22, s12, _ = plane_response(law, shape)
    return float(fastest_wave(plane_wave_speed(law, shape, density), principal_tension(s11, s22, s12), density))


@generic
def plane_diffusivity(law: Law, shape: Shape, density: float) -> float:
    """Return the kinematic viscosity (2μ + λ)/ρ of in-plane pressure waves [m²/s], with the viscosities μ and λ [Pa s] and
    the density ρ [kg/m³]; default: 0. shape: in-plane strain or deformation gradient (4-tuple)."""


@default_function(plane_diffusivity)
def _no_diffusivity(law, shape, density):
    return 0.0


@generic
def damped_rate(law: Law, rate: float, spread: float) -> float:
    """Return the inverse of the largest stable step of a membrane with viscosity [1/s]. rate: inverse of the largest stable
    step without viscosity, i.e. half the angular frequency of the waves [1/s]; spread: rate ν/h² of momentum diffusion with
    the kinematic viscosity ν over a length h [1/s]."""


@default_function(damped_rate)
def _of_waves_alone(law, rate, spread):
    return rate


@generic
def with_viscosity(law: Law, stress: InPlane, D: InPlane, ratio: float) -> InPlane:
    """Return the elastic stress plus the viscous stress, (11, 22, 12) in the local frame of a point [Pa]; D: in-plane rate
    of deformation [1/s]; ratio: ratio of the thickness to its value at rest."""


@default_function(with_viscosity)
def _without_viscosity(law, stress, D, ratio):
    return stress


@generic
def record_loss(law: Law, dissipated: np.ndarray, p: int, D: InPlane, ratio: float, scale: float) -> None:
    """Add the viscous dissipation of a step to `dissipated` at point p [J/kg], or at element p [J]. D, ratio: as in
    `with_viscosity`; scale: factor on the dissipation per unit volume and time, with the step dt, the volume V and the mass
    m: dt V for an element, dt V/m for a point, times the fraction of the stiffness that damage leaves."""


@default_function(record_loss)
def _loses_nothing(law, dissipated, p, D, ratio, scale):
    pass


@generic
def initial_shape(law: Law) -> Shape:
    """Return the in-plane shape of the undeformed membrane (zero strain or unit deformation gradient, as a 4-tuple)."""


def around(law: type[LawType]) -> type[LawType]:
    """Class decorator for a law that wraps another law (its field `law`): register the functions of the wrapped law; the
    wrapping law may then replace some."""
    point_function(initial_shape, law)(_inner_initial_shape)
    point_function(stretched, law)(_inner_stretched)
    point_function(stretched_midway, law)(_inner_stretched_midway)
    point_function(shape_of, law)(_inner_shape_of)
    point_function(smoothed, law)(_inner_smoothed)
    point_function(plane_response, law)(_inner_response)
    point_function(energy, law)(_inner_energy)
    point_function(largest_strain, law)(_inner_strain)
    point_function(plane_wave_speed, law)(_inner_speed)
    return law


def _inner_initial_shape(law):
    return initial_shape(law.law)


def _inner_stretched(law, shape, D, dt):
    return stretched(law.law, shape, D, dt)


def _inner_stretched_midway(law, shape, D, dt):
    return stretched_midway(law.law, shape, D, dt)


def _inner_shape_of(law, axes, major, minor):
    return shape_of(law.law, axes, major, minor)


def _inner_smoothed(law, shape, major, minor):
    return smoothed(law.law, shape, major, minor)


def _inner_response(law, shape):
    return plane_response(law.law, shape)


def _inner_energy(law, F):
    return energy(law.law, F)


def _inner_strain(law, shape):
    return largest_strain(law.law, shape)


def _inner_speed(law, shape, density):
    return plane_wave_speed(law.law, shape, density)
