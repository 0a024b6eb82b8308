"""What every body of points on the grid shares: its arrays, sorting, and the verbs of a step but for straining."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from pellucid.conditions.driven_points import spread_momentum, sum_motion
from pellucid.errors import RunStopped
from pellucid.geometry.mesh import NO_QUADS, NO_TRIANGLES
from pellucid.grid import transfer as kernels
from pellucid.grid.lattice import Grid
from pellucid.grid.points import FAULTS, HEATING, KINETIC, MOMENTUM_X, RATE, SPEED, STORED, PointArrays, Slabs
from pellucid.grid.sorting import empty_slabs, sort_by_cell
from pellucid.grid.velocity_transfer import Apic
from pellucid.jit.bundle import Bundle
from pellucid.reductions import ordered_sum

HIDDEN = ("volume", "affine", "driven", "start", "torn", "prescribed")  # arrays that results do not show


class GridBody(ABC):
    """Points whose unknowns live on the grid, sorted by cell whenever one strays.

    A kind of body gives the initial arrays and says how its points are strained (`update_stress`), what they store
    (`energy_kind`), and fields of its own.
    """

    energy_kind: str
    is_surface = False  # whether the points are those of a membrane, which has two sides
    areal_density: float  # of a membrane at rest [kg/m²]
    constraint: Any = None  # a prescribed motion or rigidity of its points, from `pellucid.conditions.prescribed`
    own_nodes = False  # whether its equation of motion is solved on its own points
    # elements of a surface, in the order of seeding, and what they carry; most bodies have none
    quads, triangles = NO_QUADS, NO_TRIANGLES
    element_arrays: Mapping[str, np.ndarray] = MappingProxyType({})

    def __init__(self, name: str, grid: Grid, functions: Any, velocity_transfer: Any, arrays: dict[str, np.ndarray]) -> None:
        self.name = name
        self.grid = grid
        self.functions = functions
        self._stencil = max(function.stencil for function in functions)
        self.transfer = velocity_transfer
        self.arrays = arrays
        arrays["velocity"][:, np.array(grid.thin)] = 0.0
        if isinstance(velocity_transfer, Apic):
            arrays["affine"] = np.zeros((len(arrays["mass"]), 9))
        self._scratch: dict[int, np.ndarray] = {}
        self.sums: dict[str, float] = {}
        self.bind()
        self.sort()
        self.measure()

    def vector_areas(self) -> np.ndarray:
        """Of a membrane, the share of its vector area of each point [m²], shape (n, 3); of a volume none, shape (0, 3)."""
        return np.zeros((0, 3))

    def half_width(self) -> tuple[float, float, float]:
        """How far the body reaches beyond its points: this [m], or where negative half the edge of a point's cube.

        The edge is (volume · the second number) to the power of the third.
        """
        thin = sum(self.grid.thin)
        return -1.0, self.grid.lattice.cell**-thin, 1.0 / (3 - thin)

    @abstractmethod
    def update_stress(self, dt: float, move: bool) -> None:
        """Velocity gradients, volumes, stresses; where `move`, new positions. Ends with `_collect_strain_sums`."""

    def bind(self) -> None:
        """Take up arrays that were replaced."""
        self.points = PointArrays(*(self.arrays[name] for name in PointArrays._fields))
        self._affine = self.arrays.get("affine", np.zeros((0, 9)))

    def _share(self, slabs: Slabs) -> None:
        """Hand points and slabs to the kernels."""
        self.slabs = slabs
        lattice, nodes = self.grid.lattice, self.grid.nodes
        self.mapped = Bundle(self.functions, self.transfer, lattice, nodes, self.points, slabs, self._affine)
        self.n_slabs = len(slabs.layer) - 1

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.points.mass)

    def sort(self) -> None:
        """Sort the points by cell and share them out in slabs."""
        self._share(sort_by_cell(self.arrays, self._scratch, self.grid.lattice, self._stencil))

    def sort_if_needed(self) -> None:
        """Sort again where a point left its slab."""
        if self.slabs.left_slab.any():
            self.sort()

    def restore_slabs(self, first: np.ndarray, layer: np.ndarray, left_slab: np.ndarray) -> None:
        """The slabs of a checkpoint."""
        slabs = empty_slabs(first, layer)
        slabs.left_slab[:] = left_slab
        self._share(slabs)

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum, internal forces."""
        kernels.scatter(self.n_slabs, self.mapped, int(inertia), int(force))

    def update_velocities(self, remap: bool) -> None:
        """New velocities; where `remap`, their momentum back on the nodes."""
        if len(self._affine):
            # linear functions spread by nothing at a node: their affine field is a gradient, which light nodes must not spoil
            nodes = self.grid.nodes
            kernels.gather_affine(self.n_slabs, self.mapped, nodes.strain_velocity if self._stencil == 2 else nodes.velocity)
        free = self.constraint is None
        kernels.update_velocities(self.n_slabs, self.mapped, int(remap and free))
        if not free:
            self.constraint.prescribe_velocities()
            sum_motion(self.n_slabs, self.mapped)
            if remap:
                spread_momentum(self.n_slabs, self.mapped)
        self._collect_motion_sums()

    def _collect_motion_sums(self) -> None:
        sums = ordered_sum(self.slabs.sums)
        self.sums["kinetic"], self.sums["speed"] = float(sums[KINETIC]), float(sums[SPEED])
        for d, axis in enumerate("xyz"):
            self.sums[f"momentum_{axis}"] = float(sums[MOMENTUM_X + d])

    def update_positions(self, dt: float) -> None:
        """New positions alone."""
        kernels.update_positions(self.n_slabs, self.mapped, self.grid.nodes.velocity, dt)
        self.place()

    def place(self) -> None:
        """Put the points where a prescribed motion or rigidity wants them, after they moved with the grid."""
        if self.constraint is not None:
            self.constraint.prescribe_positions()

    def _collect_strain_sums(self) -> None:
        sums = ordered_sum(self.slabs.sums)
        self.sums["stored"], self.sums["heating"] = float(sums[STORED]), float(sums[HEATING])
        self._bound_rate(float(self.slabs.sums[:, RATE].max()))

    def _bound_rate(self, rate: float) -> None:
        """The bound on the step [1/s], from the fastest signal or from how fast a motion will move the points."""
        prescribed = self.constraint.top_speed if self.constraint is not None else 0.0
        self.sums["rate"] = max(rate, prescribed * self.grid.lattice.inverse_cell)

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the point, where a kernel found a fault in this step."""
        found = np.flatnonzero(self.slabs.fault[:, 0])
        if not len(found):
            return
        code, p = self.slabs.fault[found[0]]
        self._stop(code, p, n_steps, time)

    def _stop(self, code: int, p: int, n_steps: int, time: float) -> None:
        state = {name: array[p].tolist() for name, array in self.arrays.items()}
        place = ", ".join(f"{value:.6g}" for value in state["position"])
        fault = FAULTS[int(code)]
        raise RunStopped(
            f"step {n_steps}, time {time:.6g} s: point {state['id']} of body `{self.name}` at ({place}) m: "
            f"{fault.meaning}; {fault.remedy}",
            step=n_steps,
            time=time,
            body=self.name,
            point=state["id"],
            state=state,
        )

    def measure(self) -> None:
        """The sums of the initial state."""
        sum_motion(self.n_slabs, self.mapped)
        self._collect_motion_sums()
        self.grid.nodes.strain_velocity.fill(0.0)
        self.grid.nodes.velocity.fill(0.0)
        self.update_stress(0.0, move=False)  # no strain: fills the energies and the bound on the step

    def momentum(self) -> np.ndarray:
        """Total momentum [kg m/s], shape (3,)."""
        return np.array([self.sums[f"momentum_{axis}"] for axis in "xyz"])

    @property
    def field_names(self) -> list[str]:
        """The fields that results show."""
        return [name for name in self.arrays if name not in HIDDEN] + ["density", "pressure"]

    def field(self, name: str) -> np.ndarray:
        """A field in the order in which the points are stored at the moment; units in `pellucid.state.FIELDS`."""
        if name == "density":
            return self.arrays["mass"] / self.arrays["volume"]
        if name == "pressure":
            return -self.arrays["stress"][:, :3].mean(axis=1)
        if name == "kinetic_energy":
            velocity = self.arrays["velocity"]
            return 0.5 * self.arrays["mass"] * np.einsum("ij,ij->i", velocity, velocity)
        if name == "stored_energy":
            return self.arrays["mass"] * self.arrays["strain_energy"]
        return self.arrays[name]

    def frame(self) -> dict[str, np.ndarray]:
        """The fields of the points in their original order; units in `pellucid.state.FIELDS`."""
        back = np.argsort(self.arrays["id"])
        return {name: self.field(name)[back] for name in self.field_names}
