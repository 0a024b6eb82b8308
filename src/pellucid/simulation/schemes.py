"""The order of the stages in a step. No physics here: that is in bodies, grid and contact.

USF, USL and MUSL strain the points first, last, and last with velocities mapped again from the points
(Sulsky, Zhou & Schreyer 1995, Comput. Phys. Commun. 87, 236; Bardenhagen 2002, J. Comput. Phys. 180, 383). As there, a point
uses the shape functions of its place at the start of the step throughout. Bodies with their own nodes solve their own equation
of motion; the grid gives them contact alone. Surfaces that touch each other or walls push by forces, which act from the start
of a step like those of conditions.
"""

from collections.abc import Callable
from typing import Protocol


class Steppable(Protocol):
    """The stages that a scheme orders."""

    def clear_nodes(self) -> None: ...
    def find_cell_pressures(self) -> None: ...
    def particle_to_grid(self, inertia: bool, force: bool) -> None: ...
    def predict_own_nodes(self, dt: float) -> None: ...
    def advance_momentum(self, dt: float) -> None: ...
    def detect_contact(self, dt: float) -> None: ...
    def apply_contact_impulses(self) -> None: ...
    def sum_works(self, dt: float) -> None: ...
    def grid_to_particle(self, dt: float, remap: bool) -> None: ...
    def correct_own_nodes(self) -> None: ...
    def find_strain_velocities(self) -> None: ...
    def find_strain_velocities_again(self, dt: float) -> None: ...
    def find_volume_corrections(self, dt: float) -> None: ...
    def update_stress(self, dt: float, move: bool) -> None: ...
    def update_positions(self, dt: float) -> None: ...
    def update_own_nodes(self, dt: float) -> None: ...


def musl(simulation: Steppable, dt: float) -> None:
    """Modified update stress last, Gan's order."""
    simulation.clear_nodes()
    simulation.find_cell_pressures()
    simulation.particle_to_grid(inertia=True, force=True)  # m_I, p_I, f_I
    simulation.predict_own_nodes(dt)
    simulation.detect_contact(dt)
    simulation.advance_momentum(dt)  # p_I + dt f_I, supports
    simulation.apply_contact_impulses()
    simulation.sum_works(dt)
    simulation.grid_to_particle(dt, remap=True)  # v_p; p_I mapped again
    simulation.correct_own_nodes()
    simulation.find_strain_velocities_again(dt)
    simulation.find_volume_corrections(dt)
    simulation.update_stress(dt, move=True)  # x_p, L_p, σ_p
    simulation.update_own_nodes(dt)


def usl(simulation: Steppable, dt: float) -> None:
    """Update stress last."""
    simulation.clear_nodes()
    simulation.find_cell_pressures()
    simulation.particle_to_grid(inertia=True, force=True)
    simulation.predict_own_nodes(dt)
    simulation.detect_contact(dt)
    simulation.advance_momentum(dt)
    simulation.apply_contact_impulses()
    simulation.sum_works(dt)
    simulation.grid_to_particle(dt, remap=False)
    simulation.correct_own_nodes()
    simulation.find_volume_corrections(dt)
    simulation.update_stress(dt, move=True)
    simulation.update_own_nodes(dt)


def usf(simulation: Steppable, dt: float) -> None:
    """Update stress first."""
    simulation.clear_nodes()
    simulation.particle_to_grid(inertia=True, force=False)
    simulation.predict_own_nodes(dt)
    simulation.detect_contact(dt)
    simulation.find_strain_velocities()
    simulation.update_stress(dt, move=False)
    simulation.find_cell_pressures()
    simulation.particle_to_grid(inertia=False, force=True)
    simulation.advance_momentum(dt)
    simulation.apply_contact_impulses()
    simulation.sum_works(dt)
    simulation.grid_to_particle(dt, remap=False)
    simulation.correct_own_nodes()
    simulation.find_volume_corrections(dt)
    simulation.update_positions(dt)
    simulation.update_own_nodes(dt)


SCHEMES: dict[str, Callable[[Steppable, float], None]] = {"musl": musl, "usl": usl, "usf": usf}
