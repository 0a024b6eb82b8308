"""Elastic solids: exact solutions, and results of finite elements in tables.

Among them is a smooth rigid sphere pressed into a layer on a rigid base, with linear elasticity; it includes Hertz contact
with a half-space. A sphere of radius R at the depth δ touches a layer of thickness h within the contact radius a. Its
pressure, written as the Hankel transform p̂(k) = ∫₀ᵃ φ(t) cos kt dt with an unknown function φ, displaces the face by
2(1-ν²)/E ∫ L(kh) p̂(k) J₀(kr) dk, where L is the relative compliance, 1 for the half-space. Equating this to the parabola of
the sphere gives Fredholm's equation φ(t) + 2/π ∫₀ᵃ φ(s) ∫₀^∞ (L-1) cos ks cos kt dk ds = E/(π(1-ν²)) (δ - t²/R), and φ(a) =
0 at the rim of the contact (N. N. Lebedev & Ya. S. Ufliand, J. Appl. Math. Mech. 22 (1958) 442-450; W. C. Hayes, L. M. Keer,
G. Herrmann & L. F. Mockros, J. Biomech. 5 (1972) 541-551, for the bonded layer).
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf, log, pi, sqrt
from typing import Any, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad, solve_bvp
from scipy.optimize import brentq
from scipy.special import j0, j1

from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.materials.elastic import ElasticMaterial
from pellucid.references import Array, Case, finite_elements


@dataclass(frozen=True)
class StandingWave:
    """A standing wave v = V sin(kx+φ) cos(ωt) in an elastic bar, the reference of a case: amplitude V [m/s], wave number k
    [rad/m], phase φ [rad] and wave speed [m/s]."""

    amplitude: float  # V, largest velocity [m/s]
    wave_number: float  # k [rad/m]
    phase: float  # φ [rad]
    speed: float  # wave speed c [m/s]

    @classmethod
    def of(cls, case: Case) -> "StandingWave":
        """Build the standing wave from the initial velocity of the first body of a case. In a laterally constrained bar
        the modulus is λ + 2μ."""
        body = case.body[0]
        wave = body.velocity_wave if isinstance(body, MaterialPointsCase) else None
        material: object = body.material
        if wave is None or not isinstance(material, ElasticMaterial):
            raise ValueError(f"body {body.name!r} must be an elastic solid with a velocity_wave")
        nu = material.poisson_ratio
        modulus = material.young_modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        return cls(wave.amplitude[0], wave.wave_vector[0], wave.phase, sqrt(modulus / material.density))

    @property
    def frequency(self) -> float:
        """Angular frequency ω = kc [rad/s]."""
        return abs(self.wave_number) * self.speed

    @property
    def period(self) -> float:
        """Period 2π/ω of the standing wave [s]."""
        return 2.0 * np.pi / self.frequency

    def velocity(self, x: Array, time: float) -> Array:
        """Return the velocity along the bar [m/s] at initial positions x [m] and a time [s]."""
        return self.amplitude * np.sin(self.wave_number * x + self.phase) * np.cos(self.frequency * time)

    def displacement(self, x: Array, time: float) -> Array:
        """Return the displacement along the bar [m] at initial positions x [m] and a time [s]."""
        swing = np.sin(self.frequency * time) / self.frequency
        return self.amplitude * np.sin(self.wave_number * x + self.phase) * swing


def period_of(times: Array, signal: Array) -> float:
    """Return the period [s] of an oscillation about zero, from its linearly interpolated zero crossings; NaN for fewer than
    two crossings.

    times: times of the samples [s], shape (n,); signal: samples, shape (n,).
    """
    before = np.flatnonzero(signal[:-1] * signal[1:] < 0.0)
    if len(before) < 2:
        return float("nan")
    share = signal[before] / (signal[before] - signal[before + 1])
    crossings = times[before] + share * (times[before + 1] - times[before])
    return float(2.0 * (crossings[-1] - crossings[0]) / (len(crossings) - 1))


HEIGHTS = 2001  # at which the stretch is found; Simpson's rule between them is exact to 1e-12


@dataclass(frozen=True)
class HeavyColumn:
    """A column between smooth walls that is compressed by its own weight, the reference of a case: height [m], density
    [kg/m³], gravity [m/s²] and Lamé's constants [Pa].

    At the height Y of the stress-free column the nominal stress supports the weight above, P(λ) = -ρ₀ g (H - Y), and with
    uniaxial strain P = μ (λ - 1/λ) + Λ ln λ/λ. P is also the Cauchy stress because the cross-section is constant. The deformed
    heights are y = ∫λ dY. Source: Bonet & Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., eq.
    6.28, for the law.
    """

    height: float  # H, stress-free height [m]
    density: float  # ρ₀ [kg/m³]
    gravity: float  # g [m/s²]
    first: float  # Lamé's constant λ [Pa]
    shear: float  # Lamé's constant μ [Pa]

    @classmethod
    def of(cls, case: Case) -> "HeavyColumn":
        """Build the column of a case whose first body is a box on the lower face of the grid, with gravity along -y."""
        body = case.body[0]
        lower, upper = body.bounds()
        material = cast(Any, body.material)
        young, poisson = material.young_modulus, material.poisson_ratio
        shear = young / (2.0 * (1.0 + poisson))
        first = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
        return cls(float(upper[1] - lower[1]), material.density, -case.gravity[1], first, shear)

    def stress(self, heights: Array) -> Array:
        """Return the axial stress [Pa] at heights in the stress-free column [m] of any shape."""
        return np.asarray(-self.density * self.gravity * (self.height - heights))

    def stretch(self, heights: Array) -> Array:
        """Return the axial stretch λ at heights in the stress-free column [m] of any shape, by bisection."""
        wanted = self.stress(heights)
        low, high = np.full(wanted.shape, 1e-6), np.ones(wanted.shape)
        for _ in range(60):
            middle = 0.5 * (low + high)
            below = self.shear * (middle - 1.0 / middle) + self.first * np.log(middle) / middle < wanted
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return 0.5 * (low + high)

    def place(self, heights: Array) -> Array:
        """Return the heights in the compressed column [m] for heights in the stress-free column [m] of any shape."""
        from scipy.integrate import cumulative_simpson

        line = np.linspace(0.0, self.height, HEIGHTS)
        return np.asarray(np.interp(heights, line, cumulative_simpson(self.stretch(line), x=line, initial=0.0)))


@dataclass(frozen=True)
class SpinningDisc:
    """A disc that suddenly starts to spin, the reference of a case: radius [m], elastic constants, density [kg/m³], angular
    velocity [rad/s], and number of radial modes in the sum.

    In the rotating frame a radial load ρω²r appears at t = 0. The disc oscillates radially (breathes) about its static state:
    u(r,t) = u_s(r) - Σ c_n J₁(k_n r) cos(ω_n t), ω_n = k_n sqrt((λ+2μ)/ρ), with k_n from the free rim. Valid for small strains,
    (ωR)² ρ/E << 1.
    """

    radius: float  # R [m]
    density: float  # ρ [kg/m³]
    young_modulus: float  # E [Pa]
    poisson_ratio: float
    angular_velocity: float  # ω [rad/s]
    modes: int = 20  # number of radial modes in the sum

    @classmethod
    def of(cls, case: Case) -> "SpinningDisc":
        """Build the disc of a case with one body, a cylinder along z."""
        body = case.body[0]
        cylinder = body.shape.cylinder if isinstance(body, MaterialPointsCase) else None
        material: object = body.material
        if not isinstance(body, MaterialPointsCase) or cylinder is None or not isinstance(material, ElasticMaterial):
            raise ValueError(f"body {body.name!r} must be an elastic cylinder")
        return cls(cylinder.radius, material.density, material.young_modulus, material.poisson_ratio, body.angular_velocity[2])

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's λ and μ [Pa]."""
        mu = 0.5 * self.young_modulus / (1.0 + self.poisson_ratio)
        return 2.0 * mu * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio), mu

    @cached_property
    def _static(self) -> tuple[float, float]:
        """Coefficients a and b of the static displacement u_s = a r - b r³, which balances the centrifugal force with a
        free rim."""
        lam, mu = self.lame
        b = self.density * self.angular_velocity**2 / (8.0 * (lam + 2.0 * mu))
        return b * self.radius**2 * (2.0 * lam + 3.0 * mu) / (lam + mu), b

    @cached_property
    def breathing(self) -> tuple[Array, Array, Array]:
        """Return the wave numbers k_n [rad/m], amplitudes c_n [m] and angular frequencies ω_n [rad/s] of the radial
        vibration modes."""
        lam, mu = self.lame
        modulus = lam + 2.0 * mu

        def rim_stress(z: float) -> float:  # σ_rr at the rim for u = J1(kr), z = kR, times R
            return modulus * z * float(j0(z)) - 2.0 * mu * float(j1(z))

        grid = np.linspace(0.5, np.pi * (self.modes + 1.5), 80 * (self.modes + 2))
        values = [rim_stress(z) for z in grid]
        roots = [
            brentq(rim_stress, low, high, xtol=1e-13)
            for low, high, f, g in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True)
            if f * g < 0.0
        ][: self.modes]
        k = np.array(roots) / self.radius
        a, b = self._static

        def share(q: float) -> float:
            """Return the coefficient [m] of the mode J₁(qr) in the expansion of the static displacement; q: wave number
            [rad/m]."""
            overlap = quad(lambda r: r * (a * r - b * r**3) * float(j1(q * r)), 0.0, self.radius, limit=400)[0]
            return float(overlap / quad(lambda r: r * float(j1(q * r)) ** 2, 0.0, self.radius, limit=400)[0])

        amplitude = np.array([share(q) for q in k])
        return k, amplitude, k * sqrt(modulus / self.density)

    def displacement(self, r: ArrayLike, time: float) -> Array:
        """Return the radial displacement [m] at radii r [m] and a time [s]."""
        a, b = self._static
        r = np.asarray(r, dtype=float)
        k, c, w = self.breathing
        return np.asarray(a * r - b * r**3 - np.sum(c * np.cos(w * time) * j1(k * r[..., None]), axis=-1))

    def stresses(self, r: ArrayLike, time: float | None = None) -> tuple[Array, Array]:
        """Return radial and hoop stress [Pa] at radii r > 0 [m] and a time [s]; without a time, the stresses of the static
        state (without oscillation)."""
        a, b = self._static
        r = np.asarray(r, dtype=float)
        stretch, hoop = a - 3.0 * b * r**2, a - b * r**2
        if time is not None:
            k, c, w = self.breathing
            swing, kr = c * np.cos(w * time), k * r[..., None]
            stretch = stretch - np.sum(swing * (k * j0(kr) - j1(kr) / r[..., None]), axis=-1)
            hoop = hoop - np.sum(swing * j1(kr) / r[..., None], axis=-1)
        lam, mu = self.lame
        bulk = lam * (stretch + hoop)
        return np.asarray(bulk + 2.0 * mu * stretch), np.asarray(bulk + 2.0 * mu * hoop)

    def mean_stress(self, times: ArrayLike) -> Array:
        """Return the mean over the disc of σxx + σyy [Pa] at times [s]: 4 (λ+μ) u(R)/R, by Gauss's theorem."""
        lam, mu = self.lame
        instants = np.atleast_1d(np.asarray(times, dtype=float))
        rim = np.array([float(self.displacement(self.radius, t)) for t in instants])
        return 4.0 * (lam + mu) * rim / self.radius

    @property
    def static_mean_stress(self) -> float:
        """Mean of σxx + σyy [Pa] in the static state; by the virial theorem ρω²R²/2 (twice the kinetic energy)."""
        return 0.5 * self.density * (self.angular_velocity * self.radius) ** 2


