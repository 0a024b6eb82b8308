"""Base classes of materials: `BodyMaterial` for all bodies, `PointMaterial` for bodies of material points."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, Literal, NamedTuple, Self

import numpy as np

from pellucid.materials.law import SQUEEZED, ZERO_GRADIENT, Law, diffusivity, signal_speed
from pellucid.materials.point_state import PointState
from pellucid.materials.rheology import SecondViscosity
from pellucid.materials.trial import RATE_FORM, Operation, try_material
from pellucid.model import Model, check, parameter
from pellucid.registry import Family
from pellucid.state import FIELDS
from pellucid.tensors import Symmetric


class BodyMaterial(Model):
    """Base of the materials of all kinds of bodies."""

    kind: str
    density: float = parameter("kg/m^3", "initial density", gt=0)

    creeps: ClassVar[bool] = False
    """True for a solid that deforms in time under constant load when at rest."""

    @abstractmethod
    def wave_speeds(self) -> tuple[float, float]:
        """Return the speeds of plane pressure and shear waves in the initial state [m/s]."""

    def moduli_at_rest(self) -> Mapping[str, float]:
        """Return the moduli at rest [Pa] that must be positive, by name; of a surface law [N/m], that must not be negative."""
        return {}


class ImplicitStress(NamedTuple):
    """Parameters of the stress σ = 2μD + (λ + KΔt) tr(D) I that a fluid adds to the stress of its law and for which the nodes
    solve in each step Δt, with the strain rate D at the end of the step: viscosities and the stiffness of the pressure. With
    `second`, each point has its own viscosities: μ is the `viscosity` of its state, from the step before."""

    mu: float  # shear viscosity μ, at rest [Pa s]
    lam: float  # second viscosity λ, at rest [Pa s]
    stiffness: float  # K = ρc² if the change of the pressure in the step is implicit, else 0 [Pa]
    least: float = 0.0  # smallest shear viscosity at any shear rate [Pa s]
    second: SecondViscosity | None = None  # λ as a function of the viscosity μ of the point; None: uniform viscosities

    @property
    def resists_volume(self) -> bool:
        """True if the viscosities resist changes of the volume, i.e. λ is above Stokes' value -2μ/3."""
        return 3.0 * self.lam + 2.0 * self.mu > 1e-12 * self.mu


