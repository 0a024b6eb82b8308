"""Substeps of a film within a step of the run.

Their length is chosen so that the displacement by the difference of the two velocity estimates of a substep is small
compared with the node spacing.
"""

from collections.abc import Callable
from math import ceil, inf
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.fluid_film.balance import Driving, FilmBalance, StepDone, Unbalanced
from pellucid.bodies.fluid_film.checks import THINNEST
from pellucid.bodies.fluid_film.conditions.volume_constraints import Goals
from pellucid.bodies.fluid_film.forms.film_forces import in_space
from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.system.linear_algebra import on_one_thread

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.model import FluidFilmCase

GROWTH, SHRINKAGE, SAFETY = 2.0, 0.2, 0.9  # largest and smallest factor between substeps, and safety factor
SHORTEST = 1e-9  # length of a substep, relative to the step of the run, at which the film fails
GENTLER = "apply loads and volume changes more slowly (`rise`, `volume.over`), or use more nodes where it is thin or sharp"
STILL = 1e-14  # displacement in a substep, relative to the largest coordinate, below which the film is at rest
FIRST_SHARE = 1e-3  # length of the first substep, relative to the first step of the run


def is_still(done: StepDone, span: float) -> bool:
    """Return True if a substep of length span [s] moves the nodes by no more than the round-off of their positions. done:
    result of the substep.
    """
    return bool(span * np.abs(done.velocity).max() <= STILL * np.abs(done.x).max())


class OwnSteps:
    """Moves a film by substeps.

    Updates the arrays `x` (nodal positions), `v` (nodal velocities), `part_mass`, `own_step` (length of a substep) and
    `unspread` (displacement of the nodes with the film since they were last redistributed [m]). balance: computes the
    velocities; goals: prescribed volume and area over time; how: settings of the film.
    """

    def __init__(self, balance: FilmBalance, goals: Goals, how: "FluidFilmCase", arrays: dict[str, np.ndarray]) -> None:
        self._balance, self._goals, self._how, self._arrays = balance, goals, how, arrays
        self.fault: str | None = None
        """Reason why the film cannot be moved further; None if it can."""

    def over(self, dt: float, elapsed: float, driving: Driving, count: Callable[[StepDone, float], None]) -> Operators:
        """Move the film over a step of the run from time `elapsed` to `elapsed` + dt [s]; return the geometry and strain
        operators at the end.

        driving: loads and constraints; count: function called with the result of each substep and its length [s].
        """
        arrays, geometry, accuracy, left = self._arrays, self._balance.geometry, self._how.accuracy, dt
        own = float(arrays["own_step"][0]) or FIRST_SHARE * dt
        o = geometry.operators(arrays["x"])
        with on_one_thread():
            while left > 0.0 and self.fault is None:
                span = left / ceil(left / own * (1.0 - 1e-12))
                volume, area = self._goals.at(elapsed + dt - left + span)
                done = self._try(o, span, driving._replace(volume=volume, area=area, after=dt - left))
                if done is None:
                    break
                error = span * done.change / float(geometry.spacing(geometry.places(arrays["x"])).min())
                factor = SAFETY * (accuracy / error) ** 0.5 if error > 0.0 else inf
                own = span * min(max(factor, SHRINKAGE), GROWTH)
                if not error <= accuracy:  # nor is it a number
                    own = own if np.isfinite(error) else SHRINKAGE * span
                    if own < SHORTEST * dt:
                        self.fault = f"moves or stretches without bound: its substep became too small; {GENTLER}"
                    continue
                left -= span
                if is_still(done, span):
                    arrays["v"][:] = 0.0
                    count(done.at_rest, span)
                    continue
                o = self._take(o, done, span)
                count(done, span)
                self.fault = too_thin(self._balance, arrays, o)
        arrays["own_step"][0] = own
        return o

    def velocities_now(self, dt: float, elapsed: float, driving: Driving) -> np.ndarray:
        """Return the nodal velocities at the start of a step dt [s] of the run [m/s], shape (n, d), from its first substep;
        zero if the loads cannot be balanced (the step itself reports this). elapsed: time at the start of the step [s];
        driving: loads and constraints.
        """
        x, span = self._arrays["x"], FIRST_SHARE * dt
        volume, area = self._goals.at(elapsed + span)
        with on_one_thread():
            done = self._try(self._balance.geometry.operators(x), span, driving._replace(volume=volume, area=area, after=0.0))
        self.fault = None
        return np.zeros_like(x) if done is None or is_still(done, span) else done.velocity

    def _try(self, o: Operators, dt: float, driving: Driving) -> StepDone | None:
        arrays = self._arrays
        try:
            return self._balance.step(arrays["x"], o, arrays["part_mass"], dt, self._how.time_weight, driving)
        except Unbalanced as found:
            self.fault = str(found)
        except np.linalg.LinAlgError:
            self.fault = "has no equilibrium of forces: its system of equations is singular"
        return None

    def _take(self, o: Operators, done: StepDone, span: float) -> Operators:
        """Accept the result `done` of a substep of length span [s], redistribute the nodes evenly, and return the geometry and
        strain operators at the end. o: operators at the start.

        The surface through the redistributed nodes differs from the surface before by the interpolation error, and may store
        more energy. Redistribution that can wait is done only if the stored energy grows by at most the work done on the film.
        """
        arrays, balance, geometry = self._arrays, self._balance, self._balance.geometry
        mass, moved = arrays["part_mass"], arrays["unspread"] + (done.x - arrays["x"])
        arrays["v"][:], arrays["x"][:], arrays["unspread"][:] = done.velocity, done.x, moved
        if self._how.nodes == "even":
            waits, functions = geometry.can_wait(done.x), geometry.state_arrays()
            allowed = balance.stored_energy(o, mass) + span * done.power_received if waits else inf
            spread = geometry.redistributed(done.x, mass, moved)
            there = geometry.operators(spread.x)
            if not waits or balance.stored_energy(there, spread.mass) <= allowed:
                arrays["x"][:], mass[:], arrays["unspread"][:] = *spread, 0.0
                return there
            geometry.restore(functions)
        return geometry.operators(arrays["x"])


def too_thin(balance: FilmBalance, arrays: dict[str, np.ndarray], o: Operators) -> str | None:
    """Return a message about the place where the film is stretched so much that its density is too low for the model; None
    if there is no such place.

    balance: forces and densities of the film; arrays: state of the film; o: geometry of the film in this state.
    """
    geometry, rest = balance.geometry, balance.material.density
    density = balance.densities(o, arrays["part_mass"])
    if density.min() >= THINNEST * rest:
        return None
    places = geometry.places(arrays["x"])
    node = min(int(density.argmin()), len(places) - 1)
    place = ", ".join(f"{value:.6g}" for value in in_space(places, geometry.axes)[node])
    return (
        f"is stretched to {density.min() / rest:.2g} of its rest density near ({place}) m: its tension cannot carry the loads; "
        "reduce the loads, or increase `stiffness`"
    )
