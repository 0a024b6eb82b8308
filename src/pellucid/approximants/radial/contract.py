"""The interface of radial functions, and the polynomials beside them."""

from abc import abstractmethod
from math import ceil, comb
from typing import NamedTuple

import numpy as np

from pellucid.model import Model, check, parameter

NODES_PER_POLYNOMIAL = 1.4
NO_SHAPE = 0.0


class Profile(NamedTuple):
    """A radial function φ and its derivatives with respect to s = r², each of one shape."""

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray


class RadialModel(Model):
    """A radial function with polynomials, as the user describes it. A new one is a subclass with a `kind` of its own."""

    kind: str
    degree: int = parameter("", "degree of the polynomials beside it, which are reproduced", 4, ge=0, le=8)
    neighbours: int | None = parameter(
        "", "nodes of a stencil; without it 1.4 for each polynomial: of degree 4, 7 on a curve and 21 on a surface", None, ge=2
    )

    @abstractmethod
    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        """φ at squares s of the distance over the radius of the stencil, for shape parameters that broadcast to these."""

    @property
    @abstractmethod
    def least_degree(self) -> int:
        """Of the polynomials with which there always is one interpolant; -1 where it needs none."""

    @property
    @abstractmethod
    def derivatives(self) -> int:
        """How many derivatives are finite at the nodes: 2 or less is what matters."""

    @property
    def initial_shape(self) -> float:
        """Shape parameter times the radius of a stencil, before it is raised."""
        return NO_SHAPE

    @check
    def _has_an_interpolant(self) -> None:
        if self.degree < self.least_degree:
            few = f"with polynomials of a degree below {self.least_degree} some stencils have no interpolant of this function"
            raise ValueError(f"`degree` = {self.degree} is too low: {few}; use {self.least_degree} or more")

    def n_polynomials(self, dimension: int) -> int:
        """How many polynomials of its degree there are in so many dimensions."""
        return comb(self.degree + dimension, dimension)

    def stencil_size(self, dimension: int) -> int:
        """Nodes of a stencil in so many dimensions."""
        return self.neighbours or max(ceil(NODES_PER_POLYNOMIAL * self.n_polynomials(dimension)), 2)


class ShapedModel(RadialModel):
    """What radial functions with a shape parameter share.

    It is fixed relative to the radius of the stencil, so that functions do not depend on the unit of length and keep their form
    when nodes are added; where the system of a stencil is ill-conditioned it is raised.
    """

    shape: float = parameter(
        "",
        "shape parameter ε times the radius of the stencil; raised where the system would be ill-conditioned",
        1.0,
        ge=0.5,
        le=1,
    )

    @property
    def initial_shape(self) -> float:
        """What the user gives."""
        return self.shape

    @property
    def derivatives(self) -> int:
        """Smooth: what is asked for at most."""
        return 2
