"""Operations of a time step on bodies, grid nodes and parts of the step, their order in the time-stepping schemes, and their
computing times. The physics is in bodies, grid and contact.

USF, USL and MUSL strain the points first, last, and last with velocities mapped again from the points (Sulsky, Zhou &
Schreyer 1995, Comput. Phys. Commun. 87, 236; Bardenhagen 2002, J. Comput. Phys. 180, 383). As in these sources, a point
uses the shape functions of its position at the start of the step for the whole step. Bodies with their own nodes solve
their own equation of motion; they use the grid only for contact. Surfaces in contact with each other or with walls exert
forces, which act from the start of a step, like the forces of conditions. With USF these surfaces move first, as the points
are strained first: their springs would otherwise gain energy in each vibration.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pellucid.contact.pairs import ContactPairs
from pellucid.energy import StepWork
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.loops import joint_region
from pellucid.parts.body import Body
from pellucid.parts.families import GridBody, NodalBody
from pellucid.step.part import StepParts


class Stages:
    """Operations of a time step (stages) for the bodies, velocity fields and parts of the steps of a simulation. A time
    stepping scheme, such as `musl`, calls the methods in its order.

    on_grid: bodies on the grid, by velocity field.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        fields: Sequence[VelocityField],
        on_grid: Mapping[VelocityField, Sequence[GridBody]],
        parts: StepParts,
    ) -> None:
        self._fields, self._parts = fields, parts
        self._on_nodes = any(parts.of(ContactPairs))
        self.grid_bodies = [body for body in bodies if isinstance(body, GridBody)]
        self.nodal_bodies = [body for body in bodies if isinstance(body, NodalBody)]
        self._without_heat = {field for field, together in on_grid.items() if not all(body.keeps_heat for body in together)}
        pushed = [fields if part.pushed_fields is None else part.pushed_fields for part in parts.at("act_on_nodes")]
        self._pushed = {field for several in pushed for field in several}
        self.works: list[StepWork] = []
        """Works and impulses of the last step on the nodes, an entry for each velocity field that moves points; without
        contact."""

    def sort(self) -> None:
        """Sort the points of the bodies on the grid by their nodes, if a point left its slab (a block of grid cells) or
        sorting saves time."""
        for body in self.grid_bodies:
            body.storage.sort_if_needed()

    def begin(self, time: float, load_dt: float) -> None:
        """Apply the loads and prescribed motions of a step.

        time: time of the loads at the start of the step [s]; load_dt: its increment in the step [s].
        """
        for field in self._fields:
            field.clear_external()
        self._parts.run("begin", time, load_dt)

    def exert_forces(self, dt: float) -> None:
        """Apply the forces between surfaces of a step dt [s]."""
        self._parts.run("exert_forces", dt)

    def move_surfaces(self, dt: float) -> None:
        """Move the contact surfaces of the bodies on the grid over a step dt [s] with the velocities at its start."""
        for field in self._fields:
            field.project()
        for body in self.grid_bodies:
            body.move_surface(dt)

    def clear_nodes(self) -> None:
        """Reset mass, momentum and forces of the nodes, and the nodal arrays of parts, to zero."""
        for field in self._fields:
            field.clear()
        self._parts.run("clear_nodes")

    def before_forces(self) -> None:
        """Let parts add their forces to the nodes, e.g. those of mean pressures of full cells."""
        self._parts.run("before_forces")

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Map mass and momentum (if `inertia`) and internal forces (if `force`) of the bodies on the grid to the nodes."""
        self._jointly(lambda body: body.particle_to_grid(inertia, force))

    def predict_own_nodes(self, dt: float) -> None:
        """Solve the equations of motion of the bodies with their own nodes over a step dt [s], without contact, and map their
        mass and momentum to the grid nodes."""
        for body in self.nodal_bodies:
            body.predict(dt)

    def find_contact(self) -> None:
        """Find the nodes at which velocity fields are in contact in this step."""
        self._parts.run("find_contact")

    def before_momentum(self, dt: float) -> None:
        """Let parts add forces that depend on all other forces, over a step dt [s]."""
        self._parts.run("before_momentum", dt)

    def advance_momentum(self, dt: float) -> None:
        """Advance the momentum of the grid nodes by a step dt [s], and apply the impulses of conditions."""
        for field in self._fields:
            field.advance(dt, counted=field not in self._pushed)
        self._parts.run("act_on_nodes", dt)

    def stop_approach(self) -> None:
        """Apply contact impulses to the nodes, after all other impulses."""
        self._parts.run("stop_approach")

    def after_momentum(self, dt: float) -> None:
        """Compute the works of nodal forces in a step dt [s], and let parts use the mean velocities of the nodes."""
        works = [field.works(dt) for field in self._fields]
        self.works = [work for work in works if work is not None]
        self._parts.run("after_momentum")

    def grid_to_particle(self, dt: float, remap: bool) -> None:
        """Compute the velocities of the points on the grid after a step dt [s]; if `remap`, map their momentum to the nodes
        again."""
        self._jointly(lambda body: body.begin_grid_to_particle(dt, remap))
        for body in self.grid_bodies:
            body.end_grid_to_particle(remap)

    def correct_own_nodes(self) -> None:
        """Apply contact impulses to the velocities of the bodies with their own nodes, and map their momentum to the nodes
        again."""
        for body in self.nodal_bodies:
            body.correct(remap=self._on_nodes)

    def find_strain_velocities(self, dt: float | None = None) -> None:
        """Compute the nodal velocities whose gradients strain the points, from the momentum mapped last. At contacts these
        velocities are corrected so that bodies in contact do not approach each other.

        dt: the step [s] if the momentum of the points was mapped to the nodes again at the end of the step; the bodies then
        receive the impulses of this correction. None at the start of a step.
        """
        for field in self._fields:
            field.project(dt, counted=dt is not None and field in self._without_heat)
        self._parts.run("correct_strain_velocities", dt)

    def before_stress(self, dt: float) -> None:
        """Let parts use sums over the points with their new velocities, before stresses are updated over a step dt [s]."""
        self._parts.run("before_stress", dt)

    def update_stress(self, dt: float, move: bool) -> None:
        """Compute velocity gradients, volumes and stresses of the bodies on the grid over a step dt [s], and new positions if
        `move`."""
        self._jointly(lambda body: body.begin_stress(dt, move))
        for body in self.grid_bodies:
            body.end_stress(dt, move)

    def update_positions(self, dt: float) -> None:
        """Compute the positions of the points on the grid after a step dt [s]."""
        for body in self.grid_bodies:
            body.update_positions(dt)

    def update_own_nodes(self, dt: float) -> None:
        """Compute the positions and stresses of the bodies with their own nodes after a step dt [s]."""
        for body in self.nodal_bodies:
            body.update(dt)

    def _jointly(self, begin: Callable[[GridBody], None]) -> None:
        """Run the loops over the points of all bodies on the grid in one parallel region; begin: function that starts the
        loop of one body."""
        with joint_region:
            for body in self.grid_bodies:
                joint_region.make_room()
                begin(body)


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


OF_A_STEP = {
    "sort": "sort",
    "clear_nodes": "grid",
    "before_forces": "grid",
    "before_stress": "grid",
    "find_contact": "contact",
    "before_momentum": "viscosity",
    "advance_momentum": "grid",
    "stop_approach": "contact",
    "after_momentum": "grid",
    "find_strain_velocities": "grid",
    "particle_to_grid": "scatter",
    "grid_to_particle": "velocities",
    "update_stress": "gradients and law",
    "update_positions": "move",
    "predict_own_nodes": "scatter",
    "correct_own_nodes": "velocities",
    "update_own_nodes": "gradients and law",
}


def time_stages(simulation: Any, timers: dict[str, float]) -> None:
    """Make a simulation measure the wall-clock time of the stages of its steps. The time of each stage [s] is added to an entry
    of `timers`, such as "grid" or "contact"."""
    parts = [(simulation, {"record": "reductions"}), (simulation.stages, OF_A_STEP)]
    for owner, stages in parts:
        for stage, part in stages.items():
            setattr(owner, stage, _timed(timers, part, getattr(owner, stage)))


def _timed(timers: dict[str, float], part: str, stage: Callable[..., None]) -> Callable[..., None]:
    def timed(*arguments: Any, **named: Any) -> None:
        start = time.perf_counter()
        stage(*arguments, **named)
        timers[part] = timers.get(part, 0.0) + time.perf_counter() - start

    return timed
