"""Membranes of finite elements that move on their own nodes (Lian, Liu & Zhang 2014, section 4)."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies.membrane_elements import nodes as kernels
from pellucid.bodies.membrane_elements.nodes import (
    CHUNK,
    CONTACT_IMPULSE,
    EXTRA_ROWS,
    FASTEST,
    NODE_SUMS,
    OTHER_IMPULSE,
    NodeForces,
)
from pellucid.bodies.membrane_elements.overlong import overlong
from pellucid.bodies.membrane_elements.surface import FIELDS, OF_NODES, ElementSurface, MembraneOfElements
from pellucid.contact.coupling import GridCoupling
from pellucid.contact.surface import ContactBody
from pellucid.energy import FIRST_LOAD, MOTION, SUPPORT, StepWork, Totals, row_length, step_work
from pellucid.geometry.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.grid.points import KINETIC, MOMENTUM_X, SPEED
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle
from pellucid.parts.body import NodalBody, NodalSupport
from pellucid.reductions import ordered_sum


class MembraneElements(NodalBody):
    """Elements that have a velocity field to themselves: their nodes move by their own forces; the grid serves contact.

    Without a grid nothing can touch them. A step: `begin`, the conditions, `predict`, `correct` when contact is resolved,
    `update`. Nodes keep the order of the mesh.
    gravity: acceleration [m/s²]; n_loads: channels of external forces.
    """

    energy_kind = "strain"
    is_surface = True

    def __init__(
        self,
        case: MembraneOfElements,
        grid_case: GridCase | None,
        velocity_field: VelocityField | None,
        gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
        n_loads: int = 0,
    ) -> None:
        self.name, self.velocity_field = case.name, velocity_field
        self.grid = velocity_field.grid if velocity_field else None
        self._thin = grid_case.thin() if grid_case else (False, False, False)
        self.surface = surface = ElementSurface(case, grid_case)
        self.element_arrays = surface.arrays
        self.areal_density = surface.areal_density
        n = len(surface.vertices)
        velocity = case.initial_velocity(surface.vertices)
        velocity[:, np.array(self._thin)] = 0.0
        self.arrays = {
            "id": np.arange(n),
            "position": surface.vertices,
            "velocity": velocity,
            "mass": surface.node_mass,
            "prescribed": np.zeros((n, 3), np.int64),
        }
        # nodes have no extent: GIMP takes half a cell
        self.coupling: GridCoupling | None = None
        if grid_case is not None and velocity_field is not None:
            self.functions = grid_functions(grid_case.functions, (2, 2, 2), self._thin)
            self.coupling = GridCoupling(velocity_field, self.functions, surface.vertices, velocity, surface.node_mass)
        self._increment = self.coupling.increment if self.coupling else np.zeros((n, 3))
        self._chunks = (n + CHUNK - 1) // CHUNK
        self._gravity, self._columns = gravity, FIRST_LOAD + n_loads
        self._internal, self._loads = np.zeros((n, 3)), np.zeros((n_loads, n, 3))
        self._sums, self._fault = np.zeros((self._chunks, NODE_SUMS)), np.zeros((self._chunks, 2), np.int64)
        self._left_grid: tuple[int, int] | None = None
        self._dt = self._crossing = self._top_speed = 0.0
        self._supports: Sequence[NodalSupport] = ()
        self._motions: list[str] = []
        self._motion_of_node, self._axes = np.zeros(n, np.int64), np.zeros((0, 3), np.int64)
        self.totals = Totals()
        surface.bind(self.arrays["id"], np.minimum(np.arange(self._chunks + 1) * CHUNK, n))
        self._constrain()
        self.renew_totals()

    def volumes(self) -> np.ndarray:
        """Shares of the volumes of the elements about each node [m³], shape (n,)."""
        return self.surface.mesh.at_nodes(self.element_arrays["volume"])

    # supports and prescribed motions

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """A support constrains the nodes that it selects at the start; none passes a face of the grid that is a wall."""
        self._supports = supports
        self._constrain()

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Let nodes follow prescribed motions."""
        self._motions, self._motion_of_node, self._axes = list(names), numbers, axes
        self._constrain()

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""
        first = len(self._supports)
        self._rows[first : first + len(velocity)] = velocity

    def _constrain(self) -> None:
        """Number the constraints of the nodes: supports, prescribed motions, and last the thin axes."""
        position, prescribed = self.arrays["position"], self.arrays["prescribed"]
        n_supports, n_rows = len(self._supports), len(self._supports) + len(self._motions) + 1
        prescribed.fill(0)
        walls = np.zeros((3, 2), np.int64)
        for row, support in enumerate(self._supports, start=1):
            prescribed[np.ix_(support.selects(position), np.flatnonzero(support.axes))] = row
            if support.wall is not None:
                walls[support.wall] = row
        for number, axes in enumerate(self._axes, start=1):
            prescribed[np.ix_(self._motion_of_node == number, np.flatnonzero(axes))] = n_supports + number
        prescribed[(prescribed == 0) & np.array(self._thin)] = n_rows
        self._rows = np.zeros((n_rows, 3))
        self._rows[:n_supports] = [support.velocity for support in self._supports] or np.zeros((0, 3))
        self._work = np.zeros((self._chunks, row_length(self._columns, n_rows + EXTRA_ROWS)))
        faces = np.tile((-np.inf, np.inf), (3, 1))
        if self.grid:
            lattice = self.grid.lattice
            ends = zip(lattice.lower, lattice.counts, strict=True)
            faces = np.array([(low, low + n / lattice.inverse_cell) for low, n in ends])
        a = self.arrays
        acting = (self._internal, self._loads, self._gravity, self._increment, prescribed, self._rows)
        self._forces = Bundle(NodeForces(a["position"], a["velocity"], a["mass"], *acting, faces, walls, self._work))

    # the step

    def begin(self, dt: float) -> None:
        """Forget the external forces of the last step; renew the index where a node left its slab."""
        self._dt = dt
        if self.coupling:
            self.coupling.sort_if_needed()
        self._loads.fill(0.0)

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the nodes [N], shape (n, 3), over this step."""
        self._loads[column - FIRST_LOAD] += force

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add the forces of a pressure [Pa] along the normals over this step."""
        self.surface.add_pressure_forces(self.arrays["position"], pressure, self._loads[column - FIRST_LOAD])

    def predict(self, dt: float) -> None:
        """Forces of the elements; mass, momentum and all forces to the nodes of the grid, where there is one."""
        self._internal.fill(0.0)
        self.surface.add_internal_forces(self.arrays["position"], self._internal)
        if self.coupling is None:
            return
        force = self._internal + self._loads.sum(axis=0) if len(self._loads) else self._internal
        if any(self._gravity):
            force = force + self.arrays["mass"][:, None] * np.array(self._gravity)
        self.coupling.scatter(force)

    def correct(self, remap: bool) -> None:
        """New velocities of the nodes; where `remap`, their momentum mapped to the grid again, and the damping within cells."""
        pressed = self.coupling is not None and bool(self.coupling.gather().any())
        kernels.advance_velocities(self._chunks, self._forces, self._dt)
        if self.constraint is not None:
            self.constraint.prescribe_velocities()
        if remap and self.coupling:
            self.coupling.scatter_momentum()
            if pressed:
                kernels.subtract_velocities(self._chunks, self._forces, self.coupling.subcell_loss(), self._dt)
        self._sum_momentum()

    def update(self, dt: float) -> None:
        """New positions; strains, stresses and energies of the elements, and the bound on the step."""
        position, velocity = self.arrays["position"], self.arrays["velocity"]
        kernels.advance_positions(self._chunks, position, velocity, dt, self._fault)
        self._left_grid = self.coupling.check_positions() if self.coupling else None
        rate = self.surface.strain(position, velocity, dt, self.totals)
        self.totals.rate = max(rate, self._crossing)

    def renew_totals(self) -> None:
        """Find the totals of the state as it is."""
        self._top_speed = self.constraint.top_speed if self.constraint is not None else 0.0
        self._sum_momentum()
        self.update(0.0)

    def _sum_momentum(self) -> None:
        kernels.sum_momentum(self._chunks, self.arrays["velocity"], self.arrays["mass"], self._sums)
        sums = ordered_sum(self._sums)
        totals = self.totals
        totals.kinetic, totals.momentum_size = float(sums[KINETIC]), float(sums[SPEED])
        totals.momentum = sums[MOMENTUM_X : MOMENTUM_X + 3].copy()
        if self.grid:  # no node passes a cell in a step
            fastest = max(float(self._sums[:, FASTEST].max()), self._top_speed)
            self._crossing = fastest * self.grid.lattice.inverse_cell

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the node, where a fault was found in this step."""
        found = np.flatnonzero(self._fault[:, 0])
        if len(found):
            self.stop(int(self._fault[found[0], 0]), int(self._fault[found[0], 1]), n_steps, time)
        for fault in (self._left_grid, self.surface.fault()):
            if fault is not None:
                self.stop(*fault, n_steps, time)

    def work(self) -> StepWork:
        """Work and impulses of this step; reactions to prescribed motions count as work of the motions, not of the supports."""
        sums = ordered_sum(self._work)
        impulses = sums[self._columns + 1 :].reshape(-1, 3)
        n_supports, rows = len(self._supports), len(self._rows)
        motions = slice(n_supports, rows - 1)
        motion_work = float(np.sum(impulses[motions] * self._rows[motions]))
        reactions = np.concatenate([impulses[:n_supports], impulses[rows - 1 : rows], impulses[rows + OTHER_IMPULSE :][:1]])
        whole = step_work(np.concatenate([sums[: self._columns + 1], reactions.ravel()]), self._columns)
        whole.works[SUPPORT] -= motion_work
        whole.works[MOTION] += motion_work
        return whole._replace(motions=dict(zip(self._motions, impulses[motions], strict=True)))

    @property
    def contact_impulse(self) -> np.ndarray:
        """Of contact over this step on the nodes [N s], shape (3,)."""
        impulses = ordered_sum(self._work)[self._columns + 1 :].reshape(-1, 3)
        return np.asarray(impulses[len(self._rows) + CONTACT_IMPULSE])

    # contact

    @property
    def on_grid(self) -> ContactBody | None:
        """Itself, where there is a grid: its nodes then have an index by cell."""
        return self if self.coupling else None

    def _coupled(self) -> GridCoupling:
        if self.coupling is None:
            raise ValueError(f"body {self.name} was given no grid")
        return self.coupling

    @property
    def mapped(self) -> Bundle:
        """The nodes as the kernels of `pellucid.grid.transfer` take them."""
        return self._coupled().mapped

    @property
    def n_slabs(self) -> int:
        """Number of slabs into which the index of the nodes is divided."""
        return self._coupled().n_slabs

    def cells(self) -> Cells:
        """Its elements."""
        return self.surface.cells

    def half_width(self) -> tuple[float, float, float]:
        """Half the thickness."""
        return 0.5 * self.surface.thickness, 0.0, 0.0

    def vector_areas(self) -> np.ndarray:
        """∫ N_K n dA about each node [m²], shape (n, 3)."""
        return self.surface.vector_areas(self.arrays["position"])

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """Where its elements have outgrown the cells."""
        if self.grid is None:
            return None
        return overlong(self.name, self.surface.mesh.corners, self.arrays["position"], self.grid, nodes)

    # checkpoint and results

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of the nodes and elements, and the index of the nodes by cell."""
        elements = {f"elements/{name}": array for name, array in self.element_arrays.items()}
        by_cell = self.coupling.state_arrays() if self.coupling else {}
        index = {f"index/{name}": array for name, array in by_cell.items()}
        return {**self.arrays, **elements, **index}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from such arrays."""
        for name, array in self.arrays.items():
            array[...] = arrays[name]
        for name, array in self.element_arrays.items():
            array[...] = arrays[f"elements/{name}"]
        if self.coupling:
            self.coupling.restore({name[6:]: array for name, array in arrays.items() if name.startswith("index/")})

    @property
    def field_names(self) -> list[str]:
        """The fields that results show."""
        return list(FIELDS)

    def field(self, name: str) -> np.ndarray:
        """A field of the nodes; see `ElementSurface.field`."""
        if name == "kinetic_energy":
            return self.kinetic_energies()
        return self.arrays[name] if name in OF_NODES else self.surface.field(name, self.arrays["position"], self.arrays["mass"])
