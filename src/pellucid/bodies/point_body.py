"""State of a body of points on the grid as the clock, the balance, results and checkpoints read it."""

from collections.abc import Mapping
from math import fsum

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.energy import AngularMomentum
from pellucid.grid import transfer as kernels
from pellucid.grid.lattice import Grid
from pellucid.grid.points import (
    FIELD_ENERGY,
    HEATING,
    KINETIC,
    LOST,
    MOMENTUM_X,
    POWER,
    RATE,
    SHIFT,
    SPEED,
    STORED,
    Fault,
    FullCells,
    GrowingCells,
    NoCells,
    fault_at_held_face,
)
from pellucid.jit.bundle import Bundle
from pellucid.parts.families import GridBody
from pellucid.ranks.domain import domain
from pellucid.reductions import exact_parts, ordered_sum
from pellucid.state import FIELDS, parts_of
from pellucid.step.limit import StepLimit, motion_in_cells, swings, told

NO_FIELDS = np.zeros((0, FIELD_ENERGY + 1))


class PointBody(GridBody):
    """Base class of bodies of points on the grid: totals, step limit, faults, checkpoints and fields of the points."""

    grid: Grid
    mapped: Bundle
    """The points for kernels, bundle of `MappedPoints`."""
    n_slabs: int
    _affine: np.ndarray | None
    """Affine velocity fields about the points (APIC), or None."""
    _cells: FullCells | GrowingCells | None
    """Full cells whose mean pressures act on the points, or None."""
    contact_surface: ContactSurface | None = None
    """Contact surface of the body; None if contact is computed on the grid nodes."""
    _goes_on = False
    """True if the body continues from an earlier run."""

    @property
    def mass(self) -> float:
        """Return the mass of the body [kg], bitwise equal for any order of points and any number of processes."""
        if not self.storage.is_spread:
            return super().mass
        return fsum(part for parts in domain.group.each(exact_parts(self.storage.present("mass"))) for part in parts)

    @property
    def full_cells(self) -> NoCells | FullCells:
        """Full cells (cells that the fluid fills) whose mean pressures act on the body; `NoCells` without."""
        if self._cells is None:
            return NoCells()
        return self._cells.cells if isinstance(self._cells, GrowingCells) else self._cells

    # totals

    def complete(self) -> None:
        named = (self.storage.present(name) for name in self.arrays if not parts_of(name, self.arrays))
        arrays = [*named, *self.element_arrays.values()] if self._goes_on else []
        kept = [array.copy() for array in arrays]
        self.renew_totals()
        for array, values in zip(arrays, kept, strict=True):
            array[...] = values  # no strain leaves no viscous stress
        if self._goes_on and self._affine is not None and self.rigid is None:
            self.totals.affine = float(np.sum(self.stored_field("mass") * self.stored_field("affine")[:, FIELD_ENERGY]))
            self.totals.kinetic += self.totals.affine

    def renew_totals(self) -> None:
        kernels.sum_momentum(self.n_slabs, self.mapped)
        self._collect_momentum_sums(self.storage.sums())
        self.grid.nodes.strain_velocity.fill(0.0)
        self.grid.nodes.velocity.fill(0.0)
        if isinstance(cells := self.full_cells, FullCells):
            cells.found[:, SHIFT] = 0.0
        self.update_stress(0.0, move=False)  # no strain: computes the energies and the step limit

    def _collect_momentum_sums(self, sums: np.ndarray) -> None:
        totals = self.totals
        if self.rigid is not None:
            totals.affine = self.rigid.own_energy
        totals.kinetic, totals.momentum_size = float(sums[KINETIC]) + totals.affine, float(sums[SPEED])
        totals.momentum = sums[MOMENTUM_X : MOMENTUM_X + 3].copy()

    def _collect_strain_sums(self, last: bool) -> None:
        """Collect the sums of stored energy, power of internal forces and heating over the points, after their strain was
        updated. last: True if this follows the momentum update of the step.
        """
        sums = self.storage.sums()
        self.totals.half_power = (-0.5 if last else 0.5) * float(sums[POWER])
        self.totals.stored, self.totals.heating = float(sums[STORED]), float(sums[HEATING])
        self._bound_rate(float(self.storage.slabs.sums[:, RATE].max()))

    def _bound_rate(self, rate: float) -> None:
        """Set the rate whose reciprocal is the largest stable step [1/s]: the largest of `rate`, the rate of waves and
        diffusion, the rate at which a prescribed motion crosses cells, and the rate of springs on a rigid body.
        """
        # in a steady state the time of motions is that of the loads, and the clock chooses in how many steps they act
        prescribed = self.constraint.top_speed if self.constraint is not None and not self.relaxes else 0.0
        swing = getattr(self.constraint, "swing", 0.0)  # of a rigid body on springs
        self.totals.rate = max(rate, prescribed * self.grid.lattice.inverse_cell, swing)

    def step_limit(self) -> StepLimit:
        """Return the largest stable time step and its cause: the smallest of the limits by waves and diffusion, prescribed
        motion and springs.
        """
        prescribed = self.constraint.top_speed if self.constraint is not None else 0.0
        swing = getattr(self.constraint, "swing", 0.0)
        led = [motion_in_cells(self.grid.lattice.cell, prescribed), swings(swing, "spring")]
        return told(self.totals.rate, [self.signal_limit(), *led])

    def signal_limit(self) -> StepLimit:
        """Return the largest stable time step by waves and diffusion in the body; prescribed motion is not included."""
        return super().step_limit()

    def fastest(self) -> float:
        return domain.largest(float(np.sqrt(np.max(np.sum(self.storage.present("velocity") ** 2, axis=1), initial=0.0))))

    def angular_momentum(self, about: np.ndarray) -> AngularMomentum:
        """Return the angular momentum about a point `about` [m], shape (3,), including affine velocity fields or, for a rigid
        body, its rotation.
        """
        sums = np.zeros((self.n_slabs, 4))
        affine = NO_FIELDS if self._affine is None or self.rigid is not None else self._affine
        kernels.sum_angular_momentum(self.n_slabs, self.mapped, affine, about, sums)
        total = ordered_sum(domain.complete(sums))
        return AngularMomentum(total[:3] + (0.0 if self.rigid is None else self.rigid.own_spin), float(total[3]))

    # faults

    def check(self, n_steps: int, time: float) -> None:
        if not domain.any(bool(np.count_nonzero(self.storage.slabs.fault[:, 0]))):
            return
        fault = domain.complete(self.storage.slabs.fault)
        slab = int(np.flatnonzero(fault[:, 0])[0])
        with domain.told_by(slab) as has_it:
            if has_it:
                code, p = map(int, fault[slab])
                self.stop(code, p, n_steps, time)

    def fault(self, code: int, p: int) -> Fault:
        """Return the description of a fault with this code at point p, and its remedy; for a lost point also the face of the
        grid that it crossed if a support constrains that face.
        """
        passed = self.grid.find_passed_face(self.arrays["position"][p]) if code == LOST else None
        return super().fault(code, p) if passed is None else fault_at_held_face(*passed)

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        elements = {f"elements/{name}": array for name, array in self.element_arrays.items()}
        surface = self.contact_surface.state_arrays() if self.contact_surface is not None else {}
        return {**self.storage.state_arrays(), **elements, **surface}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        for name, array in self.element_arrays.items():
            array[...] = arrays[f"elements/{name}"]
        if self.contact_surface is not None:
            self.contact_surface.restore(arrays)
        self.storage.restore(arrays)

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        for name, array in self.element_arrays.items():
            array[...] = state[f"elements/{name}"]
        self.storage.load(state)
        self._goes_on = True

    # fields

    def order(self) -> np.ndarray:
        return self.storage.order()

    @property
    def field_names(self) -> list[str]:
        return [name for name in self.arrays if FIELDS[name].shown] + ["density", "pressure"]

    def field(self, name: str) -> np.ndarray:
        try:
            stored = self.stored_field(name)
        except KeyError:
            raise self.no_field(name) from None
        return stored[self.order()]

    def stored_field(self, name: str) -> np.ndarray:
        self.storage.complete(*([name, *parts_of(name, self.arrays)] if name in self.arrays else self.arrays))
        return self.storage.shared.joined(self._field_present(name))

    def stored_array(self, name: str) -> np.ndarray:
        return self.storage.joined(name)

    def _field_present(self, name: str) -> np.ndarray:
        """Return a field of the points present on this process, by name, in storage order."""
        present = self.storage.present
        if name == "density":
            return present("mass") / present("volume")
        if name == "pressure":
            return np.asarray(-present("stress")[:, :3].mean(axis=1))
        if name == "kinetic_energy":
            return self.kinetic_energies()[: self.storage.n_present]
        if name == "stored_energy":
            return present("mass") * present("strain_energy")
        return sum((present(part) for part in parts_of(name, self.arrays)), present(name))

    def frame(self) -> dict[str, np.ndarray]:
        """Return the fields of all points by name, as recorded in a frame of the results, in the order of point numbers. For
        points that left, the fields are zero, except the position at which they left the grid.
        """
        fields, left = super().frame(), self.arrays["id"][self.storage.n_present :]
        if not len(left) or self.storage.is_spread:  # those behind are with other processes
            return fields
        there = fields["id"]
        for name, values in fields.items():
            fields[name] = np.zeros((self.n_points, *values.shape[1:]), values.dtype)
            fields[name][there] = values
        for name in ("id", "position"):
            fields[name][left] = self.arrays[name][self.storage.n_present :]
        return fields