class Stretched(NamedTuple):
    """Homogeneous state of a stretched block with free sides, as `stretched` returns it: lateral stretch, energy per
    initial volume [J/m³] and axial force per initial area [Pa]."""

    lateral: float  # stretch across the axis
    energy: float  # strain energy per initial volume [J/m³]
    stress: float  # axial force per initial area [Pa]


def stretched(form: Literal["coupled", "decoupled"], young_modulus: float, poisson_ratio: float, stretch: float) -> Stretched:
    """Compute the homogeneous state (`Stretched`) of a block with free sides, with Young's modulus [Pa] and Poisson's ratio
    < 0.5, at a stretch along its axis.

    form: strain energy, "coupled": μ/2 (I₁-3) - μ ln J + λ/2 (ln J)², or "decoupled": μ/2 (J^(-2/3) I₁-3) + κ/2 (J-1)².

    Two energies: "coupled" μ/2 (I₁-3) - μ ln J + λ/2 (ln J)² and "decoupled" μ/2 (J^(-2/3) I₁-3) + κ/2 (J-1)², with I₁ = 2a² +
    s² and J = a²s for the stretches s along the axis and a across it.
    """
    mu = young_modulus / (2.0 * (1.0 + poisson_ratio))
    bulk = young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
    state = _coupled if form == "coupled" else _decoupled
    low, high = min(1.0, 1.0 / stretch), max(1.0, 1.0 / stretch)  # the lateral stress rises with a between these
    for _ in range(100):
        lateral = 0.5 * (low + high)
        low, high = (lateral, high) if state(mu, bulk, lateral, stretch)[0] < 0.0 else (low, lateral)
    _, energy, stress = state(mu, bulk, lateral, stretch)
    return Stretched(lateral, energy, stress)


