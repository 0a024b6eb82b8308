"""Contact by surfaces in the search for equilibria with a factored stiffness: tools that move from one load step to the next,
contact forces at trial positions, and their works."""

from collections.abc import Callable, Sequence
from functools import partial
from math import inf
from typing import TypeGuard

import numpy as np

from pellucid.bodies.own_nodes.body import ExplicitNodes
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.frozen import ContactSprings
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.energy import StepWork, no_work, total_work
from pellucid.parts.body import Body
from pellucid.parts.constraint import PlacedBySearch, PrescribesWhole
from pellucid.parts.elastic_system import BodySystem
from pellucid.simulation.free_tools import FreeTool, approach, coupling_to, stiffness_of
from pellucid.simulation.joint_system import JointSystem

EXACT, ROUGH = 5e-4, 5e-3  # overlaps that may remain, see `ContactSearch.overlap`, at a load step and on the way to it
STAYS = 3  # corrections in which an overlap that decreases falls to less than half
MANY, MEAN = 8, 4  # corrections after which forces are those of the mean of several detections, and the number of these
LONG = 10.0  # ratio of a displacement to the distance at which contact acts ahead of a surface, above which it does not count
NO_WORK = no_work(0, 0)
AHEAD = 0.8  # largest relative displacement of two surfaces in a step of the search, in the depths at which contact is seen


