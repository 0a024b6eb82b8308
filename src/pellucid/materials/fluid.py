"""Compressible viscous fluid, σ = 2μD + λ tr(D) I - (P+q) I, with the pressure P and the artificial viscous pressure q.
Source: Gan et al. 2011, eqs. 23–33. The shear viscosity μ is a constant, or a function of the shear rate by a law of
`pellucid.materials.rheology`."""

from collections.abc import Iterator, Mapping, Sequence
from math import inf, sqrt
from typing import Any, ClassVar, Literal, NamedTuple, Self

import numpy as np

from pellucid.jit import generic, point_function, pointwise
from pellucid.materials.contract import ImplicitStress, PointMaterial
from pellucid.materials.energy_update import ENERGY_UPDATES, energy_of_pressure, new_energy, pressure
from pellucid.materials.eos import EquationOfState
from pellucid.materials.eos.equation import lowest_pressure, pressure_line, sound_speed, states_at_rest
from pellucid.materials.law import (
    Law,
    artificial_heating,
    diffusivity,
    point_pressure,
    rate_type,
    signal_speed,
    stored_energy,
    update,
)
from pellucid.materials.point_state import PointState, point_state
from pellucid.materials.rheology import (
    Rheology,
    SecondViscosity,
    ShearThinning,
    UniformViscosity,
    shear_viscosity,
    viscosities,
)
from pellucid.materials.trial import Operation
from pellucid.model import Model, check, parameter
from pellucid.tensors import NO_STRESS, Symmetric, double_dot, symmetric_part


class ArtificialViscosity(NamedTuple):
    """Parameters of the artificial pressure q = ρ l (c₀ l (tr D)² - c₁ a tr D) in compression, 0 in expansion, with the
    density ρ, the cell size l, the sound speed a and the rate of deformation D. Fields: c₀ (`quadratic`), c₁ (`linear`),
    and `work`, which is 1 if q heats the fluid, else 0."""

    quadratic: float
    linear: float
    work: float


class ArtificialViscosityCase(Model):
    """Artificial viscosity in a case file."""

    quadratic: float = parameter("", "coefficient c₀ of the quadratic term of the artificial viscous pressure q", 0.0, ge=0)
    linear: float = parameter("", "coefficient c₁ of the linear term of the artificial viscous pressure q", 0.0, ge=0)
    work: bool = parameter("", "true: q does work in the energy equation; false: this energy is lost in shocks", True)

    def law(self) -> ArtificialViscosity:
        return ArtificialViscosity(self.quadratic, self.linear, 1.0 if self.work else 0.0)


@pointwise
def artificial_pressure(av: ArtificialViscosity, density: float, a: float, trD: float, length: float) -> float:
    """Return the artificial pressure q [Pa] in compression, 0 in expansion (see `ArtificialViscosity`). density [kg/m³]; a:
    sound speed [m/s]; trD: volume rate tr D [1/s]; av: coefficients of the artificial viscosity; length: cell size [m]."""
    if trD >= 0.0:
        return 0.0
    return density * length * (av.quadratic * length * trD * trD - av.linear * a * trD)


@pointwise
def artificial_speed(av: ArtificialViscosity, a: float, trD: float, length: float) -> float:
    """Return the contribution Q = c₁ a + c₀ l |tr D| of artificial viscosity to the signal speed [m/s]; the signal speed
    becomes Q + sqrt(Q² + a²) (Hallquist, LS-DYNA theory manual). av: coefficients c₀ and c₁; a: sound speed [m/s]; trD:
    volume rate tr D [1/s]; length: cell size l [m]."""
    if trD >= 0.0:
        return 0.0
    return av.linear * a - av.quadratic * length * trD


SOFT = 0.03  # of its volume that a liquid may lose on the mean before a run warns
UNEVEN, SEVERAL = 0.1, 0.01  # deviation of a density from the mean, and the share of points beyond it, for a warning
LEAST, MOST = 0.5, 1e2  # densities of a liquid under pressures that it may come to, in those at the start


