"""Tension fields: a membrane without bending stiffness wrinkles rather than bear compression.

A point is *taut* where both principal stresses are tensile, *slack* where no direction is stretched, else *wrinkled*: under
uniaxial tension along its longest direction, across which it takes its natural width, the one that leaves no stress there.
That the states follow from the larger strain and the smaller stress is the mixed criterion of Roddeman et al. 1987, J. Appl.
Mech. 54, 884. The stress is the derivative of the relaxed energy, the least over all wrinklings of given in-plane lengths.
Source: Reissner 1938, Proc. 5th Int. Congr. Appl. Mech., 88; Pipkin 1986, IMA J. Appl. Math. 36, 85.

Any law may be wrapped. It gives only its state with the wrinkles smoothed out, `unwrinkled`: on the wavy surface the material
then has the stress and thickness of its own law, and there is more of it than the smoothed lengths span.
"""

from typing import NamedTuple

from pellucid.jit import generic, point_function
from pellucid.materials.law import Law, energy
from pellucid.materials.membrane import Shape, around, plane_response, plane_wave_speed, smoothed


@around
class TensionField(NamedTuple):
    """A membrane of another law that bears no compression."""

    law: Law


@generic
def unwrinkled(law: Law, shape: Shape) -> tuple[Shape, float]:
    """The in-plane shape with its wrinkles smoothed out, a 4-tuple, and the area of that over the area of the shape itself."""


@generic
def natural_width(law: Law, stretch: float) -> float:
    """The width over that at rest of a strip that is pulled to a stretch, its sides free."""


@point_function(smoothed, TensionField)
def _smoothed(law, shape, major, minor):
    _, folded = unwrinkled(law.law, shape)
    if folded == 1.0:
        return major, minor
    longest = max(major, 1.0)
    return longest, folded * major * minor / longest


@point_function(plane_response, TensionField)
def _plane_response(law, shape):
    smooth, folded = unwrinkled(law.law, shape)
    s11, s22, s12, ratio = plane_response(law.law, smooth)
    # the thickness over the smoothed area: its volume is that of the material
    return s11, s22, s12, folded * ratio


@point_function(energy, TensionField)
def _relaxed_energy(law, F):
    smooth, _ = unwrinkled(law.law, F)
    return energy(law.law, smooth)


@point_function(plane_wave_speed, TensionField)
def _plane_wave_speed(law, shape, density):
    smooth, _ = unwrinkled(law.law, shape)
    return plane_wave_speed(law.law, smooth, density)
