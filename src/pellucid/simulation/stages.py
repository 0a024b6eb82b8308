"""The stages of a step, which a scheme orders: what bodies, nodes and contact do in it."""

from collections.abc import Callable, Mapping, Sequence

from pellucid.conditions.active import ActiveConditions
from pellucid.contact.pairs import ContactPairs
from pellucid.energy import StepWork
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.joint import joint_region
from pellucid.parts.body import Body
from pellucid.parts.families import GridBody, NodalBody
from pellucid.simulation.assembly import cell_pressures, implicit_viscosities


class Stages:
    """The stages of a step of bodies and velocity fields, under conditions, with contact on the nodes.

    on_grid: those of the bodies that are on the grid, by velocity field; remaps: whether momentum is mapped again, with FLIP.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        fields: Sequence[VelocityField],
        on_grid: Mapping[VelocityField, Sequence[GridBody]],
        conditions: ActiveConditions,
        contact_pairs: ContactPairs,
        remaps: bool,
    ) -> None:
        self._fields, self._conditions, self.contact_pairs = fields, conditions, contact_pairs
        self.grid_bodies = [body for body in bodies if isinstance(body, GridBody)]
        self.nodal_bodies = [body for body in bodies if isinstance(body, NodalBody)]
        self.cell_pressures = cell_pressures(on_grid)
        self.viscosities = implicit_viscosities(on_grid)
        heat = {field: [body.keeps_heat for body in together] for field, together in on_grid.items()}
        self._strained_again = [field for field, keep in heat.items() if remaps and not any(keep)]
        self._without_heat = {field for field, keep in heat.items() if not all(keep)}
        self.works: list[StepWork] = []
        """Of the step, on the nodes, those of contact left out."""

    def sort(self) -> None:
        """Sort the points of bodies that need it."""
        for body in self.grid_bodies:
            body.sort_if_needed()

    def clear_nodes(self) -> None:
        """Set mass, momentum and forces of the nodes to zero, and sums over cells."""
        for field in self._fields:
            field.clear()
        for pressure in self.cell_pressures:
            pressure.clear()

    def find_cell_pressures(self) -> None:
        """Find the mean pressures of full cells, and their forces on the nodes."""
        for pressure in self.cell_pressures:
            pressure.find_pressures()

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum (where `inertia`) and internal forces (where `force`) of the bodies on the grid to the nodes."""
        self._jointly(lambda body: body.particle_to_grid(inertia, force))

    def predict_own_nodes(self, dt: float) -> None:
        """Solve the equations of motion of the bodies with their own nodes, without contact; mass and momentum to the nodes."""
        for body in self.nodal_bodies:
            body.predict(dt)

    def detect_contact(self) -> None:
        """Find where velocity fields touch in this step."""
        self.contact_pairs.detect()

    def solve_viscosity(self, dt: float) -> None:
        """Find the stresses of implicit viscosity, and their forces on the nodes."""
        for viscosity in self.viscosities:
            viscosity.solve(dt)

    def advance_momentum(self, dt: float) -> None:
        """Advance the momentum of the nodes, and apply the impulses of conditions."""
        for field in self._fields:
            field.advance(dt, counted=not self._conditions.give_impulses)
        self._conditions.act_on_nodes(dt)

    def apply_contact_impulses(self) -> None:
        """Apply the impulses of contact to the nodes, after all others."""
        self.contact_pairs.apply_impulses()

    def sum_works(self, dt: float) -> None:
        """Sum the works of the step on the nodes, whose momentum is advanced, and find how much full cells grow."""
        works = [field.works(dt) for field in self._fields]
        self.works = [work for work in works if work is not None]
        for pressure in self.cell_pressures:
            pressure.find_growth()
        self.contact_pairs.sum_work()

    def grid_to_particle(self, dt: float, remap: bool) -> None:
        """New velocities of the bodies on the grid; where `remap`, their momentum back on the nodes."""
        self._jointly(lambda body: body.begin_grid_to_particle(dt, remap))
        for body in self.grid_bodies:
            body.end_grid_to_particle(remap)

    def correct_own_nodes(self) -> None:
        """New velocities of the bodies with their own nodes, with what contact gave them; their momentum back on the nodes."""
        for body in self.nodal_bodies:
            body.correct(remap=len(self.contact_pairs) > 0)

    def find_strain_velocities(self, dt: float | None = None) -> None:
        """Nodal velocities of the momentum mapped last, which do not approach where bodies touch.

        dt: of the step at whose end it was mapped again, whose bodies take the impulses that this needs [s]; None of that at
        the start of a step.
        """
        for field in self._fields:
            field.project(dt, counted=dt is not None and field in self._without_heat)
        self.contact_pairs.stop_straining(self._strained_again)
        if dt is not None:
            self.contact_pairs.apply_second_impulses(dt)

    def find_volume_corrections(self, dt: float) -> None:
        """Find what the volumes of points lack of the growth of full cells, and its work."""
        for pressure in self.cell_pressures:
            pressure.find_shifts(dt)

    def update_stress(self, dt: float, move: bool) -> None:
        """Velocity gradients, volumes, stresses of the bodies on the grid; where `move`, new positions."""
        self._jointly(lambda body: body.begin_stress(dt, move))
        for body in self.grid_bodies:
            body.end_stress(dt, move)

    def update_positions(self, dt: float) -> None:
        """New positions of the bodies on the grid."""
        for body in self.grid_bodies:
            body.update_positions(dt)

    def update_own_nodes(self, dt: float) -> None:
        """New positions and stresses of the bodies with their own nodes."""
        for body in self.nodal_bodies:
            body.update(dt)

    def _jointly(self, begin: Callable[[GridBody], None]) -> None:
        """Run the first parts of the loops of all bodies on the grid in one parallel region."""
        with joint_region:
            for body in self.grid_bodies:
                joint_region.make_room()
                begin(body)
