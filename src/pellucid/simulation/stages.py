"""Operations of a time step on bodies, grid nodes and contacts, called in order by a scheme of
`pellucid.simulation.schemes`."""

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
    """Operations of a time step (stages) for the bodies and velocity fields of a simulation, with conditions and contact on
    the nodes. A time stepping scheme, such as `schemes.musl`, calls the methods in its order.

    on_grid: bodies on the grid, by velocity field; conditions, contact_pairs: all conditions, and contacts on the nodes;
    remaps: True if the momentum of points is mapped to the nodes a second time in each step, with FLIP (MUSL).
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
        """Works and impulses of the last step on the nodes, an entry for each velocity field that moves points; without
        contact."""

    def sort(self) -> None:
        """Sort the points of the bodies on the grid by their nodes, if a point left its slab (a block of grid cells) or
        sorting saves time."""
        for body in self.grid_bodies:
            body.sort_if_needed()

    def clear_nodes(self) -> None:
        """Reset mass, momentum and forces of the nodes, and the sums over points in each cell, to zero."""
        for field in self._fields:
            field.clear()
        for pressure in self.cell_pressures:
            pressure.clear()

    def find_cell_pressures(self) -> None:
        """Compute the mean pressure of the points in each full cell (a cell that a fluid fills), and add the forces of these
        pressures to the nodes."""
        for pressure in self.cell_pressures:
            pressure.find_pressures()

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Map mass and momentum (if `inertia`) and internal forces (if `force`) of the bodies on the grid to the nodes."""
        self._jointly(lambda body: body.particle_to_grid(inertia, force))

    def predict_own_nodes(self, dt: float) -> None:
        """Solve the equations of motion of the bodies with their own nodes over a step dt [s], without contact, and map their
        mass and momentum to the grid nodes."""
        for body in self.nodal_bodies:
            body.predict(dt)

    def detect_contact(self) -> None:
        """Find the nodes at which velocity fields are in contact in this step."""
        self.contact_pairs.detect()

    def solve_viscosity(self, dt: float) -> None:
        """Compute the stresses of implicit viscosity at the end of a step dt [s], and add their forces to the nodes."""
        for viscosity in self.viscosities:
            viscosity.solve(dt)

    def advance_momentum(self, dt: float) -> None:
        """Advance the momentum of the grid nodes by a step dt [s], and apply the impulses of conditions."""
        for field in self._fields:
            field.advance(dt, counted=field not in self._conditions.pushed_fields)
        self._conditions.act_on_nodes(dt)

    def apply_contact_impulses(self) -> None:
        """Apply contact impulses to the nodes, after all other impulses."""
        self.contact_pairs.apply_impulses()

    def sum_works(self, dt: float) -> None:
        """Compute the works of nodal forces in a step dt [s] after the momentum update, and the volume growth of full cells
        (cells that a fluid fills)."""
        works = [field.works(dt) for field in self._fields]
        self.works = [work for work in works if work is not None]
        for pressure in self.cell_pressures:
            pressure.find_growth()
        self.contact_pairs.sum_work()

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
            body.correct(remap=len(self.contact_pairs) > 0)

    def find_strain_velocities(self, dt: float | None = None) -> None:
        """Compute the nodal velocities whose gradients strain the points, from the momentum mapped last. At contacts these
        velocities are corrected so that bodies in contact do not approach each other.

        dt: the step [s] if the momentum of the points was mapped to the nodes again at the end of the step; the bodies then
        receive the impulses of this correction. None at the start of a step.
        """
        for field in self._fields:
            field.project(dt, counted=dt is not None and field in self._without_heat)
        self.contact_pairs.stop_straining(self._strained_again)
        if dt is not None:
            self.contact_pairs.apply_second_impulses(dt)

    def find_volume_corrections(self, dt: float) -> None:
        """Compute the difference between the volume growth of each full cell (a cell that a fluid fills) and that of its
        points, and the work of this difference over a step dt [s]."""
        for pressure in self.cell_pressures:
            pressure.find_shifts(dt)

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
