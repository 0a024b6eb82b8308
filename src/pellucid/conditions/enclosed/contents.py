"""Gas or liquid that fills a volume, given by mass, with its energy.

In a step, half of the mass flows in and out, then the volume changes, then the other half flows at the new volume. Each
change is recorded by its effect on the energy, so that the energy balances to rounding.
"""

from abc import ABC, abstractmethod
from copy import copy
from math import inf, log, log1p, sqrt

NEWTON, CONVERGED = 50, 1e-15  # most iterations for a volume, and their last relative change


class Contents(ABC):
    """Base of the gas and the liquid that a membrane encloses. The state consists of the mass [kg] and the energy [J]; the
    volume is an argument of the methods."""

    mass: float  # mass [kg]
    energy: float  # internal energy of a gas, compression energy of a liquid [J]

    @abstractmethod
    def pressure(self, volume: float) -> float:
        """Return the pressure [Pa] for a volume [m³]."""

    @abstractmethod
    def stiffness(self, volume: float) -> float:
        """Return the pressure decrease per volume increase, -dp/dV [Pa/m³], for a volume [m³]."""

    def volume_on_spring(self, spring: float, volume: float, pressure: float) -> float:
        """Return the volume W [m³] in which the contents, now in the volume V, have the pressure p_h + κ (W - V).

        spring: κ [Pa/m³]; volume: V [m³]; pressure: p_h [Pa].
        """
        found, contents = volume, copy(self)
        for _ in range(NEWTON):
            beyond = contents.pressure(found) - pressure - spring * (found - volume)
            step = beyond / (contents.stiffness(found) + spring)
            now, found = found, max(found + step, 0.5 * found)
            contents.expand(now, found)
            if abs(found - now) <= CONVERGED * found:
                break
        return found

    @property
    def temperature(self) -> float | None:
        """Return the temperature of a gas [K]; None for a liquid."""
        return None

    @abstractmethod
    def expand(self, old: float, new: float) -> float:
        """Change the volume from `old` to `new` [m³]; update the energy. Returns the heat absorbed from outside [J]."""

    @abstractmethod
    def take_in(self, mass: float, warmth: float, volume: float) -> tuple[float, float]:
        """Add an inflow with its mass [kg] and `warmth`, the integral ∫T dm of its temperature T over its mass m [K kg];
        volume: present volume [m³]. Returns the energy added and the heat absorbed from outside [J]."""

    @abstractmethod
    def let_out(self, mass: float, volume: float) -> tuple[float, float]:
        """Remove an outflow with its mass [kg] from the contents of a volume [m³]. Returns the energy removed and the heat
        absorbed from outside [J]."""

    @abstractmethod
    def excess(self, volume: float, outside: float) -> float:
        """Return the mass whose outflow from a volume [m³] reduces the pressure to the pressure `outside` [Pa], in kg."""

    @abstractmethod
    def efflux(self, volume: float, outside: float) -> float:
        """Return the mass flux per unit area of a vent, in kg/(s m²), from contents of a volume [m³] to a lower pressure
        `outside` [Pa]."""

    @abstractmethod
    def lack(self, volume: float, outside: float) -> float:
        """Return the mass whose inflow into a volume [m³] increases the pressure to the pressure `outside` [Pa], in kg."""

    @abstractmethod
    def influx(self, volume: float, outside: float) -> float:
        """Return the mass flux per unit area of a hole [kg/(s m²)] by which outside fluid at a higher pressure `outside`
        [Pa] enters contents of a volume [m³].

        The outside fluid is of the same kind as the contents: the gas at its initial temperature, or the liquid.
        """

    @abstractmethod
    def draw_in(self, mass: float, volume: float) -> tuple[float, float]:
        """Add a mass of outside fluid [kg] to the contents of a volume [m³]; the outside fluid is the gas at its initial
        temperature, or the liquid. Returns the energy added and the heat absorbed from outside [J]."""


class Gas(Contents):
    """An ideal gas with constant heat capacities and energy E in a volume V, p V = (γ-1) E. An isothermal gas absorbs heat to
    keep its temperature."""

    def __init__(self, mass: float, temperature: float, gamma: float, constant: float, isothermal: bool) -> None:
        """mass: initial mass [kg]; temperature: initial temperature [K]; gamma: ratio γ of the heat capacities; constant:
        specific gas constant R [J/(kg K)]; isothermal: True if the gas keeps its temperature."""
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
        """Return the pressure decrease per volume increase, -dp/dV [Pa/m³]: γp/V for an adiabatic gas, p/V for an
        isothermal gas, with the pressure p, the volume V and the ratio γ of the heat capacities."""
        return (1.0 if self.isothermal else self.gamma) * self.pressure(volume) / volume

    def expand(self, old: float, new: float) -> float:
        """Change the volume from `old` to `new` [m³] along an adiabat, or along an isotherm if the gas is isothermal (both
        are integrated exactly), and update the energy, which is constant along an isotherm. Returns the heat absorbed from
        outside [J], 0 along an adiabat."""
        if self.isothermal:
            return (self.gamma - 1.0) * self.energy * log(new / old)
        self.energy *= (old / new) ** (self.gamma - 1.0)
        return 0.0

    def take_in(self, mass: float, warmth: float, volume: float) -> tuple[float, float]:
        """Add an inflow of gas with its enthalpy: a mass [kg] with `warmth`, the integral ∫T dm of its temperature over its
        mass [K kg]. The volume is not used. Returns the energy added and the heat absorbed from outside [J]."""
        brought = self.gamma * self._heat_capacity * warmth
        self.mass += mass
        return brought, self._renew(brought)

    def let_out(self, mass: float, volume: float) -> tuple[float, float]:
        """Remove a mass of gas [kg] with its enthalpy; the rest expands along an adiabat, on which the energy E of the gas
        is proportional to m^γ for the mass m, or at constant temperature if the gas is isothermal. The volume is not used.
        Returns the energy removed and the heat absorbed from outside [J]."""
        left = 1.0 - mass / self.mass
        taken = mass * self.gamma * self._heat_capacity * self.temperature if self.isothermal else self._lost(left)
        self.mass *= left
        return taken, self._renew(-taken)

    def _lost(self, left: float) -> float:
        return self.energy * (1.0 - left**self.gamma)

    def _renew(self, gained: float) -> float:
        """Add the energy gained with a change of mass [J] to the energy of the gas; return the heat that the gas absorbs
        from outside if it is isothermal [J], else 0."""
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
        """Return the mass flux ψ p/√(R T) through a nozzle [kg/(s m²)] from contents of a volume [m³] to a lower pressure
        `outside` [Pa], with the flow function ψ (see `flow_function`), pressure p, specific gas constant R and temperature
        T of the gas; the flow is choked below the critical pressure ratio."""
        pressure = self.pressure(volume)
        return flow_function(outside / pressure, self.gamma) * pressure / sqrt(self.constant * self.temperature)

    def lack(self, volume: float, outside: float) -> float:
        rise = (outside - self.pressure(volume)) * volume / (self.constant * self._start)
        return rise if self.isothermal else rise / self.gamma

    def influx(self, volume: float, outside: float) -> float:
        return flow_function(self.pressure(volume) / outside, self.gamma) * outside / sqrt(self.constant * self._start)

    def draw_in(self, mass: float, volume: float) -> tuple[float, float]:
        """Add a mass of gas [kg] at the initial temperature, with its enthalpy, to the contents of a volume [m³]. Returns
        the energy added and the heat absorbed from outside [J]."""
        return self.take_in(mass, mass * self._start, volume)