@rate_type
class ViscousFluid(NamedTuple):
    """Parameters of the compressible viscous fluid: equation of state, energy update, artificial viscosity and viscosity.

    The types of `eos`, `energy_update` and `viscosity`, all NamedTuples, select the functions that compute pressure, energy and
    viscosities.
    """

    eos: Any
    energy_update: Any
    artificial_viscosity: ArtificialViscosity
    viscosity: Any  # `UniformViscosity` or `ShearThinning`
    waves: float  # 1, or 0 if the pressure is implicit, so that pressure waves do not limit the step


@point_state()
class FluidState(NamedTuple):
    """State of a fluid point: Cauchy stress [Pa] and specific internal energy [J/kg]."""

    stress: Symmetric
    internal_energy: float


@point_state(viscosity=("Pa*s", "shear viscosity at the shear rate of the last step"))
class ShearThinningState(NamedTuple):
    """State of a fluid point with a rheology: Cauchy stress [Pa], specific internal energy [J/kg], shear viscosity [Pa s]."""

    stress: Symmetric
    internal_energy: float
    viscosity: float


@generic
def fluid_state(viscosity: Any, stress: Symmetric, energy: float, mu: float) -> PointState:
    """Return the state of a fluid point. viscosity: `UniformViscosity` or `ShearThinning`; stress [Pa]; energy: specific
    internal energy [J/kg]; mu: shear viscosity of the point [Pa s]."""


@point_function(fluid_state, UniformViscosity)
def _uniform_state(viscosity, stress, energy, mu):
    return FluidState(stress, energy)


@point_function(fluid_state, ShearThinning)
def _thinning_state(viscosity, stress, energy, mu):
    return ShearThinningState(stress, energy, mu)


