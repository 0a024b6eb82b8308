"""Potential energy, forces and stiffness of a membrane of triangles at trial positions of its nodes, for its equilibria."""

from collections.abc import Callable
from typing import cast

import numpy as np
from scipy import sparse

from pellucid.bodies.membrane_elements.enclosed_pressures import EnclosedPressures
from pellucid.bodies.membrane_elements.surface import ElementSurface
from pellucid.bodies.own_nodes.equilibrium import NodalSystem, Strained
from pellucid.bodies.own_nodes.motion import ForceParts, NodalMotion, Tangent
from pellucid.bodies.own_nodes.stiffness import NodalStiffness
from pellucid.energy import Totals
from pellucid.linear.differences import GroupedDifferences
from pellucid.parts.elastic_system import VolumePressure, VolumeRates

STEP = 1e-5  # difference of a coordinate over the shortest edge: errors of 1e-10 by curvature, 1e-11 by rounding


class MembraneSystem(NodalSystem):
    """An `ElasticSystem` of a membrane of triangles with its own nodes.

    surface: elements of the membrane; position, motion, stiffness, accepted: as for `NodalSystem`; totals: energies of the
    body, which are set with the strains; conserves: True if the stress is the derivative of an energy.
    """

    includes_load_stiffness = True

    def __init__(
        self,
        surface: ElementSurface,
        position: np.ndarray,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
        totals: Totals,
        conserves: bool,
    ) -> None:
        self._surface, self._totals, self.has_energy = surface, totals, conserves
        self._bent = surface.supports_of_bending
        self.enclosed = EnclosedPressures(surface)
        self._pressed_before, self._middle_forces = list[np.ndarray](), list[np.ndarray]()
        self._volume_rates = self._volume_rates_leaving = dict[VolumePressure, VolumeRates]()
        super().__init__(surface.vertices, position, motion, stiffness, accepted)

    def begin(self, dt: float) -> None:
        super().begin(dt)
        if self._bent is not self._surface.supports_of_bending:  # other nodes are linked
            self._bent, self._stiffness = self._surface.supports_of_bending, None
        self._pressed_before = [self.enclosed.force(one, self.position, 0.0) for one in self.enclosed.all]
        for one, force in zip(self.enclosed.all, self._pressed_before, strict=True):
            self._before.loads[one.row] += force
            one.start()

    def enclose(self, pressure: VolumePressure) -> None:
        if self.enclosed.depends_on_lids(pressure, self.position, self._motion.free):
            raise ValueError("the rim of the membrane moves across its lid")
        self.enclosed.all.append(pressure)
        outwards = np.where(self._motion.free, self.enclosed.outwards(pressure, self.position), 0.0)
        self._strain(self.position)
        resisted, size = float(np.sum(outwards * self._motion.internal)), float(np.sum(outwards * outwards))
        pressure.begin_with(-resisted / size if size > 0.0 else 0.0)

    @property
    def share(self) -> float:
        """Share of the step at which the stiffness of loads is computed."""
        return self._share

    @property
    def has_factors(self) -> bool:
        return super().has_factors and self._matrix().has_springs_of(self.position)

    def corrects(self, tolerance: float) -> bool:
        every = [one.corrects(self.enclosed.volume(one, self.tried), tolerance) for one in self.enclosed.all]
        return any(every)

    def _pressed(self, position: np.ndarray) -> tuple[float, np.ndarray]:
        return self.enclosed.at(position) if self.enclosed.all else (0.0, self._unpressed)

    def _pressure_growth(self) -> np.ndarray:
        return self.enclosed.growth(self.tried) if self.enclosed.all else self._unpressed

    def follow(self, force: np.ndarray) -> np.ndarray:
        moved = super().follow(force)
        self._volume_rates_leaving = self._volume_rates
        return moved

    def _tangent(self, force: np.ndarray) -> Tangent:
        found, self._volume_rates = super()._tangent(force), {}
        for one in self.enclosed.all:
            outwards, growth = self.enclosed.outwards(one, self.tried), self.enclosed.pressure_growth(one, self.tried)
            rate, volume = float(np.sum(outwards * found.moved)), self.enclosed.volume(one, self.tried)
            stiffness = one.at(volume, self._share).stiffness
            if (own := one.compliance(volume, self._share)) is not None:  # V' = D - a p', for the pressure p
                change, compliance = own
                moved, resisted = self._matrix().follow(outwards, np.zeros_like(outwards))
                each = float(np.sum(outwards * moved))
                lacking = change - rate - compliance * (growth - stiffness * rate)
                more = lacking / (each + compliance * (1.0 - stiffness * each))
                found = Tangent(found.moved + more * self._without_drift(moved), found.resisted + more * resisted)
                loads = force - growth * outwards
                across = np.where(self._motion.free, outwards, 0.0)
                pulled = float(np.sum(across * (self._matrix().resisted_without_springs(found.moved) - loads)))
                self._volume_rates[one] = VolumeRates(rate + more * each, pulled / float(np.sum(across * across)))
            else:
                self._volume_rates[one] = VolumeRates(rate, growth - stiffness * rate)
        return found

    def _arrive(self, leaving: Tangent, arriving: Tangent) -> None:
        before, after = self.position, self._present
        middle = 0.5 * (before + after) + 0.125 * (leaving.moved - arriving.moved)
        self._middle_forces = []
        for one in self.enclosed.all:
            volumes = self.enclosed.volume(one, before), self.enclosed.volume(one, after)
            ends = (self._volume_rates_leaving if self._left_stable else {}), (self._volume_rates if self.shift == 0.0 else {})
            pressure = one.travel(*volumes, ends[0].get(one), ends[1].get(one))
            self._middle_forces.append(pressure * self.enclosed.outwards(one, middle))
            self._motion.loads[one.row] += self.enclosed.force(one, after, 1.0)

    def _middle(self, leaving: Tangent, arriving: Tangent, after: ForceParts) -> ForceParts:
        found = super()._middle(leaving, arriving, after)
        for one, before, force in zip(self.enclosed.all, self._pressed_before, self._middle_forces, strict=True):
            if not self._follow:  # otherwise the loads were computed anew
                found.loads[one.row] -= 0.5 * (before + self.enclosed.force(one, self._present, 1.0))
            found.loads[one.row] += force
        return found

    def _work_elsewhere(self) -> float:
        done = ((one.done(), self._motion.work_of_load(one.row)) for one in self.enclosed.all)
        return sum(recorded - own for own, recorded in done if own is not None)

    def _strain(self, position: np.ndarray) -> Strained:
        self._surface.take_state(position, self._totals)
        self._motion.internal.fill(0.0)
        self._surface.add_internal_forces(position, self._motion.internal)
        return Strained(self._totals.stored, self._surface.fault() is None)

    def _stored_energy(self) -> float:
        return self._totals.stored

    def _new_stiffness(self) -> "MembraneStiffness":
        return MembraneStiffness(self._surface, self)

    def _matrix(self) -> "MembraneStiffness":
        return cast(MembraneStiffness, super()._matrix())

    def local_forces(self, position: np.ndarray) -> np.ndarray:
        """Return internal forces and loads that follow the nodes, for nodes at these positions, without the forces of penalties
        on the whole membrane [N], shape (n, 3)."""
        if self._follow:
            self._present[:] = position
            self._renew(self._share)
        self._surface.strain(position, np.zeros_like(position), 0.0, Totals())
        self._motion.internal.fill(0.0)
        self._surface.add_local_forces(position, self._motion.internal)
        # loads that do not follow have no differences, and rounding with those of another load step would leave a trace
        return self._motion.forces() if self._follow else self._motion.internal

    def restore_trial(self) -> None:
        """Return to the last trial positions after forces were computed elsewhere."""
        self.attempt(self.tried)


