"""Tension fields: a membrane without bending stiffness wrinkles rather than bear compression.

A point is *taut* where both principal stresses are tensile, *slack* where no direction is stretched, else *wrinkled*: under
uniaxial tension along its longest direction, across which it takes its natural width, the one that leaves no stress there.
That the states follow from the larger strain and the smaller stress is the mixed criterion of Roddeman et al. 1987, J. Appl.
Mech. 54, 884. The stress is the derivative of the relaxed energy, the least that any wrinkling to the given outline leaves.
Source: Reissner 1938, Proc. 5th Int. Congr. Appl. Mech., 88; Pipkin 1986, IMA J. Appl. Math. 36, 85.

Any law may be wrapped. All that it has to say is what it looks like when its wrinkles are smoothed out, `unwrinkled`: on the
wavy surface the material then has the stress and thickness of its own law, and there is more of it than the outline spans.
"""

from math import sqrt
from typing import Any, NamedTuple

from pellucid.jit import generic, point_function, pointwise
from pellucid.materials.membrane import (
    initial_shape,
    largest_strain,
    plane_response,
    plane_wave_speed,
    stretched,
    stretched_midway,
)


class TensionField(NamedTuple):
    """A membrane of another law that bears no compression."""

    law: Any


@generic
def unwrinkled(law: Any, shape: Any) -> Any:
    """The in-plane shape with its wrinkles smoothed out, a 4-tuple, and the area of that over the area of the shape itself."""


@pointwise
def turned_to(a11, a22, a12, major, minor):
    """The symmetric tensor (11, 22, 12) along the principal directions of `a` with other principal values."""
    half = 0.5 * (a11 - a22)
    radius = sqrt(half * half + a12 * a12)
    cosine, sine = (half / radius, a12 / radius) if radius > 0.0 else (1.0, 0.0)  # of twice the angle
    mean, difference = 0.5 * (major + minor), 0.5 * (major - minor)
    return mean + difference * cosine, mean - difference * cosine, difference * sine


@point_function(initial_shape, TensionField)
def _initial_shape(law):
    return initial_shape(law.law)


@point_function(stretched, TensionField)
def _stretched(law, shape, D, dt):
    return stretched(law.law, shape, D, dt)


@point_function(stretched_midway, TensionField)
def _stretched_midway(law, shape, D, dt):
    return stretched_midway(law.law, shape, D, dt)


@point_function(plane_response, TensionField)
def _plane_response(law, shape):
    smooth, folded = unwrinkled(law.law, shape)
    s11, s22, s12, ratio = plane_response(law.law, smooth)
    # the thickness over the outline: its volume is that of the material
    return s11, s22, s12, folded * ratio


@point_function(largest_strain, TensionField)
def _largest_strain(law, shape):
    return largest_strain(law.law, shape)


@point_function(plane_wave_speed, TensionField)
def _plane_wave_speed(law, shape, density):
    smooth, _ = unwrinkled(law.law, shape)
    return plane_wave_speed(law.law, smooth, density)
