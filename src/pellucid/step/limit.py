"""Limits of the stable time step of a body and their reasons, predicted from models at the start or computed by bodies in a
run."""

from collections.abc import Iterable
from math import inf, sqrt
from typing import Literal, NamedTuple

Cause = Literal["wave", "membrane", "viscous", "bending", "motion", "contact", "spring", "capillary", "gravity", "none"]


class StepLimit(NamedTuple):
    """A limit of the stable time step of a body or condition: the step [s], its cause as a word, and the reason as a phrase
    for messages."""

    step: float  # largest stable time step [s]; infinite if there is no limit
    cause: Cause  # word for the cause, such as "wave"
    reason: str  # phrase with the reason, for the user


EXPLAINS = 0.01
"""Largest relative difference between the step limit and the limit by viscosity, due to a change of the fluid's density,
at which viscosity is still reported as the reason."""
NO_LIMIT = StepLimit(inf, "none", "no stability limit")


def tightest(limits: Iterable[StepLimit]) -> StepLimit:
    """Return the smallest of several step limits (the first of equal ones); NO_LIMIT if there are none."""
    return min(limits, key=lambda limit: limit.step, default=NO_LIMIT)


def waves_in_cells(cell: float, wave: float, speed: float = 0.0, cause: Cause = "wave") -> StepLimit:
    """Return the step limit for which waves at a speed `wave` [m/s] in a body that moves at `speed` [m/s] cross at most one
    cell of the size `cell` [m]; cause: word for messages."""
    if wave + speed <= 0.0:
        return NO_LIMIT
    if speed > wave:
        return StepLimit(cell / (wave + speed), "motion", f"speed {speed:.3g} m/s through cells of {cell:.4g} m")
    moving = f" and body speed {speed:.3g} m/s" if speed > 0.01 * wave else ""
    where = "in-plane wave" if cause == "membrane" else "wave"
    return StepLimit(cell / (wave + speed), cause, f"{where} speed {wave:.4g} m/s{moving} in cells of {cell:.4g} m")


def motion_in_cells(cell: float, speed: float) -> StepLimit:
    """Return the step limit for which a body moving at a speed [m/s] crosses at most one cell of the size `cell` [m]."""
    return waves_in_cells(cell, 0.0, speed)


def spread_in_cells(cell: float, diffusivity: float) -> StepLimit:
    """Return the step limit for which momentum that diffuses with a kinematic viscosity `diffusivity` [m²/s] spreads over at
    most one cell of the size `cell` [m]."""
    if diffusivity <= 0.0:
        return NO_LIMIT
    reason = f"kinematic viscosity {diffusivity:.3g} m2/s in cells of {cell:.4g} m"
    return StepLimit(cell * cell / (2.0 * diffusivity), "viscous", reason)


def bending_in_cells(cell: float, rigidity: float) -> StepLimit:
    """Return the step limit for which bending waves cross at most one cell of the size `cell` [m]; rigidity: bending stiffness
    over areal density [m⁴/s²]."""
    if rigidity <= 0.0:
        return NO_LIMIT
    return StepLimit(cell * cell / (2.0 * rigidity**0.5), "bending", f"bending waves in cells of {cell:.4g} m")


def bending_in_mesh(rate: float) -> StepLimit:
    """Return the step limit due to bending waves in a mesh; rate: half its largest angular eigenfrequency [1/s]."""
    return StepLimit(1.0 / rate, "bending", f"shortest bending waves, frequency {rate / 3.141592653589793:.3g} Hz")


def signals_in_cells(cell: float, wave: float, diffusivity: float, speed: float = 0.0, cause: Cause = "wave") -> StepLimit:
    """Return the smaller of two step limits: of waves at the speed `wave` [m/s] in a body that moves at `speed` [m/s], and
    of momentum that diffuses with a kinematic viscosity `diffusivity` [m²/s], for cells of the size `cell` [m]; cause: word
    for messages if waves limit the step."""
    return tightest([waves_in_cells(cell, wave, speed, cause), spread_in_cells(cell, diffusivity)])


def waves_in_mesh(rate: float, wave: float, cause: Literal["membrane", "wave"], spread: float = 0.0) -> StepLimit:
    """Return the step limit due to waves in membrane elements or a meshless solid.

    rate: half the largest angular eigenfrequency [1/s]; wave: wave speed [m/s]; cause: "membrane" for elements; spread: a
    quarter of the largest decay rate by viscosity [1/s], if viscous forces of the previous step are used.
    """
    if rate <= 0.0 and spread <= 0.0:
        return NO_LIMIT
    if spread > rate:
        step = 1.0 / (sqrt(rate * rate + spread * spread) + spread)
        return StepLimit(step, "viscous", f"viscosity diffuses momentum across the smallest element in {step:.3g} s")
    rate = sqrt(rate * rate + spread * spread) + spread if spread > 0.0 else rate
    kind, size = ("in-plane wave", "element size") if cause == "membrane" else ("wave", "node spacing")
    reason = f"{kind} speed {wave:.4g} m/s, smallest effective {size} {wave / rate:.3g} m"
    return StepLimit(1.0 / rate, cause, reason)


