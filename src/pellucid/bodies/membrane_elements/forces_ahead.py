"""Internal forces of membranes ahead of the start of a step, where viscosity dominates.

In a viscous liquid the velocity follows the forces without inertia. Viscous forces that are solved for act later in a step than
the internal forces of membranes, which are those of its start: `ImplicitViscosity.delay` is this time as a share s of the step,
half of it if viscous forces are fully implicit. The motion then has an error of first order. The forces f of two steps give
those at a later time (for s = 1/2 the second-order method of Adams and Bashforth):

    f = f_n + s (Δt_n / Δt_{n-1}) (f_n - f_{n-1}).

Three rules reduce s:

- Inertia. Waves that are hardly damped need the forces at the start (leapfrog); forces ahead would damp them. With the surface
  modulus E, the density ρ and viscosity μ of the liquid, and the radius a, the Laplace number ρ E a/μ² decides. The slowest
  deformation of a drop in a liquid of its density and viscosity has the frequency ω² = 24 E/(5 ρ a³) without viscosity (Lamb
  1932, Hydrodynamics, article 275), and decays with 16 E/(35 μ a) without inertia (Taylor 1934, Proc. R. Soc. A 146, 501). It
  is damped critically at the Laplace number `CRITICAL`, where ω is twice the rate of this decay.
  s is divided by 1 + (Laplace number / CRITICAL)².
- Stability. If viscous forces are fully implicit, the largest stable step is 1/(1 + 2 s) of the limit of `waves_in_liquid`,
  which is that of forces at the start.
- Steps that grow. The quotient of the steps counts at most as `LARGEST_GROWTH`.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.bodies.membrane_elements.on_grid import ElementsOnGrid
    from pellucid.grid.implicit_viscosity import ImplicitViscosity

CRITICAL = (24 / 5) / (4 * (16 / 35) ** 2)
LARGEST_GROWTH = 2.0
LEAST = 1e-3  # share of viscosity below which forces at the start are used


class ForcesAhead(StepPart):
    """Extrapolates the internal forces of a membrane to the time at which the viscous forces of the step act; see the module.

    In the energy balance, the offset between forces at the start of a step and the stored energy at its end is half the power
    of these forces (`half_power`). Of forces that are ahead by s, a share 1 - 2 s of it is left.
    """

    def __init__(self, membrane: "ElementsOnGrid", solver: "ImplicitViscosity", viscosity_share: float) -> None:
        """solver: solver of the viscous forces; viscosity_share: factor on s, see `share_of_viscosity`."""
        self.membrane, self._solver, self._viscosity_share = membrane, solver, viscosity_share
        self._dt = self._earlier_dt = 0.0
        self.share = 0.0
        """Share s of the last step by which the forces were ahead of its start."""
        self._earlier = np.zeros((membrane.n_points, 3))
        """Internal forces in the last step, in mesh order [N]."""

    def exert_forces(self, dt: float) -> None:
        self._dt = dt

    def extrapolate(self, forces: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Return the internal forces at the time of the viscous forces [N], and keep those of the start for the next step.

        forces: those of the start [N], shape (n, 3), in storage order; number: number of each node in the mesh, shape (n,).
        """
        ahead, dt = forces, self._dt
        self.share = self._share_of(dt) if self._earlier_dt > 0.0 else 0.0
        if self.share > 0.0:
            growth = min(dt / self._earlier_dt, LARGEST_GROWTH)
            ahead = forces + self.share * growth * (forces - self._earlier[number])
        self._earlier[number], self._earlier_dt = forces, dt
        return ahead

    def _share_of(self, dt: float) -> float:
        stable = self.membrane.surface.step_of_waves()
        return max(0.0, min(self._viscosity_share * self._solver.delay, 0.5 * (stable / dt - 1.0)))

    def state_numbers(self) -> dict[str, Any]:
        return {"earlier_step": self._earlier_dt}

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {"earlier_forces": self._earlier}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._earlier_dt = numbers["earlier_step"]

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        self._earlier[...] = arrays["earlier_forces"]


def share_of_viscosity(modulus: float, radius: float, density: float, viscosity: float) -> float:
    """Return the factor on s by the Laplace number of a membrane in a liquid: 1 where viscosity dominates, 0 where inertia
    does.

    modulus: surface modulus of the membrane [N/m]; radius: its radius [m]; density [kg/m³] and viscosity [Pa s] of the liquid.
    """
    laplace = density * modulus * radius / viscosity**2
    return 1.0 / (1.0 + (laplace / CRITICAL) ** 2)


def forces_ahead(bodies: Iterable[Any], solvers: Sequence["ImplicitViscosity"]) -> list[ForcesAhead]:
    """Return a part of the step for each membrane of elements in a velocity field whose liquid is more viscous than inert, and
    let the membrane use it.

    bodies: all bodies of the field on the grid; solvers: the solver of its viscous forces, if there is one.
    """
    shares = [(body, getattr(body, "viscosity_share", 0.0)) for body in bodies]
    found = [ForcesAhead(body, solver, share) for solver in solvers for body, share in shares if share > LEAST]
    for one in found:
        one.membrane.forces_ahead = one
    return found
