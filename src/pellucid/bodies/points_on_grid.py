"""Base classes of bodies of points on the grid: arrays for kernels and the stages of a step except straining, and surfaces with
a mesh whose nodes move with the nodes of the grid."""

from collections.abc import Callable, Sequence

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.bodies.own_nodes.contact_surface import PointsOfNodes
from pellucid.bodies.point_body import PointBody
from pellucid.contact.contact_body import ContactBody, TakesSecondImpulses
from pellucid.contact.contact_surface import ContactSurface
from pellucid.energy import FIRST_LOAD, Totals
from pellucid.grid import full_cells
from pellucid.grid import transfer as kernels
from pellucid.grid.nodal_fields import with_fields
from pellucid.grid.particle_to_grid import ParticleToGrid, inertia_of
from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.gifts import FIRST, giving, scatter
from pellucid.grid.passes.moving import move_points, moving
from pellucid.grid.passes.points_pass import PassAlone, traffic_of
from pellucid.grid.point_storage import PointStorage
from pellucid.grid.points import (
    AFFINE,
    FIELD_ENERGY,
    GAINED,
    GROWTH,
    KEPT,
    LOSS,
    LUMPING,
    SHIFT,
    VECTORS,
    FullCells,
    GrowingCells,
    InOrder,
    MappedPoints,
    PointArrays,
)
from pellucid.grid.transfer import scatter_vectors
from pellucid.grid.velocities import HeatArrays, taking_velocities
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Apic, VelocityTransfer
from pellucid.jit.bundle import Bundle
from pellucid.parts.capabilities import BoundByContact, HasContactSurface, TakesDrag, TakesExternalForces
from pellucid.parts.families import TransferLoss


