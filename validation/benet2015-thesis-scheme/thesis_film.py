"""The scheme of Benet 2015, chapters 4 to 6, for closed curves in the plane: kept for the record, as it fails in translation.

An extension of pellucid: a case that names this file knows the kind `thesis-film`, a fluid film that moves by it; `accuracy` is
then the normal motion of a step, of the least distance of nodes.

Tangential and normal velocities are interpolated apart, and the balances along the curve and across it, ∂σ/∂s + b_t = 0 and
b_n = κ σ, hold in windows about the nodes with cubic splines as weights (eqs. 6.7, 6.34-6.38). The geometry is frozen within a
step, but for the pressure that the density of its end gives (eq. 6.13). Both balances constrain one rate of strain,
q = ∂v_t/∂s + κ v_n, so that the system of equations has about half of the rank that it should: it is solved by least squares,
with the least velocity, in which tangential motion costs more, so that v_n is that of eq. 6.67. Nodes follow the velocity of
the centre of mass and what of the rest is normal (eqs. 6.58-6.61); by what is tangential, mass flows from segment to segment,
with the density upstream.
"""

from collections.abc import Callable, Iterator
from math import ceil
from typing import Literal, NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.balance import FIRST_SHARE, Driving, FilmBalance, StepDone, is_still, too_thin
from pellucid.bodies.fluid_film.body import FluidFilm
from pellucid.bodies.fluid_film.curve import Curve, segment_functions
from pellucid.bodies.fluid_film.film_geometry import Operators
from pellucid.bodies.fluid_film.forces import in_space
from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.errors import CaseError, Problem
from pellucid.extend import register
from pellucid.findings import Finding, Path
from pellucid.parts.body import Body, Placement
from pellucid.parts.capabilities import SurfacePoints
from pellucid.parts.part import Parts

GAUSS = 4  # points of a segment, as in figure 6.4
TANGENTIAL = 0.01  # of the scale of a tangential velocity to that of a normal one that counts as much
RANK = 0.01  # of the largest singular value: less has none


class Places(NamedTuple):
    """The curve at the quadrature points, shape (n, GAUSS, ...)."""

    normal: np.ndarray  # outward
    tangent: np.ndarray  # counterclockwise
    length: np.ndarray  # ds by the parameter of a segment [m]
    curvature: np.ndarray  # κ [1/m]
    strain: np.ndarray  # (n, GAUSS, 2, m) of the rate q by tangential and by normal velocities of the nodes about [1/m]


