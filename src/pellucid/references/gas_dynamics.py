"""Exact solutions of gas dynamics: the Riemann problem, a shock tube between closed ends, blasts."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from math import pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pellucid.references import Array, Case

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.geometry.shapes.contract import Geometry


FLOAT_LIMIT = 1e-15


class VacuumError(ValueError):
    """Error for two gas states between which a vacuum opens, so that there is no star region (the region between the waves)."""


@dataclass(frozen=True)
class GasState:
    """Uniform state of an ideal gas on one side of a Riemann problem: density [kg/m³], velocity [m/s], pressure [Pa] and
    ratio of specific heats."""

    density: float  # [kg/m³]
    velocity: float  # [m/s]
    pressure: float  # [Pa]
    gamma: float = 1.4  # ratio of specific heats

    def __post_init__(self) -> None:
        if self.gamma <= 1.0:
            raise ValueError(f"gamma = {self.gamma}: an ideal gas needs gamma > 1")
        if self.density <= 0.0 or self.pressure <= 0.0:
            raise VacuumError(f"density {self.density} and pressure {self.pressure} must both be positive")

    @property
    def sound_speed(self) -> float:
        """Speed of sound [m/s]."""
        return sqrt(self.gamma * self.pressure / self.density)

    def mirrored(self) -> "GasState":
        """Return the state of the mirror image of the gas: density and pressure are equal, the velocity changes sign."""
        return replace(self, velocity=-self.velocity)


class Wave(NamedTuple):
    """A wave (shock or rarefaction fan) that runs into one of the two gases: speeds of head and tail [m/s], and density
    behind the wave [kg/m³]."""

    head: float  # speed of the head [m/s]
    tail: float  # speed of the tail [m/s]; equal to `head` for a shock
    density: float  # density behind the wave [kg/m³]

    def mirrored(self) -> "Wave":
        """Return the mirror image of the wave: both speeds change sign, the density is equal."""
        return Wave(-self.head, -self.tail, self.density)


@dataclass(frozen=True)
class RiemannSolution:
    """Exact solution of a Riemann problem, as `solve` returns it: both initial states, pressure [Pa] and velocity [m/s]
    between the waves, and both waves. `sample` evaluates the fields."""

    left: GasState  # initial state for x < 0
    right: GasState  # initial state for x > 0
    pressure: float  # pressure p* between the waves [Pa]
    velocity: float  # velocity u* between the waves [m/s]
    left_wave: Wave  # wave into the left gas
    right_wave: Wave  # wave into the right gas

    def sample(self, speed: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Return the fields at x/t = `speed` [m/s] of any shape.

        The fields are density [kg/m^3], velocity [m/s], pressure [Pa] and internal_energy [J/kg], each of the same shape.
        """
        xi = np.asarray(speed, dtype=float)
        from_left = _one_side(self.left, self.left_wave, self.pressure, self.velocity, xi)
        from_right = _one_side(self.right.mirrored(), self.right_wave.mirrored(), self.pressure, -self.velocity, -xi)
        in_left_gas = xi < self.velocity
        density, pressure = (np.where(in_left_gas, a, b) for a, b in zip(from_left[::2], from_right[::2], strict=True))
        velocity = np.where(in_left_gas, from_left[1], -from_right[1])
        gamma = np.where(in_left_gas, self.left.gamma, self.right.gamma)
        energy = pressure / ((gamma - 1.0) * density)
        return {"density": density, "velocity": velocity, "pressure": pressure, "internal_energy": energy}