class PointsOnGrid(PointBody, TakesExternalForces, TakesDrag, TakesSecondImpulses):
    """Base class of bodies whose points move with the velocities of grid nodes.

    A subclass provides the initial arrays, `begin_stress` and `end_stress` (which ends with `_collect_strain_sums`), the kind
    of stored energy (`energy_kind`), and its own fields.
    """

    _curving = False
    """True if the points move along the curved paths of a steady flow, to second order."""
    sorting_cost = 1.0
    """Cost of sorting per point, in units of the cost of a vector of points with the same nodes (60 to 65 ns): 50 ns, and
    15 ns in the next step."""

    def __init__(
        self,
        name: str,
        velocity_field: VelocityField,
        functions: GridFunctions,
        velocity_transfer: VelocityTransfer,
        arrays: dict[str, np.ndarray],
        there: int | None = None,
    ) -> None:
        """name: name of the body; velocity_field: field that moves the points; functions: shape functions of the grid;
        velocity_transfer: scheme of the grid-to-particle transfer; arrays: initial arrays of the points; there: number of rows
        that are points on this process, if the others belong to other processes.
        """
        n = len(arrays["mass"])
        self.name = name
        self.velocity_field = velocity_field
        self.grid = velocity_field.grid
        self.functions = functions
        self._stencil = max(function.stencil for function in functions)
        self.transfer = velocity_transfer
        self._nodes = velocity_field.grid.nodes
        self._cells: FullCells | GrowingCells | None = None
        self.arrays = arrays
        arrays["velocity"][:there, np.array(self.grid.thin)] = 0.0
        if isinstance(velocity_transfer, Apic):
            arrays["affine"] = np.zeros((n, FIELD_ENERGY + 1))
        self._heat = np.zeros(n if self.keeps_heat else 0)
        self.totals = Totals()
        self.storage = PointStorage(arrays, self.grid.lattice, functions, there, self.sorting_cost, self._follow_order)
        self.n_slabs = len(self.storage.slabs.layers)
        self._bind()
        self._make_bundles()
        self.storage.sort()

    def _follow_order(self) -> None:
        """Update the data that depend on the order in which the points are stored, after they were sorted."""

    def _bind(self) -> None:
        """Collect the arrays of the points for kernels; they remain the same objects when points are sorted. Points of a body
        with elements have no stress of their own.
        """
        a = self.arrays
        self.points = PointArrays(**{name: a[name] for name in PointArrays._fields if name in a})
        self._affine = a.get("affine")

    def carry_rotation(self) -> VelocityTransfer:
        """Add affine velocity fields to the points, which describe the rotation of a rigid body. The constraint of the body
        sets them; nodal velocities do not change them.
        """
        if self._affine is None:
            self.arrays["affine"] = np.zeros((len(self.arrays["mass"]), FIELD_ENERGY + 1))
            self._bind()
            self._make_bundles()
        return self.transfer

    def _make_bundles(self) -> None:
        """Build the kernel arguments for points and slabs (layers of grid cells), and the loops over the points."""
        mapped = MappedPoints(
            functions=self.functions,
            lattice=self.grid.lattice,
            nodes=self._nodes,
            points=self.points,
            slabs=self.storage.slabs,
            index=InOrder(),
        )
        self.mapped = Bundle(mapped)
        self._to_grid = ParticleToGrid(mapped, self._affine, self._cells)
        self._by_nodes = moving(mapped, kernels.ByNodes(self._moving_velocity, float(self._curving)))
        self._velocity_passes: dict[bool, Bundle] = {}

    @property
    def _moving_velocity(self) -> np.ndarray:
        """Velocities of the grid nodes that move the points [m/s], shape (nodes, 3), unless points are moved while their
        strain is updated.
        """
        return self.grid.nodes.velocity

    def _velocity_pass(self) -> Bundle:
        """Return the loop over the points that updates their velocities (G2P). There is one for each value of `keeps_heat`,
        which may change during set-up.
        """
        if self.keeps_heat not in self._velocity_passes:
            heat = HeatArrays(self.arrays["internal_energy"], self._heat) if self.keeps_heat else None
            affine = self._affine if isinstance(self.transfer, Apic) else None
            where = self.transfer, self.mapped.content, affine, heat, self._cells
            self._velocity_passes[self.keeps_heat] = taking_velocities(*where)
        return self._velocity_passes[self.keeps_heat]

    def use_separate_force_buffer(self) -> None:
        """From now on, add the internal forces of this body to the separate array of nodal forces that its velocity field has
        for bodies that keep heat (whose internal energy contains the losses of the transfers).
        """
        self._nodes = with_fields(self.grid.nodes, {"forces": self.velocity_field.separate_forces()})
        self._make_bundles()

    @property
    def nodal_forces(self) -> np.ndarray:
        """Return the flat array of nodal forces to which the body adds its internal forces, with four numbers for each node,
        shape (4 nodes,).
        """
        return self._nodes.forces

    def share_cells(self, cells: FullCells | GrowingCells) -> None:
        """Use mean pressures for full cells (cells that the fluid fills) instead of pressures of single points. cells: data of
        these cells, `GrowingCells` with an implicit pressure; see `pellucid.grid.full_cells`.
        """
        self._cells = cells
        self._make_bundles()

    def apply_volume_correction(self, dt: float) -> None:
        """Add to the internal energy the work of the pressure on the difference between the volume change of the points and
        the volume change of full cells (cells that the fluid fills) in a step dt [s]; for an implicit pressure on the latter.
        """
        if self.keeps_heat and isinstance(cells := self.full_cells, FullCells):
            column = GROWTH if isinstance(self._cells, GrowingCells) else SHIFT
            full_cells.apply_volume_correction(
                self.n_slabs, self.mapped, cells.found, column, self.arrays["internal_energy"], dt
            )
            self.totals.stored += float(self.storage.sums()[GAINED])  # for USF, as in `end_grid_to_particle`

    @property
    def on_grid(self) -> ContactBody:
        return self

    def half_width(self) -> tuple[float, float, float]:
        """Return (-1, a, b): contact begins at the surface of the cube around each point, whose edge length is (a · volume)^b;
        see `ContactBody.half_width`.
        """
        thin = sum(self.grid.thin)
        return -1.0, self.grid.slice_thickness**-thin, 1.0 / (3 - thin)

    def passes(self) -> dict[str, PassAlone]:
        """Return, for benchmarks, the loops over the points of a step by name (particle to grid, velocities), in a form in
        which each can run without advancing time.
        """
        velocities, given = self._velocity_pass(), self._to_grid
        traffic = traffic_of(velocities)

        def take(which: int) -> Callable[[], None]:
            return lambda: each_point(velocities, 0.0, which)

        return {
            "particle to grid": PassAlone(lambda: given.scatter(inertia=True, force=True), given.read()),
            "velocities": PassAlone(take(0), traffic),
            "velocities and momentum": PassAlone(take(FIRST), traffic),
        }

    # the stages of a step

    def damp(self, rate: float, dt: float) -> tuple[float, np.ndarray]:
        """Apply the damping drag over a step dt [s] before the momentum update, exactly: point velocities decay as exp(-rate
        t) with the rate [1/s]. Returns the kinetic energy that the drag removes [J] and its impulse on the body [N s], shape
        (3,).
        """
        kept, totals = float(np.exp(-rate * dt)), self.totals
        lost, impulse = (1.0 - kept**2) * totals.kinetic, (kept - 1.0) * totals.momentum
        if kept < 1.0:
            rows = np.zeros_like(self._nodes.inertia)
            to_rows = self.mapped.content._replace(nodes=self._nodes._replace(inertia=rows))
            scatter(giving(to_rows, inertia_of(to_rows, 0.0, self._affine)))
            self.velocity_field.add_drag((1.0 - kept) * rows.reshape(-1, 4)[:, :3])
            there = self.storage.present("velocity")
            there *= kept
            if self._affine is not None:
                affine = self.storage.present("affine")
                affine[:, :FIELD_ENERGY] *= kept
                affine[:, FIELD_ENERGY:] *= kept**2
            totals.kinetic, totals.affine = kept**2 * totals.kinetic, kept**2 * totals.affine
            totals.momentum = kept * totals.momentum
        return lost, impulse

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        self._to_grid.scatter(inertia, force)

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        scatter_vectors(self.n_slabs, self.mapped, force, self.velocity_field.load_row(column - FIRST_LOAD))

    def begin_grid_to_particle(self, dt: float, remap: bool) -> None:
        """Gather the velocities of the points from the grid over a step dt [s] (G2P); if `remap`, scatter the momentum of
        points that no constraint moves back to the grid (P2G, for MUSL). In bodies that keep heat, the energy lost by the
        transfer becomes heat.
        """
        if self.rigid is None:
            each_point(self._velocity_pass(), dt, FIRST if remap and self.constraint is None else 0)
        if self.is_led(by_slabs=True):
            self._lead(remap)

    def end_grid_to_particle(self, remap: bool) -> None:
        """Complete G2P: apply constraints that prescribe velocities of the body as a whole, and sum kinetic energy, momentum
        and transfer losses. remap: True to scatter the momentum of constrained points to the grid (MUSL).
        """
        self.storage.complete("velocity")
        if self.is_led(by_slabs=False):
            self._lead(remap)
        sums = self.storage.sums()
        if (rigid := self.rigid) is not None:
            self.transfer_loss = TransferLoss(rigid.mixing)
            self._collect_momentum_sums(sums)
            return
        self.storage.short_runs.add(float(sums[VECTORS]))
        lumping, loss = float(sums[LUMPING]), float(sums[LOSS])
        if self._affine is not None:
            self.totals.affine = float(sums[AFFINE])
        if self.keeps_heat:
            self.totals.stored += float(sums[GAINED])  # for USF, in which the points were strained before
        self.transfer_loss = TransferLoss(loss, lumping, float(sums[KEPT]))
        self._collect_momentum_sums(sums)

    def is_led(self, by_slabs: bool) -> bool:
        """Return True if a constraint prescribes the velocities of the points: slab by slab (layers of grid cells) if
        `by_slabs`, otherwise of the body as a whole.
        """
        return self.constraint is not None and getattr(self.constraint, "by_slabs", False) == by_slabs

    def _lead(self, remap: bool) -> None:
        """Set the velocities of the points that the constraint of the body prescribes, if there is a constraint, and sum
        the momentum of the points; if `remap`, scatter this momentum to the grid nodes."""
        if self.constraint is not None:
            self.constraint.prescribe_velocities()
        kernels.sum_momentum(self.n_slabs, self.mapped)
        if remap:
            self._to_grid.scatter_momentum()

    def take_second_impulses(self, dt: float) -> float:
        before, second = self.totals.kinetic, self.velocity_field.second
        reached = self.storage.slabs.reached(second.layers(), self._stencil)
        kernels.add_increments(self.n_slabs, self.mapped, second.increment, reached)
        self.storage.complete("velocity")
        self._collect_momentum_sums(self.storage.sums())
        won = self.totals.kinetic - before
        if self.constraint is not None:
            self.constrain_again()
            kernels.sum_momentum(self.n_slabs, self.mapped)
            self._collect_momentum_sums(self.storage.sums())
        return won

    def update_positions(self, dt: float) -> None:
        """Move the points over a step dt [s]. If a constraint moves the body as a whole, the constraint sets all positions."""
        if self.constraint is None or self.constraint.strains:
            self._move_by_nodes(dt)
        self.prescribe_positions()
        self.storage.complete("position")

    def _move_by_nodes(self, dt: float) -> None:
        move_points(self._by_nodes, dt)

    def prescribe_positions(self) -> None:
        """Set the positions that a prescribed motion or a rigid body determines, after the points moved with the grid."""
        if self.constraint is not None:
            self.constraint.prescribe_positions()
        if self.rigid is not None:  # its velocities have rotated with it
            kernels.sum_momentum(self.n_slabs, self.mapped)
            self._collect_momentum_sums(self.storage.sums())


