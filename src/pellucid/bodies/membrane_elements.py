"""Membranes of finite elements that move on their own nodes (Lian, Liu & Zhang 2014, section 4)."""

from typing import Any

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies import element_forces as forces
from pellucid.bodies import element_nodes
from pellucid.bodies.element_kernels import CHUNK, HOURGLASS, RATE, STRAIN, SUMS, ElementArrays, strain
from pellucid.bodies.element_mesh import ElementMesh
from pellucid.bodies.element_nodes import CONTACTING, EXTRA_ROWS, LOADING, WORKS, NodeForces
from pellucid.bodies.elements_spec import MembraneElementsCase
from pellucid.bodies.point_body import PointBody
from pellucid.bundle import Bundle
from pellucid.grid import transfer
from pellucid.grid.driving import spread_momentum, sum_motion
from pellucid.grid.grid import Grid
from pellucid.grid.motion import StepWork, no_work
from pellucid.grid.points import RATE as NODE_RATE
from pellucid.grid.points import PointArrays, Slabs
from pellucid.grid.sorting import MOST_SLABS
from pellucid.grid.spec import GridCase
from pellucid.grid.velocity_transfer import Flip
from pellucid.materials.membrane import initial_shape
from pellucid.reductions import ordered_sum

FIELDS = ("id", "position", "velocity", "mass", "thickness", "stress", "strain_energy", "density", "pressure")