class ThesisSteps:
    """Moves a film: its `x`, `v`, `part_mass` and `own_step` among these arrays.

    accuracy: normal motion of a step, of the distance of nodes.
    """

    def __init__(self, balance: FilmBalance, curve: Curve, accuracy: float, arrays: dict[str, np.ndarray]) -> None:
        self._balance, self._curve, self._accuracy, self._arrays = balance, curve, accuracy, arrays
        point, weight = np.polynomial.legendre.leggauss(GAUSS)
        point, self._weight = 0.5 * (1.0 + point), 0.5 * weight
        self._value, self._first, self._second = segment_functions(curve.radial, point)
        (first, first_slope), (second, second_slope) = _spline(point), _spline(1.0 - point)
        self._tests = ((first, first_slope), (second, -second_slope))  # of the nodes at both ends of a segment
        self.fault: str | None = None

    def over(self, dt: float, elapsed: float, driving: Driving, count: Callable[[StepDone, float], None]) -> Operators:
        """See `pellucid.bodies.fluid_film.balance.OwnSteps`."""
        arrays, left = self._arrays, dt
        own = float(arrays["own_step"][0]) or FIRST_SHARE * dt
        while left > 0.0 and self.fault is None:
            done, apart, centre = self._motion(own, driving._replace(after=dt - left))
            moved = max(float(np.abs(apart[:, 1]).max()), float(np.linalg.norm(centre)))
            far = self._accuracy * float(self._curve.spacing(arrays["x"]).min())
            own = min(far / moved, dt) if moved > 0.0 else dt
            span = left / ceil(left / own * (1.0 - 1e-12))
            left -= span
            if is_still(done, span):
                arrays["v"][:] = 0.0
                count(done.at_rest, span)
                continue
            self._take(done, apart, centre, span)
            count(done, span)
            if not np.isfinite(arrays["x"]).all():
                self.fault = "moves without bound: its nodes have no finite place"
                break
            self.fault = too_thin(self._balance, arrays, self._curve.operators(arrays["x"]))
        arrays["own_step"][0] = own
        return self._curve.operators(arrays["x"])

    def velocities_now(self, dt: float, elapsed: float, driving: Driving) -> np.ndarray:
        """See `pellucid.bodies.fluid_film.balance.OwnSteps`."""
        span = FIRST_SHARE * dt
        done = self._motion(span, driving._replace(after=0.0))[0]
        return np.zeros_like(done.velocity) if is_still(done, span) else done.velocity

    def _motion(self, ahead: float, driving: Driving) -> tuple[StepDone, np.ndarray, np.ndarray]:
        """The motion now; tangential and normal velocities beside that of the centre of mass [m/s], shape (n, 2), and this.

        ahead: the time over which the pressure changes [s].
        """
        x, mass, material, physics = self._arrays["x"], self._arrays["part_mass"], self._balance.material, self._balance.physics
        at, n, nodes = self._places(x), len(x), self._curve.nodes
        area = at.length * self._weight
        density = mass / area.sum(axis=1)
        pressure, stiffness = material.pressure(density), density * material.pressure_slope(density)
        viscosity = 2.0 * physics.viscosity + physics.dilatational_viscosity
        loads = self._loads(x, at, density, driving)
        load = sum((force for _, force in loads), np.zeros_like(at.normal))
        across, along = (np.einsum("eqi,eqi->eq", load, way) for way in (at.normal, at.tangent))
        matrix, right = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
        columns = np.concatenate([nodes, n + nodes], axis=1)
        for end, (test, slope) in enumerate(self._tests):
            node = (np.arange(n) + end) % n
            tangential, normal = -slope * self._weight * np.ones((n, 1)), -at.curvature * area * test
            for row, weight, force in ((node, tangential, along), (n + node, normal, across)):
                resisted = np.einsum("eq,eqcm->ecm", weight * (viscosity + ahead * stiffness)[:, None], at.strain)
                np.add.at(matrix, (row[:, None], columns), resisted.reshape(n, -1))
                np.add.at(right, row, (weight * pressure[:, None] - area * test * force).sum(axis=1))
        matrix[:, :n] *= TANGENTIAL
        found = np.linalg.lstsq(matrix, right, rcond=RANK)[0].reshape(2, n)
        found[0] *= TANGENTIAL

        normals = self._curve.normals(x)
        ways = np.stack([np.stack([-normals[:, 1], normals[:, 0]], axis=1), normals], axis=1)
        velocity = np.einsum("cn,nci->ni", found, ways)
        of_nodes = 0.5 * (mass + np.roll(mass, 1))
        centre = of_nodes @ velocity / of_nodes.sum()
        apart = np.einsum("nci,ni->nc", ways, velocity - centre)
        rate = np.einsum("eqcm,cem->eq", at.strain, found[:, nodes])
        between = np.einsum("qm,emi->eqi", self._value, velocity[nodes])
        powers = [(column, float(np.einsum("eq,eqi,eqi->", area, force, between))) for column, force in loads]
        none = np.zeros_like(x)
        heat = float(np.sum(area * viscosity * rate**2))
        return StepDone(x, velocity, 0.0, powers, heat, 0.0, none, none, 0.0), apart, centre

    def _take(self, done: StepDone, apart: np.ndarray, centre: np.ndarray, dt: float) -> None:
        """The state after a step dt [s]."""
        arrays, normals = self._arrays, self._curve.normals(self._arrays["x"])
        mass = arrays["part_mass"]
        density = self._balance.densities(self._curve.operators(arrays["x"]), mass)
        upstream = np.where(apart[:, 0] > 0.0, np.roll(density, 1), density)
        flow = dt * apart[:, 0] * upstream
        mass += flow - np.roll(flow, -1)
        arrays["x"] += dt * (centre + apart[:, 1:] * normals)
        arrays["v"][:] = done.velocity

    def _places(self, x: np.ndarray) -> Places:
        about = x[self._curve.nodes]
        along, bend = (np.einsum("qm,emi->eqi", functions, about) for functions in (self._first, self._second))
        length = np.linalg.norm(along, axis=2)
        tangent = along / length[..., None]
        normal = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
        curvature = -np.einsum("eqi,eqi->eq", normal, bend) / length**2
        strain = np.stack([self._first / length[..., None], curvature[..., None] * self._value], axis=2)
        return Places(normal, tangent, length, curvature, strain)

    def _loads(self, x: np.ndarray, at: Places, density: np.ndarray, driving: Driving) -> list[tuple[int, np.ndarray]]:
        """Loads on unit of area at the quadrature points [Pa], shape (n, GAUSS, 2), with the columns of their works."""
        axes, nodes = list(self._curve.axes), self._curve.nodes
        place = np.einsum("qm,emi->eqi", self._value, x[nodes])
        ratio = np.broadcast_to((density / self._balance.initial_density)[:, None], at.length.shape)
        points = SurfacePoints(in_space(place, axes), in_space(at.normal, axes), ratio)
        loads = [(acting.column, acting.traction(points, driving.after)[..., axes]) for acting in driving.tractions]
        of_segments = (at.length * self._weight).sum(axis=1)
        of_nodes = 0.5 * (of_segments + np.roll(of_segments, 1))
        for column, force in driving.forces:
            loads.append((column, np.einsum("qm,emi->eqi", self._value, (force / of_nodes[:, None])[nodes])))
        return loads


