"""Tension fields: a membrane without bending stiffness wrinkles instead of carrying compression.

A point is *taut* if both principal stresses are tensile, *slack* if no direction is stretched, and otherwise *wrinkled*:
under uniaxial tension along its longest direction. Across this direction it has its natural width, i.e. the width with zero
transverse stress. The criterion for these states, by the larger strain and the smaller stress, is the mixed criterion of
Roddeman et al. 1987, J. Appl. Mech. 54, 884. The stress is the derivative of the relaxed energy, i.e. the minimum over all
wrinkled shapes with given in-plane lengths. Source: Reissner 1938, Proc. 5th Int. Congr. Appl. Mech., 88; Pipkin 1986, IMA
J. Appl. Math. 36, 85.

Any law may be wrapped. It only has to implement `unwrinkled`, its state without wrinkles: on the wavy surface the material
then has the stress and thickness of its own law, and its area exceeds the area spanned by the smoothed lengths.
"""

from typing import NamedTuple

from pellucid.jit import generic, point_function
from pellucid.materials.law import Law, energy
from pellucid.materials.membrane import Shape, around, plane_response, plane_wave_speed, smoothed


@around
class TensionField(NamedTuple):
    """Law of a membrane that wrinkles instead of carrying compression; law: law of its material without wrinkles."""

    law: Law


@generic
def unwrinkled(law: Law, shape: Shape) -> tuple[Shape, float]:
    """Return the in-plane shape (4-tuple) that the material has on the wavy surface, i.e. after the wrinkles of `shape` are
    flattened, and the ratio of its area to the area of the given shape."""


@generic
def natural_width(law: Law, stretch: float) -> float:
    """Return the width of a strip with free sides that is pulled to a stretch (length relative to its length at rest),
    relative to its width at rest."""


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
