"""Solids on their own nodes in total-Lagrangian explicit dynamics (Mountris et al. 2019, section 4)."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from pellucid.approximants.nodal.contract import NodalApproximant
from pellucid.bodies.meshless_solid.forces import CHUNK, ENERGY, LEAST_J, deformation_gradients, internal_forces
from pellucid.bodies.meshless_solid.nodal_fields import FIELDS, MOTION, nodal_field
from pellucid.bodies.meshless_solid.stable_step import largest_frequency
from pellucid.bodies.meshless_solid.tables import make_tables
from pellucid.bodies.own_nodes.body import ExplicitNodes
from pellucid.errors import RunStopped
from pellucid.geometry.cells import Cells
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit.bundle import Bundle
from pellucid.materials.law import Law
from pellucid.parts.body import Placement

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


class MeshlessSolid(ExplicitNodes):
    """Nodes with shape functions over a background mesh."""

    energy_kind = "strain"

    def __init__(self, case: SolidOfNodes, placement: Placement) -> None:
        self.name, self.mesh = case.name, case.mesh_in_order()
        tables = make_tables(
            self.mesh, case.approximant, case.law(), case.points_per_cell, case.consistent, case.averages_volume
        )
        self.solid, self._law, self._density = tables.solid, case.law(), case.density
        self._bundle, self._volume = Bundle(self.solid), tables.node_volume
        self._chunks = (len(self.mesh.nodes) + CHUNK - 1) // CHUNK
        self._frequency = 0.0  # the largest [rad/s], renewed now and then
        velocity, mass = case.initial_velocity(self.mesh.nodes), case.density * tables.node_volume
        super().__init__(self.mesh.nodes.copy(), velocity, mass, placement, tables.node_volume)
        self.renew_totals()

    def volumes(self) -> np.ndarray:
        """Volumes of the nodes at rest [m³], shape (n,)."""
        return self._volume

    # the step

    def update(self, dt: float) -> None:
        """New positions; forces and energy there."""
        super().update(dt)
        self._find_forces()
        self.totals.rate = max(0.5 * self._frequency, self.motion.crossing)

    def _find_forces(self) -> None:
        """Internal forces and energy at the positions of the nodes."""
        self._forces_at(self.arrays["position"] - self.mesh.nodes, self.motion.internal)
        nodal = float(self.solid.node_sums[:, ENERGY].sum()) if len(self.solid.block_volume) else 0.0
        self.totals.stored = float(self.solid.sums[:, ENERGY].sum()) + nodal

    def _forces_at(self, displacement: np.ndarray, force: np.ndarray) -> None:
        self.solid.displacement[:] = displacement
        internal_forces(len(self.solid.sums), self._chunks, self._bundle, force)

    def _renew_frequency(self) -> None:
        """The largest frequency about the present strain, which bounds the step."""
        position, extent = self.arrays["position"], float(np.ptp(self.mesh.nodes, axis=0).max())
        free = self.arrays["prescribed"] == 0
        found = largest_frequency(self._forces_at, position - self.mesh.nodes, self.arrays["mass"], free, extent)
        self._frequency = OVERESTIMATE * found
        self._find_forces()
        self.totals.rate = max(0.5 * self._frequency, self.motion.crossing)

    def renew_totals(self) -> None:
        """Find the totals of the state as it is."""
        super().renew_totals()
        self._renew_frequency()

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the node or the place, where a fault was found in this step."""
        super().check(n_steps, time)
        least = self._least_volume_ratio()
        if not least > 0.0:
            ratios = np.linalg.det(deformation_gradients(self.solid, len(self.mesh.cells)))
            cell = int(np.argmin(ratios)) // self.solid.n_points
            place = ", ".join(f"{x:.6g}" for x in self.arrays["position"][self.mesh.cells[cell]].mean(axis=0))
            text = f"step {n_steps}, time {time:.6g} s: body `{self.name}` is inverted near ({place}) m: the volume ratio is"
            raise RunStopped(
                f"{text} {least:.3g}; load it more slowly, or use a smaller step", step=n_steps, time=time, body=self.name
            )
        if n_steps % RENEWED == 0:
            self._renew_frequency()

    def _least_volume_ratio(self) -> float:
        """Of the averages where the volume ratio is averaged, else of the points."""
        sums = self.solid.node_sums if len(self.solid.block_volume) else self.solid.sums
        return float(sums[:, LEAST_J].min())

    # contact

    def half_width(self) -> tuple[float, float, float]:
        """None: nodes lie on the surface."""
        return 0.0, 0.0, 0.0

    # checkpoint and results

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Those of the nodes, and the bound on the step."""
        return {**super().state_arrays(), "frequency": np.array([self._frequency])}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from such arrays."""
        super().restore(arrays)
        self._frequency = float(arrays["frequency"][0])
        self._find_forces()

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
