"""What membranes of finite elements share, whichever nodes move them (Lian, Liu & Zhang 2014, section 4)."""

from typing import Any

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies.grid_body import GridBody
from pellucid.bodies.membrane_elements import forces as forces
from pellucid.bodies.membrane_elements.mesh import ElementMesh, rest_gradients
from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.bodies.membrane_elements.strain import CHUNK, HOURGLASS, RATE, STRAIN, SUMS, ElementArrays, strain
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.points import PointArrays, Slabs
from pellucid.jit.bundle import Bundle
from pellucid.materials.membrane import initial_shape
from pellucid.reductions import ordered_sum

FIELDS = ("id", "position", "velocity", "mass", "thickness", "stress", "strain_energy", "density", "pressure")
NO_VOLUME, NO_STRESS = np.zeros(0), np.zeros((0, 6))  # at the nodes: it is the elements that have them


class ElementBody(GridBody):
    """Quadrilaterals and triangles in plane stress; the points of the body are their nodes.

    more: arrays of the nodes beside those that every body of points has, in the order of the mesh.
    """

    energy_kind = "strain"
    is_surface = True

    def __init__(
        self,
        case: MembraneElementsCase,
        grid_case: GridCase,
        grid: Grid,
        velocity_transfer: Any,
        more: dict[str, np.ndarray],
    ) -> None:
        self.material = case.material
        self.law: Any = case.material.law()
        self.thickness = case.thickness
        self.areal_density = case.material.density * case.thickness
        self.control = case.hourglass.control()
        vertices, self.quads, self.triangles = mesh = case.mesh()
        self._mesh = ElementMesh(mesh)
        n, m, q = self._mesh.n_nodes, len(self._mesh.corners), self._mesh.n_quads
        volume = case.thickness * self._mesh.areas(vertices)
        mass = case.material.density * volume
        self._rest = rest_gradients(vertices[self.triangles])
        turn = np.zeros((q, 2))
        turn[:, 0] = 1.0
        self.element_arrays: dict[str, np.ndarray] = {
            "element_mass": mass,
            "plane_stress": np.zeros((m, 3)),
            "thickness": np.full(m, case.thickness),
            "volume": volume,
            "strain_energy": np.zeros(m),
            "hourglass_energy": np.zeros(m),
            "shape": np.tile(np.array(initial_shape(self.law)), (q, 1)),
            "turn": turn,
            "hourglass": np.zeros((q, 2)),
        }
        self._chunks = (m + CHUNK - 1) // CHUNK
        self._element_sums, self._element_fault = np.zeros((self._chunks, SUMS)), np.zeros((self._chunks, 2), np.int64)
        self._corner_forces = np.zeros((m, 4, 3))
        arrays = {
            "id": np.arange(n),
            "position": vertices,
            "velocity": np.tile(np.array(case.velocity), (n, 1)),
            "mass": self._mesh.at_nodes(mass),
        }
        # nodes have no extent: GIMP takes half a cell
        functions = grid_functions(grid_case.functions, (2, 2, 2), grid.thin)
        super().__init__(case.name, grid, functions, velocity_transfer, arrays | more)

    def bind(self) -> None:
        """Take up arrays that were replaced."""
        a = self.arrays
        self.points = PointArrays(a["position"], a["velocity"], a["mass"], a.get("volume", NO_VOLUME), NO_STRESS)
        self._affine = a.get("affine", np.zeros((0, 9)))
        self._carried = ElementArrays(*(self.element_arrays[name] for name in ElementArrays._fields))

    def _share(self, slabs: Slabs) -> None:
        super()._share(slabs)
        number = self.arrays["id"]
        where = np.argsort(number)  # from a node's number to its place
        corners = where[self._mesh.corners]
        what = (self.law, self.control, self.thickness, self._rest, self._carried)
        self._surface = Bundle(corners, self._mesh.n_quads, *what)
        self._about = Bundle(slabs, number, self._mesh.fan)

    # forces at the nodes [N], shape (n, 3), in the order in which the nodes are stored at the moment

    def _add_internal_forces(self, target: np.ndarray) -> None:
        forces.internal_forces(self._chunks, self._surface, self.points.position, self._corner_forces)
        forces.add_corners(self.n_slabs, self._about, self._corner_forces.reshape(-1, 3), target)

    def _add_pressure_forces(self, target: np.ndarray, pressure: float) -> None:
        forces.pressure_forces(self._chunks, self._surface, self.points.position, self._corner_forces, pressure)
        forces.add_corners(self.n_slabs, self._about, self._corner_forces.reshape(-1, 3), target)

    @property
    def corners(self) -> np.ndarray:
        """Nodes of the elements in the order of the mesh, shape (m, 4); of triangles the last one twice."""
        return self._mesh.corners

    def half_width(self) -> tuple[float, float, float]:
        """Half the thickness."""
        return 0.5 * self.thickness, 0.0, 0.0

    def vector_areas(self) -> np.ndarray:
        """∫ N_K n dA about each node [m²], shape (n, 3), in the order in which the nodes are stored at the moment."""
        areas = np.zeros((self.n_points, 3))
        self._add_pressure_forces(areas, 1.0)
        return areas

    # the verbs of a step that concern the elements

    def update_stress(self, dt: float, move: bool) -> None:
        """Where `move`, new positions, and what the elements make of them; with dt = 0 what they make of what they carry."""
        if move or dt == 0.0:
            self.update_positions(dt)

    def _strain(self, velocity: np.ndarray, dt: float) -> None:
        """What the elements make of nodes that came to their places with this velocity [m/s], shape (n, 3)."""
        x, (sums, fault) = self.points.position, (self._element_sums, self._element_fault)
        strain(self._chunks, self._surface, x, velocity, sums, fault, dt)
        totals = ordered_sum(sums)
        self.sums["hourglass"] = float(totals[HOURGLASS])
        self.sums["stored"] = float(totals[STRAIN]) + self.sums["hourglass"]
        self.sums["heating"] = 0.0
        self._element_rate = float(sums[:, RATE].max())

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the node, where a kernel found a fault in this step."""
        super().check(n_steps, time)
        found = np.flatnonzero(self._element_fault[:, 0])
        if len(found):
            code, element = self._element_fault[found[0]]
            first = np.flatnonzero(self.arrays["id"] == self._mesh.corners[element, 0])[0]
            self._stop(int(code), int(first), n_steps, time)

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