class MembraneElements(PointBody):
    """Quadrilaterals and triangles in plane stress; the points of the body are their nodes.

    A step: `begin`, `press` for each pressure, `to_grid`, `accelerate` when `grid.nodes.contact` is known, `deform`.

    gravity: acceleration [m/s²]; top_speed: of what is prescribed [m/s], for the bound on the step; prescribed_velocity, shape
    (rows, 3) [m/s]: read at every step; work: what the nodes did over the step, its `impulses` those of the prescribed rows;
    contact_work [J] and contact_impulse [N s], shape (3,): of ties and contact over the step.
    """

    energy_kind = "strain"
    is_surface = True
    own_nodes = True

    def __init__(self, case: MembraneElementsCase, grid_case: GridCase, grid: Grid, velocity_transfer: Any) -> None:
        self.material = case.material
        self.law: Any = case.material.law()
        self.thickness = case.thickness
        self.control = case.hourglass.control()
        self.gravity, self.top_speed = (0.0, 0.0, 0.0), 0.0
        vertices, self.quads, self.triangles = mesh = case.mesh()
        self._mesh = ElementMesh(mesh)
        n, m = self._mesh.n_nodes, len(self._mesh.corners)
        volume = case.thickness * self._mesh.areas(vertices)
        mass = case.material.density * volume
        turn = np.zeros((m, 2))
        turn[:, 0] = 1.0
        self.element_arrays: dict[str, np.ndarray] = {
            "element_mass": mass,
            "shape": np.tile(np.array(initial_shape(self.law)), (m, 1)),
            "turn": turn,
            "plane_stress": np.zeros((m, 3)),
            "thickness": np.full(m, case.thickness),
            "volume": volume,
            "strain_energy": np.zeros(m),
            "hourglass": np.zeros((m, 2)),
            "hourglass_energy": np.zeros(m),
        }
        self._chunks = (m + CHUNK - 1) // CHUNK
        self._element_sums, self._element_fault = np.zeros((self._chunks, SUMS)), np.zeros((self._chunks, 2), np.int64)
        self._corner_forces = np.zeros((m, 4, 3))
        self._internal, self._external = np.zeros((n, 3)), np.zeros((n, 3))
        # along thin axes nothing moves
        self.prescribed_velocity = np.zeros((1, 3))
        self._work = np.zeros((MOST_SLABS, WORKS + 3 * (EXTRA_ROWS + 1)))
        self._dt = 0.0
        arrays = {
            "id": np.arange(n),
            "position": vertices,
            "velocity": np.tile(np.array(case.velocity), (n, 1)),
            "mass": self._mesh.at_nodes(mass),
            "prescribed": np.tile(np.array(grid.thin, np.int64), (n, 1)),
        }
        # nodes of their own keep their velocity, which is what FLIP does; they have no extent: GIMP takes half a cell
        functions = grid_functions(grid_case.functions, (2, 2, 2), grid.thin)
        super().__init__(case.name, grid, functions, Flip(), arrays)
        self._total_mass = float(self.points.mass.sum())
        self.work, self.contact_work, self.contact_impulse = self._no_work(), 0.0, np.zeros(3)

    def bind(self) -> None:
        """Take up arrays that were replaced."""
        a = self.arrays
        self.points = PointArrays(a["position"], a["velocity"], a["mass"], np.zeros(0), np.zeros((0, 6)))
        self._affine = np.zeros((0, 9))
        self._carried = ElementArrays(*(self.element_arrays[name] for name in ElementArrays._fields))

    def _share(self, slabs: Slabs) -> None:
        super()._share(slabs)
        number = self.arrays["id"]
        where = np.argsort(number)  # from a node's number to its place
        corners = where[self._mesh.corners]
        self._surface = Bundle(corners, self._mesh.n_quads, self.law, self.control, self.thickness, self._carried)
        self._about = Bundle(slabs, number, self._mesh.fan)
        self._bind_forces()

    def _bind_forces(self) -> None:
        acting = (self._internal, self._external, self.arrays["prescribed"], self.prescribed_velocity, self._work)
        self._acting = Bundle(NodeForces(*acting))

    def set_prescribed(self, numbers: np.ndarray, rows: int) -> None:
        """Which directions of the nodes have a prescribed velocity, each 0 or one more than its row.

        numbers: shape (n, 3), of the nodes in the order of the mesh; rows: their number. Thin axes that nobody holds are held
        by the last row. The velocities of the rows are zero until `prescribed_velocity` is filled.
        """
        held = np.where((numbers == 0) & np.array(self.grid.thin), rows, numbers)
        self.arrays["prescribed"][:] = held[self.arrays["id"]]
        self.prescribed_velocity = np.zeros((rows, 3))
        self._work = np.zeros((MOST_SLABS, WORKS + 3 * (EXTRA_ROWS + rows)))
        self._bind_forces()
        self.work = self._no_work()

    # the verbs of a step

    def begin(self, dt: float) -> None:
        """Internal forces at the start of a step dt [s]; no external ones yet."""
        self._dt = dt
        self._internal.fill(0.0)
        self._external.fill(0.0)
        forces.internal_forces(self._chunks, self._surface, self.points.position, self._corner_forces)
        forces.add_corners(self.n_slabs, self._about, self._corner_forces.reshape(-1, 3), self._internal)

    def press(self, outside_load: np.ndarray, pressure: float) -> None:
        """Add the forces of a pressure [Pa] along the normals; `outside_load`, that of the grid's nodes, stays as it is."""
        forces.pressure_forces(self._chunks, self._surface, self.points.position, self._corner_forces, pressure)
        forces.add_corners(self.n_slabs, self._about, self._corner_forces.reshape(-1, 3), self._external)

    def half_width(self) -> tuple[float, float, float]:
        """Half the thickness."""
        return 0.5 * self.thickness, 0.0, 0.0

    def vector_areas(self) -> np.ndarray:
        """∫ N_K n dA about each node [m²], shape (n, 3), in the order in which the nodes are stored at the moment."""
        areas = np.zeros((self.n_points, 3))
        forces.pressure_forces(self._chunks, self._surface, self.points.position, self._corner_forces, 1.0)
        forces.add_corners(self.n_slabs, self._about, self._corner_forces.reshape(-1, 3), areas)
        return areas

    def to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum, nodal forces."""
        if inertia:
            transfer.scatter(self.n_slabs, self.mapped, 1, 0)
        if force:
            element_nodes.spread_forces(self.n_slabs, self.mapped, self._acting)

    def accelerate(self, remap: bool) -> None:
        """New velocities of the nodes; where `remap`, their momentum on the grid anew."""
        element_nodes.accelerate(self.n_slabs, self.mapped, self._acting, self.gravity, self._dt)
        if self.constraint is not None:
            self.constraint.steer()
        sum_motion(self.n_slabs, self.mapped)
        if remap:
            spread_momentum(self.n_slabs, self.mapped)
        self._collect_motion_sums()
        self._collect_work()

    def deform(self, dt: float, move: bool) -> None:
        """Where `move`, new positions, and what the elements make of them; with dt = 0 what they make of what they carry."""
        if move or dt == 0.0:
            self._advance(dt)

    def move(self, dt: float) -> None:
        """New positions, and what the elements make of them."""
        self._advance(dt)

    def _advance(self, dt: float) -> None:
        element_nodes.move(self.n_slabs, self.mapped, dt)
        x, v = self.points.position, self.points.velocity
        strain(self._chunks, self._surface, x, v, self._element_sums, self._element_fault, dt)
        sums = ordered_sum(self._element_sums)
        self.sums["hourglass"] = float(sums[HOURGLASS])
        self.sums["stored"] = float(sums[STRAIN]) + self.sums["hourglass"]
        self.sums["heating"] = 0.0
        crossing = max(float(self.slabs.sums[:, NODE_RATE].max()), self.top_speed * self.grid.lattice.inverse_cell)
        self.sums["rate"] = max(float(self._element_sums[:, RATE].max()), crossing)

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the node, where a kernel found a fault in this step."""
        super().check(n_steps, time)
        found = np.flatnonzero(self._element_fault[:, 0])
        if len(found):
            code, element = self._element_fault[found[0]]
            first = np.flatnonzero(self.arrays["id"] == self._mesh.corners[element, 0])[0]
            self._stop(int(code), int(first), n_steps, time)

    # the books

    def _collect_work(self) -> None:
        sums = ordered_sum(self._work[: self.n_slabs])
        impulses = sums[WORKS:].reshape(-1, 3)
        self.contact_work, self.contact_impulse = float(sums[element_nodes.CONTACT]), impulses[CONTACTING]
        self.work = self._no_work()._replace(
            internal=float(sums[element_nodes.INTERNAL]),
            gravity=float(sums[element_nodes.GRAVITY]),
            support=float(sums[element_nodes.SUPPORT]),
            load=float(sums[element_nodes.LOAD]),
            impulses=impulses[EXTRA_ROWS:],
            load_impulse=impulses[LOADING],
        )

    def _no_work(self) -> StepWork:
        return no_work(len(self.prescribed_velocity))._replace(mass=self._total_mass)

    def own_work(self, n_supports: int) -> StepWork:
        """What the nodes did over the step without what the rows of motions did, which lie behind those of the supports."""
        impulses = self.work.impulses
        motions = slice(n_supports, len(impulses) - 1)
        moved = float(np.sum(impulses[motions] * self.prescribed_velocity[motions]))
        held = np.concatenate([impulses[:n_supports], impulses[-1:]])
        return self.work._replace(support=self.work.support - moved, impulses=held)

    @property
    def reactions(self) -> np.ndarray:
        """Impulses of the prescribed rows over the step on the nodes [N s], shape (rows, 3)."""
        return self.work.impulses

    # results

    @property
    def field_names(self) -> list[str]:
        """The fields that results show."""
        return list(FIELDS)

    def field(self, name: str) -> np.ndarray:
        """A field in the order in which the nodes are stored at the moment; units in `pellucid.state.FIELDS`.

        Stress, thickness and density are means of the elements about a node by volume; energies are their shares.
        """
        number, elements = self.arrays["id"], self.element_arrays
        if name == "density":
            return self.arrays["mass"] / self._mesh.at_nodes(elements["volume"])[number]
        if name == "thickness":
            return self._mean(elements["thickness"])[number]
        if name == "stress":
            stress = np.zeros((len(self._mesh.corners), 6))
            forces.cauchy_stresses(self._chunks, self._surface, self.points.position, stress)
            return self._mean(stress)[number]
        if name == "pressure":
            return -self.field("stress")[:, :3].mean(axis=1)
        if name == "strain_energy":
            return self._mesh.at_nodes(elements["strain_energy"])[number] / self.arrays["mass"]
        if name == "stored_energy":
            return self._mesh.at_nodes(elements["strain_energy"] + elements["hourglass_energy"])[number]
        return super().field(name)

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Means by volume of what elements have, at the nodes in the order of the mesh."""
        volume = self.element_arrays["volume"]
        weighted = volume.reshape(-1, *[1] * (values.ndim - 1)) * values
        whole = self._mesh.at_nodes(volume)
        return self._mesh.at_nodes(weighted) / whole.reshape(-1, *[1] * (values.ndim - 1))