class PointMaterial(BodyMaterial):
    """Base of materials of material points: user's parameters, law, and initial state.

    A new material is a subclass with its own `kind`, such as `kind: Literal["neo-hookean"] = "neo-hookean"`.
    """

    energy_kind: ClassVar[Literal["internal", "strain"]] = "strain"
    """Kind of the stored energy: "internal" for internal energy including heat, "strain" for recoverable strain energy."""

    flows: ClassVar[bool] = False
    """True for a fluid: its pressure alone can hold it in hydrostatic equilibrium, which `at_rest` computes."""

    @property
    def keeps_points_even(self) -> bool:
        """True if density and spacing of the points of a liquid are corrected, see `pellucid.grid.even_points`."""
        return False

    @property
    def is_liquid(self) -> bool:
        """True for a fluid whose pressure depends on the density only."""
        return False

    @property
    def keeps_heat(self) -> bool:
        """True if the `internal_energy` of points receives exactly the kinetic energy lost to internal forces and transfers;
        if False, the law computes the energy from its own stress."""
        return False

    @abstractmethod
    def law(self) -> Law:
        """Return the material law in the form for kernels (a NamedTuple of its parameters, see `pellucid.materials.law`)."""

    @abstractmethod
    def initial_state(self) -> PointState:
        """Return the initial state (stress, energy, ...) that every point has at the start."""

    def shear_viscosity(self) -> float:
        """Return the shear viscosity of a fluid at rest [Pa s]; 0 for other materials."""
        return 0.0

    def implicit_stress(self) -> ImplicitStress | None:
        """Return the parameters of the stress of a fluid that is solved for on the nodes instead of computed by its law; None
        for other materials."""
        return None

    def too_soft(self, density: float) -> str | None:
        """Return a description of the problem if a liquid is compressed too much, i.e. if its mean density [kg/m³] exceeds
        the limit for which its law is meant because its sound speed is too small for the loads; None otherwise."""
        return None

    def uneven(self, densities: np.ndarray) -> str | None:
        """Return a description of the problem, without a remedy, if the densities of single points of a liquid [kg/m³], shape
        (n,), differ so much from their mean that pressures of points are wrong; None otherwise."""
        return None

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        """Return the state arrays of points of a liquid, by name, after its pressure is increased by `more` [Pa] at
        constant volume, so that the masses increase; for other materials, the arrays unchanged."""
        return arrays

    def with_implicit_pressure(self) -> Self | None:
        """Return a copy of the material whose pressure is solved for implicitly; None if this is not possible or already
        set."""
        return None

    def with_implicit_viscosity(self) -> Self | None:
        """Return a copy of the material whose viscous stress is solved for implicitly; None if this is not possible or
        already set."""
        return None

    def stressed(self, stress: Symmetric) -> tuple[float, PointState]:
        """Return the density [kg/m³] and the state of a point with an initial Cauchy stress [Pa], as a 6-tuple. Raises
        ValueError if there is no such state."""
        raise ValueError(f'a material of kind "{self.kind}" cannot have an initial stress')

    def at_rest(self, gravity: float, depth: np.ndarray) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """Return the densities [kg/m³], shape (n,), and the state arrays, by name, of a fluid at rest under gravity.

        gravity: magnitude [m/s²]; depth: depth below the level of the initial state [m], shape (n,). Raises ColumnEnds if
        the fluid has no state at a depth.
        """
        raise NotImplementedError(f'a material of kind "{self.kind}" is not a fluid at rest under its pressure')

    def signals(self, length: float) -> tuple[float, float]:
        """Return the signal speed (sound speed with artificial viscosity) [m/s] and the kinematic viscosity [m²/s] in the
        initial state; length: cell size [m]."""
        law = self.law()
        return signal_speed(law, self.initial_state(), self.density, ZERO_GRADIENT, length), diffusivity(law, self.density)

    def signals_compressed(self, length: float) -> float:
        """Return the signal speed [m/s] in the initial state, with the linear artificial viscosity that acts in
        compression, for infinitesimally slow compression; length: cell size [m]."""
        return signal_speed(self.law(), self.initial_state(), self.density, SQUEEZED, length)

    def problems(self) -> Iterator[tuple[str, str, str]]:
        """Yield key, text and remedy for each problem of the keys, e.g. keys whose values contradict each other."""
        yield from ()

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        """Return the functions of `pellucid.materials.law` that must be registered for the law and for each of its component
        laws."""
        return {law: RATE_FORM}

    @check
    def _law_is_whole(self) -> None:
        try_material(self)

    @property
    def energy_field(self) -> str:
        """Name of the field with the stored energy per unit mass [J/kg]; it is part of the state of a point or computed
        from it."""
        return f"{self.energy_kind}_energy"

    @property
    def state_fields(self) -> tuple[str, ...]:
        """Names of the state arrays of the points, in addition to position, velocity, mass and volume."""
        return self.initial_state()._fields

    @property
    def probed_fields(self) -> tuple[str, ...]:
        """Names of the fields that probes (requested histories of a quantity) can read in addition to the fields of every
        body: the stored energy, and scalars, vectors and symmetric tensors of the state."""
        own = (name for name in self.state_fields if name not in ("stress", self.energy_field))
        return (self.energy_field, *(name for name in own if FIELDS[name].components in (1, 3, 6)))


MATERIALS = Family("material", PointMaterial)
"""Kinds that a case can name, registered in `pellucid.materials`."""
