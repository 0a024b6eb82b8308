"""Contact between surfaces: forces of their overlap, friction, and damping of vibrations at the scale of a cell.

Each point of a surface at depth d inside the other surface is pushed out by the pressure κ d. These forces derive from the
energy ½ Σ κ a d². A body that slides or rolls therefore regains behind the contact the energy that it spent ahead of it,
whereas an impulse that stops an approach returns nothing. 1/κ is the sum of the compliances of both sides. The compliance
of a side is the compliance of a surface layer that oscillates at the fastest rate allowed by the time step of its body, so
that contact does not limit the step.

Friction is a spring along the surface. It slides when its force exceeds μ times the pressure (Coulomb); sticking contact
has no limit. The points of both surfaces of two bodies that deform are used. Each surface has a share of the stiffness in
proportion to its compliance, and that grows with its resolution, because the points of a coarse surface act like a bed of
nails on a fine one. Of a body of material points that deforms and one that does not, only the points of the former are used:
the area in contact of points of the other body at the rim of the deforming body would change with this rim, without work.

A parallel damper has a tenth of the critical damping for the masses of both layers, 0.15 of it for material points. It ends
their vibrations within a few periods and hardly affects the motion of the bodies as a whole. Two bodies that do not deform
hardly rebound, and their overlap hardens under load: see `pellucid.contact.dead_stop` and `pellucid.contact.overlap`.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from pellucid.contact.contact_energy import ContactEnergy
from pellucid.contact.contact_side import PreviousForces
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.dead_stop import SETTLED
from pellucid.contact.frozen import ContactSprings, FrozenSide
from pellucid.contact.images import Described, Plane, Seam, describe
from pellucid.contact.leads import ContactLead
from pellucid.contact.moved_surfaces import MovedByNodes, MovedSurfaces
from pellucid.contact.overlap import StartOverlap
from pellucid.contact.sheets import find_places_beside, passes_between
from pellucid.contact.surface_pair import SurfacePair
from pellucid.contact.touch import OverlappingStart, Touch
from pellucid.energy import CONTACT, DAMPING, FIRST_LOAD, SUPPORT, StepWork
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit import kernel
from pellucid.state import of_owner, with_owner
from pellucid.step.part import WARNING_INTERVAL, StepPart

ROUNDS = 3  # largest number of iterations for several contacts of flat sides on one body


class SurfacePairs(StepPart):
    """All contacts of a simulation in which surfaces touch each other or walls: detection of overlaps, contact forces, and
    energy balance of contact."""

    def __init__(
        self,
        pairs: Sequence[Touch],
        planes: Sequence[Plane] = (),
        seams: Sequence[Seam] = (),
        column: int | None = None,
        fields: Collection[VelocityField] = (),
        moved_by_nodes: Sequence[MovedByNodes] = (),
        moved_first: Sequence[MovedByNodes] = (),
        on_nodes_too: bool = False,
    ) -> None:
        """Collect the surfaces of the contacts `pairs`, between surfaces and of surfaces with walls.

        planes: planes of symmetry. seams: seams of a periodic grid. column: column of the work of forces between surfaces in
        arrays of works. fields: velocity fields on whose nodes forces between surfaces act. moved_by_nodes: surfaces that nodes
        move after the forces of a step. moved_first: surfaces that nodes move before these forces (USF). on_nodes_too: True if
        other bodies are in contact on the nodes.
        """
        self._fields, self._on_nodes_too = fields, on_nodes_too
        self._moved = MovedSurfaces(moved_by_nodes, moved_first)
        self._column, self._last = column, 0.0
        self._time, self._passing = 0.0, 0.0
        self._pairs, self._planes, self._seams = pairs, planes, seams
        self.surfaces = list({id(surface): surface for pair in pairs for surface in pair.surfaces}.values())
        self.energy = ContactEnergy()
        self._described: dict[int, Described] = {}  # points and images by surface; reused if the surface does not move
        self._forces: dict[int, np.ndarray] = {}
        self._holding = {id(surface) for surface in self.surfaces}  # surfaces with points that friction may hold
        self._untouched: dict[int, tuple[ContactSurface, np.ndarray]] = {}
        self._stops = any(pair.law.stop is not None for pair in pairs)
        self._is_steady = False
        self._searches = False
        self._from_outside = 0.0
        self._kept_leads: list[list[object]] = []  # of the last equilibrium
        self._frozen: list[list[tuple[Touch, FrozenSide]]] = []  # geometries of contact in a search for an equilibrium
        self._slips: dict[int, np.ndarray] = {}  # of the surfaces at the last equilibrium, in a search for the next one
        self.start_overlaps: list[OverlappingStart] = []
        """Overlaps of surfaces at the start, which exert no force until they have opened once."""

    def __len__(self) -> int:
        return len(self._pairs)

    @property
    def deepest(self) -> float:
        """Largest depth at which points count as in contact with another surface, in every contact [m]; walls have no
        limit."""
        return min((pair.deepest for pair in self._pairs if isinstance(pair, SurfacePair)), default=np.inf)

    def begin(self, time: float, dt: float) -> None:
        self._time, self._passing = time, dt

    def begin_balance(self) -> None:
        self.energy = ContactEnergy()

    def exert_forces(self, dt: float) -> None:
        """Compute the contact forces of a step dt [s] and apply them to the bodies."""
        if self._searches:
            self.exert_on_trial(self.surfaces, dt)
            return
        last = self._last
        for pair in self._pairs:
            pair.begin(self._time, self._passing / dt if dt > 0.0 else 0.0)
        described, forces, touched = self._described, dict[int, np.ndarray](), dict[int, np.ndarray]()
        for surface in self.surfaces:
            surface.begin()
            if not surface.stands or id(surface) not in described:
                described[id(surface)] = describe(surface, self._planes, self._seams, described.get(id(surface)))
            touched[id(surface)] = np.zeros(len(surface.place), bool)
            surface.swings, surface.pushed_along, surface.pushed = 0.0, [], np.zeros(6)
        for pair in self._pairs:
            pair.step = max(dt, last)
            pair.follow(last)
        touching = [pair.find(described) for pair in self._pairs]
        if self._stops:
            self._settle([pair for pair, touches in zip(self._pairs, touching, strict=True) if touches], dt, last)
        late = []
        self._moved.begin(last)
        for pair, touches in zip(self._pairs, touching, strict=True):
            if not touches:
                pair.law.separate(last, pair.before)
                continue
            if pair.is_last:
                late.append(pair)
                continue
            for surface in pair.surfaces:
                if id(surface) not in forces:
                    forces[id(surface)] = self._cleared(surface, len(described[id(surface)].place))
            pair.push(dt, last, forces, touched)
        for surface in self.surfaces:
            holds = bool(touched[id(surface)].any())
            if self._is_steady:
                self._untouched[id(surface)] = surface, ~touched[id(surface)]
            elif holds or id(surface) in self._holding:
                _let_go(surface.slip, touched[id(surface)])
                (self._holding.add if holds else self._holding.discard)(id(surface))
            if id(surface) in forces:
                on_points = described[id(surface)].fold(forces[id(surface)])
                surface.add_forces(on_points)
                self._moved.record_forces(surface, on_points)
        self._moved.count_along_surfaces()
        for pair in late:
            pair.push(dt, last, forces, touched)
        self.energy.begin_step(pair.law.held for pair in self._pairs)

    def before_stress(self, dt: float) -> None:
        self._moved.count_along_nodes()

    def end(self, dt: float) -> None:
        """Complete `lag_work`, before `TransferHeat` uses it."""
        self._last = dt
        if self._column is not None:
            self._moved.end(dt, self._column - FIRST_LOAD, self._fields)

    @property
    def lag_work(self) -> float:
        """Work of the forces on surfaces that nodes move, see `MovedSurfaces` [J]."""
        return self._moved.lag_work

    def balance(self, done: StepWork) -> None:
        """Move the work of forces between surfaces, which has a column of its own, to the contact work, the work of moving
        walls to that of supports, and assign the energy of changed contact leads to damping.

        The work along the velocities that a drag removes from the nodes at the start of a step is work of the drag.
        """
        if self._column is not None:
            from_outside = sum(pair.external_work() for pair in self._pairs)
            if self._searches:
                from_outside = 0.5 * (from_outside + self._from_outside)
            done.works[CONTACT] += done.works[self._column] - from_outside
            done.works[SUPPORT] += from_outside
            done.works[self._column] = 0.0
        done.works[CONTACT] += self._moved.drag_work
        done.works[DAMPING] += self._moved.drag_work
        self.energy.add_work(float(done.works[CONTACT]))
        if (lent := sum(pair.law.lent for pair in self._pairs)) != 0.0:  # on the way to a steady state
            done.works[CONTACT] -= lent
            done.works[DAMPING] -= lent

    def _cleared(self, surface: ContactSurface, n: int) -> np.ndarray:
        """Return an array of zero forces for the n points of a surface, shape (n, 3); the array is reused from step to
        step."""
        kept = self._forces.get(id(surface))
        if kept is None or len(kept) != n:
            kept = self._forces[id(surface)] = np.zeros((n, 3))
        else:
            kept.fill(0.0)
        return kept

    def _settle(self, touching: Sequence[Touch], dt: float, last: float) -> None:
        """Iterate the contact forces on flat sides of rigid bodies if bodies have several such contacts, as in a stack.

        touching: contacts with an overlap. dt, last: lengths of this and of the previous step [s]. Also finds the directions
        along which all contacts push the rigid bodies.
        """
        for pair in touching:
            if rigid := [surface for surface in pair.surfaces if surface.rigid_mass < np.inf]:
                way = pair.way()
                for surface in rigid:
                    surface.pushed_along.append(way)
        if not any(surface.pushed_along for surface in self.surfaces):
            return
        apart = [pair for pair in touching if pair.stops_apart]
        for pair in apart:
            if pair.law.stop is not None:
                pair.law.stop.begin()
        several = False
        for surface in self.surfaces:
            count = sum(surface in pair.surfaces for pair in apart)
            surface.stops_at_once = count == len(surface.pushed_along)
            several |= surface.rigid_mass < np.inf and count > 1 and surface.stops_at_once
        for _ in range(ROUNDS if several else 0):
            before = [surface.pushed.copy() for surface in self.surfaces]
            for pair in apart:
                pair.law.settle(pair.overlaps(), dt, last)
            change = max(float(np.abs(s.pushed - old).max()) for s, old in zip(self.surfaces, before, strict=True))
            if change <= SETTLED * max(float(np.abs(surface.pushed).max()) for surface in self.surfaces):
                break

    # steady states

    def begin_steady(self) -> None:
        """Switch to the search for equilibria: use contact leads, which remove overlaps, and update friction and initial
        overlaps in equilibria only."""
        self._is_steady = True
        for pair in self._pairs:
            pair.begin_steady()

    # the search for equilibria at trial positions

    def begin_search(self) -> None:
        """Begin the search for an equilibrium from the last one: in steps and on trials, the forces are those of the geometry
        of the last call of `freeze`, without dampers."""
        self._slips, self._searches = {id(surface): surface.slip.copy() for surface in self.surfaces}, True
        self._kept_leads = [lead.state_numbers() for lead in self._leads()]
        for lead in self._leads():
            lead.extrapolate(True)

    def note_external_work(self) -> None:
        """Note the work of moving walls over the step under the forces of the last equilibrium; the work of the step is the
        mean of this and of that under the forces of the next one."""
        self._from_outside = sum(pair.external_work() for pair in self._pairs)

    def cancel_search(self) -> None:
        """Return to the leads of the last equilibrium, for another search or a checkpoint."""
        for lead, kept in zip(self._leads(), self._kept_leads, strict=True):
            lead.restore(kept)

    def end_search(self) -> None:
        """End the search for an equilibrium: steps in time follow."""
        self._searches = False
        for lead in self._leads():
            lead.extrapolate(False)

    def freeze(self, time: float, dt: float, geometries: int = 1) -> None:
        """Detect contact at trial positions of an equilibrium at a time of the loads [s]. The velocities of the surfaces are
        their displacements since the last equilibrium over the step dt of the loads [s], from which friction follows.

        geometries: number of the last detections whose mean gives the forces.
        """
        described = self._described
        for surface in self.surfaces:
            surface.begin()
            described[id(surface)] = describe(surface, self._planes, self._seams, described.get(id(surface)))
        found = []
        for pair in self._pairs:
            pair.begin(time, 1.0)
            pair.step = dt
            if not _is_of_free_tool(pair):
                found += [(pair, side) for side in pair.freeze(described, self._slips, dt)]
        self._frozen = [*self._frozen[1 - geometries :], found] if geometries > 1 else [found]
        for _, side in chain(*self._frozen):
            side.weight = 1.0 / len(self._frozen)

    def exert_on_trial(
        self, surfaces: Sequence[ContactSurface], dt: float, tools: Sequence[ContactSurface] = ()
    ) -> list[np.ndarray]:
        """Compute the contact forces at the present positions for the geometry of the last call of `freeze`, and apply them to
        surfaces; dt: step in which they act [s]. Returns the sum of the forces on each surface of `tools` [N], shape (3,)."""
        described = self._described
        forces = {id(surface): np.zeros((len(described[id(surface)].place), 3)) for surface in self.surfaces}
        for surface in surfaces:
            surface.begin()
        for pair in self._pairs:
            pair.impulse = np.zeros(3)
        for pair, side in chain(*self._frozen):
            pair.impulse += dt * side.exert(forces, pair.surfaces[0])
        for surface in surfaces:
            surface.add_forces(described[id(surface)].fold(forces[id(surface)]))
        return [described[id(tool)].fold(forces[id(tool)]).sum(axis=0) for tool in tools]

    def jump(self, time: float, dt: float, judged: Callable[[], float]) -> float:
        """Return what `judged` returns with the geometry of contact at the present positions; afterwards the geometry is as
        before. time, dt: as for `freeze`."""
        kept = self._frozen
        self.freeze(time, dt)
        found = judged()
        self._frozen = kept
        return found

    def springs_of(self, surface: ContactSurface, tool: ContactSurface | None = None) -> list[ContactSprings]:
        """Return the springs of the last trial forces on a surface; tool: surface that they join it to, None for all."""
        sides = [side for _, side in chain(*self._frozen) if tool is None or side.touches(tool)]
        return [springs for side in sides if (springs := side.springs_of(surface)) is not None]

    def presses(self, tool: ContactSurface) -> bool:
        """Return True if the last forces at trial positions include pressure on the surface of a tool."""
        return any(side.touches(tool) and bool((side.last.press > 0.0).any()) for _, side in chain(*self._frozen))

    def left_out(self) -> list[tuple[str, ...]]:
        """Return the names of both sides of each overlap at the positions of the last call of `freeze` that the search for
        equilibria does not include: of a rigid body that is free to move with a wall or a body that does not deform."""
        pairs = [pair for pair in self._pairs if _is_of_free_tool(pair)]
        return [pair.between for pair in pairs if pair.find(self._described)]

    def store_friction(self) -> None:
        """Take the last trial as the reference state of friction and of initial overlaps."""
        for surface in self.surfaces:
            surface.slip.fill(0.0)
        for _, side in chain(*self._frozen):
            side.store_slip()
        for start in self._start_overlaps():
            start.reach_equilibrium()

    # steady states by relaxation

    def renew_leads(self) -> None:
        """Request an update of the contact leads (distances ahead of surfaces at which contact acts) at the start of the
        next step, see `pellucid.contact.leads`."""
        for lead in self._leads():
            lead.is_due = True

    def lead_change(self) -> tuple[float, float]:
        """Return two lengths [m]: the largest change of a contact lead in the last update, and the largest lead."""
        leads = self._leads()
        return max((lead.change for lead in leads), default=0.0), max((lead.largest for lead in leads), default=0.0)

    def mean_overlap(self) -> tuple[float, float]:
        """Return two lengths before the last update of the leads [m]: mean overlap around the corners and mean lead, weighted
        with the pressure; the first is infinite as long as no lead exerts pressure and there is overlap."""
        leads = self._leads()
        pressed = sum(lead.pressed for lead in leads)
        if pressed == 0.0:
            return (np.inf if self.lead_change()[0] > 0.0 else 0.0), 0.0
        overlap, length = np.sum([lead.moments for lead in leads], axis=0) / pressed
        return float(overlap), float(length)

    def reach_equilibrium(self) -> None:
        """Use the current equilibrium as the reference state of friction and initial overlaps."""
        for pair in self._pairs:
            pair.reach_equilibrium()
        for surface, at in self._untouched.values():
            surface.slip[at] = 0.0

    def _leads(self) -> list[ContactLead]:
        return [lead for pair in self._pairs for lead in pair.leads()]

    def touching(self) -> Iterator[tuple[ContactSurface, np.ndarray]]:
        """Yield each surface with the positions of its overlapping points [m], shape (n, 3)."""
        for pair in self._pairs:
            for overlap in pair.overlaps():
                yield overlap.one, overlap.one.place[overlap.listed]

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        """Return warnings about contacts in states that they cannot resolve, bodies that may pass through a sheet, surfaces
        that are too coarse where they touch, and unexplained energy."""
        found, close = dict[str, str](), list[tuple[ContactSurface, np.ndarray]]()
        for pair in self._pairs:
            if (text := pair.warning()) is not None:
                found[f"contact of {' and '.join(pair.between)}"] = text
            if len(pair.surfaces) == 2 and pair.surfaces[0].is_sheet != pair.surfaces[1].is_sheet:
                sheet, other = sorted(pair.surfaces, key=lambda surface: not surface.is_sheet)
                ahead = WARNING_INTERVAL * pair.step * (sheet.speed() + other.speed())
                if (text := passes_between(sheet, other, ahead)) is not None:
                    found[f"{other.body} on {sheet.body}"] = text
                close.append((sheet, find_places_beside(sheet, other)))
        for surface, places in [*close, *self.touching()]:
            if len(places) and (text := surface.contact_warning(places)) is not None:
                found["coarse surface"] = text
                break
        # the balance with the leads of steady states is not known, and impulses on nodes have none of their own
        judged = not (self._is_steady or self._on_nodes_too)
        if judged and (text := self.energy.warning(energy_scale)) is not None:
            found["energy"] = text
        return found

    def find_start_overlaps(self, least: float) -> None:
        """Find the contacts whose surfaces overlap at the start by more than the depth `least` [m]; see `start_overlaps`."""
        starting = [pair for pair in self._pairs if not all(surface.is_hard for surface in pair.surfaces)]
        described = dict[int, Described]()
        for surface in {id(surface): surface for pair in starting for surface in pair.surfaces}.values():
            surface.begin()
            described[id(surface)] = describe(surface, self._planes, self._seams)
        for pair in starting:
            pair.begin(0.0, 0.0)
            pair.follow(0.0)
            pair.find(described)
        depths = [(pair, depth) for pair in starting if (depth := pair.start_depth()) > least]
        self.start_overlaps = [OverlappingStart(pair.between, depth, pair.distance) for pair, depth in depths]

    def facts(self) -> Mapping[str, Any]:
        overlaps = [overlap.facts() for overlap in self.start_overlaps]
        return {"start_overlaps": overlaps} if overlaps else {}

    def go_on(self, bodies: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        """Continue the contact of bodies from an earlier run, with each other, with walls and with themselves.

        bodies: arrays of each continued body, by name. Overlaps between continued bodies exert force from the start. The
        sides of self-contact are restored if the arrays contain them.
        """
        for pair in self._pairs:
            if all(surface.body in bodies for surface in pair.surfaces):
                for start in pair.start_overlaps():
                    start.skip()
        for surface in self.surfaces:
            if surface.body in bodies and surface.of_itself:
                surface.go_on(bodies[surface.body])

    def impulses(self) -> dict[str, np.ndarray]:
        """Return the impulse on the first body of each named contact in this step [N s], shape (3,), by name."""
        total: dict[str, np.ndarray] = {}
        for pair in self._pairs:
            if pair.name is not None:
                total[pair.name] = total.get(pair.name, np.zeros(3)) + pair.impulse
        return total

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of all contacts for a checkpoint, by name: of triangulated surfaces the triangle that each point
        may touch and its side, and with USF the forces of the last step."""
        arrays: dict[str, np.ndarray] = {}
        for i, pair in enumerate(self._pairs):
            arrays |= with_owner(str(i), pair.state_arrays())
        return arrays | self._moved.state_arrays()

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        for i, pair in enumerate(self._pairs):
            pair.restore_arrays(of_owner(str(i), arrays))
        self._moved.restore(arrays)

    def state_numbers(self) -> dict[str, object]:
        """Return the numbers for a checkpoint: contact energy, dampers, initial overlaps, previous forces, and leads of
        steady states."""
        stops = [pair.law.stop.state_numbers() for pair in self._pairs if pair.law.stop]
        starts = [start.state_numbers() for start in self._start_overlaps()]
        given = [given.state_numbers() for given in self._previous_forces()]
        leads = [lead.state_numbers() for lead in self._leads()]
        lost = [pair.law.lost for pair in self._pairs]
        energy = self.energy.state_numbers()
        numbers: dict[str, object] = {"energy": energy, "stops": stops, "starts": starts, "given": given, "lost": lost}
        numbers["last"], numbers["counted"] = self._last, self._moved.state_number()
        if self._is_steady:
            numbers["leads"] = leads
        return numbers

    def _previous_forces(self) -> list[PreviousForces]:
        return [given for pair in self._pairs for given in pair.previous_forces()]

    def _start_overlaps(self) -> list[StartOverlap]:
        return [start for pair in self._pairs for start in pair.start_overlaps()]

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Restore the state of all contacts from the numbers of a checkpoint, the result of `state_numbers`."""
        self.energy.restore(numbers["energy"])
        self._last = numbers["last"]
        self._moved.restore_number(numbers["counted"])
        stops = [pair.law.stop for pair in self._pairs if pair.law.stop]
        for stop, kept in zip(stops, numbers["stops"], strict=True):
            stop.restore(kept)
        for start, kept in zip(self._start_overlaps(), numbers["starts"], strict=True):
            start.restore(kept)
        for given, kept in zip(self._previous_forces(), numbers["given"], strict=True):
            given.restore(kept)
        for lead, kept in zip(self._leads(), numbers.get("leads", ()), strict=True):
            lead.restore(kept)
        for pair, lost in zip(self._pairs, numbers["lost"], strict=True):
            pair.law.lost = lost


def _is_of_free_tool(pair: Touch) -> bool:
    """Return True for contact of a rigid body that is free to move with a wall or with a body that does not deform: a search
    for equilibria does not include it."""
    return all(surface.is_hard for surface in pair.surfaces) and any(s.rigid_mass < np.inf for s in pair.surfaces)


@kernel()
def _let_go(slip, touched):
    """Set the friction displacements `slip` [m], shape (m, 3), to zero at points that touch nothing; touched: mask, shape
    (m,)."""
    for p in range(len(slip)):
        if not touched[p]:
            slip[p, 0] = slip[p, 1] = slip[p, 2] = 0.0
