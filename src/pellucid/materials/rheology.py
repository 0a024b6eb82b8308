"""Rheology of fluids: laws of the shear viscosity μ as a function of the shear rate γ̇ = sqrt(2 D':D'), with the deviator D' of
the strain rate D. In simple shear γ̇ is the velocity gradient.

References
----------
Carreau-Yasuda: Yasuda, Armstrong & Cohen 1981, Rheol. Acta 20, 163. Yield stresses with an exponential: Papanastasiou 1987,
J. Rheol. 31, 385. Casson's law with this exponential: Pham & Mitsoulis 1994, Can. J. Chem. Eng. 72, 1080.
"""

from abc import abstractmethod
from math import sqrt
from typing import Annotated, Any, Literal, NamedTuple

from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.elementary import expm1, power
from pellucid.materials.law import Law
from pellucid.model import Model, check, parameter
from pellucid.registry import Family, OneOf
from pellucid.tensors import Symmetric, deviator, double_dot

SMALLEST = 1e-300
"""Smallest argument, so that the laws are defined at rest."""


@generic
def shear_viscosity(rheology: Law, rate: float) -> float:
    """Return the shear viscosity μ [Pa s] at a shear rate γ̇ [1/s]. It must not increase with the shear rate: the step limit
    uses its value at rest."""


@pointwise
def shear_rate(D: Symmetric) -> float:
    """Return the shear rate γ̇ = sqrt(2 D':D') [1/s] with the deviator D' of the strain rate D [1/s]."""
    of_shape = deviator(D)
    return sqrt(2.0 * double_dot(of_shape, of_shape))


class SecondViscosity(NamedTuple):
    """Second viscosity λ = `ratio` μ + `constant` of a point with the shear viscosity μ."""

    ratio: float
    constant: float  # [Pa s]


class UniformViscosity(NamedTuple):
    """Viscosities of a Newtonian fluid."""

    mu: float  # shear viscosity μ [Pa s]
    lam: float  # second viscosity λ [Pa s]


class ShearThinning(NamedTuple):
    """Viscosities that depend on the shear rate."""

    rheology: Any  # law of the shear viscosity, whose type selects `shear_viscosity`
    second: SecondViscosity
    explicit: float  # 1, or 0 if the stress of the viscosity is solved for on the nodes and not part of the law


@generic
def viscosities(viscosity: Any, D: Symmetric) -> tuple[float, float, float]:
    """Return the viscosities μ and λ of the stress of a fluid law, and the shear viscosity of the point [Pa s], at a strain
    rate D [1/s]. viscosity: `UniformViscosity` or `ShearThinning`."""


@point_function(viscosities, UniformViscosity)
def _uniform(viscosity, D):
    return viscosity.mu, viscosity.lam, viscosity.mu


@point_function(viscosities, ShearThinning)
def _thinning(viscosity, D):
    mu, second = shear_viscosity(viscosity.rheology, shear_rate(D)), viscosity.second
    return viscosity.explicit * mu, viscosity.explicit * (second.ratio * mu + second.constant), mu


class RheologyModel(Model):
    """Base of rheologies: user's parameters and law. A new one is a subclass with its own `kind`."""

    kind: str

    @abstractmethod
    def law(self) -> Law:
        """Return the law of the shear viscosity, as a NamedTuple of its parameters for the kernels."""

    @abstractmethod
    def least_viscosity(self) -> float:
        """Return the shear viscosity in the limit of infinite shear rates [Pa s]."""


RHEOLOGIES = Family("rheology", RheologyModel)
Rheology = Annotated[RheologyModel, OneOf(RHEOLOGIES)]


class CarreauYasuda(NamedTuple):
    """Parameters of the Carreau-Yasuda law for kernels: viscosities μ0 and μ∞ [Pa s], time λ [s], exponents n and a."""

    mu_zero: float
    mu_infinite: float
    time: float
    n: float
    a: float