class ContactSearch:
    """Contact of bodies that deform with each other, with walls and with tools, i.e. bodies whose motion is prescribed, in load
    steps of a search for equilibria.

    contact: contact of the case; bodies: the bodies that deform, with their own nodes; tools: all other bodies; works_on_grid:
    function that returns the works of the bodies on the grid in the last step.
    """

    def __init__(
        self,
        contact: SurfacePairs,
        bodies: Sequence[ExplicitNodes],
        tools: Sequence[Body],
        works_on_grid: Callable[[], StepWork],
    ) -> None:
        self._contact, self._bodies, self._tools, self._works_on_grid = contact, bodies, tools, works_on_grid
        own = [body.contact_surface for body in bodies]
        self._on_trial = [surface for surface in contact.surfaces if any(surface is other for other in own)]
        self._time = self._dt = 0.0
        self._is_due = True  # True if contact is detected at the next trial positions
        self._corrections = 0  # in this search
        self._kept: list[dict[str, np.ndarray]] = []  # states of the tools at the last equilibrium
        self._begun = self.done = NO_WORK  # works of the tools under the forces of the last equilibrium
        """Works of the tools in the last step, from the forces at both ends, with the impulses at its end."""
        self._deepest = contact.deepest
        rigid = [(tool, law) for tool, law in _rigid(tools) if law.moves_freely()]
        surfaces = [(tool, law, touching_surface(tool, contact)) for tool, law in rigid]
        self.free_tools = [FreeTool(tool, law, surface) for tool, law, surface in surfaces if surface is not None]
        """Rigid bodies whose place the search finds along some axes."""
        self._rigid = [law for _, law in _rigid(tools)]
        self._free_surfaces = [tool.surface for tool in self.free_tools]
        self._places: list[np.ndarray] = []  # of the points of all surfaces at the last equilibrium [m]

    # tools

    def largest_step(self) -> float:
        """Return the largest step of the time of the loads [s] in which prescribed motions bring no two bodies closer than
        contact is seen."""
        speeds = sorted(getattr(body.constraint, "top_speed", 0.0) for body in [*self._tools, *self._bodies])
        fastest = sum(speeds[-2:])
        return AHEAD * self._deepest / fastest if fastest > 0.0 else inf

    def begin(self, start: float, dt: float, begin: Callable[[float], None], act: Callable[[float], None]) -> None:
        """Move the tools over a step dt [s] of the time of the loads that begins at `start` [s]; the other bodies stay, with
        the contact forces of the last equilibrium as loads. begin, act: as for `Clock.carry_out`."""
        self._time, self._dt = start + dt, dt
        self._kept = self._states()
        for body in self._bodies:
            body.place_surface()
        for surface in self._contact.surfaces:
            surface.begin()
        self._places = [surface.place.copy() for surface in self._contact.surfaces]
        self._contact.begin_search()
        self._contact.freeze(start, 0.0)
        for tool, pushed in zip(self.free_tools, self._contact.exert_on_trial([], 0.0, self._free_surfaces), strict=True):
            tool.pushed = pushed
        self._act(start, dt, begin, act, ends=False)
        for tool in self.free_tools:
            tool.begin(dt)
        self._contact.note_external_work()
        self._begun, self._is_due, self._corrections = self._works(), True, 0

    def _act(self, time: float, dt: float, begin: Callable[[float], None], act: Callable[[float], None], ends: bool) -> None:
        self.discard_loads()
        begin(dt)
        for law in self._rigid if ends else ():
            law.apply_kept_loads()
        for tool in () if ends else self.free_tools:
            tool.leave()
        self._set_velocities(moving=True)
        self._contact.begin(time, dt)
        for body in self._bodies:
            body.relax(0.0, 0.0, 0.0, body.motion.gravity_share)
        act(dt)

    def discard_loads(self) -> None:
        """Discard the loads on rigid bodies that conditions have added."""
        for law in self._rigid:
            law.discard_loads()

    def take_loads(self) -> None:
        """Take the loads on rigid bodies that conditions have added since `discard_loads` as those of the equilibrium that is
        sought."""
        for law in self._rigid:
            law.keep_loads()
        for tool in self.free_tools:
            tool.take_loads()

    def approach(self, renew: Callable[[], None], farthest: float) -> str | None:
        """Move rigid bodies that no contact holds along their loads until they touch another body. Returns the name of a body
        that touches none within a displacement `farthest` [m], or None. renew: function that computes the loads."""
        if not self.free_tools:
            return None
        found = approach(self.free_tools, AHEAD * self._deepest, farthest, renew, self._presses)
        for tool in self.free_tools:
            for surface, places in zip(self._contact.surfaces, self._places, strict=True):
                if surface is tool.surface:
                    places += tool.approached
        return None if found is None else found.body.name

    def _presses(self, tool: FreeTool) -> bool:
        self._contact.freeze(self._time, self._dt)
        return self._contact.presses(tool.surface) or self.left_out() is not None

    def joint(self, systems: Sequence[BodySystem]) -> JointSystem:
        """Return bodies and free rigid bodies as one system; systems: of the bodies, in their order."""

        def springs(body: int, tool: FreeTool) -> list[ContactSprings]:
            surface = self._bodies[body].contact_surface
            return [] if surface is None else self._contact.springs_of(surface, tool.surface)

        def stiffness(tool: FreeTool) -> np.ndarray:
            every = [each for body in range(len(self._bodies)) for each in springs(body, tool)]
            return stiffness_of(every)

        def coupling(body: int, tool: FreeTool, axis: int) -> np.ndarray:
            return coupling_to(springs(body, tool), axis, len(systems[body].rest))

        return JointSystem(systems, self.exert, self.free_tools, stiffness, coupling)

    def counts(self, body: Body) -> bool:
        """Return True if `done` includes the works of a body with its own nodes: a tool."""
        return any(body is tool for tool in self._tools)

    def _works(self) -> StepWork:
        """Return the works of the tools in the last step."""
        own = [tool.work() for tool in self._tools if isinstance(tool, ExplicitNodes)]
        on_grid = self._works_on_grid()
        return total_work([on_grid, *own], len(on_grid.works))

    def _set_velocities(self, moving: bool) -> None:
        for tool in self._tools:
            constraint: object = tool.constraint
            if isinstance(constraint, PrescribesWhole):
                constraint.set_velocities(moving)

    def _states(self) -> list[dict[str, np.ndarray]]:
        return [{name: array.copy() for name, array in tool.state_arrays().items()} for tool in self._tools]

    def end(self, begin: Callable[[float], None], act: Callable[[float], None]) -> None:
        """Compute reactions and works of the tools under the forces of the equilibrium that was found. The tools do not
        move. begin, act: as for `begin`."""
        there = self._states()
        self._act(self._time, self._dt, begin, act, ends=True)
        ended = self._works()
        self.done = ended._replace(works=0.5 * (self._begun.works + ended.works))
        for free in self.free_tools:
            free.add_work(self.done.works)
        self._restore(there)
        self._set_velocities(moving=False)
        for tool in self._tools:
            tool.renew_totals()

    def go_back(self) -> None:
        """Return to the last equilibrium, with the tools where they were."""
        self._restore(self._kept)
        self._contact.cancel_search()

    def _restore(self, states: Sequence[dict[str, np.ndarray]]) -> None:
        for tool, state in zip(self._tools, states, strict=True):
            tool.restore(state)

    # forces on the bodies

    def exert(self) -> None:
        """Add the contact forces at the present positions of the nodes to the loads of the bodies."""
        for body in self._bodies:
            body.place_surface()
        if self._is_due:
            self._contact.freeze(self._time, self._dt, MEAN if self._corrections > MANY else 1)
            self._is_due = False
        sums = self._contact.exert_on_trial(self._on_trial, self._dt, self._free_surfaces)
        for tool, pushed in zip(self.free_tools, sums, strict=True):
            tool.pushed = pushed

    def springs_of(self, body: ExplicitNodes) -> list[ContactSprings]:
        """Return the springs of the last contact forces on a body."""
        return [] if body.contact_surface is None else self._contact.springs_of(body.contact_surface)

    def correct(self) -> None:
        """Request also new distances ahead of the surfaces at which contact acts, so that less overlap remains."""
        self._contact.renew_leads()
        self._is_due = True
        self._corrections += 1

    def overlap(self, displacement: float) -> float:
        """Return the mean overlap before the last correction, relative to a length: the largest `displacement` of the bodies
        [m], but at most `LONG` times the mean distance at which contact acts ahead of the surface."""
        overlap, lead = self._contact.mean_overlap()
        length = min(displacement, LONG * lead)
        return overlap / length if overlap > 0.0 and length > 0.0 else overlap

    def is_exact(self, overlaps: Sequence[float], on_the_way: bool) -> bool:
        """Return True if no more corrections are needed, from the results of `overlap` so far: the overlap is small, or it does
        not decrease because the corners of the surface cannot follow the other one. on_the_way: True before the end of a load
        step."""
        last = overlaps[-1]
        stays = len(overlaps) > STAYS and last > 0.5 * overlaps[-1 - STAYS]
        return (stays and len(overlaps) > 2 * MANY) or last <= (ROUGH if on_the_way or stays else EXACT)

    def jump(self, judged: Callable[[], float]) -> float:
        """Return the residual forces at the present positions with contact detected again there: by how much the forces jump.
        judged: function that attempts these positions and returns the residual forces relative to all forces."""
        return self._contact.jump(self._time, self._dt, judged)

    def accept(self) -> None:
        """Take the state of the last trial as the reference for friction and initial overlaps."""
        self._contact.store_friction()

    def left_out(self) -> str | None:
        """Return, as text, two rigid bodies, or a rigid body and a wall, that overlap at the positions of the last detection
        although no contact between them is computed; None if there are none."""
        found = self._contact.left_out() if self.free_tools else []
        return " and ".join(found[0]) if found else None

    def leave(self) -> None:
        """Prepare contact for a relaxation."""
        self._contact.end_search()

    def moved_too_far(self) -> bool:
        """Return True if a point near another body moved farther since the last equilibrium, relative to this body, than
        contact is seen: it may have passed through the body unseen."""
        pairs = list(zip(self._contact.surfaces, self._places, strict=True))
        ends = [(np.concatenate([place, surface.place]), surface.place - place) for surface, place in pairs]
        for one, (places, moved) in enumerate(ends):
            for other, (others, followed) in enumerate(ends):
                if one == other or pairs[one][0].is_hard:
                    continue
                near, beside = (_are_near(a, b, self._deepest) for a, b in ((places, others), (others, places)))
                if near.any() and beside.any():
                    apart = np.linalg.norm(moved[near] - followed[beside].mean(axis=0), axis=1)
                    if apart.max() > self._deepest:
                        return True
        return False


