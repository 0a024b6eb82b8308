"""A fluid or solid body of material points whose unknowns live on the grid."""

from typing import Any

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies.fields import point_pressures
from pellucid.bodies.seeding import points_along_axes, seed
from pellucid.bodies.spec import MaterialPointsCase
from pellucid.bundle import Bundle
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.grid import transfer as kernels
from pellucid.grid.grid import Grid
from pellucid.grid.points import FAULTS, HEATING, KINETIC, MOMENTUM_X, RATE, SPEED, STORED, PointArrays, Slabs
from pellucid.grid.sorting import empty_slabs, sort_by_cell
from pellucid.grid.spec import GridCase
from pellucid.grid.velocity_transfer import Apic
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.point_state import ARRAYS_OF
from pellucid.reductions import ordered_sum


class MaterialPoints:
    """Points that carry mass, volume, stress and what their law asks for; sorted by cell whenever one strays."""

    def __init__(self, case: MaterialPointsCase, grid_case: GridCase, grid: Grid, velocity_transfer: Any) -> None:
        self.name = case.name
        self.material = case.material
        self.law: Any = case.material.law()
        self.grid = grid
        self.transfer = velocity_transfer
        per_cell = points_along_axes(case.points_per_cell, grid.thin)
        self.functions = grid_functions(grid_case.functions, per_cell, grid.thin)
        self._stencil = max(function.stencil for function in self.functions)
        self.arrays = self._initial_arrays(case, *seed(case.shape.geometry(), grid_case, per_cell))
        self._scratch: dict[int, np.ndarray] = {}
        self.sums: dict[str, float] = {}
        self.bind()
        self.sort()
        self._measure()

    def _initial_arrays(self, case: MaterialPointsCase, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
        n = len(position)
        if n == 0:
            raise CaseError(
                Problem(
                    "no material point lies inside the shape: it is thinner than the distance between points",
                    f"body.{case.name}.shape",
                    remedy="use a smaller grid.cell or more points_per_cell",
                )
            )
        velocity = np.tile(np.array(case.velocity), (n, 1))
        velocity += np.cross(case.angular_velocity, position - case.shape.geometry().centre())
        if case.velocity_wave is not None:
            velocity += case.velocity_wave.at(position)
        velocity[:, np.array(self.grid.thin)] = 0.0
        arrays = {
            "id": np.arange(n),
            "position": position,
            "velocity": velocity,
            "mass": case.material.density * volume,
            "volume": volume,
        }
        state = case.material.initial_state()
        for name, value in zip(ARRAYS_OF[type(state)]._fields, state, strict=True):
            shape = (n, len(value)) if isinstance(value, tuple) else (n,)
            arrays[name] = np.broadcast_to(np.array(value, dtype=float), shape).copy()
        if isinstance(self.transfer, Apic):
            arrays["affine"] = np.zeros((n, 9))
        return arrays

    def bind(self) -> None:
        """Take up arrays that were replaced."""
        self.points = PointArrays(*(self.arrays[name] for name in PointArrays._fields))
        state = ARRAYS_OF[type(self.material.initial_state())]
        self._carried = state(*(self.arrays[name] for name in state._fields))
        self._affine = self.arrays.get("affine", np.zeros((0, 9)))

    def _share(self, slabs: Slabs) -> None:
        """Hand points and slabs to the kernels."""
        self.slabs = slabs
        lattice, nodes = self.grid.lattice, self.grid.nodes
        self._mapped = Bundle(self.functions, self.transfer, lattice, nodes, self.points, slabs, self._affine)
        self._strained = Bundle(self.functions, lattice, nodes, self.points, slabs, self.law, self._carried)
        self._n_slabs = len(slabs.layer) - 1

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.points.mass)

    def sort(self) -> None:
        """Sort the points by cell and share them out in slabs."""
        self._share(sort_by_cell(self.arrays, self._scratch, self.grid.lattice, self._stencil))

    def sort_if_strayed(self) -> None:
        """Sort again where a point left its slab."""
        if self.slabs.strayed.any():
            self.sort()

    def restore_slabs(self, first: np.ndarray, layer: np.ndarray, strayed: np.ndarray) -> None:
        """The slabs of a checkpoint."""
        slabs = empty_slabs(first, layer)
        slabs.strayed[:] = strayed
        self._share(slabs)

    # the verbs of a step, in the order in which MUSL calls them

    def to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum, internal forces."""
        kernels.scatter(self._n_slabs, self._mapped, int(inertia), int(force))

    def accelerate(self, remap: bool) -> None:
        """New velocities; where `remap`, their momentum back on the nodes."""
        if len(self._affine):
            # linear functions spread by nothing at a node: their affine field is a gradient, which light nodes must not spoil
            nodes = self.grid.nodes
            kernels.gather_affine(self._n_slabs, self._mapped, nodes.deforming if self._stencil == 2 else nodes.velocity)
        kernels.accelerate(self._n_slabs, self._mapped, int(remap))
        sums = ordered_sum(self.slabs.sums)
        self.sums["kinetic"], self.sums["speed"] = float(sums[KINETIC]), float(sums[SPEED])
        for d, axis in enumerate("xyz"):
            self.sums[f"momentum_{axis}"] = float(sums[MOMENTUM_X + d])

    def deform(self, dt: float, move: bool) -> None:
        """Velocity gradients, volumes, stresses; where `move`, new positions."""
        kernels.deform(self._n_slabs, self._strained, dt, int(move))
        sums = ordered_sum(self.slabs.sums)
        self.sums["stored"], self.sums["heating"] = float(sums[STORED]), float(sums[HEATING])
        self.sums["rate"] = float(self.slabs.sums[:, RATE].max())

    def move(self, dt: float) -> None:
        """New positions alone."""
        kernels.move(self._n_slabs, self._mapped, dt)

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped`, naming the point, where a kernel found a fault in this step."""
        found = np.flatnonzero(self.slabs.fault[:, 0])
        if not len(found):
            return
        code, p = self.slabs.fault[found[0]]
        state = {name: array[p].tolist() for name, array in self.arrays.items()}
        place = ", ".join(f"{value:.6g}" for value in state["position"])
        remedies = {
            1: "use a smaller time.step or time.courant, or look in forensics/failure.json for what is impossible in it",
            2: "use a smaller time.step or time.courant, a finer grid.cell, or artificial viscosity for shocks",
            3: "make the grid larger or put a support on the face it crossed",
        }
        raise RunStopped(
            f"step {n_steps}, time {time:.6g} s: point {state['id']} of body `{self.name}` at ({place}) m: "
            f"{FAULTS[int(code)]}; {remedies[int(code)]}",
            step=n_steps,
            time=time,
            body=self.name,
            point=state["id"],
            state=state,
        )

    def _measure(self) -> None:
        """The sums of the initial state."""
        mass, velocity = self.points.mass, self.points.velocity
        self.sums["kinetic"] = float(0.5 * (mass @ np.einsum("ij,ij->i", velocity, velocity)))
        self.sums["speed"] = float(mass @ np.linalg.norm(velocity, axis=1))
        for d, axis in enumerate("xyz"):
            self.sums[f"momentum_{axis}"] = float(mass @ velocity[:, d])
        self.grid.nodes.deforming.fill(0.0)
        self.grid.nodes.velocity.fill(0.0)
        self.deform(0.0, move=False)  # no strain: fills the energies and the bound on the step

    @property
    def energy_kind(self) -> str:
        """How the ledger calls what the points store."""
        return "internal" if isinstance(self.material, FluidMaterial) else "strain"

    def momentum(self) -> np.ndarray:
        """Total momentum [kg m/s], shape (3,)."""
        return np.array([self.sums[f"momentum_{axis}"] for axis in "xyz"])

    @property
    def field_names(self) -> list[str]:
        """The fields that results show."""
        return [name for name in self.arrays if name not in ("volume", "affine")] + ["density", "pressure"]

    def field(self, name: str) -> np.ndarray:
        """A field in the order in which the points are stored at the moment; units in `pellucid.state.FIELDS`."""
        if name == "density":
            return self.arrays["mass"] / self.arrays["volume"]
        if name == "pressure":
            if isinstance(self.material, FluidMaterial):
                return point_pressures(self.law.eos, self.field("density"), self.arrays["internal_energy"])
            return -self.arrays["stress"][:, :3].mean(axis=1)
        return self.arrays[name]

    def frame(self) -> dict[str, np.ndarray]:
        """The fields of the points in their original order; units in `pellucid.state.FIELDS`."""
        back = np.argsort(self.arrays["id"])
        return {name: self.field(name)[back] for name in self.field_names}
