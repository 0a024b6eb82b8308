"""The order of the verbs in a step. No physics here; bodies and grid hold it.

USF, USL and MUSL strain the points first, last, and last with the velocities mapped anew from the points
(Sulsky, Zhou & Schreyer 1995, Comput. Phys. Commun. 87, 236; Bardenhagen 2002, J. Comput. Phys. 180, 383). As there, a point
uses the shape functions of its place at the start of the step throughout.
"""

from collections.abc import Callable
from typing import Any


def musl(simulation: Any, dt: float) -> None:
    """Modified update stress last, Gan's order."""
    velocity_fields = simulation.velocity_fields
    velocity_fields.clear_inertia()
    velocity_fields.clear_force()
    for body in simulation.bodies:
        body.particle_to_grid(inertia=True, force=True)  # m, p, f
    simulation.meet()  # where fields touch
    simulation.advance(dt)  # p + dt f, supports, contact
    velocity_fields.clear_momentum()
    for body in simulation.bodies:
        body.update_velocities(remap=True)  # v of the points, p anew
    simulation.project()
    for body in simulation.bodies:
        body.update_stress(dt, move=True)  # x, L, σ


def usl(simulation: Any, dt: float) -> None:
    """Update stress last."""
    velocity_fields = simulation.velocity_fields
    velocity_fields.clear_inertia()
    velocity_fields.clear_force()
    for body in simulation.bodies:
        body.particle_to_grid(inertia=True, force=True)
    simulation.meet()
    simulation.advance(dt)
    if simulation.touching:
        velocity_fields.clear_momentum()
    for body in simulation.bodies:
        body.update_velocities(remap=simulation.touching)  # p anew for contact
    for body in simulation.bodies:
        body.update_stress(dt, move=True)


def usf(simulation: Any, dt: float) -> None:
    """Update stress first."""
    velocity_fields = simulation.velocity_fields
    velocity_fields.clear_inertia()
    for body in simulation.bodies:
        body.particle_to_grid(inertia=True, force=False)
    simulation.meet()
    simulation.project()
    for body in simulation.bodies:
        body.update_stress(dt, move=False)
    velocity_fields.clear_force()
    for body in simulation.bodies:
        body.particle_to_grid(inertia=False, force=True)
    simulation.advance(dt)
    if simulation.touching:
        velocity_fields.clear_momentum()
    for body in simulation.bodies:
        body.update_velocities(remap=simulation.touching)
    for body in simulation.bodies:
        body.update_positions(dt)


SCHEMES: dict[str, Callable[[Any, float], None]] = {"musl": musl, "usl": usl, "usf": usf}
