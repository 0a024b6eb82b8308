"""The surface of membranes of finite elements: state, strains and forces of the elements, independent of the motion of the
nodes; and the base class of membranes of elements, on their own nodes or on the grid.

Source: Lian, Liu & Zhang 2014, section 4.
"""

from collections.abc import Callable
from math import hypot, inf
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from pellucid.bodies.membrane_elements import forces
from pellucid.bodies.membrane_elements.constraints import Constraints, Swings
from pellucid.bodies.membrane_elements.forces import (
    CHUNK,
    ELEMENT_SUMS,
    FREQUENCY,
    HOURGLASS,
    STRAIN,
    ElementArrays,
    StrainedElements,
    strain,
)
from pellucid.bodies.membrane_elements.mesh import ElementMesh, incidence, initial_turns, rest_gradients
from pellucid.bodies.membranes.bending import make_bending
from pellucid.bodies.membranes.plane_slice import slice_factor
from pellucid.bodies.membranes.prestretch import prestretch
from pellucid.bodies.own_nodes.contact_surface import find_overlong
from pellucid.energy import Totals
from pellucid.geometry.checks.quality import rates_of_surface
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.jit.bundle import Bundle
from pellucid.materials.membrane import plane_diffusivity, wave_in_shape
from pellucid.parts.body import Body
from pellucid.parts.capabilities import Membrane
from pellucid.reductions import ordered_sum
from pellucid.step.limit import NO_LIMIT, StepLimit, motion_in_cells, tightest, waves_in_mesh

if TYPE_CHECKING:
    from pellucid.bodies.membrane_elements.model import MembraneElementsCase


FIELDS = ("id", "position", "velocity", "mass", "thickness", "stress", "tension", "strain_energy", "density", "pressure")
"""Names of the fields in results."""
OVERLONG = (
    "other bodies can pass between nodes that are more than two cells apart; refine the elements, or use a larger grid.cell"
)


