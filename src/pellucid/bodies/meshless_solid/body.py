"""Meshless solids: nodes that move by their own equation of motion, in total-Lagrangian explicit dynamics (Mountris et al.
2019, section 4)."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.meshless_solid.equilibrium import MovingSolid, SolidSystem
from pellucid.bodies.meshless_solid.functions import SolidFunctions, quadrature_places
from pellucid.bodies.meshless_solid.linear_stiffness import LinearTetrahedra
from pellucid.bodies.meshless_solid.material_forces import ElasticForces, ViscousForces
from pellucid.bodies.meshless_solid.nodal_fields import FIELDS, LOST, MOTION, nodal_field
from pellucid.bodies.meshless_solid.prescribed import PrescribedField
from pellucid.bodies.meshless_solid.skin import Skin
from pellucid.bodies.meshless_solid.solid import inversion
from pellucid.bodies.meshless_solid.stable_step import PowerIteration, VolumeInertia, pays
from pellucid.bodies.own_nodes.body import ExplicitNodes
from pellucid.bodies.own_nodes.contact_surface import LONGEST_EDGE, PointsOfFaces
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.contact.contact_body import ContactBody
from pellucid.energy import DAMPING, FIRST_LOAD, StepWork
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.geometry.meshes.cells import Cells, FaceShares
from pellucid.parts.body import Placement, in_metres
from pellucid.parts.capabilities import SLOWER_LOADS, HasContactSurface, HasMesh, Springs
from pellucid.parts.elastic_system import HasElasticSystem, HasMovingSystem, MovingSystem, PathSystem
from pellucid.state import with_owner
from pellucid.step.limit import StepLimit, motion_in_cells, springs_of_contact, told, waves_in_mesh

if TYPE_CHECKING:
    from pellucid.bodies.meshless_solid.model import MeshlessSolidCase

HELD = 1e-9  # displacement, relative to the extent of the body, that counts as round-off
OVERESTIMATE = 1.05  # safety factor of the largest frequency: power iteration converges from below


class MeshlessSolid(ExplicitNodes, HasMesh, HasContactSurface, HasElasticSystem, HasMovingSystem):
    """A meshless solid: nodes with shape functions over a background mesh. The functions are built when all supports, motions
    and loads are known (`complete`).
    """

    energy_kind = "strain"

    def __init__(self, case: "MeshlessSolidCase", placement: Placement) -> None:
        self.name, self.mesh, self._case = case.name, case.mesh_in_order(), case
        self._law, self._density = case.law(), case.density
        n = len(self.mesh.nodes)
        self._volume = np.zeros(n)
        self.skin: Skin | None = None
        self._volume_inertia: VolumeInertia | None = None
        self._shifted = 0.0  # work in this step of the force changes by the volume inertia [J]
        self._start: Mapping[str, np.ndarray] = {}
        velocity = case.initial_velocity(self.mesh.nodes)
        super().__init__(self.mesh.nodes.copy(), velocity, np.zeros(n), placement, self._volume)

    def complete(self) -> None:
        """Build shape functions, masses and totals, after all supports, motions and loads are known. The functions may depend
        on the nodes and faces on which supports and motions prescribe the displacement field. Raises `CaseError` if the
        approximant has no functions at a point, or the field cannot follow the constraints.
        """
        motion, case, arrays = self.motion, self._case, self.arrays
        self._check_held()
        self.prescribed = PrescribedField(self.mesh, arrays["prescribed"], motion.groups(), len(motion.rows))
        self._functions = SolidFunctions(case, self.mesh, self._law, self.prescribed)
        tables, viscous = self._functions.tables, case.viscous()
        self.solid = tables.solid
        stress = case.initial_stress_at(quadrature_places(self.mesh, case.points_per_cell))
        self._forces = ElasticForces(self.solid, stress)
        if viscous is not None:
            wave_number = float(np.sqrt((tables.row_sums / tables.node_volume).max()))
            self._forces = ViscousForces(viscous, self.solid, case.density, wave_number, stress)
        for name, array in self._forces.arrays.items():
            array[...] = self._start.get(f"history/{name}", array)
        self._volume[:] = tables.node_volume
        arrays["mass"][:] = case.density * tables.node_volume
        if (coupling := self.coupling) is not None:
            longest = LONGEST_EDGE * coupling.velocity_field.grid.lattice.cell
            points = self._functions.skin_points(arrays["mass"], longest, motion.on_walls())
            self.skin = Skin(self.name, coupling, arrays, self._volume, self._functions.at_nodes, points)
        if correction := self._functions.correction(arrays["position"], motion.inertia, motion.motion_rows):
            motion.impose_on_field(correction)
        self.renew_totals()

    def let_go(self, supports: Collection[int]) -> None:
        """Release supports with these numbers, and search again for the largest natural frequency, which the release may
        raise.
        """
        motion, number, displacement = self.motion, self.arrays["prescribed"], self.prescribed.displacement
        before = number.copy()
        super().let_go(supports)
        self.prescribed = PrescribedField(self.mesh, number, motion.groups(), len(motion.rows))
        self.prescribed.displacement[:] = displacement
        self._functions.follow(self.prescribed)
        if not self._functions.prescribes_nodes:
            motion.impose_on_field(self._functions.correction(self.arrays["position"], motion.inertia, motion.motion_rows))
        self._fastest.free = motion.free
        if self._volume_inertia:
            self._volume_inertia.release(motion.free)
        if (number != before).any():  # and not in a run that goes on, whose nodes are free already
            self._find_fastest()

    def _find_fastest(self) -> None:
        """Compute the largest natural frequency of the body in its present state, starting from a random vector; then update
        internal forces and step limit.
        """
        self._fastest = self._power_iteration()
        self._forces.converge(self._fastest, self.arrays["position"] - self.mesh.nodes)
        self._find_forces()
        self._bound_step()

    def volumes(self) -> np.ndarray:
        return self.arrays["mass"] / self.field("density")

    # the step

    def update(self, dt: float) -> None:
        super().update(dt)
        if self.skin:
            self.skin.update()
        self.prescribed.displacement += dt * self.motion.rows
        iterate = dt > 0.0 and self._fastest.is_due()
        self._find_forces(dt, iterate)
        if self._volume_inertia and dt > 0.0 and self._volume_inertia.wears(dt, self._fastest.frequency):
            self._volume_inertia.renew()
            self._fastest.renew()
        self._count_power()
        self._bound_step()

    def begin_relaxing(self, scaled: bool) -> None:
        """Prepare the body for a relaxation to a steady state.

        scaled: True to set the inertia of each node in proportion to a bound of its stiffness, with the mass of the body as
        total. Nearly incompressible solids get an inertia against changes of volume.
        """
        if scaled:
            row_sums = self._functions.tables.row_sums
            self.motion.scale_inertia(row_sums * (self.mass / row_sums.sum()))
            self.renew_totals()
        shear = self._density * self._case.wave_speeds()[1] ** 2
        if self._functions.prescribes_nodes and pays(self.solid, shear):
            motion, frequency = self.motion, self._fastest.frequency
            self._volume_inertia = VolumeInertia(self.solid, motion.inertia, motion.free, shear, frequency)
            self.renew_totals()

    def elastic_system(self) -> PathSystem:
        """Return energy, forces and stiffness for equilibria; only for nodal values that are prescribed directly."""
        approximates = self._case.approximates_stiffness
        tetrahedra = LinearTetrahedra(self.mesh, self._functions.at_nodes) if approximates else None
        return SolidSystem(*self._of_system(), self._take_equilibrium, tetrahedra)

    def moving_system(self) -> MovingSystem:
        """Return energy, forces, stiffness and inertia for implicit time steps; only for nodal values that are prescribed
        directly."""
        return MovingSolid(*self._of_system(), self._end_step)

    def _of_system(self) -> tuple[np.ndarray, np.ndarray, ElasticForces, NodalMotion, float]:
        stiffness = self.mass * self._case.wave_speeds()[0] ** 2
        return self.mesh.nodes, self.arrays["position"], self._forces, self.motion, stiffness

    def _take_equilibrium(self, dt: float) -> None:
        """Update everything that depends on the positions of the nodes after a new equilibrium; dt: step of the time of the
        loads [s]."""
        self.prescribed.displacement += dt * self.motion.rows
        self.motion.sum_at_rest(self.totals, dt)
        self.totals.stored, self.totals.half_power = self._forces.stored(), 0.0
        self._shifted = 0.0

    def _end_step(self, dt: float) -> None:
        """Update everything that depends on positions and velocities at the end of an implicit time step dt [s]."""
        self.prescribed.displacement += dt * self.motion.rows
        self.motion.sum_momentum(self.totals)
        self._find_forces()
        self.totals.half_power, self._shifted = 0.0, 0.0

    def correct(self, remap: bool) -> None:
        """Update the nodal velocities with forces, constraints and contact; `remap`: also map the momentum to the grid again.
        If there is an inertia against changes of volume, the forces are first converted to effective forces on the nodal
        masses.
        """
        if self._volume_inertia is None:
            super().correct(remap)
            return
        motion, velocity = self.motion, self.arrays["velocity"]
        internal, old = motion.internal.copy(), velocity.copy()
        shift = self._volume_inertia.shift(motion.forces())
        motion.internal += shift
        super().correct(remap)
        motion.internal[:] = internal
        self._shifted = 0.5 * self._dt * float(np.sum(shift * (old + velocity)))

    def work(self) -> StepWork:
        """Return work and impulses of this step; the energy that the inertia against changes of volume absorbs counts as work
        of damping.
        """
        found = super().work()
        found.works[DAMPING] -= self._shifted
        return found

    def springs(self) -> Springs:
        """Return the internal forces and the nodal positions at the end of the step, from which a relaxation estimates the
        stiffness.
        """
        return super().springs()._replace(position=self.arrays["position"])

    def _find_forces(self, dt: float = 0.0, iterate: bool = False) -> None:
        """Compute internal forces and stored energy for the present nodal positions. dt: length of the step that ended with
        these positions [s]; iterate: True to also update the estimate of the largest natural frequency."""
        displacement, force = self.arrays["position"] - self.mesh.nodes, self.motion.internal
        if iterate:
            self._forces.find_and_iterate(displacement, force, dt, self._fastest)
        else:
            self._forces.find(displacement, force, dt)
        self.totals.stored, lost = self._forces.stored(), self._forces.lost
        if lost is not None:
            self.totals.parts["dissipated"] = lost
            self.totals.stored += lost

    def _bound_step(self) -> None:
        wear = self._volume_inertia.rate if self._volume_inertia else 0.0
        self.totals.rate = max(0.5 * OVERESTIMATE * self._fastest.frequency, self.motion.crossing, wear, self.contact_rate)

    def step_limit(self) -> StepLimit:
        modes = waves_in_mesh(0.5 * OVERESTIMATE * self._fastest.frequency, self._case.wave_speeds()[0], "wave")
        crossing = self.motion.crossing
        moves = [motion_in_cells(self.grid.lattice.cell, crossing * self.grid.lattice.cell)] if self.grid else []
        return told(self.totals.rate, [modes, *moves, springs_of_contact(self.contact_rate)])

    def renew_totals(self) -> None:
        """Sum energy and momentum of the present state, and compute the largest natural frequency."""
        self._fastest = self._power_iteration()
        super().renew_totals()
        self._find_fastest()

    def _power_iteration(self) -> PowerIteration:
        extent = float(np.ptp(self.mesh.nodes, axis=0).max())
        of_volume = self._volume_inertia
        return PowerIteration(self.motion.inertia, self.motion.free, extent, of_volume.shift if of_volume else None)

    def check(self, n_steps: int, time: float) -> None:
        found = inversion(self.mesh, self.solid)
        if found is not None:
            slower = SLOWER_LOADS if self.relaxes else "apply loads more slowly, or use a smaller time.courant or time.step"
            words, node = found
            text = f"step {n_steps}, time {time:.6g} s: body `{self.name}` is inverted {words}; {slower}, and if this does not "
            text += "help, the load itself crushes the body at this point"
            position = self.arrays["position"][node].tolist()
            raise RunStopped(text, step=n_steps, time=time, body=self.name, point=node, position=position)
        super().check(n_steps, time)

    def whereabouts(self, p: int) -> str:
        """Return a text with the initial position of node p for messages, since its present position may not be finite."""
        return f"from {in_metres(self.mesh.nodes[p])} at rest"

    # conditions

    def node_sets(self) -> Mapping[str, np.ndarray]:
        return self.mesh.sets

    def face_shares(self, faces: np.ndarray) -> FaceShares:
        """Return the means of the shape functions over outer faces with corners `faces`, shape (f, 3), for surface loads;
        available once all conditions are known.
        """
        return self._functions.face_shares(faces)

    @property
    def n_stress_points(self) -> int:
        return len(self.mesh.cells) * self._case.points_per_cell

    # contact

    def make_contact_surface(self, column: int) -> PointsOfFaces | None:
        if self.skin is None or self.grid is None:
            return None
        self._contact_row = column - FIRST_LOAD
        surface = self.skin.surface_of(self.grid, self.motion.loads[self._contact_row], self.motion, self.follows)
        surface.rate = self.totals.rate
        self.contact_surface = surface
        return surface

    @property
    def contact_body(self) -> ContactBody | None:
        return self.skin

    def begin(self, dt: float) -> None:
        super().begin(dt)
        if self.skin:
            self.skin.begin()

    def predict(self, dt: float) -> None:
        """Scatter mass, momentum and all forces of the surface points, including drag, to the grid (P2G) for contact. dt: time
        step [s].
        """
        if self.skin and self.touches_on_nodes:
            self.skin.scatter(self.motion.forces() + self.motion.drag_forces(dt))

    def gather(self) -> np.ndarray:
        return self.skin.gather() if self.skin else super().gather()

    def scatter_momentum(self) -> None:
        if self.skin:
            self.skin.scatter_momentum()

    def place_surface(self) -> None:
        if self.skin:
            self.skin.follow()

    def half_width(self) -> tuple[float, float, float]:
        """Return zeros: contact begins at the nodes, which lie on the surface."""
        return 0.0, 0.0, 0.0

    # checkpoint and results

    def state_arrays(self) -> dict[str, np.ndarray]:
        prescribed = {"prescribed_displacement": self.prescribed.displacement}
        history = with_owner("history", self._forces.arrays)
        skin = self.skin.state_arrays() if self.skin else {}
        of_volume = self._volume_inertia.state_arrays() if self._volume_inertia else {}
        return {**super().state_arrays(), **history, **skin, **of_volume, **prescribed, **self._fastest.state_arrays()}

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Load positions, velocities and viscous stresses of an earlier run; `complete` uses the viscous stresses."""
        for name in ("position", "velocity"):
            self.arrays[name][...] = state[name]
        if self._case.viscous() is not None:
            self._start = {name: array for name, array in state.items() if name.startswith("history/")}
            if not self._start:
                raise KeyError("viscous stresses")
        if self.coupling:
            self.coupling.sort()

    def _check_held(self) -> None:
        """Raise `CaseError` if the initial displacement of a node differs from the initial displacement that a support or
        motion prescribes."""
        displacement = self.arrays["position"] - self.mesh.nodes
        held = (self.arrays["prescribed"] > 0) & (abs(displacement) > HELD * np.ptp(self.mesh.nodes, axis=0).max())
        if held.any():
            node = int(np.flatnonzero(held.any(axis=1))[0])
            text = (
                f"node {node} of body {self.name}, {self.whereabouts(node)}, is constrained or prescribed but starts "
                "with a displacement"
            )
            remedy = "constrain it at its rest position in the earlier run too"
            raise CaseError(Problem(text, "start", remedy=remedy))

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(arrays)
        self._fastest.restore(arrays)
        self.prescribed.displacement[:] = arrays["prescribed_displacement"]
        for name, array in self._forces.arrays.items():
            array[...] = arrays[f"history/{name}"]
        if self.skin:
            self.skin.restore(arrays)
        if self._volume_inertia:
            self._forces.find(arrays["volume_inertia"], self.motion.internal, 0.0)
            self._volume_inertia.restore(arrays)
        self._find_forces()

    def cells(self) -> Cells:
        return Cells(tetrahedra=self.mesh.cells)

    def places(self) -> np.ndarray:
        """Return the present positions of the material points that started at the nodes [m], shape (n, 3)."""
        return np.asarray(self.mesh.nodes + self._functions.at_nodes @ (self.arrays["position"] - self.mesh.nodes))

    def facts(self) -> dict[str, float]:
        """Return, for the summary of a run, the largest difference between the displacement field and its prescribed values
        [m], at boundary nodes and between them.
        """
        found = self._functions.residuals.largest(self.arrays["position"] - self.mesh.nodes)
        return {f"ebc_residual_{name}": value for name, value in found.items()}

    @property
    def field_names(self) -> list[str]:
        return [*FIELDS, LOST] if self._forces.lost is not None else list(FIELDS)

    def field(self, name: str) -> np.ndarray:
        """Return a field of the results at the nodes, by name. Position and velocity are values of the interpolated field at
        the nodes, not nodal coefficients; stresses are averages over the cells around a node.
        """
        if name == "kinetic_energy":
            return self.kinetic_energies()
        if name == "position":
            return self.places()
        if name == "velocity":
            return np.asarray(self._functions.at_nodes @ self.arrays["velocity"])
        if name in MOTION:
            return self.arrays[name]
        if name not in (*self.field_names, "stored_energy"):
            raise self.no_field(name)
        return nodal_field(name, self.mesh, self.solid, self._forces.at_points, self._law, self._density)
