"""Walls that supports define by a shape: fluids do not slip on the surface of the shape itself.

A support that clamps the nodes in a region holds those alone, and the fluid meets it at some place between the last held node
and the next one. Here the nodes near the surface are free, and get in each step the velocity of the wall and in addition the
tangential velocity δ of `pellucid.conditions.rigid.no_slip`: within the region in all directions, outside of it along the
surface. Distances are those of the shape itself, which does not move.

This requires B-splines and material points of viscous fluids with APIC, in a velocity field that they share at most with rigid
bodies, viscosity that is not implicit, and a support that holds all directions and does not end. Near a rigid body the nodes of
the region are held as in other cases, so that the body does not sink in.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.conditions.rigid.no_slip import DEGREES, LEAST_SLOPE, NoSlip, Surface, Window
from pellucid.energy import IMPACT, SUPPORT, StepWork
from pellucid.geometry.region import Region, within
from pellucid.geometry.shape import Shape
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.grid.actions import NodalActions
from pellucid.grid.momentum import MASS_EPS
from pellucid.grid.velocity_transfer import Apic
from pellucid.model import Vector
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.ranks.domain import domain

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

SMOOTH = (
    "quadratic-bspline",
    "cubic-bspline",
)  # with trilinear functions the flow in a pipe of four cells was too slow by half
SAMPLES = 4  # in a cell along each axis, of the share of a node that a region fills
MOST_PLACES = 1_000_000  # that are looked up at once
BISECTIONS = 40  # of the distance from the surface
RIGID_REACH = 2  # cells around the points of rigid bodies within which nodes stay held


class WallSurface(NamedTuple):
    """The surface of a region as seen from the nodes near it."""

    node: np.ndarray  # (n,) in order
    held: np.ndarray  # (n,) which of them the support holds
    surface: Surface
    window: Window
    samples: list[np.ndarray]  # two of (n, 3), where the fluid's velocity is read [m]


class NoSlipWall(ActiveCondition):
    """The wall of one support in one velocity field."""

    def __init__(
        self, actions: NodalActions, row: int, region: Geometry, rigid: Sequence[AssembledBody], assembly: Assembly
    ) -> None:
        """row: number of the support among those of the faces, from 0."""
        self._actions, self._row, self._rigid, self._layout = actions, row, rigid, assembly.layout
        self._field, grid = actions.field, actions.field.grid
        self._no_slip = NoSlip(grid)
        self._velocity = actions.supports.velocity[row]
        self._impulse = np.zeros(3)
        x, y, z = grid.thin
        self._wall = find_wall(self._no_slip, actions, row, region, (not x, not y, not z))
        self._marks = grid.nodes.constrained[self._wall.node].copy()
        self._acts = np.zeros(len(self._wall.node), bool)

    @property
    def acts_anywhere(self) -> bool:
        """Return True if the support holds nodes near the surface, and the surface ends at no face of the grid: there,
        pressure-driven flow in a pipe became too slow by more than half."""
        grid = self._field.grid
        at = (grid.find_positions(self._wall.node) - np.array(grid.lattice.lower)) / grid.lattice.cell
        on_face = (at < 0.5) | (at > np.array(grid.lattice.counts) - 0.5)
        return bool(self._wall.held.any() and not (on_face & ~np.array(grid.thin) & ~np.array(grid.periodic)).any())

    def begin(self, time: float, dt: float) -> None:
        """Let the nodes near the surface go, except near rigid bodies."""
        wall, constrained = self._wall, self._field.grid.nodes.constrained
        self._acts[:] = ~self._near_rigid()
        thin = np.array(self._field.grid.thin)
        lets_go = (wall.held & self._acts)[:, None] & ~thin
        constrained[wall.node] = np.where(lets_go, 0, self._marks)

    def _near_rigid(self) -> np.ndarray:
        """Return which nodes near the surface rigid bodies may reach, shape (n,)."""
        grid, reached = self._field.grid, np.zeros(len(self._wall.node), bool)
        cell, thin = grid.lattice.cell, np.array(grid.thin)
        periods = np.array(grid.periods)
        place = np.where(thin, 0.0, grid.find_positions(self._wall.node))
        for member in self._rigid:
            points = np.where(thin, 0.0, domain.whole(member.body.arrays["position"]))
            middle, half = 0.5 * (points.min(axis=0) + points.max(axis=0)), 0.5 * np.ptp(points, axis=0)
            off = place - middle
            off -= periods * np.round(off / np.where(periods > 0.0, periods, np.inf))
            close = np.flatnonzero(np.all(np.abs(off) <= half + RIGID_REACH * cell, axis=1))
            if not len(close):
                continue
            cells = np.unique(np.rint((points - middle) / cell).astype(int), axis=0)
            for k in close:
                reached[k] |= bool(np.any(np.all(np.abs(cells * cell - off[k]) <= (RIGID_REACH + 0.5) * cell, axis=1)))
        return reached

    def act_on_nodes(self, dt: float) -> None:
        """Give the nodes near the surface the velocity with which the fluid does not slip on it."""
        wall, nodes, no_slip = self._wall, self._field.grid.nodes, self._no_slip
        window, at = wall.window, wall.node
        mass, old = (
            domain.of_nodes(values, window.node)
            for values in (nodes.mass[window.node], nodes.velocity[window.node] - nodes.velocity_increment[window.node])
        )
        old = np.where(mass[:, None] > MASS_EPS, old, 0.0)
        (near, near_known), (far, far_known) = (no_slip.sample(window, old, mass, place) for place in wall.samples)
        certainty = wall.surface.certainty * near_known
        surface = wall.surface._replace(certainty=certainty)
        slip = no_slip.continue_profile(surface, near - self._velocity, far - self._velocity, far_known)
        missing = self._velocity + slip - domain.of_nodes(nodes.velocity[at], at)
        across = np.sum(missing * surface.normal, axis=1)[:, None] * surface.normal
        missing = np.where(wall.held[:, None], missing, certainty[:, None] * (missing - across))
        missing = np.where(self._acts[:, None], missing, 0.0)
        impulse = domain.of_nodes(nodes.mass[at], at)[:, None] * missing
        taken = domain.of_nodes(self._field.add_impulses(impulse, IMPACT, -1.0, at), at)
        held = at[wall.held & self._acts]
        nodes.strain_velocity[held] = nodes.velocity[held]
        self._impulse = taken.sum(axis=0)

    def work(self) -> StepWork:
        """Return the impulse of the wall and its work; the velocity field has counted them as external."""
        done = self._layout.no_work()
        done.reactions[self._row] += self._impulse
        done.impulse[:] -= self._impulse
        done.works[[SUPPORT, IMPACT]] += float(self._impulse @ self._velocity)
        return done


def no_slip_walls(supports: "Sequence[Support]", assembly: Assembly) -> list[NoSlipWall]:
    """Return the walls of supports, each on one face or none, in all velocity fields where fluids do not slip on them."""
    walls = []
    for actions in assembly.actions:
        members = [member for member in assembly.bodies.values() if member.actions is actions]
        rigid = [member for member in members if member.model.is_rigid]
        fluids = [member for member in members if not member.model.is_rigid]
        smooth = actions.field.grid.case.functions in SMOOTH
        if not (smooth and fluids and all(map(_is_viscous, fluids))):
            continue
        for row, support in enumerate(supports):
            shape = None if support.body is not None or support.until is not None else _shape_of(support)
            if shape is None or not support.holds_all():
                continue
            wall = NoSlipWall(actions, row, shape.geometry(), rigid, assembly)
            walls += [wall] if wall.acts_anywhere else []
    return walls


def _shape_of(support: "Support") -> Shape | None:
    region = support.region()
    return region.shape if isinstance(region, Region) and not region.needs_mesh else None


def _is_viscous(member: AssembledBody) -> bool:
    """Return True for material points of a fluid with viscosity that is part of its law, and APIC."""
    material = getattr(member.model, "material", None)
    viscous = getattr(material, "viscosity", 0.0) > 0.0 and not member.model.solves_viscosity
    return member.model.kind == "material-points" and viscous and isinstance(getattr(member.body, "transfer", None), Apic)


def find_wall(no_slip: NoSlip, actions: NodalActions, row: int, region: Geometry, active: ActiveAxes) -> WallSurface:
    """Return the nodes near the surface of a region that the support in a row holds, or that none holds."""
    grid = actions.field.grid
    periods = grid.periods
    cell, axes = grid.lattice.cell, np.flatnonzero(active)
    index, place = grid.where()
    order = np.argsort(index)
    index, place = index[order], place[order]
    marks = grid.nodes.constrained[index][:, axes]
    held, free = np.all(marks == row + 1, axis=1), np.all(marks == 0, axis=1)
    half = 0.5 * (DEGREES[grid.case.functions] + 1)
    inside = within(region, place, active, periods)
    mixed = np.zeros(len(place), bool)
    for steps in np.ndindex(*np.where(active, 5, 1)):
        by = np.where(active, np.array(steps) - 2, 0) * cell
        mixed |= within(region, place + by, active, periods) != inside
    chosen = np.flatnonzero(mixed & (held | free))
    filled, slope = _find_shares(no_slip, region, place[chosen], cell, half, active, periods)
    steepness = np.linalg.norm(slope, axis=1)
    keep = (steepness > LEAST_SLOPE) & (filled > 0.0) & (filled < 1.0)
    chosen, filled, slope, steepness = chosen[keep], filled[keep], slope[keep], steepness[keep]
    normal, most = -slope / steepness[:, None], half * cell * np.sqrt(len(axes))
    distance, found = _distances(region, place[chosen], normal, most, active, periods)
    # few samples fill nodes far outside: the normal is found again on the surface
    slope = _find_shares(no_slip, region, place[chosen] - distance[:, None] * normal, cell, half, active, periods)[1]
    normal = -slope / np.maximum(np.linalg.norm(slope, axis=1), LEAST_SLOPE)[:, None]
    distance, again = _distances(region, place[chosen], normal, most, active, periods)
    found &= again
    node = index[chosen]
    certainty = np.where(found, no_slip.certainty(filled, steepness), 0.0)
    window = no_slip.find_window(node)
    surface = Surface(distance, normal, certainty, no_slip.curvature_of(window, node, normal, certainty, distance))
    samples = [place[chosen] + (height - distance)[:, None] * normal for height in no_slip.heights]
    return WallSurface(node, held[chosen], surface, window, samples)


def _find_shares(
    no_slip: NoSlip, region: Geometry, place: np.ndarray, cell: float, half: float, active: ActiveAxes, periods: Vector
) -> tuple[np.ndarray, np.ndarray]:
    """Return the share of the volume of a node at each place that a region fills, (n,), and its slope, (n, 3) [1/cell].

    half: half of the width of the shape functions in cells.
    """
    axes = np.flatnonzero(active)
    offsets = (np.arange(-half * SAMPLES, half * SAMPLES) + 0.5) / SAMPLES
    weight, rise = no_slip.functions(offsets)
    lattice = np.stack(np.meshgrid(*(offsets if on else [0.0] for on in active), indexing="ij"), axis=-1).reshape(-1, 3)
    along, ones = [np.searchsorted(offsets, lattice[:, d]) for d in range(3)], np.ones(len(lattice))
    weights = [weight[along[d]] if active[d] else ones for d in range(3)]
    shares = np.prod(weights, axis=0) / SAMPLES ** len(axes)
    slopes = np.zeros((len(lattice), 3))
    for d in axes:  # seen from a sample, the place lies on the other side
        others = [weights[e] for e in range(3) if e != d]
        slopes[:, d] = -rise[along[d]] * np.prod(others, axis=0) / SAMPLES ** len(axes)
    filled, slope = np.zeros(len(place)), np.zeros((len(place), 3))
    at_once = max(1, MOST_PLACES // len(lattice))
    for k in range(0, len(place), at_once):
        these = place[k : k + at_once, None] + cell * lattice
        contains = within(region, these.reshape(-1, 3), active, periods).reshape(len(these), -1).astype(float)
        filled[k : k + at_once], slope[k : k + at_once] = contains @ shares, contains @ slopes
    return filled, slope


def _distances(
    region: Geometry, place: np.ndarray, normal: np.ndarray, most: float, active: ActiveAxes, periods: Vector
) -> tuple[np.ndarray, np.ndarray]:
    """Return the signed distances [m] of places from the surface of a region along normals, and whether it lies that near."""
    inside = within(region, place, active, periods)
    sign = np.where(inside, 1.0, -1.0)
    low, high = np.zeros(len(place)), np.full(len(place), most)
    found = within(region, place + (sign * high)[:, None] * normal, active, periods) != inside
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        same = within(region, place + (sign * middle)[:, None] * normal, active, periods) == inside
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return -sign * 0.5 * (low + high), found
