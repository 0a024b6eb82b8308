"""Laws of membranes: plane stress in the tangent plane of a point, in a frame that turns with the material.

In-plane tensors are 3-tuples (11, 22, 12). A law sees the stretching (rate of deformation) in the frame and answers with the
Cauchy stress in the frame and the ratio of thickness to its initial value. Source: Gan et al. 2011, section 2.1.
"""

from typing import Any

from pellucid.jit import generic

InPlane = tuple[float, float, float]


@generic
def stretched(law: Any, shape: Any, D: Any, dt: float) -> Any:
    """The in-plane shape, a 4-tuple that is the law's own, after a step with stretching D [1/s]."""


@generic
def stretched_midway(law: Any, shape: Any, D: Any, dt: float) -> Any:
    """As `stretched`, with D in the geometry at the middle of the step, not at its start: second order in dt."""


@generic
def plane_response(law: Any, shape: Any) -> Any:
    """Stress in the frame [Pa] and thickness ratio, (σ11, σ22, σ12, ratio), of a membrane without damage."""


@generic
def largest_strain(law: Any, shape: Any) -> float:
    """Largest principal strain in the plane; where strains are finite, the logarithmic one."""


@generic
def plane_wave_speed(law: Any, shape: Any, density: float) -> float:
    """Fastest wave in the plane [m/s]."""


@generic
def initial_shape(law: Any) -> Any:
    """The in-plane shape of the undeformed membrane, a 4-tuple."""
