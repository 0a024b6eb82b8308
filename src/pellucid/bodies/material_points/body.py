"""A fluid or solid body of material points, which carry its mass and state through the grid."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from pellucid.bodies.material_points.initial_arrays import point_energies, point_pressures, seeded_arrays
from pellucid.bodies.material_points.leaving import OpenPoints
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.material_points.seeding import points_along_axes
from pellucid.bodies.material_points.touching import PointsInContact
from pellucid.grid.model import GridCase
from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.points_pass import PassAlone, traffic_of
from pellucid.grid.points import DISSIPATED, INVERTED, NOT_FINITE, Fault
from pellucid.grid.sorting import points_here
from pellucid.grid.straining import straining
from pellucid.grid.transfer import sum_momentum
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.grid.viscous_bodies import VISCOUS_STRESS
from pellucid.jit.bundle import Bundle
from pellucid.materials.contract import ImplicitStress
from pellucid.materials.hyperelastic import undefined_strain
from pellucid.materials.law import Law
from pellucid.materials.point_state import in_arrays
from pellucid.model import Vector
from pellucid.parts.capabilities import KeepsHeat
from pellucid.ranks.domain import domain
from pellucid.step.limit import StepLimit, motion_in_cells, signals_seen, swings, tightest


class MaterialPoints(OpenPoints, PointsInContact, KeepsHeat):
    """A fluid or solid body of material points that fill a volume, each with the state variables of its material law."""

    def __init__(
        self,
        case: SeededBody,
        grid_case: GridCase,
        velocity_field: VelocityField,
        velocity_transfer: VelocityTransfer,
        gravity: Vector,
    ) -> None:
        self.material = case.material
        self.law: Law = case.material.law()
        self.energy_kind = case.material.energy_kind
        self._model, self._grid_case, self._gravity = case, grid_case, gravity
        per_cell = points_along_axes(case.points_per_cell, grid_case.thin())
        functions = velocity_field.grid.functions(per_cell)
        here = partial(points_here, velocity_field.grid.lattice, functions)
        arrays, there = seeded_arrays(case, grid_case, here, gravity)
        if not case.material.flows and there == len(arrays["id"]):
            self._begun = arrays["position"][np.argsort(arrays["id"])]
        super().__init__(case.name, velocity_field, functions, velocity_transfer, arrays, there)

    def _bind(self) -> None:
        super()._bind()
        self._stressed: bool | None = None
        self._state = in_arrays(self.material.initial_state(), self.arrays)

    def _make_bundles(self) -> None:
        super()._make_bundles()
        self._strain = straining(self.law, self.mapped.content, self._state, self._cells, curving=self._curving)
        self._strain_at_rest: Bundle | None = None

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(arrays)
        self._stressed = None

    def signal_limit(self) -> StepLimit:
        cell, fastest = self.grid.lattice.cell, self.fastest()
        if self._strains:
            return signals_seen(cell, self.totals.rate, self.material.signals(cell)[1], fastest)
        swing = self.contact_surface.contact_rate() if self.contact_surface is not None else 0.0
        return tightest([motion_in_cells(cell, fastest), swings(swing, "contact")])

    @property
    def fills_cells(self) -> bool:
        """True if mean pressures of full cells act on the body: `cell_pressure` is on and no motion prescribes the body."""
        return self._model.cell_pressure and self.constraint is None

    @property
    def keeps_even(self) -> bool:
        """True if density and spacing of the points are corrected, see `pellucid.grid.even_points`."""
        return self.material.keeps_points_even and self._strains

    def remove_momentum(self, gained: np.ndarray) -> None:
        """Subtract the momentum `gained` [N s], shape (3,), from the points in proportion to their masses, and take the kinetic
        energy that the body gained since its momentum was last summed from the internal energy."""
        before = self.totals.kinetic
        self.storage.present("velocity")[...] -= gained / self.mass
        self.storage.complete("velocity")
        sum_momentum(self.n_slabs, self.mapped)
        self._collect_momentum_sums(self.storage.sums())
        won = self.totals.kinetic - before
        self.storage.present("internal_energy")[...] -= won / self.mass
        self.totals.stored -= won

    @property
    def solves_viscosity(self) -> bool:
        """True if the viscosity is implicit and the grid strains the body."""
        return VISCOUS_STRESS in self.arrays and self._strains

    @property
    def implicit_stress(self) -> ImplicitStress:
        """Parameters of the implicit stress; all zero without such a stress."""
        return self.material.implicit_stress() or ImplicitStress(0.0, 0.0, 0.0)

    def curve_paths(self) -> None:
        self._curving = True
        self._make_bundles()

    def liquid_volume(self) -> float:
        return self.mass / self.material.density if self.material.is_liquid and self._strains else 0.0

    def fluid_volume(self) -> float:
        """Return the volume of the points of a fluid [m³]; 0 for a solid."""
        return float(self.stored_field("volume").sum()) if self.material.flows else 0.0

    def fault(self, code: int, p: int) -> Fault:
        """Return the description of a fault with this code at point p, and its remedy; for a state that is not finite also
        whether the material law is not defined at the strain of the point."""
        if code == NOT_FINITE and "deformation_gradient" in self.arrays:
            F = tuple(self.arrays["deformation_gradient"][p].ravel().tolist())
            for law in self.material.operations(self.law):
                if (factor := undefined_strain(law, F)) is not None:
                    where = "its strain" if factor == 1.0 else f"{factor:.3g} times its strain"
                    law_fails = f"the energy of its law {type(law).__name__} is not defined at {where}"
                    meaning = f"its state is not a finite number; {law_fails}"
                    return Fault(meaning, "use a law or parameters that allow larger strains, or smaller loads and velocities")
        if code == INVERTED and self.implicit_stress.stiffness > 0.0:  # artificial viscosity is refused
            settings, smaller = self.even_settings(), "use a smaller time.step or time.courant, or a finer grid.cell"
            return super().fault(code, p)._replace(remedy=f"set {settings}, or {smaller}" if settings else smaller)
        return super().fault(code, p)

    def state_warning(self) -> str | None:
        """Return a warning if a liquid is compressed beyond the limit of its material law, or if the densities of its points
        have drifted apart; None otherwise."""
        volume = self.fluid_volume()
        told = self.material.too_soft(float(self.stored_field("mass").sum()) / volume) if volume > 0.0 else None
        if told is None:
            uneven = self.material.uneven(self.stored_field("density")) if self._strains else None
            if uneven is None:
                return None
            settings = self.even_settings()
            remedy = f"for confined flow set {settings}" if settings else "use a smaller grid.cell"
            return f"body `{self.name}`: {uneven}; {remedy}"
        passage = "; and balance the [[inflow]] with an [[outflow]] of the same flow rate" if self._takes_in else ""
        return f"body `{self.name}`: {told}{passage}"

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Scatter mass and momentum (`inertia`) and internal forces (`force`) to the grid (P2G). A body that the grid does not
        strain, such as a rigid one, keeps its initial stress (usually zero).
        """
        if force and not self._strains:
            if self._stressed is None:
                self._stressed = domain.any(bool(self.storage.present("stress").any()))
            force = self._stressed
        if inertia or force:
            super().particle_to_grid(inertia, force)

    def renew_totals(self) -> None:
        super().renew_totals()
        if not self._strains:  # else straining finds it
            self.totals.stored = float(np.sum(self.stored_field("stored_energy")))

    def begin_stress(self, dt: float, move: bool) -> None:
        if self._strains:
            each_point(self._strain if move else self._strain_alone(), dt)
        if move and self.is_led(by_slabs=True):
            self.prescribe_positions()

    def passes(self) -> dict[str, PassAlone]:
        straining = PassAlone(lambda: each_point(self._strain, 0.0), traffic_of(self._strain))
        return {**super().passes(), "straining": straining}

    def _strain_alone(self) -> Bundle:
        """Return the loop over the points that updates strain and stress without moving the points, for USF and before the
        first step.
        """
        if self._strain_at_rest is None:
            self._strain_at_rest = straining(self.law, self.mapped.content, self._state, self._cells, moving=False)
        return self._strain_at_rest

    def end_stress(self, dt: float, move: bool) -> None:
        """Complete a stress update: sum energy and power, compute the step limit and, if `move` is True, move the contact
        surface over the step dt [s] and the points of a body whose motion is prescribed as a whole.
        """
        if move and self.is_led(by_slabs=False):
            self.prescribe_positions()
        if move:
            self.storage.complete("position")
        velocity = self.storage.present("velocity")
        squares = None if self._strains else np.einsum("pi,pi->p", velocity, velocity)
        if move and self.contact_surface is not None:
            if squares is None or domain.any(bool(squares.any())):
                self.contact_surface.follow(dt)
            else:
                self.contact_surface.rest()
        if squares is None:
            self._collect_strain_sums(last=move)
        else:
            swing = self.contact_surface.contact_rate() if self.contact_surface is not None else 0.0
            fastest = domain.largest(float(np.sqrt(squares.max(initial=0.0))))
            self._bound_rate(max(fastest * self.grid.lattice.inverse_cell, swing))

    @property
    def keeps_heat(self) -> bool:  # type: ignore[override]
        """True if the material has an internal energy that heating changes, and the grid strains the body."""
        return self.material.keeps_heat and self._strains

    def return_heat(self, share: float) -> None:
        energy = self.storage.present("internal_energy")
        energy -= share * np.maximum(self._heat[: self.storage.n_present], 0.0)
        self.totals.stored -= share * self.transfer_loss.kept

    def _collect_strain_sums(self, last: bool) -> None:
        super()._collect_strain_sums(last)
        if self.material.keeps_heat:
            self.totals.half_power = 0.0  # its energy follows that of the points step by step
        if "dissipated_energy" in self.arrays:
            lost = float(self.storage.sums()[DISSIPATED])
            self.totals.parts["dissipated"] = lost
            self.totals.stored += lost

    @property
    def field_names(self) -> list[str]:
        names = super().field_names
        energy = self.material.energy_field
        return names if energy in names else [*names, energy]

    def _field_present(self, name: str) -> np.ndarray:
        """Return a field of the points present on this process, by name; pressure and stored energy are computed from the
        material law.
        """
        if name == "pressure":
            return point_pressures(self.law, self._state, self._field_present("density"))
        if name == "stored_energy":
            return self.storage.present("mass") * self._field_present(self.material.energy_field)
        if name == self.material.energy_field and name not in self.arrays:
            return point_energies(self.law, self._state, self._field_present("density"))
        return super()._field_present(name)