class ElementSurface:
    """Elements of a membrane, quadrilaterals and triangles in plane stress; the body stores their nodes.

    arrays: state of the elements, in mesh order. Nodal arrays such as positions have the shape (n, 3), in the storage order of
    the body.
    """

    def __init__(self, case: "MembraneElementsCase", grid_case: GridCase | None) -> None:
        tense = prestretch(case.material.law, case.tension, case.thickness, case.inflation)
        self.law = tense.law
        self.thickness = case.thickness / tense.ratio
        """Thickness at rest [m]."""
        self.contact_reach = case.contact_reach
        """Distance from the mid-surface at which contact with other bodies begins [m]."""
        self.areal_density = case.material.density * case.thickness
        self.wave_at_start = wave_in_shape(self.law, tense.shape, case.material.density)
        """Speed of the fastest small wave at the start [m/s]."""
        self._in_liquid: Callable[[float], StepLimit] | None = None
        self._rate_at_start = 0.0
        self._control = case.hourglass.control()
        mesh = case.mesh()
        self.vertices = mesh.vertices
        self.cells = Cells(triangles=mesh.triangles, quadrilaterals=mesh.quads)
        self.mesh = ElementMesh(mesh)
        m, q = len(self.mesh.corners), self.mesh.n_quads
        self._slice = slice_factor(self.vertices, grid_case)
        thickness = case.thickness * self._slice  # the elements span their mesh, and weigh and resist as the slice does
        volume = thickness * self.mesh.areas(self.vertices)
        mass = case.material.density * volume
        self.node_mass = self.mesh.at_nodes(mass)
        """Nodal masses in mesh order [kg], shape (n,)."""
        direction = case.material.direction
        self._rest = tense.stretch * rest_gradients(self.vertices[mesh.triangles], direction)
        plane_stress = np.tile(tense.stress, (m, 1))
        plane_stress[q:] *= tense.ratio  # of triangles the second Piola-Kirchhoff stress, V/V₀ U⁻¹ σ U⁻¹
        turn = initial_turns(self.vertices[mesh.quads], direction)
        self.arrays: dict[str, np.ndarray] = {
            "element_mass": mass,
            "plane_stress": plane_stress,
            "thickness": np.full(m, thickness),
            "volume": volume,
            "strain_energy": tense.energy * volume,
            "hourglass_energy": np.zeros(m),
            "shape": np.tile(np.array(tense.shape), (q, 1)),
            "turn": turn,
            "hourglass": np.zeros((q, 2)),
        }
        self.bending = None
        if case.bending is not None:
            self.bending = make_bending(case.bending, case.material, mesh.triangles, mesh.vertices, self.node_mass)
        kept = case.area_stiffness, case.volume_stiffness
        self.constraints = Constraints.of(*kept, self.mesh, self.vertices) if case.is_kept else None
        self._swings = Swings()
        self._slopes: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None  # positions, slopes of area and volume there
        self._diffusivity = plane_diffusivity(self.law, tense.shape, case.material.density)
        if self._diffusivity > 0.0:
            self.arrays["dissipated_energy"] = np.zeros(m)
        self._chunks = (m + CHUNK - 1) // CHUNK
        self._sums, self._fault = np.zeros((self._chunks, ELEMENT_SUMS)), np.zeros((self._chunks, 2), np.int64)
        self._corner_forces = np.zeros((m, 4, 3))

    def bind(self, number: np.ndarray, first: np.ndarray) -> None:
        """Set the order in which the body stores the nodes.

        number: number in the mesh of the node in each row, shape (n,); first: nodes first[r]:first[r+1] are processed by one
        thread.
        """
        self.number, self._ranges, self._slopes = number, len(first) - 1, None
        where = np.argsort(number)  # from a node's number to its place
        state = ElementArrays(*(self.arrays.get(name, np.zeros(0)) for name in ElementArrays._fields))
        what = (self.law, self._control, self.thickness * self._slice, self._rest, state)
        self._bundle = Bundle(StrainedElements(where[self.mesh.corners], self.mesh.n_quads, *what))
        self._about = Bundle(forces.CornersAbout(first, number, self.mesh.fan))
        if self.bending is not None:
            self.bending.bind(where)

    def add_internal_forces(self, position: np.ndarray, target: np.ndarray) -> None:
        """Add the nodal forces of stress, hourglass control, bending and penalties [N] to `target`, shape (n, 3). position:
        nodal positions [m], shape (n, 3).
        """
        self.add_local_forces(position, target)
        if self.constraints is not None:
            self.constraints.add_forces(self, position, target)

    def add_local_forces(self, position: np.ndarray, target: np.ndarray) -> None:
        """Add the nodal forces of stress, hourglass control and bending [N] to `target`, shape (n, 3). position: nodal
        positions [m], shape (n, 3).
        """
        forces.internal_forces(self._chunks, self._bundle, position, self._corner_forces)
        forces.add_corners(self._ranges, self._about, self._corner_forces.reshape(-1, 3), target)
        if self.bending is not None:
            self.bending.add_forces(position, target)

    def add_pressure_forces(self, position: np.ndarray, pressure: float, target: np.ndarray) -> None:
        """Add the nodal forces of a pressure [Pa] along the normals [N] to `target`, shape (n, 3). position: nodal positions
        [m], shape (n, 3).
        """
        forces.pressure_forces(self._chunks, self._bundle, position, self._corner_forces, pressure * self._slice)
        forces.add_corners(self._ranges, self._about, self._corner_forces.reshape(-1, 3), target)

    def vector_areas(self, position: np.ndarray) -> np.ndarray:
        """Return ∫ N_K n dA around each node K [m²], shape (n, 3), with its shape function N_K and the normal n; in plane
        problems, for the computed slice. position: nodal positions [m], shape (n, 3).
        """
        areas = np.zeros((len(position), 3))
        self.add_pressure_forces(position, 1.0, areas)
        return areas

    def slopes(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of area [m] and enclosed volume [m²] with respect to the position of each node, for a
        membrane of triangles, shape (n, 3) each. The arrays must not be modified. position: nodal positions [m], shape (n, 3).
        """
        if self._slopes is None or not np.array_equal(self._slopes[0], position):
            growth = np.zeros((len(position), 3))
            forces.area_slopes(self._chunks, self._bundle, position, self._corner_forces)
            forces.add_corners(self._ranges, self._about, self._corner_forces.reshape(-1, 3), growth)
            self._slopes = position.copy(), growth, self.vector_areas(position)
        return self._slopes[1:]

    def areas(self, place: np.ndarray) -> np.ndarray:
        """Return the nodal areas [m²], shape (n,): each element area is distributed equally among its nodes. place: nodal
        positions in mesh order [m], shape (n, 3). In plane problems, the areas of the slice."""
        return self._slice * self.mesh.at_nodes(self.mesh.areas(place))

    def overlong(self, name: str, place: np.ndarray, grid: Grid, nodes: np.ndarray) -> str | None:
        """Return a warning about elements of body `name` in contact at the grid nodes `nodes` that have become larger than the
        cells; None if there are none. place: nodal positions in mesh order [m], shape (n, 3).
        """
        what = f"body {name} touches another, its element"
        return find_overlong(what, self.mesh.corners, place, grid, nodes, OVERLONG)

    def strain(self, position: np.ndarray, velocity: np.ndarray, dt: float, totals: Totals) -> float:
        """Update strains, stresses and energies of the elements over a step dt [s], after their nodes moved to `position` with
        these velocities [m/s].

        Sets the stored energies of `totals`. Returns half the largest eigenfrequency of elements and penalty springs [1/s].
        """
        strain(self._chunks, self._bundle, position, velocity, self._sums, self._fault, dt)
        sums = ordered_sum(self._sums)
        totals.parts["hourglass"] = float(sums[HOURGLASS])
        if self._diffusivity > 0.0:
            totals.parts["dissipated"] = float(self.arrays["dissipated_energy"].sum())
        totals.stored = float(sums[STRAIN]) + totals.parts["hourglass"]
        if self.bending is not None:
            totals.parts["bending"] = self.bending.energy(position)
            totals.stored += totals.parts["bending"]
        rate = self._wave_rate() if self._in_liquid is None else 1.0 / self.step_of_waves()
        if self.constraints is None:
            return rate
        totals.parts["constraint"], self._swings = self.constraints.energy_and_swings(self, position)
        totals.stored += totals.parts["constraint"]
        return hypot(rate, self._swings.rate)

    def take_state(self, position: np.ndarray, totals: Totals) -> None:
        """Set strains, stresses and energies to those of nodes at rest at `position` [m], shape (n, 3), whatever the nodes did
        before; only for triangles. Sets the stored energies of `totals`."""
        forces.find_energies(self._chunks, self._bundle, position)
        self.strain(position, np.zeros_like(position), 0.0, totals)

    def linked_nodes(self) -> sparse.csr_array:
        """Return which nodes determine each term of the energy: a matrix with a row per term and a column per node. Terms of
        the whole membrane, on its area or volume, are not included. Only for triangles."""
        terms = incidence(self.mesh.corners[:, :3], len(self.vertices))
        if self.bending is None:
            return terms
        return sparse.csr_array(sparse.vstack([terms, self.bending.linked_nodes()]))

    @property
    def supports_of_bending(self) -> object | None:
        """Supports that affect the bending, as an object that is replaced when they change; None without bending."""
        return getattr(self.bending, "supports", None)

    def shortest_edge(self) -> float:
        """Return the length of the shortest edge at the start [m]."""
        places = self.vertices[self.mesh.corners[:, :3]]
        return float(np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).min())

    def go_on(self, position: np.ndarray) -> None:
        """Recompute the values that a checkpoint does not contain, such as bending energies and the step limits of elements
        and penalty springs, for nodes at `position` [m], shape (n, 3).
        """
        kept = {name: array.copy() for name, array in self.arrays.items()}
        self.strain(position, np.zeros_like(position), 0.0, Totals())
        for name, array in kept.items():
            self.arrays[name][...] = array  # no strain leaves no viscous stress

    def step_limit(self, grid: Grid | None, speed: float) -> StepLimit:
        """Return the largest stable time step by waves in the elements at their last strain, by the area and volume penalties,
        and by nodes that move at a speed [m/s] through the cells of a grid.
        """
        in_cells = [motion_in_cells(grid.lattice.cell, speed)] if grid is not None else []
        waves = (
            waves_in_mesh(self._wave_rate(), self.wave_at_start, "membrane")
            if self._in_liquid is None
            else self._waves_in_liquid(self._in_liquid)
        )
        return tightest([waves, self._swings.limit(), *in_cells])

    def move_in_liquid(self, limit: Callable[[float], StepLimit], mesh: Mesh) -> None:
        """Let waves limit the step as in a liquid whose pressure is implicit. limit: step limit as a function of the wave speed
        [m/s]; mesh: the elements at the start."""
        self._in_liquid, self._rate_at_start = limit, self.wave_at_start * float(rates_of_surface(mesh).max())

    @property
    def in_liquid(self) -> bool:
        """True if the membrane moves with liquids whose pressure is implicit."""
        return self._in_liquid is not None

    def _wave_rate(self) -> float:
        """Return half the largest eigenfrequency of the elements at their last strain [1/s]."""
        return float(self._sums[:, FREQUENCY].max())

    def _waves_in_liquid(self, limit: Callable[[float], StepLimit]) -> StepLimit:
        rate = self._wave_rate()
        return limit(self.wave_at_start * rate / self._rate_at_start) if self._rate_at_start > 0.0 else NO_LIMIT

    def step_of_waves(self) -> float:
        """Return the largest stable step [s] by waves in the elements at their last strain, in the liquid."""
        return inf if self._in_liquid is None else self._waves_in_liquid(self._in_liquid).step

    def fault(self) -> tuple[int, int] | None:
        """Return the fault of an element after a step: a code of `pellucid.grid.points` and the storage row of its first
        node; None if there is none."""
        found = np.flatnonzero(self._fault[:, 0])
        if not len(found):
            return None
        code, element = self._fault[found[0]]
        return int(code), int(np.flatnonzero(self.number == self.mesh.corners[element, 0])[0])

    @property
    def field_names(self) -> list[str]:
        """Return the names of the fields of the elements in the results."""
        lost = ("dissipated_energy",) if "dissipated_energy" in self.arrays else ()
        return [*FIELDS, *lost, *(("curvature", "bending_energy") if self.bending is not None else ())]

    def field(self, name: str, position: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """Return a field of the elements at the nodes, by name; units in `pellucid.state.FIELDS`.

        position: nodal positions [m], shape (n, 3); mass: nodal masses [kg], shape (n,). Stress, thickness and density are
        volume-weighted averages over the elements around a node; energies are distributed equally among the nodes of an
        element.
        """
        at_nodes, elements = self.mesh.at_nodes, self.arrays
        if name == "density":
            return np.asarray(mass / at_nodes(elements["volume"])[self.number])
        if name == "thickness":
            return self._mean(elements["thickness"])[self.number] / self._slice
        if name == "stress":
            stress = np.zeros((len(self.mesh.corners), 6))
            forces.cauchy_stresses(self._chunks, self._bundle, position, stress)
            return self._mean(stress)[self.number]
        if name == "tension":  # the mean of both directions: no stress stands across the membrane
            traces = self.field("stress", position, mass)[:, :3].sum(axis=1)
            return np.asarray(0.5 * traces * self.field("thickness", position, mass))
        if name == "pressure":
            return np.asarray(-self.field("stress", position, mass)[:, :3].mean(axis=1))
        if name in ("strain_energy", "dissipated_energy"):
            return np.asarray(at_nodes(elements[name])[self.number] / mass)
        if name == "stored_energy":
            bent = 0.0 if self.bending is None else self.bending.energies
            return np.asarray((at_nodes(elements["strain_energy"] + elements["hourglass_energy"]) + bent)[self.number])
        if name == "curvature" and self.bending is not None:
            return self.bending.curvatures(position)[self.number]
        if name == "bending_energy" and self.bending is not None:
            return self.bending.energies[self.number]
        raise KeyError(name)

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Return the volume-weighted averages of element values, shape (m, ...), at the nodes, in mesh order."""
        volume = self.arrays["volume"]
        weighted = volume.reshape(-1, *[1] * (values.ndim - 1)) * values
        whole = self.mesh.at_nodes(volume)
        return np.asarray(self.mesh.at_nodes(weighted) / whole.reshape(-1, *[1] * (values.ndim - 1)))


OF_NODES = ("id", "position", "velocity", "mass", "kinetic_energy")
"""Fields that are stored at the nodes, not at the elements."""


class ElementMembrane(Body, Membrane):
    """Base class of membranes whose nodes are the nodes of an `ElementSurface`; provides fields, areas and contact data of
    the membrane."""

    energy_kind = "strain"
    surface: ElementSurface

    def cells(self) -> Cells:
        return self.surface.cells

    def half_width(self) -> tuple[float, float, float]:
        """Return the distance from the mid-surface at which contact begins [m], and two numbers that are not used (see
        `ContactBody.half_width`).
        """
        return self.surface.contact_reach, 0.0, 0.0

    def check(self, n_steps: int, time: float) -> None:
        super().check(n_steps, time)  # type: ignore[safe-super]  # that of the family
        fault = self.surface.fault()
        if fault is not None:
            self.stop(*fault, n_steps, time)

    def vector_areas(self) -> np.ndarray:
        """Return ∫ N_K n dA around each node K [m²], shape (n, 3), in storage order; N_K is its shape function, n the normal
        of the membrane.
        """
        return self.surface.vector_areas(self.arrays["position"])

    def pressed_areas(self) -> np.ndarray:
        return self.vector_areas()[self.order()]

    def surface_areas(self) -> np.ndarray:
        return self.surface.areas(self.places())

    def facts(self) -> dict[str, float]:
        kept = self.surface.constraints
        drifts = {} if kept is None else kept.drifts(self.surface, self.arrays["position"])
        return {**super().facts(), **drifts}

    @property
    def field_names(self) -> list[str]:
        return self.surface.field_names
