"""Isotropic elastodamage of membranes: a damage variable ω, driven by the largest principal strain, reduces the stress.

ε_max - S_L (1 + ω) ≤ 0, ω never decreases, and σ = (1 + c₀ (exp(-c₁ ω) - 1)) σᵉ, clipped at zero. Source: Gan et al. 2011,
eqs. 38-41; the factor 2 of eq. 39 is a misprint: with it the stiffness is negative at the failure strain stated in the
text. Here S_L is `elastic_limit`, c₀ `stiffness_loss`, c₁ `rate`.

A membrane has a damage law in addition to its elastic law; `Undamaged` compiles to no code.
"""

from math import exp
from typing import NamedTuple

import numpy as np

from pellucid.jit import generic, point_function, pointwise
from pellucid.materials.law import Law
from pellucid.materials.membrane import Shape, largest_strain
from pellucid.model import Model, check, parameter


class Undamaged(NamedTuple):
    """Damage law of a membrane without damage; its type selects functions that leave the stiffness unchanged."""


class Elastodamage(NamedTuple):
    """Parameters of the damage law, which multiplies the elastic stress by 1 + c₀ (exp(-c₁ ω) - 1), with the damage ω =
    max(0, ε_max/S_L - 1) for the largest principal strain ε_max so far: elastic limit S_L, stiffness loss c₀, rate c₁, and the
    strain at which a point fails."""

    elastic_limit: float  # S_L: principal strain at which damage starts
    stiffness_loss: float  # c₀
    rate: float  # c₁
    failure_strain: float  # largest principal strain above which a point fails


class DamageRecord(NamedTuple):
    """Damage state of points; arrays of length 0 without damage."""

    damage: np.ndarray  # (n,) damage variable ω, 0 for undamaged points
    failed: np.ndarray  # (n,) 1 for a failed point, else 0
    dissipated_energy: np.ndarray  # (n,) work of the stress dissipated by damage [J/kg]


class DamageCase(Model):
    """Elastodamage of a membrane, driven by its largest principal strain in the plane."""

    elastic_limit: float = parameter("", "elastic limit S_L: strain at which damage starts", gt=0)
    stiffness_loss: float = parameter("", "c₀: fraction of the stiffness lost at full damage; all of it if above 1", gt=0)
    rate: float = parameter("", "c₁: rate of the decrease of stiffness with the damage ω = ε_max/S_L - 1", gt=0)
    failure_strain: float = parameter("", "strain beyond which a point fails permanently", gt=0)

    radius: float | None = parameter(
        "m",
        "radius on the initial surface over which the strain is averaged for damage; default: the strain at the point",
        None,
        gt=0,
    )

    @check
    def _fails_after_it_yields(self) -> None:
        if self.failure_strain <= self.elastic_limit:
            text = f"failure_strain = {self.failure_strain:g} is not above elastic_limit = {self.elastic_limit:g}"
            raise ValueError(f"{text}; set failure_strain above elastic_limit")

    def law(self) -> Elastodamage:
        """Return the damage law, as a NamedTuple of its parameters for the kernels."""
        return Elastodamage(self.elastic_limit, self.stiffness_loss, self.rate, self.failure_strain)


@pointwise
def stiffness(law, damage):
    """Return the fraction of the initial stiffness that remains at the damage ω, 1 + c₀ (exp(-c₁ ω) - 1), at least 0; law:
    its parameters."""
    return max(0.0, 1.0 + law.stiffness_loss * (exp(-law.rate * damage) - 1.0))


@generic
def has_failed(law: Law, record: DamageRecord, p: int) -> bool:
    """Return True if point p has failed, so that it carries no stress; law: damage law of the membrane; record: damage state
    of its points."""


@generic
def upright(law: Law, along: float) -> bool:
    """Return True if a triangle contributes to the orientation (normal) of the surface at its corner; law: damage law;
    along: component of the normal of the triangle along the previous normal at the corner.

    Near a tear, triangles turn over or vanish while other triangles at the corner still carry stress.
    """


@generic
def driving_strain(law: Law, elastic: Law, shape: Shape) -> float:
    """Return the strain that drives damage by the damage law `law`: the largest principal strain of the in-plane shape (see
    `pellucid.materials.membrane`) of a membrane with the elastic law `elastic`."""


@generic
def weaken(law: Law, record: DamageRecord, p: int, strain: float) -> tuple[float, float]:
    """Update the damage of point p in the record for the strain that drives damage (`driving_strain`). Return the stiffness
    divided by the initial stiffness, and divided by the stiffness before the step."""


@generic
def dissipate(law: Law, record: DamageRecord, p: int, work: float, kept: float) -> None:
    """Add the energy per unit mass dissipated by damage in the step [J/kg] to the record of point p; work: work of the
    stress on the point since the start [J/kg]; kept: stiffness divided by the stiffness before the step. The recoverable
    part of the work is proportional to the stiffness."""


@point_function(has_failed, Undamaged)
def _never(law, record, p):
    return False


@point_function(upright, Undamaged)
def _always(law, along):
    return True


@point_function(driving_strain, Undamaged)
def _nothing_drives(law, elastic, shape):
    return 0.0


@point_function(weaken, Undamaged)
def _stays(law, record, p, strain):
    return 1.0, 1.0


@point_function(dissipate, Undamaged)
def _dissipates_nothing(law, record, p, work, kept):
    pass


@point_function(has_failed, Elastodamage)
def _has_failed(law, record, p):
    return record.failed[p] > 0.0


@point_function(upright, Elastodamage)
def _upright(law, along):
    return along > 0.0


@point_function(driving_strain, Elastodamage)
def _driving_strain(law, elastic, shape):
    return largest_strain(elastic, shape)


@point_function(weaken, Elastodamage)
def _weaken(law, record, p, strain):
    before = record.damage[p]
    after = max(before, strain / law.elastic_limit - 1.0)
    if strain > law.failure_strain:
        record.failed[p] = 1.0
        left = kept = 0.0
    elif after > 0.0:
        left, whole = stiffness(law, after), stiffness(law, before)
        kept = left / whole if whole > 0.0 else 0.0
    else:
        left = kept = 1.0
    record.damage[p] = after
    return left, kept


@point_function(dissipate, Elastodamage)
def _dissipate(law, record, p, work, kept):
    # what can be recovered is proportional to the stiffness
    record.dissipated_energy[p] += (work - record.dissipated_energy[p]) * (1.0 - kept)
