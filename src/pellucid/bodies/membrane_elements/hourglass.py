"""Hourglass control of one-point quadrilaterals in their plane.

Source: Flanagan & Belytschko 1981, Int. J. Numer. Methods Eng. 17, 679.
The strain at the centre does not contain the hourglass rate q̇ = γ·v, where γ = ¼ (h - Σ (h·x_j) ∂N/∂x_j), h = (1, -1, 1,
-1), is orthogonal to every linear field. Forces -Q γ resist it, with B² = Σ_K |∇N_K|² at the centre, the mass m of the
element, and the speed c of waves in its plane:

    stiffness  Q̇ = 2 κ m c² B² q̇
    viscous    Q = κ m c B q̇

The first is the form of Belytschko, Lin & Tsay 1984, Comput. Methods Appl. Mech. Eng. 42, 225; a square has the stiffness
of full integration for κ = (3 - ν)/6. The second removes the fraction κ of an hourglass velocity in a step of the largest
stable length, 1/(c B).
"""

from typing import Any, Literal, NamedTuple

from pellucid.jit import generic, point_function
from pellucid.model import Model, parameter


class StiffnessControl(NamedTuple):
    """Hourglass control of quadrilaterals by springs: Q̇ = 2 κ m c² B² q̇, with the hourglass force Q [N], the hourglass
    rate q̇ [m/s], the mass m of the element, the speed c of waves in its plane, and B² = Σ_K |∇N_K|² over its nodes K at
    the centre."""

    share: float  # κ


class ViscousControl(NamedTuple):
    """Hourglass control of quadrilaterals by dashpots: Q = κ m c B q̇, with the hourglass force Q [N], the hourglass rate
    q̇ [m/s], the mass m of the element, the speed c of waves in its plane, and B² = Σ_K |∇N_K|² over its nodes K at the
    centre."""

    share: float  # κ


class HourglassCase(Model):
    """Hourglass control of quadrilaterals."""

    kind: Literal["stiffness", "viscous"] = parameter(
        "", "stiffness (springs) or viscous (dashpots) hourglass control", "stiffness"
    )
    coefficient: float = parameter("", "hourglass coefficient κ; 0 switches the control off", 0.05, ge=0, le=0.5)

    def control(self) -> StiffnessControl | ViscousControl:
        """Return the hourglass control in the form that the kernels use."""
        return (StiffnessControl if self.kind == "stiffness" else ViscousControl)(self.coefficient)


@generic
def resisted(control: Any, force: float, rate: float, dt: float, stiffness: float, impedance: float) -> float:
    """Return the hourglass force Q of a quadrilateral at the end of a step dt [s] [N].

    control: kind and coefficient κ of the hourglass control; force: Q at the start [N]; rate: hourglass rate q̇ [m/s];
    stiffness, impedance: the coefficients m c² B² [N/m] and m c B [kg/s], with the mass m, the wave speed c and B² = Σ_K
    |∇N_K|² at the centre.
    """


@point_function(resisted, StiffnessControl)
def _springs(control, force, rate, dt, stiffness, impedance):
    return force + 2.0 * control.share * stiffness * dt * rate


@point_function(resisted, ViscousControl)
def _dashpots(control, force, rate, dt, stiffness, impedance):
    return control.share * impedance * rate
