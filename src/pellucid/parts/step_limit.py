"""What bounds the step of a body, and why: what models foretell at the start, and bodies say of themselves as they are."""

from collections.abc import Iterable
from math import inf, sqrt
from typing import Literal, NamedTuple

Cause = Literal["wave", "membrane", "viscous", "bending", "motion", "contact", "spring", "capillary", "gravity", "none"]


class StepLimit(NamedTuple):
    """The largest stable step [s], infinite where nothing bounds it; in a word and in a clause, why."""

    step: float
    cause: Cause
    reason: str


EXPLAINS = 0.01
"""By which the density of a fluid may have changed, and its viscosity still be what bounds the step."""
NO_LIMIT = StepLimit(inf, "none", "nothing in it bounds the step")


def tightest(limits: Iterable[StepLimit]) -> StepLimit:
    """The smallest of some limits; the first of equal ones."""
    return min(limits, key=lambda limit: limit.step, default=NO_LIMIT)


def waves_in_cells(cell: float, wave: float, speed: float = 0.0, cause: Cause = "wave") -> StepLimit:
    """Waves [m/s] in what moves at a speed [m/s] cross no more than a cell [m] in a step."""
    if wave + speed <= 0.0:
        return NO_LIMIT
    if speed > wave:
        return StepLimit(cell / (wave + speed), "motion", f"it moves at {speed:.3g} m/s through cells of {cell:.4g} m")
    moving = f", moving at {speed:.3g} m/s," if speed > 0.01 * wave else ""
    where = "in its plane" if cause == "membrane" else "in it"
    return StepLimit(cell / (wave + speed), cause, f"waves {where} of {wave:.4g} m/s{moving} cross cells of {cell:.4g} m")


def motion_in_cells(cell: float, speed: float) -> StepLimit:
    """Nothing passes more than a cell [m] in a step at its speed [m/s]."""
    return waves_in_cells(cell, 0.0, speed)


def spread_in_cells(cell: float, diffusivity: float) -> StepLimit:
    """Momentum that spreads at a kinematic viscosity [m²/s] goes no farther than a cell [m]."""
    if diffusivity <= 0.0:
        return NO_LIMIT
    reason = f"its kinematic viscosity, {diffusivity:.3g} m2/s, spreads momentum over cells of {cell:.4g} m"
    return StepLimit(cell * cell / (2.0 * diffusivity), "viscous", reason)


def bending_in_cells(cell: float, rigidity: float) -> StepLimit:
    """Bending waves of a stiffness over areal density [m⁴/s²] cross no more than a cell [m]."""
    if rigidity <= 0.0:
        return NO_LIMIT
    return StepLimit(cell * cell / (2.0 * rigidity**0.5), "bending", f"bending waves cross cells of {cell:.4g} m")


def bending_in_mesh(rate: float) -> StepLimit:
    """Half the largest eigenfrequency of a mesh that bends [1/s]."""
    return StepLimit(1.0 / rate, "bending", f"its shortest bending waves swing at {rate / 3.141592653589793:.3g} Hz")


def signals_in_cells(cell: float, wave: float, diffusivity: float, speed: float = 0.0, cause: Cause = "wave") -> StepLimit:
    """The tighter of `waves_in_cells` and `spread_in_cells`."""
    return tightest([waves_in_cells(cell, wave, speed, cause), spread_in_cells(cell, diffusivity)])


def waves_in_mesh(rate: float, wave: float, cause: Literal["membrane", "wave"], spread: float = 0.0) -> StepLimit:
    """Half the largest eigenfrequency of membrane elements, or of a meshless solid [1/s], and the speed of waves in these
    [m/s]; a quarter of the largest rate at which their viscosity lets modes fade [1/s], by forces of the step before."""
    if rate <= 0.0 and spread <= 0.0:
        return NO_LIMIT
    if spread > rate:
        step = 1.0 / (sqrt(rate * rate + spread * spread) + spread)
        return StepLimit(step, "viscous", f"its viscosity spreads momentum over its smallest element within {step:.3g} s")
    rate = sqrt(rate * rate + spread * spread) + spread if spread > 0.0 else rate
    way, crossed, width = ("its plane", "smallest element", "wide") if cause == "membrane" else ("it", "closest nodes", "apart")
    reason = f"waves in {way} of {wave:.4g} m/s cross its {crossed}, in effect {wave / rate:.3g} m {width}"
    return StepLimit(1.0 / rate, cause, reason)


def swings(rate: float, cause: Literal["contact", "spring"]) -> StepLimit:
    """A rigid body that swings at a rate [1/s] on what it touches, or on springs."""
    if rate <= 0.0:
        return NO_LIMIT
    what = "what it touches" if cause == "contact" else "its springs"
    return StepLimit(1.0 / rate, cause, f"it swings on {what} within {1.0 / rate:.3g} s")


def springs_of_contact(rate: float) -> StepLimit:
    """Return the limit by springs of contact that are as stiff as the first step of the body allows, at its rate then [1/s]."""
    if rate <= 0.0:
        return NO_LIMIT
    return StepLimit(1.0 / rate, "contact", "the springs of its contact are as stiff as its step at the start allows")


def fall_through_cells(step: float) -> StepLimit:
    """The time in which what falls from rest passes a cell [s]."""
    return StepLimit(step, "gravity", f"what falls from rest passes a cell in {step:.3g} s")


def time_to_fall(cell: float, gravity: float) -> float:
    """In which what falls from rest passes a cell [s]."""
    return sqrt(2.0 * cell / gravity)


def told(rate: float, limits: Iterable[StepLimit]) -> StepLimit:
    """Of a bound that was found as a rate [1/s], which of some limits explains it: the tightest."""
    return tightest(limits)._replace(step=1.0 / rate) if rate > 0.0 else NO_LIMIT


def signals_seen(cell: float, rate: float, diffusivity: float, speed: float, cause: Cause = "wave") -> StepLimit:
    """Why signals cross cells [m] at a rate that was found [1/s]: their kinematic viscosity [m²/s] where it explains it, else
    waves, in what moves at a speed [m/s]."""
    spread = spread_in_cells(cell, diffusivity)
    if spread.step * rate < 1.0 + EXPLAINS:
        return spread
    return waves_in_cells(cell, max(rate * cell - speed, 0.0), speed, cause)