FILTERED_WAVE = 2.0, 0.53
"""Wave number of the waves that limit the step of a membrane moved by a grid [1/cell], and the share of its forces that the
shape functions pass on: the square of the linear functions' filter (sin(k/2)/(k/2))², for which the share times the wave number
is largest. Smoother shape functions pass on less."""


def waves_in_liquid(cell: float, wave: float, areal_density: float, viscosity: float) -> StepLimit:
    """Return the step limit of a membrane that moves with a grid whose liquid has implicit pressure and viscosity.

    cell: cell size h [m]; wave: speed c of in-plane waves [m/s]; areal_density: mass m per area of the membrane [kg/m²];
    viscosity: μ of the liquid [Pa s]. The grid filters waves by its shape functions twice, when it gathers forces and when it
    moves the membrane: the wave number k = 2/h limits the step, with the share s = 0.53 of the forces. With the angular
    frequency ω² = s c² k², and the damping rate γ = 2μk/m of the liquid on both sides, which is implicit, the explicit forces
    of the membrane are stable in steps shorter than (γ + √(γ² + 4ω²))/ω²: 2/ω without viscosity, and 4μ/(s m c² k) if
    viscosity dominates.
    """
    if wave <= 0.0:
        return NO_LIMIT
    number, share = FILTERED_WAVE
    k = number / cell
    square, damping = share * (wave * k) ** 2, 2.0 * viscosity * k / areal_density
    step = (damping + sqrt(damping * damping + 4.0 * square)) / square
    reason = (
        f"in-plane wave speed {wave:.4g} m/s, damped by a liquid of viscosity {viscosity:.3g} Pa s, in cells of {cell:.4g} m"
    )
    return StepLimit(step, "membrane", reason)


def swings(rate: float, cause: Literal["contact", "spring"]) -> StepLimit:
    """Return the limit 1/rate [s] of a step that must resolve the oscillation of a rigid body on its contacts or springs; rate:
    [1/s], proportional to the angular frequency of the oscillation; cause: "contact" or "spring"."""
    if rate <= 0.0:
        return NO_LIMIT
    what = "contacts" if cause == "contact" else "springs"
    return StepLimit(1.0 / rate, cause, f"oscillation of the body on its {what}, which limits the step to {1.0 / rate:.3g} s")


def springs_of_contact(rate: float) -> StepLimit:
    """Return the limit 1/rate [s] of a step that must resolve the oscillation of a body on contact springs, whose stiffness is
    the largest that the first step allows; rate: [1/s], proportional to the angular frequency of the oscillation."""
    if rate <= 0.0:
        return NO_LIMIT
    return StepLimit(1.0 / rate, "contact", "contact springs with the largest stiffness that the first step allows")


def fall_through_cells(step: float) -> StepLimit:
    """Return the limit `step` [s] with its reason: an object falling from rest crosses a cell in this time."""
    return StepLimit(step, "gravity", f"an object falling from rest crosses a cell in {step:.3g} s")


def time_to_fall(cell: float, gravity: float) -> float:
    """Return the time that an object needs to fall from rest across a cell [s]; cell: edge length [m], gravity:
    acceleration [m/s²]."""
    return sqrt(2.0 * cell / gravity)


def with_consistent_mass(lumped: StepLimit) -> StepLimit:
    """Return the step limit with the consistent mass matrix (`pellucid.grid.consistent_mass`), which may double accelerations
    by given forces, and thus squares of frequencies and decay rates of velocities; lumped: limit with lumped masses."""
    share = 0.5 if lumped.cause == "viscous" else sqrt(0.5)
    return lumped._replace(step=share * lumped.step, reason=f"{lumped.reason}, with the consistent mass matrix")


def told(rate: float, limits: Iterable[StepLimit]) -> StepLimit:
    """Return the step limit 1/rate [s] for a rate computed in a run [1/s], with the cause and reason of the tightest of several
    limits."""
    return tightest(limits)._replace(step=1.0 / rate) if rate > 0.0 else NO_LIMIT


def signals_seen(cell: float, rate: float, diffusivity: float, speed: float, cause: Cause = "wave") -> StepLimit:
    """Return the step limit 1/rate for the rate [1/s] at which signals cross cells of the size `cell` [m] in a run, with
    its probable reason: viscosity if the kinematic viscosity `diffusivity` [m²/s] explains the rate, otherwise waves in a
    body that moves at `speed` [m/s]. cause: word for messages if the reason is waves."""
    spread = spread_in_cells(cell, diffusivity)
    if spread.step * rate < 1.0 + EXPLAINS:
        return spread
    return waves_in_cells(cell, max(rate * cell - speed, 0.0), speed, cause)