def _coupled(mu: float, bulk: float, a: float, s: float) -> tuple[float, float, float]:
    """Return a value with the sign of the lateral stress, the energy per initial volume [J/m³], and the axial force per initial
    area [Pa], for shear and bulk modulus [Pa], lateral stretch a and axial stretch s."""
    lam, ln_J = bulk - 2.0 * mu / 3.0, log(a * a * s)
    energy = 0.5 * mu * (2.0 * a * a + s * s - 3.0) - mu * ln_J + 0.5 * lam * ln_J**2
    return mu * (a * a - 1.0) + lam * ln_J, energy, (mu * (s * s - 1.0) + lam * ln_J) / s


def _decoupled(mu: float, bulk: float, a: float, s: float) -> tuple[float, float, float]:
    """For the decoupled energy, return a value with the sign of the lateral stress, the energy per initial volume [J/m³],
    and the axial force per initial area [Pa]; mu, bulk: shear and bulk modulus [Pa]; a, s: lateral and axial stretch."""
    J, trace = a * a * s, 2.0 * a * a + s * s
    shear, pressure = mu * J ** (-2.0 / 3.0), bulk * (J - 1.0) * J
    energy = 0.5 * (shear * trace - 3.0 * mu) + 0.5 * bulk * (J - 1.0) ** 2
    return shear * (a * a - trace / 3.0) + pressure, energy, (shear * (s * s - trace / 3.0) + pressure) / s


