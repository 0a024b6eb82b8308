"""Gas or liquid that fills a volume, given by mass, with its energy.

In a step, first the volume changes, then mass flows in and out at the new volume. Each change is recorded by its effect on
the energy, so that the energy balances to rounding.
"""

from abc import ABC, abstractmethod
from math import inf, log, sqrt


class Contents(ABC):
    """Gas or liquid in a volume. Its state is its mass [kg] and its energy [J]."""

    mass: float
    energy: float

    @abstractmethod
    def pressure(self, volume: float) -> float:
        """Return the pressure [Pa] for a volume [m³]."""

    @abstractmethod
    def stiffness(self, volume: float) -> float:
        """Return the stiffness -dp/dV [Pa/m³]."""

    @property
    def temperature(self) -> float | None:
        """Return the temperature of a gas [K]; None for a liquid."""
        return None

    @abstractmethod
    def expand(self, old: float, new: float) -> float:
        """Change the volume from `old` to `new` [m³]. Returns the heat absorbed [J]."""

    @abstractmethod
    def take_in(self, mass: float, warmth: float, volume: float) -> tuple[float, float]:
        """Add an inflow with its mass [kg] and `warmth`, the integral ∫T dm of its temperature T over its mass m [K kg].
        Returns the energy added and the heat absorbed [J]."""

    @abstractmethod
    def let_out(self, mass: float, volume: float) -> tuple[float, float]:
        """Remove an outflow with its mass [kg]. Returns the energy removed and the heat absorbed [J]."""

    @abstractmethod
    def excess(self, volume: float, outside: float) -> float:
        """Return the mass whose outflow reduces the pressure to the outside pressure [kg]."""

    @abstractmethod
    def efflux(self, volume: float, outside: float) -> float:
        """Return the mass flux through a vent to a lower outside pressure [Pa], in kg/(s m²)."""

    @abstractmethod
    def lack(self, volume: float, outside: float) -> float:
        """Return the mass whose inflow increases the pressure to the outside pressure [kg]."""

    @abstractmethod
    def influx(self, volume: float, outside: float) -> float:
        """Return the mass flux through a hole from a higher outside pressure [Pa], in kg/(s m²).

        The outside fluid is the same gas, at its initial temperature, or the same liquid.
        """

    @abstractmethod
    def draw_in(self, mass: float, volume: float) -> tuple[float, float]:
        """Add mass from outside [kg]. Returns the energy added and the heat absorbed [J]."""


class Gas(Contents):
    """An ideal gas with constant heat capacities, p V = (γ-1) E. An isothermal gas absorbs heat to keep its temperature."""

    def __init__(self, mass: float, temperature: float, gamma: float, constant: float, isothermal: bool) -> None:
        """constant: specific gas constant R [J/(kg K)]."""
        self.gamma, self.constant, self.isothermal, self._start = gamma, constant, isothermal, temperature
        self._heat_capacity = constant / (gamma - 1.0)  # at constant volume
        self.mass, self.energy = mass, mass * self._heat_capacity * temperature

    def pressure(self, volume: float) -> float:
        """Return the pressure p = (γ-1) E/V [Pa], from the energy E and the volume V."""
        return (self.gamma - 1.0) * self.energy / volume

    @property
    def temperature(self) -> float:
        """Return the temperature [K]; the initial temperature if no gas is left."""
        return self.energy / (self.mass * self._heat_capacity) if self.mass > 0.0 else self._start

    def stiffness(self, volume: float) -> float:
        """Return the stiffness -dp/dV [Pa/m³]: γp/V for an adiabatic gas, p/V for an isothermal gas."""
        return (1.0 if self.isothermal else self.gamma) * self.pressure(volume) / volume

    def expand(self, old: float, new: float) -> float:
        """Change the volume along an adiabat, or along an isotherm if the gas is isothermal (both are integrated exactly)."""
        if self.isothermal:
            return (self.gamma - 1.0) * self.energy * log(new / old)
        self.energy *= (old / new) ** (self.gamma - 1.0)
        return 0.0

    def take_in(self, mass: float, warmth: float, volume: float) -> tuple[float, float]:
        """Add gas with its enthalpy."""
        brought = self.gamma * self._heat_capacity * warmth
        self.mass += mass
        return brought, self._renew(brought)

    def let_out(self, mass: float, volume: float) -> tuple[float, float]:
        """Remove gas with its enthalpy; the rest expands along an adiabat, E ~ m^γ."""
        left = 1.0 - mass / self.mass
        taken = mass * self.gamma * self._heat_capacity * self.temperature if self.isothermal else self._lost(left)
        self.mass *= left
        return taken, self._renew(-taken)

    def _lost(self, left: float) -> float:
        return self.energy * (1.0 - left**self.gamma)

    def _renew(self, gained: float) -> float:
        """Add the energy gained with a change of mass [J]; return the heat that the gas absorbs if it is isothermal [J],
        else 0."""
        new = self.energy + gained
        if self.isothermal:
            new = self.mass * self._heat_capacity * self._start
        heat = new - self.energy - gained if self.isothermal else 0.0
        self.energy = new
        return heat

    def excess(self, volume: float, outside: float) -> float:
        ratio = outside / self.pressure(volume)
        return self.mass * (1.0 - (ratio if self.isothermal else ratio ** (1.0 / self.gamma)))

    def efflux(self, volume: float, outside: float) -> float:
        """Return the mass flux ψ p/√(R T) through a nozzle [kg/(s m²)], with the flow function ψ; choked below the
        critical pressure ratio."""
        pressure = self.pressure(volume)
        return flow_function(outside / pressure, self.gamma) * pressure / sqrt(self.constant * self.temperature)

    def lack(self, volume: float, outside: float) -> float:
        rise = (outside - self.pressure(volume)) * volume / (self.constant * self._start)
        return rise if self.isothermal else rise / self.gamma

    def influx(self, volume: float, outside: float) -> float:
        return flow_function(self.pressure(volume) / outside, self.gamma) * outside / sqrt(self.constant * self._start)

    def draw_in(self, mass: float, volume: float) -> tuple[float, float]:
        """Add gas at the initial temperature."""
        return self.take_in(mass, mass * self._start, volume)