class FluidMaterial(PointMaterial):
    """Compressible viscous fluid with an equation of state."""

    energy_kind: ClassVar[Literal["internal", "strain"]] = "internal"
    flows: ClassVar[bool] = True

    kind: Literal["fluid"] = "fluid"
    pressure: float = parameter("Pa", "initial pressure", 0.0)
    eos: EquationOfState = parameter("", "equation of state")
    viscosity: float = parameter("Pa*s", "shear viscosity μ", 0.0, ge=0)
    rheology: Rheology | None = parameter(
        "", "alternative to `viscosity`: shear viscosity as a function of the shear rate", None
    )
    second_viscosity: float | None = parameter("Pa*s", "second viscosity λ; default: Stokes' value -2μ/3", None)
    implicit_viscosity: bool = parameter(
        "", "true: solve for the viscous stress implicitly on the nodes; viscosity then does not limit the time step", False
    )
    implicit_pressure: bool = parameter(
        "",
        "true: solve for pressure and viscosity of a liquid implicitly on the nodes; sound then does not limit the time step",
        False,
    )
    even_points: bool = parameter(
        "",
        "true: correct densities and positions of the points of a liquid in confined flow, so that both stay even",
        False,
    )
    artificial_viscosity: ArtificialViscosityCase = parameter("", "artificial viscosity", ArtificialViscosityCase())
    energy_update: Literal["conservative", "closed", "iterated", "explicit", "midpoint"] = parameter(
        "", "method of integrating the energy equation of the points in time", "conservative"
    )

    @check
    def _pressure_is_possible(self) -> None:
        eos, energy = self.law().eos, self.initial_state().internal_energy
        found = pressure(eos, self.density, energy)
        # rounding of the terms that cancel in a stiff liquid
        if abs(found - self.pressure) > 1e-9 * (abs(self.pressure) + abs(pressure_line(eos, self.density)[0])):
            text = f"the pressure is {self.pressure:g} Pa, but this equation of state gives {found:g} Pa at the initial density"
            raise ValueError(f"{text} and its pressure does not depend on the energy; use pressure = {found:g}")

    @check
    def _artificial_work_is_kept(self) -> None:
        if self.keeps_heat and not self.artificial_viscosity.work:
            text = "artificial_viscosity.work = false omits work that the conservative energy update includes"
            raise ValueError(f'{text}; add energy_update = "closed"')

    @check
    def _viscosity_is_given_once(self) -> None:
        if self.rheology is not None and self.viscosity > 0.0:
            text = f"viscosity = {self.viscosity:g} Pa*s and rheology both define the shear viscosity"
            raise ValueError(f"{text}; remove one of the two")

    @check
    def _viscosity_takes_energy(self) -> None:
        name = "viscosity" if self.rheology is None else "of the viscosity in the limit of infinite shear rates"
        least = -2.0 / 3.0 * self._least_viscosity()
        if self.second_viscosity is not None and self.second_viscosity < least * (1.0 + 1e-12):
            text = f"second_viscosity = {self.second_viscosity:g} Pa*s is below -2/3 {name} = {least:g} Pa*s"
            raise ValueError(f"{text}: expansion would gain energy; remove `second_viscosity` to use Stokes' value")

    @check
    def _implicit_viscosity_is_heat(self) -> None:
        if self.implicit_viscosity and not self.implicit_pressure and not any(self.viscosities()):
            raise ValueError(
                "implicit_viscosity = true, but the fluid has no viscosity; set `viscosity`, or remove `implicit_viscosity`"
            )
        if (key := self._implicit_key) is not None and not self.keeps_heat:
            text = (
                f'energy_update = "{self.energy_update}" integrates the work of the viscous stress, which is known '
                f"only on the nodes with {key}"
            )
            raise ValueError(f'{text}; use "conservative" with {key}, or remove {key}')

    @check
    def _implicit_pressure_is_of_a_liquid(self) -> None:
        if not self.implicit_pressure:
            return
        if not self.is_liquid:
            text = (
                f"implicit_pressure = true, but the pressure of the equation of state {self.eos.kind!r} depends on the energy"
            )
            raise ValueError(f"{text}; use an equation of state of a liquid, such as tait, or remove implicit_pressure")
        if self._smooths_shocks:
            text = "artificial_viscosity smooths shocks, which steps beyond the sound limit of implicit_pressure do not resolve"
            raise ValueError(f"{text}; remove artificial_viscosity or implicit_pressure")

    @check
    def _even_points_are_of_a_liquid(self) -> None:
        if self.even_points and not (self.is_liquid and self.keeps_heat):
            reason = (
                f"energy_update = {self.energy_update!r}"
                if self.is_liquid
                else f"the pressure of the equation of state {self.eos.kind!r} depends on the energy"
            )
            raise ValueError(
                f'even_points = true, but {reason}; use a liquid, such as tait, with energy_update = "conservative", '
                "or remove even_points"
            )

    @property
    def keeps_points_even(self) -> bool:
        return self.even_points

    @property
    def _implicit_key(self) -> str | None:
        names = (name for name in ("implicit_pressure", "implicit_viscosity") if getattr(self, name))
        return next(names, None)

    @property
    def _smooths_shocks(self) -> bool:
        return self.artificial_viscosity.quadratic > 0.0 or self.artificial_viscosity.linear > 0.0

    @property
    def keeps_heat(self) -> bool:
        return self.energy_update == "conservative"

    @property
    def is_liquid(self) -> bool:
        """True if the pressure depends on the density only."""
        return pressure_line(self.law().eos, self.density)[1] == 0.0

    def too_soft(self, density: float) -> str | None:
        """Return a description of the problem if a liquid (a fluid whose pressure depends only on the density) is
        compressed too much at its mean density [kg/m³], with the sound speed that it needs; None otherwise."""
        squeezed = 1.0 - self.density / density
        if squeezed <= SOFT or not self.is_liquid:
            return None
        speed = sound_speed(self.law().eos, self.density, 0.0) * sqrt(squeezed / (0.2 * SOFT))
        return (
            f"it is compressed by {100 * squeezed:.2g} % of its volume; if this is not intended, increase eos.sound_speed: "
            f"with {speed:.2g} m/s it is {20 * SOFT:.2g} %"
        )

    def uneven(self, densities: np.ndarray) -> str | None:
        if not self.is_liquid or not len(densities):
            return None
        if lowest_pressure(self.law().eos) > -inf:  # what tears expands, which also changes the mean
            off = np.maximum(densities / self.density - 1.0, 0.0)
        else:
            off = np.abs(densities / float(np.mean(densities)) - 1.0)
        share = float(np.mean(off > UNEVEN))
        if share <= SEVERAL:
            return None
        return (
            f"the densities of {100 * share:.2g} % of its points differ by more than {100 * UNEVEN:g} % from the mean, so the "
            "pressures of single points are wrong"
        )

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        """Return the state arrays, by name, of points of a liquid (its pressure depends only on the density) after
        isentropic compression that raises the pressure by `more` [Pa]; the points keep their volumes, and their masses
        increase. For other fluids, the arrays unchanged."""
        from scipy.optimize import brentq  # models of cases stay light without it

        if not self.is_liquid:
            return arrays
        eos, before = self.law().eos, arrays["mass"] / arrays["volume"]
        of_each, number = np.unique(before, return_inverse=True)
        old = np.array([pressure(eos, density, 0.0) for density in of_each.tolist()])
        new = np.maximum(old + more, max(lowest_pressure(eos), pressure_line(eos, LEAST * self.density)[0]))
        after = [
            brentq(lambda x, p: pressure_line(eos, x)[0] - p, LEAST * self.density, MOST * self.density, (p,)) for p in new
        ]
        ratio, stress = (np.array(after) / of_each)[number], arrays["stress"].copy()
        stress[:, :3] -= (new - old)[number, None]
        gained = 0.5 * (old + new)[number] * (1.0 - 1.0 / ratio) / before
        return {
            **arrays,
            "mass": arrays["mass"] * ratio,
            "stress": stress,
            "internal_energy": arrays["internal_energy"] + gained,
        }

    def law(self) -> ViscousFluid:
        """Return the law, as a NamedTuple of its parameters for the kernels. It does not contain a viscosity that is solved
        for implicitly on the nodes."""
        viscosity: Any = UniformViscosity(*((0.0, 0.0) if self._implicit_key else self.viscosities()))
        if self.rheology is not None:
            viscosity = ShearThinning(self.rheology.law(), self._second_viscosity(), 0.0 if self._implicit_key else 1.0)
        return ViscousFluid(
            self.eos.law(self.density, self.pressure),
            ENERGY_UPDATES[self.energy_update],
            self.artificial_viscosity.law(),
            viscosity,
            0.0 if self.implicit_pressure else 1.0,
        )

    def implicit_stress(self) -> ImplicitStress | None:
        """Return the parameters of the stress that is solved for if `implicit_viscosity` or `implicit_pressure` is set, else
        None. The stiffness of the pressure is that of the initial state."""
        if self._implicit_key is None:
            return None
        stiffness = self.density * self.wave_speeds()[0] ** 2 if self.implicit_pressure else 0.0
        second = None if self.rheology is None else self._second_viscosity()
        return ImplicitStress(*self.viscosities(), stiffness, self._least_viscosity(), second)

    def with_implicit_pressure(self) -> Self | None:
        possible = self.keeps_heat and self.is_liquid and not (self._smooths_shocks or self.implicit_pressure)
        return self.model_copy(update={"implicit_pressure": True}) if possible else None

    def with_implicit_viscosity(self) -> Self | None:
        possible = self.keeps_heat and self._implicit_key is None and max(self.viscosities()) > 0.0
        return self.model_copy(update={"implicit_viscosity": True}) if possible else None

    def shear_viscosity(self) -> float:
        return self.viscosities()[0]

    def viscosities(self) -> tuple[float, float]:
        """Return the shear and second viscosities μ and λ [Pa s] at rest, where a rheology has its largest viscosity."""
        mu = self.viscosity if self.rheology is None else float(shear_viscosity(self.rheology.law(), 0.0))
        return mu, -2.0 / 3.0 * mu if self.second_viscosity is None else self.second_viscosity

    def _least_viscosity(self) -> float:
        return self.viscosity if self.rheology is None else self.rheology.least_viscosity()

    def _second_viscosity(self) -> SecondViscosity:
        given = self.second_viscosity
        return SecondViscosity(-2.0 / 3.0, 0.0) if given is None else SecondViscosity(0.0, given)

    def initial_state(self) -> FluidState | ShearThinningState:
        law, P = self.law(), self.pressure
        A, B = pressure_line(law.eos, self.density)
        stress, energy = (-P, -P, -P, 0.0, 0.0, 0.0), (P - A) / B if B > 0.0 else 0.0
        return fluid_state(law.viscosity, stress, energy, self.viscosities()[0])  # type: ignore[return-value]

    def at_rest(self, gravity: float, depth: np.ndarray) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """Return densities and states of an isentropic column in hydrostatic equilibrium; arguments and result as in
        `PointMaterial.at_rest`."""
        eos = self.law().eos
        density, energy = states_at_rest(eos, self.density, self.initial_state().internal_energy, gravity, depth)
        stress = np.zeros((len(depth), 6))
        stress[:, :3] = -np.array([pressure(eos, *state) for state in zip(density, energy, strict=True)])[:, None]
        at_rest = np.full(len(depth), self.viscosities()[0])
        state: Any = fluid_state(self.law().viscosity, stress, energy, at_rest)  # type: ignore[arg-type]
        return density, state._asdict()

    def operations(self, law: Any) -> Mapping[Law, Sequence[Operation]]:
        rheology = {} if self.rheology is None else {law.viscosity.rheology: (shear_viscosity,)}
        return {**super().operations(law), law.eos: (pressure_line, lowest_pressure, sound_speed), **rheology}

    def wave_speeds(self) -> tuple[float, float]:
        return sound_speed(self.law().eos, self.density, self.initial_state().internal_energy), 0.0

    def problems(self) -> Iterator[tuple[str, str, str]]:
        """Yield key, text and remedy if the equation of state has no real sound speed under the tension that it allows."""
        if self.pressure < 0.0 and not self.wave_speeds()[0]:
            text = f"the fluid has no real sound speed at density {self.density:g} kg/m^3"
            yield "pressure", text, "increase the pressure, or p_infinity if the equation has one"