def solve(left: GasState, right: GasState) -> RiemannSolution:
    """Compute the solution for two gas states: the star region (between the waves) and the waves.

    Raises VacuumError if a vacuum opens between them.

    Two uniform states are in contact at x = 0. For t > 0 the solution depends on x/t alone: a wave (shock or rarefaction fan)
    runs into each state, and a contact separates the gases between the waves, with the same pressure p* and velocity u* on both
    sides. Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, 3rd ed., chapter 4. Here each gas may
    have its own gamma.
    """
    reach = sum(2.0 * gas.sound_speed / (gas.gamma - 1.0) for gas in (left, right))
    if right.velocity - left.velocity >= reach:
        parting = right.velocity - left.velocity
        raise VacuumError(
            f"a vacuum would form: the states separate at {parting:g} m/s, but must separate at less than {reach:g} m/s"
        )
    pressure = _star_pressure(left, right)
    velocity = left.velocity - _velocity_change(left, pressure)[0]
    right_wave = _wave(right.mirrored(), pressure).mirrored()
    return RiemannSolution(left, right, pressure, velocity, _wave(left, pressure), right_wave)


def _star_pressure(left: GasState, right: GasState) -> float:
    """Return the pressure between the waves [Pa], the root of f(p) = f_L(p) + f_R(p) + u_R - u_L with `_velocity_change` f_L,
    f_R. f is increasing and concave, so Newton's method from below never overshoots."""

    def mismatch(p: float) -> tuple[float, float]:
        (f_left, df_left), (f_right, df_right) = _velocity_change(left, p), _velocity_change(right, p)
        return f_left + f_right + right.velocity - left.velocity, df_left + df_right

    pressure = min(left.pressure, right.pressure)
    while mismatch(pressure)[0] > 0.0:
        pressure *= 0.1
    for _ in range(200):
        value, slope = mismatch(pressure)
        change = -value / slope
        pressure += change
        if abs(change) <= FLOAT_LIMIT * pressure:
            break
    return pressure


def _velocity_change(gas: GasState, pressure: float) -> tuple[float, float]:
    """Return the velocity change f across the wave from `gas` to the pressure behind it [m/s], and its derivative with respect
    to this pressure [m/(s Pa)]."""
    gamma = gas.gamma
    if pressure > gas.pressure:  # shock: Rankine-Hugoniot
        a, b = 2.0 / ((gamma + 1.0) * gas.density), (gamma - 1.0) / (gamma + 1.0) * gas.pressure
        root = sqrt(a / (pressure + b))
        return (pressure - gas.pressure) * root, root * (1.0 - 0.5 * (pressure - gas.pressure) / (pressure + b))
    ratio = pressure / gas.pressure  # fan: constant entropy and Riemann invariant
    change = 2.0 * gas.sound_speed / (gamma - 1.0) * (ratio ** ((gamma - 1.0) / (2.0 * gamma)) - 1.0)
    return change, ratio ** (-(gamma + 1.0) / (2.0 * gamma)) / (gas.density * gas.sound_speed)


def _wave(gas: GasState, pressure: float) -> Wave:
    """Return the wave that runs into the *left* gas state; pressure: pressure behind it, in the star region [Pa]."""
    gamma, ratio = gas.gamma, pressure / gas.pressure
    if ratio > 1.0:
        g = (gamma - 1.0) / (gamma + 1.0)
        speed = gas.velocity - gas.sound_speed * sqrt((gamma + 1.0) / (2.0 * gamma) * (ratio - 1.0) + 1.0)
        return Wave(speed, speed, gas.density * (ratio + g) / (g * ratio + 1.0))
    star_sound = gas.sound_speed * ratio ** ((gamma - 1.0) / (2.0 * gamma))
    star_velocity = gas.velocity - _velocity_change(gas, pressure)[0]
    head, tail = gas.velocity - gas.sound_speed, star_velocity - star_sound
    return Wave(head, tail, gas.density * ratio ** (1.0 / gamma))


