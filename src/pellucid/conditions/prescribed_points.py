"""Prescribed motions of points in a run: they constrain the points of a body, and the nodes to which these points
contribute."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.conditions import driven_points
from pellucid.energy import IMPACT, MOTION, StepWork
from pellucid.errors import CaseError, Problem
from pellucid.findings import Finding, Reason, refuse
from pellucid.geometry.region import chosen_nodes, faults
from pellucid.geometry.shapes.rotation import Turn
from pellucid.grid.passes.moving import move_points_jointly, moving
from pellucid.grid.sorting import MOST_SLABS
from pellucid.grid.transfer import scatter_listed_numbers
from pellucid.jit.bundle import Bundle
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import TakesMotions, TakesNormalMotions
from pellucid.parts.constraint import LeadsPoints, RepeatedConstraint, RigidRates
from pellucid.parts.families import GridBody
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.prescribed_motion import Motion

ROUNDING = 1e-9  # relative to a mass: smaller remainders are rounding


def marked(member: AssembledBody, motions: "Sequence[Motion]") -> np.ndarray:
    """Return 1 + the index in `motions` of the motion that each point of the body follows, 0 if there is none, shape (n,),
    in storage order. Raises CaseError if the parts of two motions overlap or a part contains no point."""
    body, of = member.body, member.selectable()
    driven = np.zeros(len(of.position), np.int64)
    for number, motion in enumerate(motions, start=1):
        inside = np.ones(len(driven), bool)
        if motion.part is not None:
            refuse(faults(motion.part, of, ("motion", motion.name, "part"), body.name, member.active_axes))
            inside = chosen_nodes(motion.part, of, member.active_axes)
        if driven[inside].any():
            other = motions[int(driven[inside].max()) - 1].name
            text = f"some points of body {body.name} already follow the motion {other}"
            raise CaseError(Problem(text, f"motion.{motion.name}.part", remedy="choose parts of a body that do not overlap"))
        driven[inside] = number
    return driven


class PrescribedPoints(StepPart, RepeatedConstraint, LeadsPoints):
    """Prescribed motions of one body.

    Arrays of the body: `driven`, the index of a point's motion plus one, or 0; `start`, the initial position of a point
    [m]. On the grid, the nodes around points with a prescribed motion are constrained, so that other points and contact
    do not move them.
    """

    by_slabs = True
    """True, since the points of a slab are updated independently of other points, in loops that bodies share
    (`pellucid.jit.loops`)."""

    def __init__(self, member: AssembledBody, motions: "Sequence[Motion]", assembly: Assembly) -> None:
        body, thin, self._layout = member.body, member.thin, assembly.layout
        self.body, self._points = body, body.on_grid
        self.names = [motion.name for motion in motions]
        self._functions = [motion.functions() for motion in motions]
        self.top_speed = max((motion.top_speed() for motion in motions), default=0.0)
        self._nodes = Bundle(member.actions.driven()) if member.actions else None
        self._velocity, self._displacement = np.zeros((len(motions), 3)), np.zeros((len(motions), 3))
        self._axes = np.zeros((len(motions), 3), np.int64)
        self._taken = np.zeros((MOST_SLABS, driven_points.IMPULSE + 3 * len(motions)))
        for number, functions in enumerate(self._functions):
            self._axes[number, list(functions)] = 1
        of_points = np.zeros(body.n_points, np.int64)  # in the order of the point numbers
        of_points[body.stored_array("id")] = marked(member, motions)
        driven = of_points[body.arrays["id"]]
        body.arrays["driven"], body.arrays["start"] = driven, body.arrays["position"].copy()
        motion_arrays = self._velocity, self._displacement, self._axes
        drive = driven_points.DrivenPoints(driven, body.arrays["start"], *motion_arrays, self._taken)
        self._bundle = Bundle(drive)
        self._leading = moving(body.on_grid.mapped.content, drive) if body.on_grid is not None else None
        # a body that is driven as a whole along every axis is rigid: the nodes about it do not strain it
        self.strains = not (self._axes[:, ~np.array(thin)].all() and (of_points > 0).all())
        # points on the grid follow by this constraint alone
        self._released, self._released_mass = np.zeros(0, np.int64), np.zeros((0, 3))
        self._own_nodes = None if isinstance(body, GridBody) else member.offers(TakesMotions)
        if self._own_nodes is not None:
            self._own_nodes.add_motions(self.names, driven, self._axes)
        body.constrain(self)

    def begin(self, time: float, dt: float) -> None:
        """Set the mean velocities over a step dt [s] from `time` [s], so that the points end exactly at the prescribed
        displacements; zero if dt is 0."""
        for number, functions in enumerate(self._functions):
            for axis, function in functions.items():
                reached = function(time + dt)
                self._displacement[number, axis] = reached
                self._velocity[number, axis] = (reached - function(time)) / dt if dt > 0.0 else 0.0
        if self._own_nodes is not None:
            self._own_nodes.set_motion_velocities(self._velocity)
        if self._points is not None and self._nodes is not None:
            self._velocity *= self.body.load_rate  # points and nodes of the grid go by the time of the step
            driven_points.constrain_nodes(self._points.n_slabs, self._points.mapped, self._bundle, self._nodes)
            self._release(self._nodes.content.mass)

    def rows(self) -> np.ndarray:
        """Return 1 + the index of the motion that each point follows along each axis, 0 if it is free, shape (n, 3), in
        storage order."""
        driven = self.body.arrays["driven"]
        axes = np.concatenate([np.zeros((1, 3), np.int64), self._axes])
        return np.asarray(axes[driven] * driven[:, None])

    def placement(self) -> Turn:
        moved = self.body.stored_array("position")[:1] - self.body.stored_array("start")[:1]
        return Turn(np.eye(3), np.zeros(3), moved[0])

    def prescribed_rates(self) -> RigidRates:
        return RigidRates(self._velocity[0], np.zeros(3), np.zeros(3))

    def set_velocities(self, moving: bool) -> None:
        rows = np.concatenate([np.zeros((1, 3)), self._velocity])[self.body.arrays["driven"]]
        self.body.arrays["velocity"][...] = rows if moving else 0.0

    def shares(self, impulse: np.ndarray) -> tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]:
        return {self.names[0]: self._axes[0] * impulse[:3]}, {}

    def release_nodes(self, nodes: np.ndarray) -> None:
        """Exclude nodes of the grid (numbers, shape (k,)) from the constraint by points with a prescribed motion. Only
        contributions of points at their current positions are excluded, so that these points must stay at rest."""
        if self._points is None or self._nodes is None:
            return
        rows, arrays = self.rows() > 0, self.body.arrays
        listed = np.flatnonzero(rows.any(axis=1))
        shares = np.zeros_like(self._nodes.content.mass)
        values = arrays["mass"][listed, None] * rows[listed]
        scatter_listed_numbers(self._points.mapped, arrays["position"], listed, values, shares)
        self._released, self._released_mass = nodes, shares[nodes]

    def _release(self, driven_mass: np.ndarray) -> None:
        left = driven_mass[self._released] - self._released_mass
        driven_mass[self._released] = np.where(left > ROUNDING * self._released_mass, left, 0.0)

    def prescribe_velocities(self) -> None:
        """Set the prescribed velocities of the points, and record the impulses that change the velocities of the points and
        of the nodes around them."""
        if self._points is not None:
            self._taken.fill(0.0)
            driven_points.prescribe_velocities(self._points.n_slabs, self._points.mapped, self._bundle, self._nodes)

    def prescribe_velocities_again(self) -> None:
        """Set the prescribed velocities again after the second of two contact stages of a step, and record the further
        impulses."""
        taken = self._taken.copy()
        self.prescribe_velocities()
        self._taken += taken

    def prescribe_positions(self) -> None:
        """Set the positions of the points that the motions prescribe at the end of the step."""
        if self._leading is not None:
            move_points_jointly(self._leading, 0.0)

    def work(self) -> StepWork:
        """Return work and impulses of the motions; zeros for a body with its own nodes, which records them itself."""
        done = self._layout.no_work()
        if self._points is None:
            return done
        taken = ordered_sum(domain.complete(self._taken[: self._points.n_slabs]))
        done.works[MOTION], done.works[IMPACT] = taken[driven_points.WORK], taken[driven_points.LOSS]
        impulses = taken[driven_points.IMPULSE :].reshape(-1, 3)
        return done._replace(motions=dict(zip(self.names, impulses, strict=True)))


class NormalMotions(StepPart):
    """Prescribed displacements of nodes of one fluid film along the normal of the film. The film itself records the work
    and the impulses of these displacements."""

    def __init__(self, member: AssembledBody, motions: "Sequence[Motion]") -> None:
        self._functions = [motion.along_normal() for motion in motions]
        numbers = marked(member, motions)
        if reason := why_no_normal_motion(member.model, whole=bool((numbers > 0).all())):
            refuse([Finding(("motion", motions[0].name, "displacement"), *reason)])
        self._body = member.offers(TakesNormalMotions)
        self._body.add_normal_motions([motion.name for motion in motions], numbers)

    def begin(self, time: float, dt: float) -> None:
        """Set the mean normal velocities over a step dt [s] from `time` [s], so that the nodes end exactly at the prescribed
        displacements."""
        self._body.set_normal_velocities(np.array([(of(time + dt) - of(time)) / dt for of in self._functions]))


def why_no_normal_motion(body: BodyModel, whole: bool) -> Reason | None:
    """Return the reason why nodes of the body (all of them if `whole`) cannot follow a prescribed motion along their normal,
    or None."""
    if not isinstance(body, FluidFilmCase):
        return Reason(f"body {body.name} is not a fluid film", "prescribe the displacement along x, y or z")
    if body.is_shared:
        text = f"the fluid around film {body.name} moves its nodes, so their motion cannot be prescribed"
        return Reason(text, "remove this motion")
    if not whole or (body.volume is None and body.area == "free"):
        return None
    held = "area" if body.volume is None else "volume"
    text = f"the motion prescribes all nodes of film {body.name}, whose {held} is already prescribed"
    return Reason(text, f"remove `{held}` of the film, or prescribe only a `part` of it")
