"""Solids on their own nodes in total-Lagrangian explicit dynamics (Mountris et al. 2019, section 4)."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.approximants.nodal.contract import NodalApproximant
from pellucid.bodies.meshless_solid.forces import CHUNK, ENERGY, LEAST_J, internal_forces
from pellucid.bodies.meshless_solid.nodal_fields import FIELDS, MOTION, nodal_field
from pellucid.bodies.meshless_solid.stable_step import largest_frequency
from pellucid.bodies.meshless_solid.tables import make_tables
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.contact.coupling import GridCoupling
from pellucid.contact.surface import ContactBody
from pellucid.energy import StepWork, Totals
from pellucid.errors import RunStopped
from pellucid.geometry.cells import Cells
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit.bundle import Bundle
from pellucid.materials.law import Law
from pellucid.parts.body import NodalBody, NodalSupport, Placement

RENEWED = 200  # steps between estimates of the largest frequency, which strain changes
OVERESTIMATE = 1.05  # of that frequency: power iteration approaches it from below


class SolidOfNodes(Protocol):
    """What the body asks of its model."""

    @property
    def name(self) -> str: ...
    @property
    def approximant(self) -> NodalApproximant: ...
    @property
    def points_per_cell(self) -> int: ...
    @property
    def consistent(self) -> bool: ...
    @property
    def averages_volume(self) -> bool: ...
    @property
    def density(self) -> float: ...
    def mesh_in_order(self) -> SimplexMesh: ...
    def law(self) -> Law: ...
    def initial_velocity(self, position: np.ndarray) -> np.ndarray: ...


class MeshlessSolid(NodalBody):
    """Nodes with shape functions over a background mesh. A step: `begin`, the conditions, `predict`, `correct`, `update`."""

    energy_kind = "strain"

    def __init__(self, case: SolidOfNodes, placement: Placement) -> None:
        self.name, self.mesh = case.name, case.mesh_in_order()
        tables = make_tables(
            self.mesh, case.approximant, case.law(), case.points_per_cell, case.consistent, case.averages_volume
        )
        self.solid, self._law, self._density = tables.solid, case.law(), case.density
        self._bundle = Bundle(self.solid)
        n = len(self.mesh.nodes)
        self._chunks = (n + CHUNK - 1) // CHUNK
        self._volume = tables.node_volume
        self.arrays = {
            "id": np.arange(n),
            "position": self.mesh.nodes.copy(),
            "velocity": case.initial_velocity(self.mesh.nodes),
            "mass": case.density * tables.node_volume,
            "prescribed": np.zeros((n, 3), np.int64),
        }
        self.coupling: GridCoupling | None = None
        thin = (False, False, False)
        a = self.arrays
        if placement.velocity_field is not None:
            grid_case, field = placement.on_grid()
            self.functions = grid_functions(grid_case.functions, (2, 2, 2), thin)
            self.coupling = GridCoupling(field, self.functions, a["position"], a["velocity"], a["mass"], tables.node_volume)
        increment = self.coupling.increment if self.coupling else np.zeros((n, 3))
        grid = placement.velocity_field.grid if placement.velocity_field else None
        self.motion = NodalMotion(a, grid, thin, placement.gravity, placement.n_loads, increment)
        self._dt, self._n_steps = 0.0, 0
        self._left_grid: tuple[int, int] | None = None
        self.totals = Totals()
        self.renew_totals()

    def volumes(self) -> np.ndarray:
        """Volumes of the nodes at rest [m³], shape (n,)."""
        return self._volume

    # conditions

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """A support constrains the nodes that it selects at the start."""
        self.motion.add_supports(supports)

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Let nodes follow prescribed motions."""
        self.motion.add_motions(names, numbers, axes)

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""
        self.motion.set_motion_velocities(velocity)

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the nodes [N], shape (n, 3), over this step."""
        self.motion.add_external_force(force, column)

    # the step

    def begin(self, dt: float) -> None:
        """Forget the external forces of the last step; renew the index where a node left its slab."""
        self._dt = dt
        if self.coupling:
            self.coupling.sort_if_needed()
        self.motion.loads.fill(0.0)

    def predict(self, dt: float) -> None:
        """Mass, momentum and all forces to the nodes of the grid, where there is one."""
        if self.coupling:
            self.coupling.scatter(self.motion.forces())

    def correct(self, remap: bool) -> None:
        """New velocities of the nodes; where `remap`, their momentum mapped to the grid again."""
        if self.coupling:
            self.coupling.gather()
        self.motion.advance_velocities(self._dt)
        if self.constraint is not None:
            self.constraint.prescribe_velocities()
        if remap and self.coupling:
            self.coupling.scatter_momentum()
        self.motion.sum_momentum(self.totals)

    def update(self, dt: float) -> None:
        """New positions; forces and energy there."""
        self.motion.advance_positions(dt)
        self._left_grid = self.coupling.check_positions() if self.coupling else None
        self._find_forces()

    def _find_forces(self) -> None:
        """Internal forces and energy at the positions of the nodes."""
        self._forces_at(self.arrays["position"] - self.mesh.nodes, self.motion.internal)
        nodal = float(self.solid.node_sums[:, ENERGY].sum()) if len(self.solid.block_volume) else 0.0
        self.totals.stored = float(self.solid.sums[:, ENERGY].sum()) + nodal

    def _forces_at(self, displacement: np.ndarray, force: np.ndarray) -> None:
        self.solid.displacement[:] = displacement
        internal_forces(len(self.solid.sums), self._chunks, self._bundle, force)

    def _bound_rate(self) -> None:
        """The bound on the step: 2 over the largest frequency, at the present strain."""
        frequency = largest_frequency(
            self._forces_at, self.arrays["position"] - self.mesh.nodes, self.arrays["mass"], self.arrays["prescribed"] == 0
        )
        self._frequency = OVERESTIMATE * frequency
        self.totals.rate = max(0.5 * self._frequency, self.motion.crossing)

    def renew_totals(self) -> None:
        """Find the totals of the state as it is."""
        self.motion.top_speed = self.constraint.top_speed if self.constraint is not None else 0.0
        self.motion.sum_momentum(self.totals)
        self._bound_rate()
        self._find_forces()

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the node, where a fault was found in this step."""
        for fault in (self.motion.fault(), self._left_grid):
            if fault is not None:
                self.stop(*fault, n_steps, time)
        least = self._least_volume_ratio()
        if not least > 0.0:
            cell = int(np.argmin(np.linalg.det(self.solid.deformation.reshape(-1, 3, 3)))) // self.solid.deformation.shape[1]
            place = ", ".join(f"{x:.6g}" for x in self.arrays["position"][self.mesh.cells[cell]].mean(axis=0))
            text = f"step {n_steps}, time {time:.6g} s: cell {cell} of body `{self.name}` at ({place}) m: its volume ratio is"
            raise RunStopped(f"{text} {least:.3g}, the solid is inverted; load it more slowly, or use a smaller step")
        if n_steps % RENEWED == 0:
            self._bound_rate()
            self._find_forces()
        self.totals.rate = max(0.5 * self._frequency, self.motion.crossing)

    def _least_volume_ratio(self) -> float:
        """Of the averages where the volume ratio is averaged, else of the points."""
        sums = self.solid.node_sums if len(self.solid.block_volume) else self.solid.sums
        return float(sums[:, LEAST_J].min())

    def work(self) -> StepWork:
        """Work and impulses of this step."""
        return self.motion.work()

    # contact

    @property
    def on_grid(self) -> ContactBody | None:
        """Itself, where there is a grid."""
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

    def half_width(self) -> tuple[float, float, float]:
        """None: nodes lie on the surface."""
        return 0.0, 0.0, 0.0

    # checkpoint and results

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of the nodes, the bound on the step, and the index of the nodes by cell."""
        by_cell = self.coupling.state_arrays() if self.coupling else {}
        index = {f"index/{name}": array for name, array in by_cell.items()}
        return {**self.arrays, "frequency": np.array([self._frequency]), **index}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from such arrays."""
        for name, array in self.arrays.items():
            array[...] = arrays[name]
        self._frequency = float(arrays["frequency"][0])
        self._find_forces()
        if self.coupling:
            self.coupling.restore({name[6:]: array for name, array in arrays.items() if name.startswith("index/")})

    def cells(self) -> Cells:
        """Its tetrahedra."""
        return Cells(tetrahedra=self.mesh.cells)

    @property
    def field_names(self) -> list[str]:
        """The fields that results show."""
        return list(FIELDS)

    def field(self, name: str) -> np.ndarray:
        """A field of the nodes; stresses are means over the cells about a node."""
        if name == "kinetic_energy":
            return self.kinetic_energies()
        return self.arrays[name] if name in MOTION else nodal_field(name, self.mesh, self.solid, self._law, self._density)