def _one_side(
    gas: GasState, wave: Wave, star_pressure: float, star_velocity: float, xi: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return density [kg/m^3], velocity [m/s] and pressure [Pa] at x/t = xi [m/s] on the left of the contact, each of the shape
    of xi. gas: left state; wave: left wave."""
    gamma, sound = gas.gamma, gas.sound_speed
    star = (np.full(xi.shape, wave.density), np.full(xi.shape, star_velocity), np.full(xi.shape, star_pressure))
    inside = (xi >= wave.head) & (xi < wave.tail)
    # within the fan the invariant u + 2c/(gamma-1) and u - c = x/t give c, and constant entropy the rest
    inner = np.where(inside, xi, wave.head)
    fan_sound = (2.0 * sound + (gamma - 1.0) * (gas.velocity - inner)) / (gamma + 1.0)
    compression = (fan_sound / sound) ** (2.0 / (gamma - 1.0))
    fan = (gas.density * compression, inner + fan_sound, gas.pressure * compression**gamma)
    outer = (gas.density, gas.velocity, gas.pressure)
    density, velocity, pressure = (
        np.where(xi < wave.head, o, np.where(inside, f, s)) for o, f, s in zip(outer, fan, star, strict=True)
    )
    return density, velocity, pressure


QUANTITIES = {"density": "kg/m^3", "pressure": "Pa", "velocity": "m/s", "internal_energy": "J/kg"}


@dataclass(frozen=True)
class Tube:
    """A shock tube along x, the reference of a case: exact solution, position of the diaphragm, ends of the tube and cell
    size [m]."""

    solution: RiemannSolution  # exact solution for the gases on both sides of the diaphragm
    diaphragm: float  # initial position of the contact between the gases [m]
    lower: float  # lower end of the tube [m]
    upper: float  # upper end of the tube [m]
    cell: float  # cell size of the grid [m]

    @classmethod
    def of(cls, case: Case) -> "Tube":
        """Build the tube of a case whose first body is the gas on the left and whose second body is the gas on the right."""
        left, right = (_gas(body) for body in case.body)
        diaphragm = float(case.body[0].bounds()[1][0])
        return cls(solve(left, right), diaphragm, case.grid.lower[0], case.grid.upper[0], case.grid.cell)

    def exact(self, x: Array, time: float) -> dict[str, Array]:
        """Return density, velocity, pressure and internal energy by name (SI units) at positions x [m] of any shape and a time
        [s]; valid until a wave reaches an end of the tube."""
        if time == 0.0:  # the two gases, whatever lies between them later
            return self.solution.sample(np.where(x < self.diaphragm, -np.inf, np.inf))
        return self.solution.sample((x - self.diaphragm) / time)

    def fronts(self, time: float) -> dict[str, float]:
        """Return the positions of the head and tail of the left rarefaction, of the contact, and of the right shock [m] at a
        time [s], by name."""
        speeds = {
            "fan head": self.solution.left_wave.head,
            "fan tail": self.solution.left_wave.tail,
            "contact": self.solution.velocity,
            "shock": self.solution.right_wave.head,
        }
        return {name: self.diaphragm + speed * time for name, speed in speeds.items()}

    def mean_profile(self, time: float, cells: int = 4, samples: int = 400) -> "Profile":
        """Return the means of the exact fields at a time [s] over bins of `cells` grid cells, weighted as in
        `Profile.of_points`, by the midpoint rule with `samples` points in each bin."""
        edges = self.edges(cells)
        inside = (np.arange(samples) + 0.5) / samples
        fields = self.exact(edges[:-1, None] + np.diff(edges)[:, None] * inside, time)
        density = fields["density"].mean(axis=1)
        means = {"density": density, "pressure": fields["pressure"].mean(axis=1)}
        for name in ("velocity", "internal_energy"):
            means[name] = (fields["density"] * fields[name]).mean(axis=1) / density
        return Profile(edges, means)

    def edges(self, cells: int) -> Array:
        """Return the edges of bins of about `cells` grid cells along the tube [m]."""
        count = max(1, round((self.upper - self.lower) / self.cell / cells))
        return np.linspace(self.lower, self.upper, count + 1)


@dataclass(frozen=True)
class Profile:
    """A profile of means over bins (intervals along x): `edges` [m], shape (n+1,), and `means`, an array of shape (n,) for each
    quantity."""

    edges: Array
    means: dict[str, Array]

    @property
    def centres(self) -> Array:
        """Centres of the bins [m], shape (n,)."""
        return 0.5 * (self.edges[:-1] + self.edges[1:])

    @classmethod
    def of_points(cls, points: dict[str, Array], edges: Array) -> "Profile":
        """Compute means of the fields of points (by name) in bins along x with the given edges [m], shape (n+1,).

        Density is mass divided by volume; pressure is weighted by volume, velocity and internal energy by mass. A bin without
        points has the value NaN.
        """
        x, mass = points["position"][:, 0], points["mass"]
        volume = mass / points["density"]

        def total(weight: Array) -> Array:
            return np.histogram(x, bins=edges, weights=weight)[0]

        with np.errstate(invalid="ignore"):
            in_bin, filled = total(mass), total(volume)
            means = {"density": in_bin / filled, "pressure": total(volume * points["pressure"]) / filled}
            means["velocity"] = total(mass * points["velocity"][:, 0]) / in_bin
            means["internal_energy"] = total(mass * points["internal_energy"]) / in_bin
        return cls(edges, means)

    def relative_l1(self, exact: "Profile", name: str) -> float:
        """Return the relative L1 error of the quantity `name`, sum |mean - exact mean| / sum |exact mean|, over the bins that
        contain points. exact: profile of exact means in the same bins."""
        width, found, wanted = np.diff(self.edges), self.means[name], exact.means[name]
        known = np.isfinite(found)
        return float(np.sum((width * np.abs(found - wanted))[known]) / np.sum(width * np.abs(wanted)))

    def relative_variation(self, name: str) -> float:
        """Return the total variation of a quantity along the tube, divided by the integral of its absolute value [1/m].

        A profile displaced by d has a relative L1 error of at most d times this number, which converts a length into an
        error.
        """
        values = self.means[name]
        return float(np.sum(np.abs(np.diff(values))) / np.sum(np.diff(self.edges) * np.abs(values)))


def points_of(run: Any, bodies: Iterable[Any] | None = None) -> dict[str, Array]:
    """Return the fields of the points of several bodies (default: all) at the end of a run, concatenated."""
    frames = [run.fields(body.name) for body in (run.case.body if bodies is None else bodies)]
    names = ("position", "velocity", "density", "pressure", "internal_energy", "mass")
    return {name: np.concatenate([np.asarray(frame[name], dtype=float) for frame in frames]) for name in names}


def _gas(body: Any) -> GasState:
    material = body.material
    if material.kind != "fluid" or material.eos.kind != "ideal-gas":
        raise ValueError(f"body {body.name!r} is not an ideal gas: the exact solution of the tube is for ideal gases")
    return GasState(material.density, body.velocity[0], material.pressure, material.eos.gamma)


INNERMOST = 1e-3  # ξ, within which there is less than 1e-12 of the mass and 1e-5 of the energy, which is added
MEASURE = {1: 2.0, 2: 2.0 * pi, 3: 4.0 * pi}  # of the unit sphere's surface; of a plane, on both its sides


@dataclass(frozen=True)
class Similarity:
    """The self-similar solution of an explosion: the energy constant α, and profiles along ξ = r/R (radius over shock
    radius).

    The shock is at R = (E t²/(α ρ₀))^(1/(n+2)) in n dimensions. Behind it u = Ṙ U(ξ), ρ = ρ₀ G(ξ), p = ρ₀ Ṙ² P(ξ) with ξ = r/R.
    Source: L. I. Sedov, Similarity and Dimensional Methods in Mechanics (1959), chapter IV; G. I. Taylor, Proc. R. Soc. A 201
    (1950) 159-174. Here the balances of mass, momentum, entropy and energy are integrated from the shock inwards.
    """

    alpha: float  # α
    xi: Array  # (n,) ξ, ascending from INNERMOST to 1
    velocity: Array  # (n,) dimensionless velocity U
    density: Array  # (n,) dimensionless density G
    pressure: Array  # (n,) dimensionless pressure P


@cache
def similarity(dimensions: int, gamma: float) -> Similarity:
    """Compute the self-similar solution of a plane (1), cylindrical (2) or spherical (3) explosion in a gas with the ratio γ of
    specific heats."""
    from scipy.integrate import solve_ivp

    n = dimensions
    slowing = -0.5 * n  # R R̈/Ṙ² where R grows as t^(2/(n+2))

    def slope(x: float, state: Array) -> list[float]:
        """Return the derivatives with respect to ln ξ of the dimensionless velocity U, the logarithms of density G and
        pressure P, and the enclosed energy."""
        xi, U, G, P = np.exp(x), state[0], np.exp(state[1]), np.exp(state[2])
        w = U - xi
        # w ln G' + U' = -(n-1) U/ξ;  w U' + P/G ln P' = -slowing U;  ln P' - γ ln G' = -2 slowing/w
        system = np.array([[1.0, w, 0.0], [w, 0.0, P / G], [0.0, -gamma, 1.0]])
        dU, dG, dP = np.linalg.solve(system, [-(n - 1) * U / xi, -slowing * U, -2.0 * slowing / w])
        energy = (0.5 * G * U**2 + P / (gamma - 1.0)) * xi ** (n - 1)
        return [xi * dU, xi * dG, xi * dP, xi * energy]

    shock = [2.0 / (gamma + 1.0), np.log((gamma + 1.0) / (gamma - 1.0)), np.log(2.0 / (gamma + 1.0)), 0.0]
    # even in r about the front, where density changes fastest
    xi = np.linspace(1.0, INNERMOST, 20001)
    found = solve_ivp(slope, (0.0, np.log(INNERMOST)), shock, method="DOP853", rtol=1e-11, atol=1e-13, t_eval=np.log(xi))
    U, log_density, log_pressure, energy = found.y[:, ::-1]
    pressure = np.exp(log_pressure)
    within = -energy[0] + pressure[0] / (gamma - 1.0) * INNERMOST**n / n  # at the centre the pressure is even
    alpha = MEASURE[n] * (2.0 / (n + 2.0)) ** 2 * within
    return Similarity(float(alpha), xi[::-1], U, np.exp(log_density), pressure)


@dataclass(frozen=True)
class Blast:
    """An explosion in a cold ideal gas, the reference of a case: number of dimensions, released energy [J; J/m for a line],
    density [kg/m³] and ratio of specific heats of the gas."""

    dimensions: int  # 1 plane, 2 cylindrical, 3 spherical
    energy: float  # released energy [J; J/m for a line]
    density: float  # density of the cold gas [kg/m³]
    gamma: float  # γ, ratio of specific heats

    @classmethod
    def of(cls, case: "Case") -> "Blast":
        """Build the blast of a case. The first body must be the hot gas, a cylinder or ball that may be cut by planes of
        symmetry; the second body is the cold gas."""
        hot, cold = case.body
        x, y, z = (not thin for thin in case.thin)
        active, material = (x, y, z), cast(Any, hot.material)
        energy = cast("Geometry", hot.occupied()).measure(active) * material.pressure / (material.eos.gamma - 1.0)
        return cls(sum(active), energy, cold.material.density, material.eos.gamma)

    def radius(self, time: Any) -> Array:
        """Return the radius of the shock [m] at times [s] of any shape."""
        n = self.dimensions
        alpha = similarity(n, self.gamma).alpha
        return np.asarray((self.energy * np.square(time) / (alpha * self.density)) ** (1.0 / (n + 2)))

    def at(self, radius: Array, time: float) -> dict[str, Array]:
        """Return density [kg/m³], radial velocity [m/s] and pressure [Pa] by name at radii [m] of any shape and a time [s]; the
        gas ahead of the shock is at rest with zero pressure."""
        front = float(self.radius(time))
        speed = 2.0 / (self.dimensions + 2.0) * front / time
        profiles, xi = similarity(self.dimensions, self.gamma), radius / front
        inside = {"density": (self.density, profiles.density), "velocity": (speed, profiles.velocity)}
        inside["pressure"] = (self.density * speed**2, profiles.pressure)
        outside = {"density": self.density, "velocity": 0.0, "pressure": 0.0}
        return {
            name: np.where(xi <= 1.0, scale * np.interp(xi, profiles.xi, values), outside[name])
            for name, (scale, values) in inside.items()
        }
