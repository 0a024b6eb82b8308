"""Speeds at which waves, viscosity and bending propagate changes in a film on the grid; they limit the time step."""

from math import sqrt

import numpy as np

from pellucid.bodies.fluid_film.forms.virtual_power import FilmPhysics
from pellucid.materials.lipid_film import LipidFilm
from pellucid.step.limit import StepLimit, bending_in_cells, spread_in_cells, tightest, waves_in_cells


class Signals:
    """The wave speed [m/s], momentum diffusivity [m²/s] and bending coefficient [m⁴/s²] of a film with inertia.

    physics: viscosities and bending rigidity; material: equation of state of the film; density: surface density at its nodes
    or elements [kg/m²].
    """

    def __init__(self, physics: FilmPhysics, material: LipidFilm, density: np.ndarray) -> None:
        tension, least = -material.pressure(density), float(density.min())
        self.wave = sqrt(float(np.max((density * material.pressure_slope(density) + np.maximum(tension, 0.0)) / density)))
        self.spread = (2.0 * physics.viscosity + physics.dilatational_viscosity) / least
        self.bending = physics.bending_rigidity / least

    def rate(self, h: float) -> float:
        """Return the reciprocal of the largest stable time step by waves, viscosity and bending [1/s]. h: reciprocal of the
        size of the grid cells [1/m].
        """
        return max(h * self.wave, 2.0 * h * h * self.spread, 2.0 * h * h * sqrt(self.bending))

    def limit(self, cell: float, speed: float) -> StepLimit:
        """Return the largest stable time step and its cause, for grid cells of size `cell` [m] and a film that moves at a
        speed [m/s].
        """
        waves, spread = waves_in_cells(cell, self.wave, cause="membrane"), spread_in_cells(cell, self.spread)
        tight = tightest([waves, spread, bending_in_cells(cell, self.bending)])
        return tight._replace(step=1.0 / (1.0 / tight.step + speed / cell))
