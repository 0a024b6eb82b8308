"""Pairs of velocity fields in contact: where they touch, what impulses they give each other, and the work of these."""

from collections.abc import Collection, Iterator, Sequence
from itertools import chain
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.contact import impulse_works, impulses
from pellucid.contact.contact_body import ContactBody
from pellucid.contact.detection import ContactDetection
from pellucid.energy import CONTACT, FIRST_LOAD, StepWork, no_work, row_length, step_work, total_work
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle
from pellucid.reductions import ordered_sum

SWEEPS = 4  # where several pairs share nodes, the impulses of one change the approach of another
ANSWERS = 32  # times at most that bodies whose motion is not that of the grid answer to impulses,
SETTLED = 1e-3  # unless what changes is this share of all
SIGNS = 1.0, -1.0  # of the impulses on the first side and on the second


class ContactPair:
    """Two velocity fields and how they touch; `name`: what a probe calls the impulse on the first of them.

    kind: STICK or SLIP of `pellucid.contact.impulses`; friction: coefficient μ.
    """

    def __init__(
        self,
        fields: tuple[VelocityField, VelocityField],
        bodies: tuple[Sequence[ContactBody], Sequence[ContactBody]],
        kind: int,
        friction: float = 0.0,
        name: str | None = None,
    ) -> None:
        self.name, self._kind, self._friction = name, kind, friction
        self.detection = ContactDetection(fields, bodies)
        self.fields, self.bodies = fields, bodies
        self._sides = [Bundle(impulses.Side(field.grid.nodes, field.external, field.moves_points)) for field in fields]
        self._second_sides = [Bundle(side._replace(moves_points=False)) for side in self._sides]  # the bodies count theirs
        self._mobility, self._closing, self._gap_closing = np.zeros((2, 0, 3)), np.zeros(0), np.zeros(0)
        self.impulses, self.second = np.zeros((2, 0, 3))
        """On the first side at each node of `detection` in this step [N s], shape (n, 3); and what stopped the approach of the
        velocities mapped again."""
        self.touches = False
        """Anywhere, in this step."""

    @property
    def _chunks(self) -> int:
        return len(self.impulses) // impulses.CHUNK + 1

    @property
    def _takes_second(self) -> bool:
        return all(body.takes_second_impulses for side in self.bodies for body in side)

    def detect(self, dt: float) -> None:
        """Find where the velocity fields touch in a step dt [s], after the bodies' mass was mapped to the nodes."""
        self.detection.find()
        n = len(self.detection.node)
        self.touches = bool(self.detection.normal.any())
        self._mobility, self.impulses, self.second = np.zeros((2, n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        self._closing = self._gap_closing = self.detection.room / dt if dt > 0.0 else np.zeros(n)
        if not self.touches:
            return
        impulses.measure_mobility(self._chunks, self.detection.node, *self._sides, self._mobility)

    def touching(self) -> Iterator[tuple[ContactBody, np.ndarray]]:
        """The bodies of both velocity fields, each with the nodes at which these touch, shape (n,)."""
        closed = (self.detection.room == 0.0) | self.impulses.any(axis=1)
        nodes = self.detection.node[self.detection.normal.any(axis=1) & closed]
        return ((body, nodes) for side in self.bodies for body in side)

    def measure_again(self) -> None:
        """What nodes can move, where walls may have let them go as they were advanced."""
        if self.touches and any(field.may_be_let_go for field in self.fields):
            impulses.measure_mobility(self._chunks, self.detection.node, *self._sides, self._mobility)

    def let_return(self) -> None:
        """Let bodies that part as the step begins come back as fast, when their momentum was advanced: their mean approach over
        the step is nothing then, and the impulses do no work. Stopped earlier, they would win energy at each such return. Not
        bodies that answer to impulses themselves: the velocities of their nodes are not those with which their material parts.
        """
        if not (self.touches and self._takes_second):
            return
        where = self.detection.node, self._mobility, self.detection.normal
        self._closing = np.empty(len(self.detection.node))
        impulses.measure_parting(self._chunks, *self._sides, *where, self._gap_closing, self._closing)

    def _moved(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """What impulses change of the nodes of both sides."""
        nodes = [field.grid.nodes for field in self.fields]
        return [(side.velocity, side.velocity_increment, side.strain_velocity) for side in nodes]

    def resolve(self, anew: bool) -> None:
        """Impulses on the nodes after their momentum was advanced, or `anew` after the bodies answered to these."""
        if not self.touches:
            return
        how = self._kind, self._friction, anew, self.detection.node, (self.detection.normal, self._closing)
        impulses.resolve(self._chunks, *how, *self._moved(), *self._mobility, self.impulses)
        if self.impulses.any():
            for field in self.fields:
                field.pressed = True

    def give(self, impulse: np.ndarray) -> None:
        """Impulses on the first side and against the second [N s], shape (n, 3), beside those so far."""
        impulses.give(self._chunks, self.detection.node, impulse, *self._moved(), *self._mobility, self.impulses)

    def in_contact(self) -> list[ContactBody]:
        """The bodies of both velocity fields, where these touch anywhere."""
        return [body for side in self.bodies for body in side] if self.touches else []

    def project(self) -> None:
        """The same for the velocities mapped again, those that strain the points."""
        if not self.touches:
            return
        how = self._kind, self._friction, self.detection.node, (self.detection.normal, self._gap_closing)
        sides = [field.grid.nodes.strain_velocity for field in self.fields]
        impulses.stop_approach(self._chunks, *how, *sides, *self._mobility, self.second)

    def gives_second(self) -> bool:
        """Whether there are such impulses, which all bodies take; else none does, since they are equal and opposite."""
        return self.touches and self._takes_second and bool(self.second.any())

    def add_second(self) -> None:
        """Add what these change to the second increments of both fields."""
        for field, mobility, sign in zip(self.fields, self._mobility, SIGNS, strict=True):
            field.add_second_increments(self.detection.node, sign * mobility * self.second)

    def second_works(self, row: int) -> np.ndarray:
        """Of these impulses on constrained nodes alone; see `works`."""
        return self._works(self._second_sides, self.second, row)

    def impulse(self) -> np.ndarray:
        """On the first velocity field over this step [N s], shape (3,)."""
        return self.impulses.sum(axis=0)

    def lag_work(self, fields: Collection[VelocityField]) -> float:
        """See `ContactPairs.project`."""
        total = 0.0
        if not self.impulses.any():
            return total
        for field, side, mobility, sign in zip(self.fields, self._sides, self._mobility, SIGNS, strict=True):
            if field in fields:
                sums = np.zeros((self._chunks, 1))
                given = self.detection.node, mobility, self.impulses
                impulse_works.sum_lag_works(self._chunks, side, *given, field.small_mass, sums)
                total += sign * float(ordered_sum(sums)[0])
        return total

    def works(self, row: int) -> np.ndarray:
        """Of the impulses of this step, as a row of this length that `pellucid.energy.step_work` reads."""
        return self._works(self._sides, self.impulses, row)

    def _works(self, sides: Sequence[Bundle], given: np.ndarray, row: int) -> np.ndarray:
        if not given.any():
            return np.zeros(row)
        works = np.zeros((self._chunks, row))
        impulse_works.sum_works(self._chunks, *sides, self.detection.node, self._mobility, given, works)
        return ordered_sum(works)


def _along(tried: Sequence[np.ndarray], found: Sequence[np.ndarray], before: Sequence[np.ndarray]) -> float:
    """How far impulses were taken back along the way that they went."""
    return float(sum(((y - x) * (x - z)).sum() for y, x, z in zip(tried, found, before, strict=True)))


class ContactWork(NamedTuple):
    """What all pairs did: their work; impulses by name, (3,) [N s]."""

    work: StepWork
    impulses: dict[str, np.ndarray]

    def add(self, other: "ContactWork") -> "ContactWork":
        """With what was done after it."""
        more = {name: self.impulses[name] + impulse for name, impulse in other.impulses.items()}
        return ContactWork(total_work([self.work, other.work], len(self.work.works)), self.impulses | more)


NO_CONTACT = ContactWork(no_work(0, 0), {})


class ContactPairs:
    """All pairs of velocity fields of a simulation, with so many supports and channels of loads."""

    def __init__(self, pairs: Sequence[ContactPair], n_supports: int, n_loads: int) -> None:
        self._pairs = pairs
        self._fields = list({id(field): field for pair in pairs for field in pair.fields}.values())
        self._sweeps = 1 if len(pairs) == 1 else SWEEPS
        self._columns = FIRST_LOAD + n_loads
        self.lag_work = 0.0  # see `project`
        self._row = row_length(self._columns, n_supports + 2)  # thin axes and other impulses have rows too

    def __len__(self) -> int:
        return len(self._pairs)

    def detect(self, dt: float) -> None:
        """Find where velocity fields touch in a step dt [s], after the bodies' mass was mapped to the nodes."""
        for pair in self._pairs:
            pair.detect(dt)
        for field in self._fields:
            field.await_impulses(pair.detection.node for pair in self._pairs if field in pair.fields and pair.touches)

    def touching(self) -> Iterator[tuple[ContactBody, np.ndarray]]:
        """The bodies of each pair, each with the nodes at which its field touches the other, shape (n,)."""
        return chain.from_iterable(pair.touching() for pair in self._pairs)

    def resolve(self) -> None:
        """Impulses on the nodes after their momentum was advanced."""
        for pair in self._pairs:
            pair.measure_again()
            pair.let_return()
        self._sweep(anew=False)
        bodies = list({id(body): body for pair in self._pairs for body in pair.in_contact()}.values())
        self._settle(bodies)
        for body in bodies:
            body.end_contact()

    def work(self) -> ContactWork:
        """What the impulses did, when the mean velocities of the nodes are known."""
        total = np.zeros(self._row)
        for pair in self._pairs:
            total += pair.works(self._row)
        named = {pair.name: pair.impulse() for pair in self._pairs if pair.name is not None}
        return ContactWork(step_work(total, self._columns), named)

    def _sweep(self, anew: bool) -> None:
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.resolve(anew)

    def _settle(self, bodies: Sequence[ContactBody]) -> None:
        """Let bodies answer to the impulses, and find these anew, until they hardly change.

        What is sought are impulses that push and bodies that part or stay, the minimum of a convex function: a projected
        gradient method with momentum finds it (Nesterov 1983, Soviet Math. Dokl. 27, 372), which begins again where it turns
        back (O'Donoghue & Candès 2015, Found. Comput. Math. 15, 715, section 3.2).
        """
        last, weight, ahead = [pair.impulses.copy() for pair in self._pairs], 1.0, 0.0
        for _ in range(ANSWERS):
            now = [pair.impulses.copy() for pair in self._pairs]
            if ahead > 0.0:
                for pair, new, old in zip(self._pairs, now, last, strict=True):
                    pair.give(ahead * (new - old))
            tried = [pair.impulses.copy() for pair in self._pairs]
            answers = [body.answer_contact() for body in bodies]
            if not any(answers):
                return
            self._sweep(anew=True)
            found = [pair.impulses for pair in self._pairs]
            changed = sum(float(np.abs(new - old).sum()) for new, old in zip(found, tried, strict=True))
            if changed <= SETTLED * sum(float(np.abs(impulse).sum()) for impulse in found):
                return
            weight, before = 0.5 + sqrt(0.25 + weight**2), weight
            ahead = (before - 1.0) / weight
            if _along(tried, found, now) > 0.0:
                weight, ahead = 1.0, 0.0
            last = now

    def project(self, fields: Collection[VelocityField]) -> None:
        """Remove the approach from the velocities mapped again, those that strain the points.

        Finds `lag_work` before: how much more work the impulses did on the nodes of some velocity fields than on the points
        of these [J], on which they work along the mean of the velocities that the points give to the nodes before and after
        the step.
        """
        self.lag_work = sum(pair.lag_work(fields) for pair in self._pairs)
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.project()

    def give_second(self, dt: float) -> ContactWork:
        """Let the bodies have the impulses that removed this approach: of fields where all can, in a step dt [s]."""
        total, named, bodies = np.zeros(self._row), {}, dict[int, ContactBody]()
        for field in self._fields:
            field.begin_second()
        for pair in self._pairs:
            if pair.gives_second():
                pair.add_second()
                total += pair.second_works(self._row)
                bodies |= {id(body): body for side in pair.bodies for body in side}
                if pair.name is not None:
                    named[pair.name] = pair.second.sum(axis=0)
        done = step_work(total, self._columns)
        done.works[CONTACT] += sum(body.take_second_impulses(dt) for body in bodies.values())
        return ContactWork(done, named)