def flow_function(ratio: float, gamma: float) -> float:
    """Return the flow function ψ (dimensionless mass flux) of a nozzle; ratio: downstream over upstream pressure; gamma:
    ratio of the heat capacities. Source: Saint-Venant & Wantzel 1839."""
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    r = max(ratio, critical)
    return sqrt(2.0 * gamma / (gamma - 1.0) * max(r ** (2.0 / gamma) - r ** ((gamma + 1.0) / gamma), 0.0))


class Liquid(Contents):
    """A liquid with mass m and constant bulk modulus K in a volume V, p = K (m/(ρ₀V) - 1) with the density ρ₀ at zero
    pressure; its energy is the compression energy."""

    def __init__(self, mass: float, bulk_modulus: float, density: float, volume: float) -> None:
        """mass: initial mass [kg]; bulk_modulus: K [Pa]; density: density ρ₀ at zero pressure [kg/m³]; volume: initial volume
        [m³]."""
        self.bulk_modulus, self.density, self.mass = bulk_modulus, density, mass
        self.energy = self._energy(volume)

    def _energy(self, volume: float) -> float:
        rest = self.mass / self.density
        if rest <= 0.0:
            return inf
        strain = (volume - rest) / rest
        return self.bulk_modulus * rest * (strain - log1p(strain))  # accurate for small strains

    def pressure(self, volume: float) -> float:
        """Return the pressure [Pa], negative if the liquid is stretched."""
        return self.bulk_modulus * (self.mass / (self.density * volume) - 1.0)

    def stiffness(self, volume: float) -> float:
        """Return the pressure decrease per volume increase, -dp/dV = K m/(ρ₀V²) [Pa/m³], with the bulk modulus K, the mass
        m, the density ρ₀ at zero pressure and the volume V."""
        return self.bulk_modulus * self.mass / (self.density * volume * volume)

    def _renew(self, volume: float) -> float:
        before, self.energy = self.energy, self._energy(volume)
        return self.energy - before

    def expand(self, old: float, new: float) -> float:
        """Change the volume from `old` to `new` [m³] and update the compression energy; return 0, since a liquid absorbs no
        heat."""
        self._renew(new)
        return 0.0

    def take_in(self, mass: float, warmth: float, volume: float) -> tuple[float, float]:
        """Add a mass of liquid [kg] to the contents of a volume [m³]; `warmth` is not used. Returns the energy added, i.e.
        the increase of the compression energy [J], and 0, since a liquid absorbs no heat."""
        self.mass += mass
        return self._renew(volume), 0.0

    def let_out(self, mass: float, volume: float) -> tuple[float, float]:
        """Remove a mass of liquid [kg] from the contents of a volume [m³]. Returns the energy removed, i.e. the decrease of
        the compression energy [J], and 0, since a liquid absorbs no heat."""
        self.mass -= mass
        return -self._renew(volume), 0.0

    def excess(self, volume: float, outside: float) -> float:
        return self.density * volume * (self.pressure(volume) - outside) / self.bulk_modulus

    def efflux(self, volume: float, outside: float) -> float:
        """Return the mass flux √(2ρ Δp) [kg/(s m²)] from contents of a volume [m³] to a lower pressure `outside` [Pa], with
        the density ρ of the contents and the pressure difference Δp."""
        return sqrt(2.0 * self.mass / volume * (self.pressure(volume) - outside))

    def lack(self, volume: float, outside: float) -> float:
        return -self.excess(volume, outside)

    def influx(self, volume: float, outside: float) -> float:
        """Return the mass flux √(2ρ₀ Δp) [kg/(s m²)] from a higher pressure `outside` [Pa] into contents of a volume [m³],
        with the density ρ₀ at zero pressure and the pressure difference Δp."""
        return sqrt(2.0 * self.density * (outside - self.pressure(volume)))

    def draw_in(self, mass: float, volume: float) -> tuple[float, float]:
        return self.take_in(mass, 0.0, volume)