def flow_function(ratio: float, gamma: float) -> float:
    """Return the flow function ψ of a nozzle; ratio: downstream over upstream pressure. Source: Saint-Venant & Wantzel
    1839."""
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    r = max(ratio, critical)
    return sqrt(2.0 * gamma / (gamma - 1.0) * max(r ** (2.0 / gamma) - r ** ((gamma + 1.0) / gamma), 0.0))


class Liquid(Contents):
    """A liquid with constant bulk modulus K, p = K (m/(ρ₀V) - 1); its energy is the compression energy."""

    def __init__(self, mass: float, bulk_modulus: float, density: float, volume: float) -> None:
        """density: density ρ₀ at zero pressure [kg/m³]."""
        self.bulk_modulus, self.density, self.mass = bulk_modulus, density, mass
        self.energy = self._energy(volume)

    def _energy(self, volume: float) -> float:
        rest = self.mass / self.density
        return self.bulk_modulus * (volume - rest - rest * log(volume / rest)) if rest > 0.0 else inf

    def pressure(self, volume: float) -> float:
        """Return the pressure [Pa], negative if the liquid is stretched."""
        return self.bulk_modulus * (self.mass / (self.density * volume) - 1.0)

    def stiffness(self, volume: float) -> float:
        """Return the stiffness -dp/dV = K m/(ρ₀V²) [Pa/m³]."""
        return self.bulk_modulus * self.mass / (self.density * volume * volume)

    def _renew(self, volume: float) -> float:
        before, self.energy = self.energy, self._energy(volume)
        return self.energy - before

    def expand(self, old: float, new: float) -> float:
        """Update the compression energy for the new volume; a liquid absorbs no heat."""
        self._renew(new)
        return 0.0

    def take_in(self, mass: float, warmth: float, volume: float) -> tuple[float, float]:
        """Add liquid with its compression energy."""
        self.mass += mass
        return self._renew(volume), 0.0

    def let_out(self, mass: float, volume: float) -> tuple[float, float]:
        """Remove liquid; the energy removed is the decrease of the compression energy."""
        self.mass -= mass
        return -self._renew(volume), 0.0

    def excess(self, volume: float, outside: float) -> float:
        return self.density * volume * (self.pressure(volume) - outside) / self.bulk_modulus

    def efflux(self, volume: float, outside: float) -> float:
        """Return the mass flux √(2ρ Δp) [kg/(s m²)], with the density ρ and the pressure difference Δp to the outside."""
        return sqrt(2.0 * self.mass / volume * (self.pressure(volume) - outside))

    def lack(self, volume: float, outside: float) -> float:
        return -self.excess(volume, outside)

    def influx(self, volume: float, outside: float) -> float:
        """Return the mass flux √(2ρ₀ Δp) [kg/(s m²)], with the density ρ₀ at zero pressure and the pressure difference
        Δp to the outside."""
        return sqrt(2.0 * self.density * (outside - self.pressure(volume)))

    def draw_in(self, mass: float, volume: float) -> tuple[float, float]:
        return self.take_in(mass, 0.0, volume)
