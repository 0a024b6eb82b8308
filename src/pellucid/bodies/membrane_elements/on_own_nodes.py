"""Membranes of finite elements that move on their own nodes (Lian, Liu & Zhang 2014, section 4)."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies.membrane_elements.overlong import overlong
from pellucid.bodies.membrane_elements.surface import FIELDS, OF_NODES, ElementSurface, MembraneOfElements
from pellucid.bodies.own_nodes.kernels import CHUNK
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.contact.coupling import GridCoupling
from pellucid.contact.surface import ContactBody
from pellucid.energy import FIRST_LOAD, StepWork, Totals
from pellucid.geometry.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle
from pellucid.parts.body import NodalBody, NodalSupport


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
        increment = self.coupling.increment if self.coupling else np.zeros((n, 3))
        self.motion = NodalMotion(self.arrays, self.grid, self._thin, gravity, n_loads, increment)
        self._left_grid: tuple[int, int] | None = None
        self._dt = 0.0
        self.totals = Totals()
        surface.bind(self.arrays["id"], np.minimum(np.arange(self.motion.chunks + 1) * CHUNK, n))
        self.renew_totals()

    def volumes(self) -> np.ndarray:
        """Shares of the volumes of the elements about each node [m³], shape (n,)."""
        return self.surface.mesh.at_nodes(self.element_arrays["volume"])

    # conditions

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """A support constrains the nodes that it selects at the start; none passes a face of the grid that is a wall."""
        self.motion.add_supports(supports)

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Let nodes follow prescribed motions."""
        self.motion.add_motions(names, numbers, axes)

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""
        self.motion.set_motion_velocities(velocity)

    # the step

    def begin(self, dt: float) -> None:
        """Forget the external forces of the last step; renew the index where a node left its slab."""
        self._dt = dt
        if self.coupling:
            self.coupling.sort_if_needed()
        self.motion.loads.fill(0.0)

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the nodes [N], shape (n, 3), over this step."""
        self.motion.add_external_force(force, column)

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add the forces of a pressure [Pa] along the normals over this step."""
        self.surface.add_pressure_forces(self.arrays["position"], pressure, self.motion.loads[column - FIRST_LOAD])

    def predict(self, dt: float) -> None:
        """Forces of the elements; mass, momentum and all forces to the nodes of the grid, where there is one."""
        self.motion.internal.fill(0.0)
        self.surface.add_internal_forces(self.arrays["position"], self.motion.internal)
        if self.coupling:
            self.coupling.scatter(self.motion.forces())

    def correct(self, remap: bool) -> None:
        """New velocities of the nodes; where `remap`, their momentum mapped to the grid again, and the damping within cells."""
        pressed = self.coupling is not None and bool(self.coupling.gather().any())
        self.motion.advance_velocities(self._dt)
        if self.constraint is not None:
            self.constraint.prescribe_velocities()
        if remap and self.coupling:
            self.coupling.scatter_momentum()
            if pressed:
                self.motion.subtract_velocities(self.coupling.subcell_loss(), self._dt)
        self.motion.sum_momentum(self.totals)

    def update(self, dt: float) -> None:
        """New positions; strains, stresses and energies of the elements, and the bound on the step."""
        position, velocity = self.arrays["position"], self.arrays["velocity"]
        self.motion.advance_positions(dt)
        self._left_grid = self.coupling.check_positions() if self.coupling else None
        rate = self.surface.strain(position, velocity, dt, self.totals)
        self.totals.rate = max(rate, self.motion.crossing)

    def renew_totals(self) -> None:
        """Find the totals of the state as it is."""
        self.motion.top_speed = self.constraint.top_speed if self.constraint is not None else 0.0
        self.motion.sum_momentum(self.totals)
        self.update(0.0)

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the node, where a fault was found in this step."""
        for fault in (self.motion.fault(), self._left_grid, self.surface.fault()):
            if fault is not None:
                self.stop(*fault, n_steps, time)

    def work(self) -> StepWork:
        """Work and impulses of this step."""
        return self.motion.work()

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
