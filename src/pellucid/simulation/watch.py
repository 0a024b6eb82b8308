"""Warnings during a run, each issued once: balances of energy and angular momentum, volume of fluids, states of bodies and of
parts of the step."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from pellucid.conditions.contact import Contact
from pellucid.conditions.enclosed.model import Enclosed
from pellucid.conditions.rigid.model import Rigid
from pellucid.conditions.support import Support
from pellucid.conditions.surface_tension.model import SurfaceTension
from pellucid.contact.contact_body import WarnsOfApproach
from pellucid.energy import FIRST_JUDGED, EnergyBudget
from pellucid.errors import RunStopped
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.parts.families import GridBody
from pellucid.set_up.even_densities import advice_on_even_densities
from pellucid.simulation.clock import Clock, fastest_point
from pellucid.step.part import WARNING_INTERVAL, StepParts

if TYPE_CHECKING:
    from pellucid.case import Case

LOOKS = 20  # steps between searches for parts of one body that approach each other
GAPS = 0.01  # cells without points over those with liquid; with 0.02, slow flow past a disc is 10 % too fast
CONFINED = 0.9  # smallest volume of liquids over that of their cells and of the gaps in a space that they fill
OVERFULL = 1.01  # largest volume of a fluid over that of the grid; errors of shapes and compression are much smaller
AGAINST_LOSS = "Check loads, velocities and moduli for values that are too large, or set a smaller time.courant"

CELLS = "set a smaller grid.cell"
APIC = f'Set time.transfer = "apic" and grid.functions = "quadratic-bspline", which conserve it, or {CELLS}'
TURNING = {
    "flip": f'The transfer "flip" does not conserve it if stresses vary from cell to cell. {APIC}',
    "blend": f'The PIC part of the transfer "blend" damps rotation within a cell. {APIC}',
    "pic": f'The transfer "pic" damps rotation within a cell. {APIC}',
    "aflip": f'The transfer "aflip" conserves it only in a rigid rotation. {APIC}',
    "apic": f'The transfer "apic" conserves it only with grid.functions = "quadratic-bspline": set these, or {CELLS}',
}
"""Remedies for a drift of the angular momentum, by transfer."""
SUMS = (
    "the works of loads and reactions differ from the stored energy by {:.2g} %, since they are sums over few large load "
    "steps; displacements and forces are not affected. Set a larger steady.load_steps if you need the works"
)
BETWEEN_BODIES = (Contact, Enclosed, Rigid, Support, SurfaceTension)
"""Conditions whose forces act between bodies, and supports, whose actions are detected by their impulses. Any other
condition may exert external torques on bodies, so that angular momentum is not conserved."""


class Watch:
    """Checks of a simulation after its steps: issues warnings about possible errors, and stops a run with a large error of
    the energy balance."""

    def __init__(self, case: "Case", own_steps: bool) -> None:
        """own_steps: True if all bodies take their own substeps."""
        self._case, self._limits, self._own_steps = case, case.energy, own_steps
        finer = (
            "a lower `accuracy` or more nodes"
            if own_steps
            else "a smaller time step or a finer grid"
            if case.grid_or_none is not None
            else "a smaller time step"
        )
        self._advice = f"Use {finer}, or increase energy.stop if the loss is expected"
        self._turning_advice = TURNING[case.time.transfer]
        self.warned: set[str] = set()
        """Keys of the warnings issued so far."""

    def energy(self, budget: EnergyBudget, clock: Clock, bodies: Sequence[Body]) -> None:
        """Check the energy balance `budget` at the end of a step, and warn if its error is large.

        The balance is not checked in the first steps of a run (unless bodies take substeps) or while a steady analysis
        corrects overlaps, but always in the last step. Raises RunStopped if the error is above the limit, and in any step if
        the balance is not finite.
        """
        error = abs(budget.energy_error())
        if not isfinite(error):
            words, place = fastest_point(bodies)
            text = f"step {clock.n_steps}, time {clock.progress():.6g} s: the energy balance is not finite"
            causes = f"infinite or undefined: {', '.join(budget.lost_entries()) or 'sums'}"
            raise RunStopped(f"{text} ({causes}){', ' * bool(words)}{words}\n    {AGAINST_LOSS}.", **place)
        if clock.adds_works_of_load_steps:
            if clock.finished(None) and error >= self._limits.warn:
                self._warn("energy", SUMS.format(100 * error))
            return
        early = clock.n_steps < FIRST_JUDGED and not self._own_steps
        if (early and not clock.finished(None)) or clock.is_adjusting or error < self._limits.warn:
            return
        causes = f"transfer {budget.transfer:.3g} J, time integration {budget.time_integration:.3g} J"
        if budget.made > 0.0:
            causes += f", added by contact and transfers {budget.made:.3g} J"
        text = f"step {clock.n_steps}, time {clock.progress():.6g} s: the energy error is {100 * error:.2g} % ({causes})"
        if error >= self._limits.stop:
            words, place = fastest_point(bodies)
            limit = f"above energy.stop = {100 * self._limits.stop:g} %{', ' * bool(words)}{words}"
            raise RunStopped(f"{text}, {limit}\n    {clock.against_energy_error or self._advice}.", **place)
        self._warn("energy", f"{text}, above energy.warn = {100 * self._limits.warn:g} %")

    def angular_momentum(self, budget: EnergyBudget, clock: Clock) -> None:
        """Warn if the angular momentum of bodies without external actions drifts; checked at intervals and at the end."""
        last = clock.finished(None)
        if budget.angular is None or not budget.is_isolated or (clock.n_steps % WARNING_INTERVAL and not last):
            return
        if (error := budget.angular.observe()) < self._limits.warn:
            return
        if clock.n_steps >= FIRST_JUDGED or last:
            where, change = f"step {clock.n_steps}, time {clock.progress():.6g} s", f"{100 * error:.2g} %"
            text = f"{where}: the angular momentum has changed by {change}, above energy.warn = {100 * self._limits.warn:g} %"
            text += f", although no external load acts on the bodies. {self._turning_advice}."
            self._warn("angular momentum", text)

    def approaches(self, bodies: Sequence[Body], clock: Clock) -> None:
        """Warn about parts of the surface of one body that approach each other: such parts would stick, as material points
        of one velocity field share the nodes of the grid. Checked at intervals and at the end, once for each body."""
        if clock.n_steps % LOOKS and not clock.finished(None):
            return
        for body in bodies:
            what = f"approach in {body.name}"
            if not isinstance(body, WarnsOfApproach) or what in self.warned:
                continue
            others = [other for other in bodies if other is not body]
            if (text := body.approach_warning(partial(_lie_near, others))) is not None:
                self._warn(what, f"step {clock.n_steps}, time {clock.time:.6g} s: {text}")

    def states(self, bodies: Sequence[Body], clock: Clock) -> None:
        """Issue the warnings of bodies about their state (`Body.state_warning`), at intervals and at the end; each body
        warns once."""
        if clock.n_steps % WARNING_INTERVAL and not clock.finished(None):
            return
        for body in bodies:
            if (what := f"state of {body.name}") not in self.warned and (text := body.state_warning()) is not None:
                self._warn(what, f"step {clock.n_steps}, time {clock.time:.6g} s: {text}")

    def parts(self, parts: StepParts, budget: EnergyBudget, clock: Clock) -> None:
        """Issue the warnings of the parts of a step, at intervals and at the end; each part warns once of each topic."""
        last = clock.finished(None)
        if clock.n_steps % WARNING_INTERVAL and not last:
            return
        scale = budget.energy_scale if clock.n_steps >= FIRST_JUDGED or last else inf
        for topic, text in parts.warnings(scale).items():
            self._warn(topic, f"step {clock.n_steps}, time {clock.time:.6g} s: {text}")

    def volumes(self, fields: Mapping[VelocityField, Sequence[GridBody]], clock: Clock) -> None:
        """Warn, at intervals, if the volume of the fluid points of a velocity field exceeds the volume of the grid; fields:
        velocity fields with their bodies on the grid."""
        if clock.n_steps % WARNING_INTERVAL or "volume" in self.warned:
            return
        for field, bodies in fields.items():
            share = sum(body.fluid_volume() for body in bodies) / field.grid.volume
            if share > OVERFULL:
                names = " and ".join(body.name for body in bodies if body.fluid_volume() > 0.0)
                text = (
                    f"the volume of the points of {names} is {100 * (share - 1):.2g} % larger than the grid, so the "
                    "pressure is too low"
                )
                come_and_go = any("mass" not in body.constant_fields for body in bodies)  # such have no cell_pressure
                advice = "Add carries_tension = true to the eos" if come_and_go else "Add cell_pressure = true to the body"
                if self._case.time.transfer != "apic":
                    advice += ', or set time.transfer = "apic"'
                where = "see `Rest does not last for ever` in docs/physics/fluids.md"
                return self._warn("volume", f"step {clock.n_steps}, time {clock.time:.6g} s: {text}. {advice}; {where}.")

    def gaps(self, fields: Mapping[VelocityField, Sequence[GridBody]], clock: Clock) -> None:
        """Warn, at intervals and at the end, if liquids that fill their space have left gaps in it: cells without points, in
        which no stress acts. fields: velocity fields with their bodies on the grid."""
        if "gaps" in self.warned or (clock.n_steps % WARNING_INTERVAL and not clock.finished(None)):
            return
        for field, bodies in fields.items():
            liquids = [body for body in bodies if body.liquid_volume() > 0.0]
            if not liquids or (share := share_of_gaps(field, bodies)) <= GAPS:
                continue
            names = " and ".join(body.name for body in liquids)
            text = f"{100 * share:.2g} % of the cells inside {names} contain no points, so the flow is wrong there"
            smooth = field.grid.case.is_smooth  # with others a slit lets too much pass, see validation/slit
            settings = [] if smooth else ['grid.functions = "quadratic-bspline"']
            if even := advice_on_even_densities(self._case, [body.name for body in liquids]):
                settings.append(even)
            advice = f"{' and '.join(settings)}, or a smaller grid.cell" if settings else "a smaller grid.cell"
            return self._warn("gaps", f"step {clock.n_steps}, time {clock.time:.6g} s: {text}. Set {advice}.")

    def _warn(self, what: str, text: str) -> None:
        if what not in self.warned:
            self.warned.add(what)
            warnings.warn(text, stacklevel=4)


def share_of_gaps(field: VelocityField, bodies: Sequence[GridBody]) -> float:
    """Return the number of cells without points that are at least a cell away from walls, over the number of cells with
    liquid; 0 if liquids do not fill the space of a velocity field, as beside a free surface. bodies: bodies on its grid."""
    grid = field.grid
    counts, cell = np.array(grid.lattice.counts), grid.lattice.cell
    empty, dry = np.ones(counts, bool), np.ones(counts, bool)
    for body in bodies:
        at = np.floor((body.stored_field("position") - grid.lattice.lower) / cell).astype(int)
        at = np.where(grid.periodic, np.mod(at, counts), np.clip(at, 0, counts - 1))
        empty[tuple(at.T)] = False
        if body.liquid_volume() > 0.0:
            dry[tuple(at.T)] = False
    middle = grid.lattice.lower + (np.argwhere(empty) + 0.5) * cell
    axes = np.eye(3)[~np.array(grid.thin)]
    for wall in field.walls:
        near = [wall.fills(middle + step * cell) for step in (np.zeros(3), *axes, *-axes)]
        middle = middle[~np.any(near, axis=0)]
    filled, gaps = dry.size - np.count_nonzero(dry), len(middle)
    volume = sum(body.liquid_volume() for body in bodies)
    return gaps / filled if volume >= CONFINED * (filled + gaps) * grid.cell_volume else 0.0


def _lie_near(bodies: Iterable[Body], places: np.ndarray, distance: float) -> np.ndarray:
    """Return a mask of the positions [m], shape (k, 3), that lie within a distance [m] of at least one point of the bodies."""
    near = np.zeros(len(places), bool)
    for body in bodies:
        if len(places):
            near |= np.isfinite(cKDTree(np.asarray(body.field("position"))).query(places, distance_upper_bound=distance)[0])
    return near


def free_axes(case: "Case") -> Sequence[int]:
    """Return the axes (0, 1, 2) about which the angular momentum of a case is constant unless supports or gravity act on a
    body."""
    acting = [base for base, several in case.conditions().items() if several and not issubclass(base, BETWEEN_BODIES)]
    if acting or case.steady is not None or any(body.has_own_step or not body.moves for body in case.body):
        return []
    bound = [thin or period > 0.0 for thin, period in zip(case.thin, case.periods, strict=True)]
    return [axis for axis in range(3) if not any(bound[other] for other in range(3) if other != axis)]
