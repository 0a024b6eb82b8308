"""The interface of a material to a body of material points, whatever its law."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, Literal, Self

import numpy as np

from pellucid.materials.law import SQUEEZED, ZERO_GRADIENT, Law, diffusivity, signal_speed
from pellucid.materials.point_state import PointState
from pellucid.materials.trial import RATE_FORM, Operation, try_material
from pellucid.model import Model, check, parameter
from pellucid.registry import Family
from pellucid.state import FIELDS
from pellucid.tensors import Symmetric


class BodyMaterial(Model):
    """Base of the materials of all kinds of bodies."""

    kind: str
    density: float = parameter("kg/m^3", "initial density", gt=0)

    @abstractmethod
    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of plane pressure and shear waves at the start [m/s]."""


class PointMaterial(BodyMaterial):
    """A material of material points: the parameters that the user gives, its law, and its state at the start.

    A new material is a subclass with a `kind` of its own, such as `kind: Literal["neo-hookean"] = "neo-hookean"`.
    """

    energy_kind: ClassVar[Literal["internal", "strain"]] = "strain"
    """Which energy it stores: the internal energy, with heat, or the strain energy, which can be had back."""

    flows: ClassVar[bool] = False
    """Whether it is at rest under gravity by its pressure alone: then it has `at_rest`."""

    @property
    def keeps_heat(self) -> bool:
        """True if the `internal_energy` of points receives exactly the kinetic energy lost to internal forces and
        transfers; otherwise the law integrates its energy."""
        return False

    @abstractmethod
    def law(self) -> Law:
        """The law as kernels take it."""

    @abstractmethod
    def initial_state(self) -> PointState:
        """The state of every point at the start."""

    def implicit_viscosities(self) -> tuple[float, float] | None:
        """Shear and second viscosity, μ and λ [Pa s], of a fluid whose viscous stress is no part of its law, but solved for on
        the nodes; None of others."""
        return None

    def too_soft(self, density: float) -> str | None:
        """Report a liquid compressed beyond the limit at this mean density [kg/m³]; None otherwise."""
        return None

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        """Arrays of points of a liquid under a pressure larger by `more` [Pa]; those of other materials as they are."""
        return arrays

    def with_implicit_viscosity(self) -> Self | None:
        """The same material with implicit viscosity; None where it has none, or has it already."""
        return None

    def stressed(self, stress: Symmetric) -> tuple[float, PointState]:
        """Density [kg/m³] and state of a point under a stress [Pa]. Raises ValueError where there is no such state."""
        raise ValueError(f'a material of kind "{self.kind}" cannot have an initial stress')

    def at_rest(self, gravity: float, depth: np.ndarray) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """Densities [kg/m³], shape (n,), and arrays of the state, of a fluid at rest under gravity.

        gravity: its magnitude [m/s²]; depth: below the level of the initial state [m], shape (n,). Raises ColumnEnds where it
        has no state there.
        """
        raise NotImplementedError(f'a material of kind "{self.kind}" is not a fluid at rest under its pressure')

    def signals(self, length: float) -> tuple[float, float]:
        """Speed of signals [m/s] and kinematic viscosity [m²/s] at the start, in cells of the given length [m]."""
        law = self.law()
        return signal_speed(law, self.initial_state(), self.density, ZERO_GRADIENT, length), diffusivity(law, self.density)

    def signals_compressed(self, length: float) -> float:
        """Speed of signals [m/s] at the start where it is compressed ever so little: with the linear artificial viscosity."""
        return signal_speed(self.law(), self.initial_state(), self.density, SQUEEZED, length)

    def problems(self) -> Iterator[tuple[str, str, str]]:
        """Yield faults of the combination of keys: key, text, remedy."""
        yield from ()

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        """Return the operations to register for the law and for its component laws."""
        return {law: RATE_FORM}

    @check
    def _law_is_whole(self) -> None:
        try_material(self)

    @property
    def energy_field(self) -> str:
        """The field with its stored energy of unit mass [J/kg], part of the state of a point or worked out from it."""
        return f"{self.energy_kind}_energy"

    @property
    def state_fields(self) -> tuple[str, ...]:
        """The arrays of its points beside position, velocity, mass and volume."""
        return self.initial_state()._fields

    @property
    def probed_fields(self) -> tuple[str, ...]:
        """The fields that probes read beside those of every body: its energy, and of its state scalars, vectors and
        symmetric tensors."""
        own = (name for name in self.state_fields if name not in ("stress", self.energy_field))
        return (self.energy_field, *(name for name in own if FIELDS[name].components in (1, 3, 6)))


MATERIALS = Family("material", PointMaterial)
"""The kinds that a case can name: the list is in `pellucid.materials`."""