class MeshOnGrid(PointsOnGrid, HasContactSurface, BoundByContact):
    """Base class of films and membranes of elements in a shared velocity field. The motion of the nodes strains them, not the
    velocity gradient of the grid.
    """

    contact_surface: PointsOfNodes | None = None
    _contact_rate = 0.0
    """Reciprocal of the largest step that resolves the contact springs [1/s]."""

    def _contact_load(self, column: int) -> Callable[[np.ndarray], None]:
        """Return the function that adds contact forces on the nodes [N], shape (n, 3), in the order of the mesh; column: place
        of the work of contact forces in arrays of works.
        """

        def add(force: np.ndarray) -> None:
            load = self.velocity_field.load_row(column - FIRST_LOAD)
            scatter_vectors(self.n_slabs, self.mapped, force[self.arrays["id"]], load)

        return add

    def bound_by_contact(self, touching: Sequence[ContactSurface]) -> None:
        """Limit the time step by the contact springs if the contact surface is one of `touching`, the surfaces with possible
        contact; otherwise remove this surface.
        """
        if self.contact_surface is not None and any(other is self.contact_surface for other in touching):
            self._contact_rate = self.contact_surface.rate
        else:
            self.contact_surface = None

    def begin_stress(self, dt: float, move: bool) -> None:
        """Do nothing: the motion of the nodes strains the body, in `end_stress`."""

    def end_stress(self, dt: float, move: bool) -> None:
        """Move the nodes over dt [s] if `move` is True, and update strains, energies and step limit; with dt = 0, only compute
        energies and step limit.
        """
        if move or dt == 0.0:
            self.update_positions(dt)

    @property
    def _moving_velocity(self) -> np.ndarray:
        """Nodal velocities of the grid that strain bodies [m/s], shape (nodes, 3). The body moves with these velocities, so
        that no energy is lost between its motion and the work of its forces."""
        return self.grid.nodes.strain_velocity