class ThesisFilm(FluidFilm):
    """A film that cannot hold or lead nodes."""

    def complete(self) -> None:
        """Raises CaseError where something does."""
        super().complete()
        if self._held.prescribed()[0].any() or (self._held.numbers > 0).any():
            text = "this scheme cannot hold or lead nodes, and a support or motion does"
            raise CaseError(
                Problem(text, f"body.{self.name}.kind", remedy='use "fluid-film", or leave out the support or motion')
            )


@register
class ThesisFilmCase(FluidFilmCase):
    """A film that moves by this scheme."""

    kind: Literal["thesis-film"] = "thesis-film"  # type: ignore[assignment]

    def steps(self, balance: FilmBalance, goals: object, arrays: dict[str, np.ndarray]) -> ThesisSteps:  # type: ignore[override]
        """What moves it; arrays: its state."""
        return ThesisSteps(balance, balance.geometry, self.accuracy, arrays)

    def build(self, placement: Placement) -> Body:
        """The body."""
        return ThesisFilm(self, placement)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """What the thesis does not have."""
        yield from super().problems(path, parts)
        beyond = {
            "surfaces: it is for closed curves in the plane": self.shape.span != "plane",
            "drag": self.has_drag,
            "bending": self.material.bending_rigidity > 0.0,
            "given volume or area": self.volume is not None or self.area == "kept",
            'nodes that go with the material: they move along the normal (nodes = "even" stands for that)': self.nodes
            == "material",
            "time_weight": self.time_weight != 0.5,
        }
        if lacks := next((what for what, is_there in beyond.items() if is_there), None):
            text = f"the scheme of the thesis has no {lacks}"
            yield Finding((*path, "kind"), text, 'leave that out, or use "fluid-film"')


def _spline(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The cubic spline that ends at a distance 1 and its slope, at distances s from 0 to 1."""
    near = s < 0.5
    value = np.where(near, 2.0 / 3.0 - 4.0 * s**2 + 4.0 * s**3, 4.0 / 3.0 * (1.0 - s) ** 3)
    return value, np.where(near, -8.0 * s + 12.0 * s**2, -4.0 * (1.0 - s) ** 2)
