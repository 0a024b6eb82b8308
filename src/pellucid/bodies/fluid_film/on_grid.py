"""Fluid films that share a velocity field with other bodies: the nodes of the grid move them.

Such a film is the surface of a drop or a vesicle in a flow, without slip. The surrounding fluid acts on it through the
inertia and the stress on the grid; the film needs no drag, and the fluid inside keeps its volume. The forces of the film
are explicit. Bending forces act at the length of the film's elements, but the grid cannot move them in waves shorter than
its cells. The cells therefore limit the step, not the elements.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from pellucid.bodies.fluid_film.body import FIELDS, NodalFields
from pellucid.bodies.fluid_film.forces import FilmForces, Signals, dissipation, in_space
from pellucid.bodies.fluid_film.loop_surface import LoopSurface, limit_matrix
from pellucid.bodies.own_nodes.contact_surface import PointsOfNodes
from pellucid.bodies.own_nodes.kernels import power
from pellucid.bodies.points_on_grid import MeshOnGrid
from pellucid.energy import FIRST_LOAD, INTERNAL, VISCOUS, StepWork, no_work
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.enclosure import inside
from pellucid.grid.model import GridCase
from pellucid.grid.passes.moving import move_points
from pellucid.grid.transfer import gather_vectors, scatter_vectors
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.parts.capabilities import Membrane, TakesTractions, Traction
from pellucid.state import of_owner
from pellucid.step.limit import StepLimit, springs_of_contact, tightest

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.model import FluidFilmCase

OF_POINTS = ("id", "velocity", "mass", "kinetic_energy")


class FilmOnGrid(MeshOnGrid, Membrane, TakesTractions):
    """A film whose nodes move with a velocity field that other bodies share.

    For a Loop surface the points are the control vertices, near the surface but not on the surface. Points are numbered as
    in the initial shape; the array `node` holds the number of each point in the geometry. `v`, the velocities of the last
    step [m/s], and `part_mass`, the masses of the parts of the film (pieces that belong to a node or an element) [kg], are
    in the order of the geometry.
    """

    energy_kind = "strain"

    def __init__(
        self, case: "FluidFilmCase", grid_case: GridCase, velocity_field: VelocityField, velocity_transfer: VelocityTransfer
    ) -> None:
        self.geometry, x = case.geometry()
        self.forces = FilmForces(self.geometry, case.material, case.physics(), case.initial_density)
        self._o = self.geometry.operators(x)
        self._heat_of_viscosity = 0.0
        self._spreads = case.nodes == "even"
        self._slice = grid_case.slice_thickness() if any(grid_case.thin()) else 1.0  # curves are a metre deep
        self.areal_density = case.initial_density
        part_mass = case.initial_density * self.forces.part_areas(self._o)
        n = len(x)
        self._film = {
            "x": x,
            "v": np.zeros_like(x),
            "part_mass": part_mass,
            **{name: np.zeros((n, 3)) for name in ("position", "velocity")},
            "mass": np.zeros(n),
        }
        self._fields = NodalFields(self.forces, self._film, is_around=False)
        self._fields.show(self._o)
        position, numbers = in_space(x, self.geometry.axes), case.shape.numbers()
        self._numbers = numbers.copy()
        arrays = {
            "id": numbers,
            "node": np.arange(n),
            "position": position,
            "velocity": case.initial_velocity(position[np.argsort(numbers)])[numbers],
            "mass": self._slice * self._film["mass"],
            "volume": np.zeros(n),
        }
        self.element_arrays = {name: self._film[name] for name in ("x", "v", "part_mass")}
        functions = velocity_field.grid.functions((2, 2, 2))  # nodes have no extent
        super().__init__(case.name, velocity_field, functions, velocity_transfer, arrays)

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the state arrays for a checkpoint, including the ones on which the shape functions of the geometry depend."""
        kept = {f"geometry/{name}": array for name, array in self.geometry.state_arrays().items()}
        return {**super().state_arrays(), **kept}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        self.geometry.restore(of_owner("geometry", arrays))
        super().restore(arrays)
        self._show()

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        self.geometry.restore(of_owner("geometry", state))
        super().load_state(state)
        self._show()

    # forces

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        if inertia:
            self._to_grid.scatter(inertia=True, force=False)
        if force:
            self._scatter(self._internal_force(), self.grid.nodes.force)

    def _internal_force(self) -> np.ndarray:
        """Return the internal force on the nodes in the order of the geometry, shape (n, d) [N; N per metre of depth for a
        curve]."""
        return self.forces.internal_force(self._o, self._film["part_mass"], self._film["v"])

    def add_traction(self, traction: Traction, column: int, label: str) -> None:
        force = self.forces.traction_force(self._o, self._film["part_mass"], traction, 0.0)
        self._scatter(force, self.velocity_field.load_row(column - FIRST_LOAD))

    def _scatter(self, force: np.ndarray, target: np.ndarray) -> None:
        """Scatter forces on the nodes of the film [N; N per metre of depth for a curve], shape (n, d), to the nodal forces
        `target` of the grid.
        """
        forces = self._slice * in_space(force, self.geometry.axes)[self.arrays["node"]]
        scatter_vectors(self.n_slabs, self.mapped, forces, target)

    # contact

    def make_contact_surface(self, column: int) -> PointsOfNodes | None:
        """Return the contact surface of the film, with contact points on the film at its nodes; contact forces act on these
        nodes.

        column: index of the contact work in the works of a step.
        """

        def velocities() -> np.ndarray:
            velocity = np.empty((len(self._numbers), 3))
            velocity[self._numbers] = in_space(self._film["v"], self.geometry.axes)
            return velocity

        how = self.pressed_areas, self.surface_areas(), self._contact_load(column), lambda nodes: None
        surface = PointsOfNodes(self.grid, self.cells(), self.places, velocities, *how, shares=self._limit_shares())
        surface.triangles = None  # it has no thickness, by which layers of triangles keep their sides
        surface.mass_per_area, surface.rate = self.areal_density, self.totals.rate
        self.contact_surface = surface
        return surface

    def _limit_shares(self) -> sparse.csr_array | None:
        """Return the matrix that maps nodal positions to the limit positions of a Loop surface, shape (n, n), in the order of
        the point numbers; None if the surface passes through its nodes."""
        if not isinstance(self.geometry, LoopSurface):
            return None
        of_geometry = limit_matrix(self.geometry.rings).tocoo()
        numbers, n = self._numbers, len(self._numbers)
        entries = of_geometry.data, (numbers[of_geometry.row], numbers[of_geometry.col])
        return sparse.csr_array(entries, shape=(n, n))

    def encloses(self, places: np.ndarray) -> bool:
        cells, own = self.cells(), self.places()
        if len(cells.triangles):
            return bool(inside(places, own, cells.triangles).all())
        first, second = cells.lines.T
        n, z = len(own), np.array((0.0, 0.0, 1.0))
        flat = own * (1.0, 1.0, 0.0)
        band = np.concatenate([np.stack([first, second, second + n], axis=1), np.stack([first, second + n, first + n], axis=1)])
        return bool(inside(places * (1.0, 1.0, 0.0) + 0.5 * z, np.concatenate([flat, flat + z]), band).all())

    # motion

    def update_positions(self, dt: float) -> None:
        """Move the nodes over a step dt [s], redistribute them evenly along the film, and update energies and step limit."""
        film, order, axes = self._film, self.arrays["node"], list(self.geometry.axes)
        move_points(self._by_nodes, dt)
        self.storage.complete("position")
        if dt > 0.0:
            x = np.empty_like(film["x"])
            x[order] = self.points.position[:, axes]
            moved = x - film["x"]
            film["v"][:], film["x"][:] = moved / dt, x
            heating = dissipation(self._o, self.forces.physics, film["v"][self.geometry.nodes]).viscous
            self._heat_of_viscosity = dt * self._slice * heating
            if self._spreads:
                self._spread(moved)
            else:
                self._show()
        force, velocity = (in_space(vectors, self.geometry.axes) for vectors in (self._internal_force(), film["v"]))
        self.totals.half_power = 0.5 * self._slice * power(force, velocity)
        self.totals.stored = self._slice * self.forces.stored_energy(self._o, film["part_mass"])
        fastest = float(np.sqrt(np.max(np.sum(self.points.velocity**2, axis=1))))
        h = self.grid.lattice.inverse_cell
        self._bound_rate(max(self._signals().rate(h) + fastest * h, self._contact_rate))

    def _spread(self, moved: np.ndarray) -> None:
        """Redistribute nodes and mass evenly along the film, conserving total momentum. moved: displacement of the nodes in the
        step [m], shape (n, d)."""
        film, points, order = self._film, self.points, self.arrays["node"]
        x, film["part_mass"][:] = self.geometry.redistributed(film["x"], film["part_mass"], moved)
        stay = np.array_equal(x, film["x"])
        film["x"][:] = x
        self._show()
        if stay:
            return
        momentum, before = points.mass @ points.velocity, self._of_grid()
        points.position[:, list(self.geometry.axes)] = x[order]
        points.velocity[:] += self._of_grid() - before  # change of the grid velocity from the old to the new positions
        points.mass[:] = self._slice * film["mass"][order]
        points.velocity[:] += (momentum - points.mass @ points.velocity) / points.mass.sum()
        self.storage.slabs.left_slab[:] = 1

    def _show(self) -> None:
        """Compute geometry and strain operators of the film at its present positions, and update the fields of the results at
        its nodes.
        """
        self._o = self.geometry.operators(self._film["x"])
        self._fields.show(self._o)

    def _of_grid(self) -> np.ndarray:
        """Interpolate the velocities with which the grid strains the bodies to the nodes of the film [m/s], shape (n, 3)."""
        found = np.empty_like(self.points.position)
        gather_vectors(self.n_slabs, self.mapped, self.grid.nodes.strain_velocity, found)
        self.storage.shared.fill(found)
        return found

    def _signals(self) -> Signals:
        """Return the wave speed, the diffusivity of momentum and the bending coefficient of the film in its present state,
        which limit the time step (see `Signals`).
        """
        return Signals(self.forces.physics, self.forces.material, self.forces.densities(self._o, self._film["part_mass"]))

    def signal_limit(self) -> StepLimit:
        limit = self._signals().limit(self.grid.lattice.cell, self.fastest())
        return limit if self._contact_rate == 0.0 else tightest([limit, springs_of_contact(self._contact_rate)])

    def work(self) -> StepWork:
        done = no_work(VISCOUS + 1, 0)
        done.works[[VISCOUS, INTERNAL]] = self._heat_of_viscosity  # the internal work of the grid has it too
        return done

    # data for other parts

    def half_width(self) -> tuple[float, float, float]:
        """Return zeros: a film has no thickness, so that contact begins at its nodes."""
        return 0.0, 0.0, 0.0

    def vector_areas(self) -> np.ndarray:
        """Return ∫ N_I n dA around each node I [m²], shape (n, 3), in the present storage order of the nodes; N_I is its shape
        function, n the normal."""
        return self._slice * in_space(self.forces.vector_areas(self._o), self.geometry.axes)[self.arrays["node"]]

    def pressed_areas(self) -> np.ndarray:
        return self.vector_areas()[self.order()]

    def surface_areas(self) -> np.ndarray:
        return self._slice * self._fields.areas(self._o)[np.argsort(self._numbers)]

    def cells(self) -> Cells:
        return self.geometry.cells().renumbered(self._numbers)

    @property
    def field_names(self) -> list[str]:
        return list(FIELDS)

    def stored_field(self, name: str) -> np.ndarray:
        return super().stored_field(name) if name in OF_POINTS else self._fields.field(name)[self.arrays["node"]]
