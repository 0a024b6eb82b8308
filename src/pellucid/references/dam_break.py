"""Collapse of a water column on a dry floor: Martin and Moyce's experiment, and Ritter's bound."""

import csv
from dataclasses import dataclass
from importlib.resources import files
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from pellucid.references.annotations import Array, Case


def martin_moyce(quantity: str) -> tuple[Array, Array]:
    """Return times and values of a measured curve, shape (n,) each, for n² = 2: `front` (times T = n t sqrt(g/a), front Z =
    x/a) or `height` (times tau = t sqrt(g/a), height at the wall H = y/(n² a)).

    a: initial width of the column, n²: ratio of its height to its width. The start of the flow could not be observed in the
    experiment: each series is shifted in time so that all agree at Z = 1.44.
    """
    text = files("pellucid.references").joinpath("martin_moyce_1952.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    pairs = np.array([(float(row["time"]), float(row["value"])) for row in rows if row["quantity"] == quantity])
    return pairs[:, 0], pairs[:, 1]


@dataclass(frozen=True)
class Column:
    """A water column that collapses at a wall: initial width and height [m], and gravity [m/s²], which convert times and
    lengths of a run to the dimensionless numbers of the measurements (`martin_moyce`)."""

    width: float  # initial width a [m]
    height: float  # initial height [m]
    gravity: float  # g [m/s²]

    @classmethod
    def of(cls, case: Case) -> "Column":
        """Build the column of a case whose first body is a box, with gravity along -y."""
        lower, upper = case.body[0].bounds()
        return cls(float(upper[0] - lower[0]), float(upper[1] - lower[1]), -case.gravity[1])

    @property
    def aspect(self) -> float:
        """n², the ratio of the initial height to the initial width of the column."""
        return self.height / self.width

    def front_time(self, time: ArrayLike) -> Array:
        """Return the dimensionless times T = n t sqrt(g/a) of times t [s]."""
        return np.asarray(time, dtype=float) * sqrt(self.aspect * self.gravity / self.width)

    def height_time(self, time: ArrayLike) -> Array:
        """Return the dimensionless times tau = t sqrt(g/a) of times t [s]."""
        return np.asarray(time, dtype=float) * sqrt(self.gravity / self.width)

    def ritter(self, time: ArrayLike) -> Array:
        """Return the front position x/a = 1 + 2T of a frictionless thin sheet (shallow water) at times [s], an upper bound for
        all columns; T: dimensionless time of `front_time`."""
        return 1.0 + 2.0 * self.front_time(time)