class MembraneStiffness(NodalStiffness):
    """Stiffness of a membrane of triangles with its loads, and solutions of linear systems with it.

    surface: elements of the membrane; system: its forces.
    """

    least_pivot = 10.0 * STEP**2  # across a flat membrane the differences of forces are those of their curvature

    def __init__(self, surface: ElementSurface, system: MembraneSystem) -> None:
        self._surface, self._system = surface, system
        self._of_contents = list[float]()
        terms = surface.linked_nodes()
        links = sparse.csr_array(terms.T @ terms)
        super().__init__(links, surface.vertices)
        self._differences = GroupedDifferences(links, STEP * surface.shortest_edge())

    def _find(self, dt: float) -> None:
        position, kept, enclosed = self._system.tried.copy(), self._surface.constraints, self._system.enclosed
        tension, suction = (0.0, 0.0) if kept is None else kept.tensions(self._surface, position)
        suction -= enclosed.along_normals(position, self._system.share)

        def forces(x: np.ndarray) -> np.ndarray:
            found = self._system.local_forces(x)
            if kept is None and not enclosed.all:
                return found
            growth, outwards = self._surface.slopes(x)
            return np.asarray(found - tension * growth - suction * outwards)

        self._values[self._entry] = self._differences.find(forces, position)
        self._system.restore_trial()

    def _springs(self) -> list[tuple[float, np.ndarray]]:
        kept, position = self._surface.constraints, self._system.tried
        own = [] if kept is None else kept.springs(self._surface, position)
        contents = self._system.enclosed.springs(position, self._system.share)
        self._of_contents = [stiffness for stiffness, _ in contents]
        return own + contents

    def has_springs_of(self, position: np.ndarray) -> bool:
        """Return True if the last factors include the present stiffness of enclosed contents at these positions of the nodes
        [m], shape (n, 3)."""
        return self._of_contents == [stiffness for stiffness, _ in self._system.enclosed.springs(position, 0.0)]
