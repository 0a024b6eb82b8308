"""Shock tubes: the exact profile of a case, and profiles of a run averaged over a few grid cells."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pellucid.references.annotations import Array, Case
from pellucid.references.riemann import GasState, RiemannSolution, solve

QUANTITIES = {"density": "kg/m^3", "pressure": "Pa", "velocity": "m/s", "internal_energy": "J/kg"}


@dataclass(frozen=True)
class Tube:
    """A shock tube along x, the reference of a case: exact solution, position of the diaphragm, ends of the tube and cell
    size [m]."""

    solution: RiemannSolution  # exact solution for the gases on both sides of the diaphragm
    diaphragm: float  # initial position of the contact between the gases [m]
    lower: float  # lower end of the tube [m]
    upper: float  # upper end of the tube [m]
    cell: float  # cell size of the grid [m]

    @classmethod
    def of(cls, case: Case) -> "Tube":
        """Build the tube of a case whose first body is the gas on the left and whose second body is the gas on the right."""
        left, right = (_gas(body) for body in case.body)
        diaphragm = float(case.body[0].bounds()[1][0])
        return cls(solve(left, right), diaphragm, case.grid.lower[0], case.grid.upper[0], case.grid.cell)

    def exact(self, x: Array, time: float) -> dict[str, Array]:
        """Return density, velocity, pressure and internal energy by name (SI units) at positions x [m] of any shape and a time
        [s]; valid until a wave reaches an end of the tube."""
        if time == 0.0:  # the two gases, whatever lies between them later
            return self.solution.sample(np.where(x < self.diaphragm, -np.inf, np.inf))
        return self.solution.sample((x - self.diaphragm) / time)

    def fronts(self, time: float) -> dict[str, float]:
        """Return the positions of the head and tail of the left rarefaction, of the contact, and of the right shock [m] at a
        time [s], by name."""
        speeds = {
            "fan head": self.solution.left_wave.head,
            "fan tail": self.solution.left_wave.tail,
            "contact": self.solution.velocity,
            "shock": self.solution.right_wave.head,
        }
        return {name: self.diaphragm + speed * time for name, speed in speeds.items()}

    def mean_profile(self, time: float, cells: int = 4, samples: int = 400) -> "Profile":
        """Return the means of the exact fields at a time [s] over bins of `cells` grid cells, weighted as in
        `Profile.of_points`, by the midpoint rule with `samples` points in each bin."""
        edges = self.edges(cells)
        inside = (np.arange(samples) + 0.5) / samples
        fields = self.exact(edges[:-1, None] + np.diff(edges)[:, None] * inside, time)
        density = fields["density"].mean(axis=1)
        means = {"density": density, "pressure": fields["pressure"].mean(axis=1)}
        for name in ("velocity", "internal_energy"):
            means[name] = (fields["density"] * fields[name]).mean(axis=1) / density
        return Profile(edges, means)

    def edges(self, cells: int) -> Array:
        """Return the edges of bins of about `cells` grid cells along the tube [m]."""
        count = max(1, round((self.upper - self.lower) / self.cell / cells))
        return np.linspace(self.lower, self.upper, count + 1)


@dataclass(frozen=True)
class Profile:
    """A profile of means over bins (intervals along x): `edges` [m], shape (n+1,), and `means`, an array of shape (n,) for each
    quantity."""

    edges: Array
    means: dict[str, Array]

    @property
    def centres(self) -> Array:
        """Centres of the bins [m], shape (n,)."""
        return 0.5 * (self.edges[:-1] + self.edges[1:])

    @classmethod
    def of_points(cls, points: dict[str, Array], edges: Array) -> "Profile":
        """Compute means of the fields of points (by name) in bins along x with the given edges [m], shape (n+1,).

        Density is mass divided by volume; pressure is weighted by volume, velocity and internal energy by mass. A bin without
        points has the value NaN.
        """
        x, mass = points["position"][:, 0], points["mass"]
        volume = mass / points["density"]

        def total(weight: Array) -> Array:
            return np.histogram(x, bins=edges, weights=weight)[0]

        with np.errstate(invalid="ignore"):
            in_bin, filled = total(mass), total(volume)
            means = {"density": in_bin / filled, "pressure": total(volume * points["pressure"]) / filled}
            means["velocity"] = total(mass * points["velocity"][:, 0]) / in_bin
            means["internal_energy"] = total(mass * points["internal_energy"]) / in_bin
        return cls(edges, means)

    def relative_l1(self, exact: "Profile", name: str) -> float:
        """Return the relative L1 error of the quantity `name`, sum |mean - exact mean| / sum |exact mean|, over the bins that
        contain points. exact: profile of exact means in the same bins."""
        width, found, wanted = np.diff(self.edges), self.means[name], exact.means[name]
        known = np.isfinite(found)
        return float(np.sum((width * np.abs(found - wanted))[known]) / np.sum(width * np.abs(wanted)))

    def relative_variation(self, name: str) -> float:
        """Return the total variation of a quantity along the tube, divided by the integral of its absolute value [1/m].

        A profile displaced by d has a relative L1 error of at most d times this number, which converts a length into an
        error.
        """
        values = self.means[name]
        return float(np.sum(np.abs(np.diff(values))) / np.sum(np.diff(self.edges) * np.abs(values)))


def points_of(run: Any, bodies: Iterable[Any] | None = None) -> dict[str, Array]:
    """Return the fields of the points of several bodies (default: all) at the end of a run, concatenated."""
    frames = [run.fields(body.name) for body in (run.case.body if bodies is None else bodies)]
    names = ("position", "velocity", "density", "pressure", "internal_energy", "mass")
    return {name: np.concatenate([np.asarray(frame[name], dtype=float) for frame in frames]) for name in names}


def _gas(body: Any) -> GasState:
    material = body.material
    if material.kind != "fluid" or material.eos.kind != "ideal-gas":
        raise ValueError(f"body {body.name!r} is not an ideal gas: the exact solution of the tube is for ideal gases")
    return GasState(material.density, body.velocity[0], material.pressure, material.eos.gamma)
