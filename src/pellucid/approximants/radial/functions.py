"""Interface of radial functions with polynomials, which define the shape functions of radial point interpolation."""

from abc import abstractmethod
from math import ceil, comb
from typing import Literal, NamedTuple

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


class PolyharmonicModel(RadialModel):
    """Radial function φ = r³, r⁵ or r⁷ of the distance r (Duchon 1977), without a length parameter."""

    kind: Literal["polyharmonic"] = "polyharmonic"
    power: Literal[3, 5, 7] = parameter("", "power p in the radial function φ = rᵖ of the distance r", 5)

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        half = 0.5 * self.power
        root = np.sqrt(square)
        inverse = 1.0 / np.where(root > 0.0, root, np.inf)  # for r³; at a node it is only multiplied by zeros
        lowest = {3: inverse, 5: root, 7: square * root}[self.power]
        return Profile(square * square * lowest, half * square * lowest, half * (half - 1.0) * lowest)

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials for the power p: (p - 1)/2, as the function is conditionally definite of
        order ⌈p/2⌉."""
        return (self.power - 1) // 2

    @property
    def derivatives(self) -> int:
        return self.power - 1


class ThinPlateModel(RadialModel):
    """Radial function φ = r²ᵏ ln r of the distance r (Duchon 1977); second derivatives of r² ln r, the thin plate itself, are
    infinite at the nodes."""

    kind: Literal["thin-plate"] = "thin-plate"
    order: Literal[1, 2, 3] = parameter("", "exponent k in the radial function φ = r²ᵏ ln r of the distance r", 2)

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        """Return the radial function φ = r²ᵏ ln r = ½ sᵏ ln s of s = r² (`square`) and its first two derivatives by s;
        arguments: see `RadialModel.profile`."""
        k = self.order
        logarithm = np.log(np.where(square > 0.0, square, 1.0))  # at a node it is multiplied by zeros
        first = 0.5 * square ** (k - 1) * (k * logarithm + 1.0)
        # for k = 1 it is only used away from the nodes
        lower = square ** (k - 2) if k > 1 else 1.0 / np.where(square > 0.0, square, np.inf)
        return Profile(0.5 * square**k * logarithm, first, 0.5 * lower * (k * (k - 1) * logarithm + 2 * k - 1))

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials: k, as the function r²ᵏ ln r is conditionally definite of order k + 1."""
        return self.order

    @property
    def derivatives(self) -> int:
        return 2 * self.order - 1


class MultiquadricModel(ShapedModel):
    """Radial function φ = √(1 + (εr)²) of the distance r, with the shape parameter ε (Hardy 1971)."""

    kind: Literal["multiquadric"] = "multiquadric"

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        e = shape * shape
        value = np.sqrt(1.0 + e * square)
        return Profile(value, 0.5 * e / value, -0.25 * e * e / value**3)

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials: 0, as the function is conditionally definite of order 1."""
        return 0


class GaussianModel(ShapedModel):
    """Radial function φ = exp(-(εr)²) of the distance r, with the shape parameter ε (Benet 2015, eq. 4.16)."""

    kind: Literal["gaussian"] = "gaussian"

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        e = shape * shape
        value = np.exp(-e * square)
        return Profile(value, -e * value, e * e * value)

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials: -1, i.e. none are needed, as the function is positive definite."""
        return -1