@point_function(update, ViscousFluid)
def _update(law, state, density, L, dt, length):
    D = symmetric_part(L)
    trD = D[0] + D[1] + D[2]
    a = sound_speed(law.eos, density, state.internal_energy)
    q = artificial_pressure(law.artificial_viscosity, density, a, trD, length)
    mu, lam, point_viscosity = viscosities(law.viscosity, D)
    bulk = lam * trD
    viscous_power = 2.0 * mu * double_dot(D, D) + bulk * trD
    heating_q = law.artificial_viscosity.work * q
    by_density = 1.0 / density
    other_work = dt * by_density * (viscous_power - heating_q * trD)
    if law.artificial_viscosity.work > 0.0:
        old_work = dt * by_density * double_dot(state.stress, D)
    else:  # the old stress has the old q in it: compute its pressure again
        P = pressure(law.eos, density * (1.0 + dt * trD), state.internal_energy)
        old_work = dt * by_density * (viscous_power - P * trD)
    energy = new_energy(law.energy_update, law.eos, state.internal_energy, density, trD, old_work, other_work, dt)
    ahead = energy_of_pressure(law.energy_update, law.eos, energy, density, trD, old_work, other_work, dt)
    normal = bulk - pressure(law.eos, density, ahead) - q
    two_mu = 2.0 * mu
    stress = (
        two_mu * D[0] + normal,
        two_mu * D[1] + normal,
        two_mu * D[2] + normal,
        two_mu * D[3],
        two_mu * D[4],
        two_mu * D[5],
    )
    return fluid_state(law.viscosity, stress, energy, point_viscosity)


@point_function(signal_speed, ViscousFluid)
def _signal_speed(law, state, density, L, length):
    a = sound_speed(law.eos, density, state.internal_energy)
    Q = artificial_speed(law.artificial_viscosity, a, L[0] + L[4] + L[8], length)
    return law.waves * (Q + sqrt(Q * Q + a * a))


@point_function(diffusivity, ViscousFluid)
def _diffusivity(law, density):
    mu, lam, _ = viscosities(law.viscosity, NO_STRESS)  # at rest, where viscosities are largest
    return (2.0 * mu + lam) * (1.0 / density)


@point_function(stored_energy, ViscousFluid)
def _stored_energy(law, state, density):
    return state.internal_energy


@point_function(artificial_heating, ViscousFluid)
def _artificial_heating(law, state, density, L, length):
    av = law.artificial_viscosity
    trD = L[0] + L[4] + L[8]
    a = sound_speed(law.eos, density, state.internal_energy)
    return -av.work * artificial_pressure(av, density, a, trD, length) * trD * (1.0 / density)


@point_function(point_pressure, ViscousFluid)
def _point_pressure(law, state, density):
    return pressure(law.eos, density, state.internal_energy)
