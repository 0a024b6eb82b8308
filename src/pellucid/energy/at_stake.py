"""Energy at stake at the start of a run: the energy that its bodies could release."""

from collections.abc import Sequence

import numpy as np

from pellucid.energy.budget import Balanced

ROUNDING_SHARE = 1e-8
"""Fraction of the internal energy that counts as energy at stake, i.e. as part of the reference of the energy error. Most of
the internal energy of a fluid does not cause motion, and the part that is exchanged counts as energy that moved. But in a
case without motion, the rounding of sums must not count as an error: half a unit in the last place of double precision,
1.1e-16 in each step, adds up to 1e-10 of the internal energy in 1e6 steps that all round in the same direction. This is 1 %
of the energy at stake then."""

ROUNDING_STRAIN = 1e-7
"""Strain whose energy covers the rounding of the strain energy of solids and membranes. Many laws compute the energy of a
small strain as a difference of numbers of the size of the moduli, such as tr b - 3 - 2 ln J. Half a unit in the last place
of these numbers is about 5e-17 m c²: as much as a strain of 1e-8 stores. It is 1 % of the energy of this strain, m c²/2
times its square."""


def energy_at_stake(bodies: Sequence[Balanced], gravity: tuple[float, float, float], wave_speeds: Sequence[float]) -> float:
    """Return the energy that the bodies could release [J]: strain energy, potential energy above the lowest point of all
    bodies, and an allowance for the rounding of the stored energy.

    gravity: acceleration, shape (3,) [m/s²]. wave_speeds: speed of pressure waves in each body [m/s], 0 for a body without
    waves.
    """
    strain = 0.0
    for body, speed in zip(bodies, wave_speeds, strict=True):
        if body.energy_kind == "strain":
            strain += abs(body.totals.stored) + 0.5 * float(body.stored_field("mass").sum()) * (speed * ROUNDING_STRAIN) ** 2
    internal = sum(abs(body.totals.stored) for body in bodies if body.energy_kind != "strain")
    masses = [body.stored_field("mass") for body in bodies]
    heights = [-np.sum(body.stored_field("position") * gravity, axis=1) for body in bodies]  # times the acceleration [m²/s²]
    lowest = min(float(height.min()) for height in heights)
    # no matrix products: their rounding depends on the number of cores
    potential = sum(float(np.sum(mass * (height - lowest))) for mass, height in zip(masses, heights, strict=True))
    return strain + potential + ROUNDING_SHARE * internal
