"""Interface of radial functions with polynomials, which define the shape functions of radial point interpolation."""

from abc import abstractmethod
from math import ceil, comb
from typing import NamedTuple

import numpy as np

from pellucid.model import Model, check, parameter

NODES_PER_POLYNOMIAL = 1.4
NO_SHAPE = 0.0


class Profile(NamedTuple):
    """A radial function φ and its first and second derivatives with respect to s = r², all of the same shape."""

    value: np.ndarray  # φ
    first: np.ndarray  # dφ/ds
    second: np.ndarray  # d²φ/ds²


class RadialModel(Model):
    """A radial function with polynomials, as defined in a case. A new one is a subclass with its own `kind`."""

    kind: str
    degree: int = parameter(
        "", "degree of the polynomials added to the radial functions; they are reproduced exactly", 4, ge=0, le=8
    )
    neighbours: int | None = parameter(
        "",
        "number of nodes of a stencil. Default: 1.4 times the number of polynomials, "
        "which is 7 nodes on a curve and 21 on a surface for degree 4",
        None,
        ge=2,
    )

    @abstractmethod
    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        """Return φ and its first two derivatives with respect to s = r² (`square`), at distances r in units of the stencil
        radius.

        shape: shape parameters times the stencil radius, which broadcast to s.
        """

    @property
    @abstractmethod
    def least_degree(self) -> int:
        """Smallest degree of the polynomials that guarantees a unique interpolant; -1 if no polynomials are needed."""

    @property
    @abstractmethod
    def derivatives(self) -> int:
        """Number of derivatives of the interpolant that are finite at the nodes; at most 2 are used."""

    @property
    def initial_shape(self) -> float:
        """Shape parameter times the radius of a stencil, before it is increased for ill-conditioned systems; 0 without a
        parameter."""
        return NO_SHAPE

    @check
    def _has_an_interpolant(self) -> None:
        if self.degree < self.least_degree:
            few = f"some stencils have no interpolant with this function unless the degree is at least {self.least_degree}"
            raise ValueError(f"`degree` = {self.degree} is too low: {few}; set `degree` to {self.least_degree} or more")

    def n_polynomials(self, dimension: int) -> int:
        """Return the number of monomials up to the degree of the model in `dimension` variables."""
        return comb(self.degree + dimension, dimension)

    def stencil_size(self, dimension: int) -> int:
        """Return the number of nodes of a stencil in `dimension` dimensions."""
        return self.neighbours or max(ceil(NODES_PER_POLYNOMIAL * self.n_polynomials(dimension)), 2)


class ShapedModel(RadialModel):
    """Base of radial functions with a shape parameter.

    The parameter is fixed relative to the radius of the stencil, so that functions do not depend on the unit of length and keep
    their shape when nodes are added. It is increased for a stencil whose system is ill-conditioned.
    """

    shape: float = parameter(
        "",
        "shape parameter ε times the radius of the stencil; increased automatically if the system is ill-conditioned",
        1.0,
        ge=0.5,
        le=1,
    )

    @property
    def initial_shape(self) -> float:
        return self.shape

    @property
    def derivatives(self) -> int:
        """Number of derivatives of the interpolant that are finite at the nodes and implemented: 2."""
        return 2
