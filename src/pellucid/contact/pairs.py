"""All pairs of velocity fields in contact. In a step: `detect`, then `apply_impulses`, on the velocities mapped again too."""

from collections.abc import Collection, Iterator, Sequence
from itertools import chain
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.contact.contact_body import ContactBody, ContactResponse, TakesSecondImpulses
from pellucid.contact.pair import ContactPair
from pellucid.energy import CONTACT, FIRST_LOAD, StepWork, no_work, row_length, step_work, total_work
from pellucid.grid.velocity_field import VelocityField

SWEEPS = 4  # where several pairs share nodes, the impulses of one change the approach of another
MOST_RESPONSES = 32  # times at most that bodies whose motion is not that of the grid respond to impulses,
TOLERANCE = 1e-3  # unless what changes is this share of all


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


class ContactPairs:
    """All pairs of velocity fields of a simulation, with so many supports and channels of loads."""

    def __init__(self, pairs: Sequence[ContactPair], n_supports: int, n_loads: int) -> None:
        self._pairs = pairs
        self._fields = list({id(field): field for pair in pairs for field in pair.fields}.values())
        self._sweeps = 1 if len(pairs) == 1 else SWEEPS
        self._columns = FIRST_LOAD + n_loads
        self._row = row_length(self._columns, n_supports + 2)  # thin axes and other impulses have rows too
        self.done = ContactWork(no_work(0, 0), {})
        """What the impulses of this step did so far."""
        self.lag_work = 0.0
        """How much more work they did on the nodes of some velocity fields than on the points of these [J], on which they work
        along the mean of the velocities that the points give to the nodes before and after the step."""

    def __len__(self) -> int:
        return len(self._pairs)

    def detect(self) -> None:
        """Find where velocity fields touch in a step, after the bodies' mass was mapped to the nodes."""
        for pair in self._pairs:
            pair.detect()
        for field in self._fields:
            field.await_impulses(pair.detection.node for pair in self._pairs if field in pair.fields and pair.touches)

    def touching(self) -> Iterator[tuple[ContactBody, np.ndarray]]:
        """The bodies of each pair, each with the nodes at which its field touches the other, shape (n,)."""
        return chain.from_iterable(pair.touching() for pair in self._pairs)

    def apply_impulses(self) -> None:
        """Impulses on the nodes after their momentum was advanced."""
        for pair in self._pairs:
            pair.begin_impulses()
        self._sweep(anew=False)
        bodies = {id(body): body for pair in self._pairs if pair.touches for body in pair.bodies}.values()
        responses = [response for body in bodies if (response := body.contact_response) is not None]
        if responses:
            self._iterate(responses)
        for response in responses:
            response.finish()

    def sum_work(self) -> None:
        """What these impulses did, when the mean velocities of the nodes are known."""
        if not self._pairs:
            return
        total = np.zeros(self._row)
        for pair in self._pairs:
            total += pair.works(self._row)
        named = {pair.name: pair.impulse() for pair in self._pairs if pair.name is not None}
        self.done = ContactWork(step_work(total, self._columns), named)

    def _sweep(self, anew: bool) -> None:
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.resolve(anew)

    def _iterate(self, responses: Sequence[ContactResponse]) -> None:
        """Let bodies respond to the impulses, and find these anew, until they hardly change.

        What is sought are impulses that push and bodies that part or stay, the minimum of a convex function: a projected
        gradient method with momentum finds it (Nesterov 1983, Soviet Math. Dokl. 27, 372), which begins again where it turns
        back (O'Donoghue & Candès 2015, Found. Comput. Math. 15, 715, section 3.2).
        """
        last, weight, ahead = self._given(), 1.0, 0.0
        for _ in range(MOST_RESPONSES):
            now = self._given()
            if ahead > 0.0:
                for pair, new, old in zip(self._pairs, now, last, strict=True):
                    pair.apply_impulses(ahead * (new - old))
            tried = self._given()
            for response in responses:
                response.respond()
            self._sweep(anew=True)
            found, tried, before = ([*map(ContactPair.of_all, self._pairs, one)] for one in (self._given(), tried, now))
            changed = sum(float(np.abs(new - old).sum()) for new, old in zip(found, tried, strict=True))
            if changed <= TOLERANCE * sum(float(np.abs(impulse).sum()) for impulse in found):
                return
            ahead, weight = weight - 1.0, 0.5 + sqrt(0.25 + weight**2)
            ahead /= weight
            if _along(tried, found, before) > 0.0:
                weight, ahead = 1.0, 0.0
            last = now

    def _given(self) -> list[np.ndarray]:
        """The impulses of each pair so far."""
        return [pair.impulses.copy() for pair in self._pairs]

    def stop_straining(self, fields: Collection[VelocityField]) -> None:
        """Stop the approach of the velocities mapped again, those that strain the points.

        Finds `lag_work` of these fields before.
        """
        self.lag_work = sum(pair.lag_work(fields) for pair in self._pairs)
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.stop_straining()

    def apply_second_impulses(self, dt: float) -> None:
        """Give the bodies the impulses that stopped this approach, where all can take them, in a step dt [s]."""
        if not self._pairs:
            return
        total, named, bodies = np.zeros(self._row), dict[str, np.ndarray](), dict[int, TakesSecondImpulses]()
        for field in self._fields:
            field.begin_second()
        for pair in self._pairs:
            if pair.begin_second():
                total += pair.second_works(self._row)
                bodies |= {id(body): body for body in pair.taking_second}
                if pair.name is not None:
                    named[pair.name] = pair.second_impulse()
        done = step_work(total, self._columns)
        done.works[CONTACT] += sum(body.take_second_impulses(dt) for body in bodies.values())
        self.done = self.done.add(ContactWork(done, named))