class CarreauYasudaCase(RheologyModel):
    """Carreau-Yasuda, μ = μ∞ + (μ0 - μ∞) (1 + (λγ̇)^a)^((n-1)/a)."""

    kind: Literal["carreau-yasuda"] = "carreau-yasuda"
    zero_viscosity: float = parameter("Pa*s", "viscosity μ0 at rest", gt=0)
    infinite_viscosity: float = parameter("Pa*s", "viscosity μ∞ in the limit of infinite shear rates", ge=0)
    time: float = parameter("s", "time λ; the viscosity decreases at shear rates above 1/λ", ge=0)
    exponent: float = parameter("", "exponent n of the power law between both limits", gt=0, le=1)
    transition: float = parameter("", "exponent a of the transition; 2: Carreau's law", 2.0, ge=0.1)

    @check
    def _viscosity_decreases(self) -> None:
        if self.infinite_viscosity > self.zero_viscosity:
            text = (
                f"infinite_viscosity = {self.infinite_viscosity:g} Pa*s exceeds zero_viscosity = {self.zero_viscosity:g} Pa*s"
            )
            raise ValueError(f"{text}, but the viscosity must decrease with the shear rate; exchange both values")

    def law(self) -> CarreauYasuda:
        return CarreauYasuda(self.zero_viscosity, self.infinite_viscosity, self.time, self.exponent, self.transition)

    def least_viscosity(self) -> float:
        return self.infinite_viscosity if self.exponent < 1.0 and self.time > 0.0 else self.zero_viscosity


@point_function(shear_viscosity, CarreauYasuda)
def _carreau_yasuda(rheology, rate):
    strain = power(max(rheology.time * rate, SMALLEST), rheology.a)
    thinned = power(1.0 + strain, (rheology.n - 1.0) / rheology.a)
    return rheology.mu_infinite + (rheology.mu_zero - rheology.mu_infinite) * thinned


class YieldStressModel(RheologyModel):
    """Base of rheologies with a yield stress, below which the fluid has the viscosity of its state at rest."""

    plastic_viscosity: float = parameter("Pa*s", "viscosity μ in the limit of infinite shear rates", gt=0)
    yield_stress: float = parameter("Pa", "yield stress τy", ge=0)
    time: float = parameter(
        "s", "time m of the regularisation: at shear rates well below 1/m the fluid has a constant, large viscosity", gt=0
    )

    def least_viscosity(self) -> float:
        return self.plastic_viscosity


@pointwise
def _regularised(x):
    """Return (1 - exp(-x))/x of a number x ≥ 0, 1 at x = 0."""
    x = max(x, SMALLEST)
    return -expm1(-x) / x


class Bingham(NamedTuple):
    """Parameters of Bingham's law for kernels: viscosity μ [Pa s], yield stress τy [Pa], time m [s]."""

    mu: float
    yield_stress: float
    time: float


class BinghamCase(YieldStressModel):
    """Bingham, regularised: μ(γ̇) = μ + τy (1 - exp(-mγ̇))/γ̇."""

    kind: Literal["bingham"] = "bingham"

    def law(self) -> Bingham:
        return Bingham(self.plastic_viscosity, self.yield_stress, self.time)


@point_function(shear_viscosity, Bingham)
def _bingham(rheology, rate):
    return rheology.mu + rheology.yield_stress * rheology.time * _regularised(rheology.time * rate)


class Casson(NamedTuple):
    """Parameters of Casson's law for kernels: viscosity μ [Pa s], yield stress τy [Pa], time m [s]."""

    mu: float
    yield_stress: float
    time: float


class CassonCase(YieldStressModel):
    """Casson, regularised: μ(γ̇) = (√μ + √(τy/γ̇) (1 - exp(-√(mγ̇))))²."""

    kind: Literal["casson"] = "casson"

    def law(self) -> Casson:
        return Casson(self.plastic_viscosity, self.yield_stress, self.time)


@point_function(shear_viscosity, Casson)
def _casson(rheology, rate):
    largest = sqrt(rheology.yield_stress * rheology.time)
    root = sqrt(rheology.mu) + largest * _regularised(sqrt(rheology.time * rate))
    return root * root


RHEOLOGIES.add(CarreauYasudaCase)
RHEOLOGIES.add(BinghamCase)
RHEOLOGIES.add(CassonCase)
