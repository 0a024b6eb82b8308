"""Soft cube bonded to two plates and stretched or compressed, by finite elements: `validation/mountris2019-cube`.

Edge 0.1 m, Young's modulus 3000 Pa, Poisson's ratio 0.49; the free sides may pass the planes of the plates. The two forms of
the energy are defined in `stretched_block`. The positions of the free sides of the stretched cube are in the table `cube_bulge`
of `finite_elements`.
"""

from typing import NamedTuple


class AtRest(NamedTuple):
    """Reference values for the deformed cube at rest: strain energy [J] and force on the upper face [N], with estimated
    relative errors."""

    energy: float  # strain energy [J]
    reaction: float  # force along z on the upper face [N]
    energy_error: float  # relative error of `energy`
    reaction_error: float  # relative error of `reaction`


BONDED_CUBE = {
    ("coupled", 0.05): AtRest(0.34983, 12.5117, 2e-4, 2e-4),
    ("decoupled", 0.05): AtRest(0.34697, 12.3609, 2e-4, 2e-4),
    ("coupled", -0.01): AtRest(0.01957, -4.0473, 3e-4, 3e-4),
    ("decoupled", -0.01): AtRest(0.01962, -4.065, 3e-3, 3e-3),
    ("coupled", -0.02): AtRest(0.0836, -8.88, 4e-3, 7e-3),
    ("decoupled", -0.02): AtRest(0.08439, -9.05, 5e-3, 8e-3),
}
"""Reference values by form of the energy and increase of the distance of the plates [m]."""