def _are_near(places: np.ndarray, others: np.ndarray, distance: float) -> np.ndarray:
    """Return a mask of the points that are at the start or the end within a distance [m] of the box about other points; places,
    others: positions of both at the start and at the end, shape (2 n, 3) [m]."""
    inside = (places > others.min(axis=0) - distance) & (places < others.max(axis=0) + distance)
    return np.asarray(inside.all(axis=1).reshape(2, -1).any(axis=0))


def _rigid(tools: Sequence[Body]) -> list[tuple[Body, PlacedBySearch]]:
    """Return the rigid bodies among tools, with the objects that move them."""
    pairs: list[tuple[Body, object]] = [(tool, tool.constraint) for tool in tools]
    return [(tool, law) for tool, law in pairs if isinstance(law, PlacedBySearch)]


def touching_surface(body: Body, contact: SurfacePairs | None) -> ContactSurface | None:
    """Return the surface by which a body takes part in the contact of the case, or None."""
    own: ContactSurface | None = getattr(body, "contact_surface", None)
    return own if contact is not None and any(own is other for other in contact.surfaces) else None


def must_touch(bodies: Sequence[Body], contact: SurfacePairs | None) -> Body | None:
    """Return a rigid body that is free to move but takes no part in the contact of the case, so that nothing could balance
    its loads; None if there is none."""
    return next((body for body, law in _rigid(bodies) if law.moves_freely() and touching_surface(body, contact) is None), None)


def deforms(body: Body) -> TypeGuard[ExplicitNodes]:
    """Return True for a body with its own nodes that not all follow prescribed motions."""
    return isinstance(body, ExplicitNodes) and not body.follows


def contact_search(
    contact: SurfacePairs, bodies: Sequence[Body], systems: Sequence[BodySystem], works_on_grid: Callable[[], StepWork]
) -> ContactSearch:
    """Return the contact of the bodies of a case, and pass it to the systems of those that deform; works_on_grid: as for
    `ContactSearch`."""
    own = [body for body in bodies if deforms(body)]
    search = ContactSearch(contact, own, [body for body in bodies if not deforms(body)], works_on_grid)
    for body, system in zip(own, systems, strict=True):
        system.take_contact(search.exert, partial(search.springs_of, body))
    return search