class AtRest(NamedTuple):
    """Reference values for the deformed cube at rest: strain energy [J] and force on the upper face [N], with estimated
    relative errors.

    Edge 0.1 m, Young's modulus 3000 Pa, Poisson's ratio 0.49; the free sides may pass the planes of the plates. The two forms
    of the energy are defined in `stretched`. The positions of the free sides of the stretched cube are in the table
    `cube_bulge` of `finite_elements`.
    """

    energy: float  # strain energy [J]
    reaction: float  # force along z on the upper face [N]
    energy_error: float  # relative error of `energy`
    reaction_error: float  # relative error of `reaction`


BONDED_CUBE = {
    ("coupled", 0.05): AtRest(0.34983, 12.5117, 2e-4, 2e-4),
    ("decoupled", 0.05): AtRest(0.34697, 12.3609, 2e-4, 2e-4),
    ("coupled", -0.01): AtRest(0.01957, -4.0473, 3e-4, 3e-4),
    ("decoupled", -0.01): AtRest(0.01962, -4.065, 3e-3, 3e-3),
    ("coupled", -0.02): AtRest(0.0836, -8.88, 4e-3, 7e-3),
    ("decoupled", -0.02): AtRest(0.08439, -9.05, 5e-3, 8e-3),
}
"""Reference values by form of the energy and increase of the distance of the plates [m]."""


class Indented(NamedTuple):
    """Strain energies [J], and forces along the displacement [N], of an indented body, each by linear and by quadratic
    tetrahedra."""

    energy: tuple[float, float]  # by linear, by quadratic tetrahedra [J]
    force: tuple[float, float]  # by linear, by quadratic tetrahedra [N]


def indented(body: Literal["cylinder", "heart"], nodes: int, share: float) -> Indented | None:
    """Return the finite-element reference for a body on the mesh with this number of nodes, at a share (0 to 1) of the full
    displacement of the indenter; None if this state was not computed.

    Neo-Hookean in the coupled form, Young's modulus 3000 Pa, Poisson's ratio 0.49.
    """
    table = finite_elements.read(f"indented_{body}")
    rows = np.flatnonzero((table["nodes"] == nodes) & np.isclose(table["share"], share))
    if not len(rows):
        return None
    first, second = (
        [float(table[f"{order}_{what}"][rows[0]]) for what in ("energy", "force")] for order in ("first", "second")
    )
    return Indented((first[0], second[0]), (first[1], second[1]))


START = 200  # places at which the search for the shape begins


