"""The order of the verbs in a step. No physics here: that is in bodies, grid and contact.

USF, USL and MUSL strain the points first, last, and last with velocities mapped again from the points
(Sulsky, Zhou & Schreyer 1995, Comput. Phys. Commun. 87, 236; Bardenhagen 2002, J. Comput. Phys. 180, 383). As there, a point
uses the shape functions of its place at the start of the step throughout. Bodies with their own nodes solve their own equation
of motion; the grid gives them contact alone.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pellucid.simulation.simulation import Simulation


def musl(simulation: "Simulation", dt: float) -> None:
    """Modified update stress last, Gan's order."""
    simulation.clear()
    simulation.find_pressures()
    simulation.particle_to_grid(inertia=True, force=True)  # m, p, f
    for own in simulation.nodal_bodies:
        own.predict(dt)  # their own equation of motion
    simulation.detect_contact(dt)
    simulation.advance(dt)  # p + dt f, supports, contact
    simulation.update_velocities(dt, remap=True)  # v of the points, p mapped again
    for own in simulation.nodal_bodies:
        own.correct(remap=simulation.has_contact)
    simulation.project(dt)
    simulation.give_second_impulses(dt)  # of contact, which stops what approaches again
    simulation.find_shifts(dt)
    simulation.update_stress(dt, move=True)  # x, L, σ
    for own in simulation.nodal_bodies:
        own.update(dt)


def usl(simulation: "Simulation", dt: float) -> None:
    """Update stress last."""
    simulation.clear()
    simulation.find_pressures()
    simulation.particle_to_grid(inertia=True, force=True)
    for own in simulation.nodal_bodies:
        own.predict(dt)
    simulation.detect_contact(dt)
    simulation.advance(dt)
    simulation.update_velocities(dt, remap=False)
    for own in simulation.nodal_bodies:
        own.correct(remap=simulation.has_contact)
    simulation.find_shifts(dt)
    simulation.update_stress(dt, move=True)
    for own in simulation.nodal_bodies:
        own.update(dt)


def usf(simulation: "Simulation", dt: float) -> None:
    """Update stress first."""
    simulation.clear()
    simulation.particle_to_grid(inertia=True, force=False)
    for own in simulation.nodal_bodies:
        own.predict(dt)
    simulation.detect_contact(dt)
    simulation.project()
    simulation.update_stress(dt, move=False)
    simulation.find_pressures()
    simulation.particle_to_grid(inertia=False, force=True)
    simulation.advance(dt)
    simulation.update_velocities(dt, remap=False)
    for own in simulation.nodal_bodies:
        own.correct(remap=simulation.has_contact)
    simulation.find_shifts(dt)
    for body in simulation.grid_bodies:
        body.update_positions(dt)
    for own in simulation.nodal_bodies:
        own.update(dt)


SCHEMES: dict[str, Callable[["Simulation", float], None]] = {"musl": musl, "usl": usl, "usf": usf}
