"""Initial tension of membranes: computes the equal biaxial stretch that produces it, or the tension for a given stretch."""

from collections.abc import Callable
from typing import NamedTuple

from pellucid.materials.law import Law
from pellucid.materials.membrane import InPlane, Shape, initial_shape, plane_response, shape_of

ISOTROPIC = (1.0, 1.0, 0.0)
LARGEST, THINNEST = 10.0, 0.05  # largest stretch and smallest relative thickness in the search for a tension


class Prestretch(NamedTuple):
    """State of a membrane that is stretched equally in all in-plane directions: stretch, stress, thickness ratio and stored
    energy.
    """

    stretch: float  # in-plane stretch relative to the rest state
    stress: InPlane  # in-plane stress [Pa], equal along all directions unless the law has directions
    ratio: float  # ratio of the present thickness to the thickness at rest
    shape: Shape  # deformation in the form of the law
    energy: float  # stored energy per present volume [J/m³]
    law: Law  # law of the membrane with its thickness at rest


def prestretch(law_of: Callable[[float], Law], tension: float, thickness: float, inflation: float = 0.0) -> Prestretch:
    """Return the state of a membrane, with the present thickness [m], under a tension [N/m] or with the biaxial stretch 1 +
    inflation.

    law_of: function that returns the law of a membrane of a given thickness at rest [m]; the ratio of stretched thickness
    to thickness at rest must not depend on the thickness at rest. Raises ValueError if no such state exists.
    """
    if tension == inflation == 0.0:
        law = law_of(thickness)
        return Prestretch(1.0, (0.0, 0.0, 0.0), 1.0, initial_shape(law), 0.0, law)
    from scipy.integrate import quad

    def under(law: Law, stretch: float) -> tuple[InPlane, float]:
        *stress, ratio = plane_response(law, shape_of(law, ISOTROPIC, stretch, stretch))
        return (stress[0], stress[1], stress[2]), ratio

    def response(stretch: float) -> tuple[float, float]:
        _, ratio = under(law_of(thickness), stretch)
        stress, ratio = under(law_of(thickness / ratio), stretch)
        return stress[0], ratio

    def power(law: Law, stretch: float) -> float:
        # on unit of volume at rest each direction takes its σ times the ratio of thickness times λ, along dλ
        (first, second, _), ratio = under(law, stretch)
        return (first + second) * ratio * stretch

    stretch = 1.0 + inflation if inflation else _bearing(response, tension / thickness)
    if stretch is None or response(stretch)[1] <= THINNEST:
        what = f"tension of {tension:g} N/m" if inflation == 0.0 else f"inflation of {inflation:g}"
        raise ValueError(f"the material cannot carry the {what} at a thickness of {thickness:g} m")
    law = law_of(thickness / response(stretch)[1])
    stress, ratio = under(law, stretch)
    work = quad(lambda trial: power(law, trial), 1.0, stretch, epsabs=0.0, epsrel=1e-11)[0]
    shape = shape_of(law, ISOTROPIC, stretch, stretch)
    return Prestretch(stretch, stress, ratio, shape, work / (stretch**2 * ratio), law)


def _bearing(response: Callable[[float], tuple[float, float]], wanted: float) -> float | None:
    """Return the smallest biaxial stretch at which the membrane has the stress `wanted` [Pa]; None if there is none. response:
    function that returns the stress [Pa] and the ratio of thickness to thickness at rest for a stretch.
    """
    from scipy.optimize import brentq

    stretch = 1.0
    while response(stretch)[0] < wanted and stretch < LARGEST and response(stretch)[1] > THINNEST:
        stretch *= 1.1
    if response(stretch)[0] < wanted:
        return None
    return float(brentq(lambda trial: response(trial)[0] - wanted, 1.0, stretch, xtol=1e-15))