def heavy_elastica(
    along: Array, length: float, rigidity: float, weight: float, stretching_stiffness: float = inf
) -> tuple[Array, Array]:
    """Return the horizontal and vertical distances from the clamp [m] of positions on the beam at rest.

    along: arc lengths of the positions from the clamp [m]; length: length L of the beam [m]; rigidity: bending rigidity D
    [J]; weight: weight q per unit area [Pa]; stretching_stiffness: EA per width [N/m].

    With the angle θ below the horizontal at the arc length s from the clamp, the length L, the bending rigidity D, the weight q
    per unit area and the stretching stiffness EA, all per width:

        D θ'' + (1 + e) q (L - s) cos θ = 0,    θ(0) = 0, θ'(L) = 0,    e = q (L - s) sin θ / EA,

    where e is the strain caused by the weight below s. Source: Rohde 1953, Q. Appl. Math. 11, 337, without e.
    """

    def change(s: Array, state: Array) -> Array:
        angle, bend = state[0], state[1]
        below = weight * (length - s)
        stretch = 1.0 + below * np.sin(angle) / stretching_stiffness
        return np.stack([bend, -stretch * below * np.cos(angle) / rigidity, stretch * np.cos(angle), stretch * np.sin(angle)])

    def ends(clamp: Array, tip: Array) -> Array:
        return np.array([clamp[0], tip[1], clamp[2], clamp[3]])

    s = np.linspace(0.0, length, START)
    found = solve_bvp(change, ends, s, np.zeros((4, START)), tol=1e-9)
    if not found.success:
        raise ValueError(f"no shape of the heavy elastica was found: {found.message}")
    shape = found.sol(along)
    return shape[2], shape[3]


class Layer(NamedTuple):
    """An elastic layer on a rigid base, into which a sphere is pressed (`at_contact`): Young's modulus [Pa], Poisson's
    ratio, thickness [m], and whether the layer is bonded to the base or free to slip."""

    young_modulus: float  # [Pa]
    poisson_ratio: float
    thickness: float  # [m]
    bonded: bool  # True: bonded to the base, False: free to slip

    def compliance(self, kh: Array) -> Array:
        """Return the factor L(kh): displacement of the face under a sinusoidal pressure of wave number k, divided by the
        displacement of a half-space (no unit)."""
        x = np.minimum(kh, 300.0)
        if not self.bonded:
            share: Array = 2.0 * np.sinh(x) ** 2 / (np.sinh(2.0 * x) + 2.0 * x)
            return share
        m = 3.0 - 4.0 * self.poisson_ratio
        held: Array = (2.0 * m * np.sinh(2.0 * x) - 4.0 * x) / (2.0 * m * np.cosh(2.0 * x) + 4.0 * x * x + 1.0 + m * m)
        return held


def at_contact(layer: Layer, radius: float, contact: float) -> tuple[float, float]:
    """Return the depth [m] to which a sphere of the radius `radius` [m] is pressed into a layer, and the force on the
    sphere [N], for a contact of the radius `contact` [m].

    Raises ValueError if the contact is wider than two thicknesses, which the quadrature does not resolve.
    """
    if contact > 2.0 * layer.thickness:
        raise ValueError(
            f"a contact radius of {contact:g} m is more than twice the thickness of "
            f"{layer.thickness:g} m, the limit of the reference solution"
        )
    nodes, weights = np.polynomial.legendre.leggauss(24)
    t, dt = 0.5 * contact * (nodes + 1.0), 0.5 * contact * weights
    t, dt = np.append(t, contact), np.append(dt, 0.0)  # φ at the rim as well
    waves, shares = np.polynomial.legendre.leggauss(200)
    end = 25.0 / layer.thickness
    k, dk = 0.5 * end * (waves + 1.0), 0.5 * end * shares
    cosines = np.cos(np.outer(t, k))
    kernel = 2.0 / pi * (cosines * ((layer.compliance(k * layer.thickness) - 1.0) * dk)) @ cosines.T
    modulus = layer.young_modulus / (pi * (1.0 - layer.poisson_ratio**2))
    sides = modulus * np.stack([np.ones_like(t), -(t**2) / radius], axis=1)
    per_depth, of_shape = np.linalg.solve(np.eye(len(t)) + kernel * dt, sides).T
    depth = -float(of_shape[-1] / per_depth[-1])
    return depth, 2.0 * pi * float(dt @ (depth * per_depth + of_shape))


def force(layer: Layer, radius: float, depth: float) -> float:
    """Return the force [N] on a rigid sphere of a radius [m] at a depth [m] in a layer; the depth must be small compared
    with the radius."""
    low, high = 0.0, sqrt(2.0 * radius * depth)  # a half-space has a = √(Rδ), a bed of springs √(2Rδ)
    for _ in range(45):
        contact = 0.5 * (low + high)
        low, high = (contact, high) if at_contact(layer, radius, contact)[0] < depth else (low, contact)
    return at_contact(layer, radius, 0.5 * (low + high))[1]
