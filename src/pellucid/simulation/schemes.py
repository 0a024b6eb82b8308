"""Time stepping schemes, i.e. the order of the operations in a step. The physics is in bodies, grid and contact.

USF, USL and MUSL strain the points first, last, and last with velocities mapped again from the points (Sulsky, Zhou &
Schreyer 1995, Comput. Phys. Commun. 87, 236; Bardenhagen 2002, J. Comput. Phys. 180, 383). As in these sources, a point
uses the shape functions of its position at the start of the step for the whole step. Bodies with their own nodes solve
their own equation of motion; they use the grid only for contact. Surfaces in contact with each other or with walls exert
forces, which act from the start of a step, like the forces of conditions. With USF these surfaces move first, as the points
are strained first: their springs would otherwise gain energy in each vibration.
"""

from collections.abc import Callable

from pellucid.simulation.stages import Stages


def _stress_last(stages: Stages, dt: float, remap: bool) -> None:
    stages.exert_forces(dt)
    stages.clear_nodes()
    stages.before_forces()
    stages.particle_to_grid(inertia=True, force=True)  # m_I, p_I, f_I
    stages.predict_own_nodes(dt)
    stages.find_contact()
    stages.before_momentum(dt)
    stages.advance_momentum(dt)  # p_I + dt f_I, supports
    stages.stop_approach()
    stages.after_momentum(dt)
    stages.grid_to_particle(dt, remap)  # v_p; where `remap`, p_I mapped again
    stages.correct_own_nodes()
    if remap:
        stages.find_strain_velocities(dt)
    stages.before_stress(dt)
    stages.update_stress(dt, move=True)  # x_p, L_p, σ_p
    stages.update_own_nodes(dt)


def musl(stages: Stages, dt: float) -> None:
    """Advance one step dt [s] by modified update stress last (MUSL), in the order of operations of Gan et al. 2011:
    stresses are updated last, with nodal velocities from momentum that is mapped again from the points; stages: the
    operations of a step, see `Stages`."""
    _stress_last(stages, dt, remap=True)


def usl(stages: Stages, dt: float) -> None:
    """Advance one step dt [s] by update stress last (USL): stresses are updated after the momentum equation; stages: the
    operations of a step, see `Stages`."""
    _stress_last(stages, dt, remap=False)


def usf(stages: Stages, dt: float) -> None:
    """Advance one step dt [s] by update stress first (USF): stresses are updated before the momentum equation; stages: the
    operations of a step, see `Stages`."""
    stages.clear_nodes()
    stages.particle_to_grid(inertia=True, force=False)
    stages.move_surfaces(dt)
    stages.exert_forces(dt)
    stages.predict_own_nodes(dt)
    stages.find_contact()
    stages.find_strain_velocities()
    stages.update_stress(dt, move=False)
    stages.before_forces()
    stages.particle_to_grid(inertia=False, force=True)
    stages.before_momentum(dt)
    stages.advance_momentum(dt)
    stages.stop_approach()
    stages.after_momentum(dt)
    stages.grid_to_particle(dt, remap=False)
    stages.correct_own_nodes()
    stages.before_stress(dt)
    stages.update_positions(dt)
    stages.update_own_nodes(dt)


SCHEMES: dict[str, Callable[[Stages, float], None]] = {"musl": musl, "usl": usl, "usf": usf}
