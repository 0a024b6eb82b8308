"""Membranes as material points: the vertices of a triangulated surface in plane stress (Gan et al. 2011, section 2.1)."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.membrane_points import kernels
from pellucid.bodies.membrane_points.kernels import gathering_gradients
from pellucid.bodies.membrane_points.point import MembraneArrays, StrainedMembrane
from pellucid.bodies.membrane_points.surface import NonlocalMean, area_shares, fans_of, initial_frames, press, torn
from pellucid.bodies.membranes.bending import make_bending
from pellucid.bodies.membranes.on_grid import BendsOnGrid, membrane_functions
from pellucid.bodies.membranes.plane_slice import slice_factor
from pellucid.bodies.membranes.plate_bending import PlateBending
from pellucid.bodies.membranes.prestretch import prestretch
from pellucid.bodies.own_nodes.kernels import power
from pellucid.energy import FIRST_LOAD
from pellucid.geometry.meshes.cells import Cells, vector_areas
from pellucid.grid.model import GridCase
from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.points_pass import PassAlone, traffic_of
from pellucid.grid.points import LOST, Fault
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.jit.bundle import Bundle
from pellucid.materials.damage import DamageRecord, Elastodamage
from pellucid.materials.membrane import plane_diffusivity
from pellucid.parts.capabilities import Membrane, TakesPressure
from pellucid.step.limit import StepLimit, signals_seen

if TYPE_CHECKING:
    from pellucid.bodies.membrane_points.model import MembranePointsCase


class MembranePoints(BendsOnGrid, Membrane, TakesPressure):
    """A membrane of material points: the vertices of a triangulated surface, with their tangent frames and the triangles
    between them."""

    energy_kind = "strain"
    sorting_cost = 8.0  # the triangles around each point are listed again

    def __init__(
        self,
        case: "MembranePointsCase",
        grid_case: GridCase,
        velocity_field: VelocityField,
        velocity_transfer: VelocityTransfer,
    ) -> None:
        self.material = case.material
        tense = prestretch(case.material.law, case.tension, case.thickness, case.inflation)
        self.law: Any = tense.law
        self.thickness = case.thickness / tense.ratio
        """Thickness at rest [m]."""
        self._contact_reach = case.contact_reach
        self.areal_density = case.material.density * case.thickness
        vertices, self._triangles = case.surface.triangulate()
        n = len(vertices)
        area = area_shares(vertices, self._triangles)
        self._slice = slice_factor(vertices, grid_case)
        volume = area * case.thickness * self._slice
        arrays = {
            "id": np.arange(n),
            "position": vertices,
            "velocity": case.initial_velocity(vertices),
            "mass": case.material.density * volume,
            "volume": volume,
            "stress": np.zeros((n, 6)),
            "frame": initial_frames(vertices, self._triangles, case.material.direction),
            "in_plane": np.tile(np.array(tense.shape), (n, 1)),
            "plane_stress": np.tile(tense.stress, (n, 1)),
            "strain_energy": np.full(n, tense.energy / case.material.density),
        }
        self.damage: Any = case.material.damage_law()
        if isinstance(self.damage, Elastodamage):
            arrays |= {name: np.zeros(n) for name in DamageRecord._fields}
        self._diffusivity = plane_diffusivity(self.law, tense.shape, case.material.density)
        if self._diffusivity > 0.0 and case.material.recoverable_energy(arrays["in_plane"]) is None:
            arrays["dissipated_energy"] = np.zeros(n)
        radius = case.material.damage_radius
        self._mean = NonlocalMean(vertices, area, radius) if radius else None
        if radius:
            arrays["torn"] = np.zeros((n, 3))
        self._kinematics = np.zeros((n if radius else 0, 5))
        self._gradient = np.zeros((n, 9))
        self.start_positions = vertices.copy()
        if case.bending is not None:
            self.bending = make_bending(
                case.bending, case.material, self._triangles, self.start_positions, arrays["mass"].copy()
            )
        self._bent_before: np.ndarray | None = None  # positions before the points moved
        functions = membrane_functions(velocity_field.grid, isinstance(self.bending, PlateBending))
        super().__init__(case.name, velocity_field, functions, velocity_transfer, arrays)

    def _bind(self) -> None:
        super()._bind()
        self._state = MembraneArrays(*(self.arrays[name] for name in MembraneArrays._fields))
        self._record = DamageRecord(*(self.arrays.get(name, np.zeros(0)) for name in DamageRecord._fields))

    def _make_bundles(self) -> None:
        super()._make_bundles()
        passes = (gathering_gradients(self.mapped.content, self._gradient, moving) for moving in (False, True))
        self._gather_alone, self._gather_and_move = passes

    def _follow_order(self) -> None:
        where = np.argsort(self.arrays["id"])  # from a point's number to its place
        if self.bending is not None:
            self.bending.bind(where)
        fans = fans_of(where[self._triangles], self.n_points)
        self.fans = Bundle(fans)
        strained = StrainedMembrane(
            lattice=self.grid.lattice,
            points=self.points,
            slabs=self.storage.slabs,
            index=self.mapped.index,
            fans=fans,
            gradient=self._gradient,
            law=self.law,
            state=self._state,
            thickness=self.thickness * self._slice,
            damage=self.damage,
            record=self._record,
        )
        self._surface = Bundle(strained)

    @property
    def _moving_velocity(self) -> np.ndarray:
        """Nodal velocity that moves the points [m/s], shape (nodes, 3); with bending it is the velocity that strains bodies,
        so that bending forces do the same work on points and on the grid.
        """
        return super()._moving_velocity if self.bending is None else self.grid.nodes.strain_velocity

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(arrays)
        if self.bending is not None:
            self.bending.energy(self.points.position)  # fills the energies of the points

    def signal_limit(self) -> StepLimit:
        cell, bending = self.grid.lattice.cell, self._bending_limit()
        signals = signals_seen(cell, self.totals.rate, self._diffusivity, self.fastest(), "membrane")
        return bending if bending.step * self.totals.rate <= 1.0 else signals

    def cells(self) -> Cells:
        return Cells(triangles=self._triangles)

    def state_warning(self) -> str | None:
        """Return a warning if the membrane was torn without damage because its points are too far apart for the grid; None
        otherwise.
        """
        failed = np.zeros(self.n_points, bool)
        if len(self._record.failed):
            failed[self.arrays["id"]] = self._record.failed > 0.0
        return torn(self.name, self.places(), self._triangles, failed, self.grid)

    def fault(self, code: int, p: int) -> Fault:
        """Return the description of a fault with this code at point p, and its remedy. For a point outside the grid that
        had failed before, the description reports the failure."""
        if code == LOST and len(self._record.failed) and self._record.failed[p] > 0.0:
            return Fault("it had failed, and left the grid", "enlarge the grid, or end the run before")
        return super().fault(code, p)

    def half_width(self) -> tuple[float, float, float]:
        """Return the distance from the mid-surface at which contact begins [m], and two numbers that are not used (see
        `ContactBody.half_width`).
        """
        return self._contact_reach, 0.0, 0.0

    def vector_areas(self) -> np.ndarray:
        """Return the vector areas of the points (area times normal) [m²], shape (n, 3), in storage order; in plane problems,
        of the computed slice.
        """
        thickness = self.thickness  # the thickness of failed points is meaningless, and others thin by a few per cent
        return self.arrays["frame"][:, 6:] * (self.points.volume / thickness)[:, None]

    def pressed_areas(self) -> np.ndarray:
        """Return the vector areas on which pressure acts: a third of the vector areas of the triangles around each point [m²],
        shape (n, 3).
        """
        thirds = np.repeat(self._slice / 3.0 * vector_areas(self.places(), self._triangles), 3, axis=0)
        corners = self._triangles.ravel()
        return np.stack([np.bincount(corners, part, self.n_points) for part in thirds.T], axis=1)

    def surface_areas(self) -> np.ndarray:
        return self._slice * area_shares(self.places(), self._triangles)

    @property
    def field_names(self) -> list[str]:
        bent = ("curvature", "bending_energy") if self.bending is not None else ()
        return [*super().field_names, "tension", *bent]

    def _field_present(self, name: str) -> np.ndarray:
        if name == "tension":  # the mean of both directions, over what is the thickness now
            thickness = self.storage.present("volume") / self.surface_areas()[self.storage.present("id")]
            return np.asarray(0.5 * self.storage.present("plane_stress")[:, :2].sum(axis=1) * thickness)
        if self.bending is not None and name in ("curvature", "bending_energy"):
            by_number = self.bending.energies if name == "bending_energy" else self.bending.curvatures(self.points.position)
            return by_number[self.storage.present("id")]
        return super()._field_present(name)

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        super().particle_to_grid(inertia, force)
        if force and self.bending is not None:
            self._scatter_internal_forces(self._bending_forces(), self._nodes.force)

    def _bending_forces(self) -> np.ndarray:
        forces = np.zeros((self.n_points, 3))
        if self.bending is not None:
            self.bending.add_forces(self.points.position, forces)
        return forces

    def _count_bending(self, dt: float) -> None:
        """Add the bending energy of the present positions to the totals of the body, and half the power of the bending forces
        over the step dt [s].
        """
        if self.bending is None:
            return
        self.totals.stored -= self.totals.parts.get("bending", 0.0)
        self.totals.parts["bending"] = self.bending.energy(self.points.position)
        self.totals.stored += self.totals.parts["bending"]
        if self._bent_before is not None and dt > 0.0:
            velocity = (self.points.position - self._bent_before) / dt
            self.totals.half_power += 0.5 * power(self._bending_forces(), velocity)
        self._bent_before = None

    def add_pressure(self, pressure: float, column: int) -> None:
        load = self.velocity_field.load_row(column - FIRST_LOAD)
        press(self.n_slabs, self.mapped, self._surface, load, pressure * self._slice)

    def passes(self) -> dict[str, PassAlone]:
        gathered = self._gather_and_move
        return {**super().passes(), "gradients": PassAlone(lambda: each_point(gathered, 0.0), traffic_of(gathered))}

    def begin_stress(self, dt: float, move: bool) -> None:
        moves = move and self.bending is None  # what bends moves afterwards, with the velocity that strains it
        each_point(self._gather_and_move if moves else self._gather_alone, dt)
        if moves and self.is_led(by_slabs=True):
            self.prescribe_positions()

    def end_stress(self, dt: float, move: bool) -> None:
        if move and self.bending is not None:
            self._bent_before = self.points.position.copy()
            self._move_by_nodes(dt)
            if self.is_led(by_slabs=True):
                self.prescribe_positions()
        if move and self.is_led(by_slabs=False):
            self.prescribe_positions()
        self.storage.complete("position")
        kernels.find_normals(len(self._triangles) // kernels.CHUNK + 1, self.points.position, self.fans)
        if self._mean is None:
            kernels.strain(self.n_slabs, self._surface, dt)
        else:
            self._strain_with_mean(self._mean, dt)
        self._collect_strain_sums(last=move)
        self._bound_rate(max(self.totals.rate, 1.0 / self._bending_limit().step))
        if self.bending is not None:
            self.totals.parts["bending"] = 0.0  # the sums are those of the strain alone
            self._count_bending(dt)
        if len(self._record.dissipated_energy):
            self.storage.complete("dissipated_energy")
            self.totals.parts["dissipated"] = float((self.points.mass * self._record.dissipated_energy).sum())
            return
        self.storage.complete("strain_energy", "in_plane")
        if (recoverable := self.material.recoverable_energy(self._state.in_plane)) is not None:
            lost = self._state.strain_energy - recoverable
            self.totals.parts["dissipated"] = float((self.points.mass * lost).sum())

    def update_positions(self, dt: float) -> None:
        """Move the points over a step dt [s], and compute the bending energy of the new positions."""
        if self.bending is not None:
            self._bent_before = self.points.position.copy()
        super().update_positions(dt)
        self._count_bending(dt)

    def _strain_with_mean(self, mean: NonlocalMean, dt: float) -> None:
        number = self.arrays["id"]
        kernels.stretch(self.n_slabs, self._surface, number, self.arrays["torn"], mean.local, self._kinematics, dt)
        self.storage.shared.fill(mean.local, self.arrays["id"])
        if mean.local.max() > self.damage.elastic_limit:  # else no mean is beyond it, and damage cannot grow
            mean.update()
        kernels.respond(self.n_slabs, self._surface, number, mean.mean, self._kinematics, dt)
