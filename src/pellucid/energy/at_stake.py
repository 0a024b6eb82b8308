"""Energy at stake at the start of a run: the energy that its bodies could release."""

from collections.abc import Sequence

import numpy as np

from pellucid.energy.budget import Balanced

ROUNDING_SHARE = 1e-8
"""Of internal energy. Most of that of a fluid moves nothing; what it gives to others is judged as energy that moved. But where
nothing moves, the rounding of sums must not count as an error: half a unit in the last place of double precision, 1.1e-16 in
each step, adds up to 1e-10 of it in 1e6 steps that all round one way, and that is then 1 % of what is at stake."""

ROUNDING_STRAIN = 1e-7
"""Of solids and membranes. Many laws find the strain energy of a small strain as the difference of numbers of the size of the
moduli, such as tr b - 3 - 2 ln J, and half a unit in the last place of these is some 5e-17 m c²: as much as a strain of 1e-8
stores. That is 1 % of what this strain would store, m c²/2 times its square."""


def energy_at_stake(bodies: Sequence[Balanced], gravity: tuple[float, float, float], wave_speeds: Sequence[float]) -> float:
    """Strain energy, potential energy above the lowest point of all bodies, and what covers the rounding of stored energy [J].

    wave_speeds: of pressure waves in each body [m/s], 0 where none cross it.
    """
    strain = 0.0
    for body, speed in zip(bodies, wave_speeds, strict=True):
        if body.energy_kind == "strain":
            strain += abs(body.totals.stored) + 0.5 * float(body.stored_field("mass").sum()) * (speed * ROUNDING_STRAIN) ** 2
    internal = sum(abs(body.totals.stored) for body in bodies if body.energy_kind != "strain")
    masses = [body.stored_field("mass") for body in bodies]
    heights = [-np.sum(body.stored_field("position") * gravity, axis=1) for body in bodies]  # times the acceleration [m²/s²]
    lowest = min(float(height.min()) for height in heights)
    # no matrix products: their bits depend on the cores of the machine
    potential = sum(float(np.sum(mass * (height - lowest))) for mass, height in zip(masses, heights, strict=True))
    return strain + potential + ROUNDING_SHARE * internal
