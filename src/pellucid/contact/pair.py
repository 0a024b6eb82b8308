"""Two velocity fields in contact: where they touch, and what impulses they give each other."""

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from pellucid.contact import impulse_works, impulses
from pellucid.contact.contact_body import ContactBody, TakesSecondImpulses
from pellucid.contact.detection import ContactDetection
from pellucid.contact.impulses import ContactNodes, Friction
from pellucid.grid.chunks import by_row
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum

SIGNS = 1.0, -1.0  # of the impulses on the first side and on the second


class ContactPair:
    """Two velocity fields and how they touch; `name`: what a probe calls the impulse on the first of them."""

    def __init__(
        self,
        fields: tuple[VelocityField, VelocityField],
        bodies: tuple[Sequence[ContactBody], Sequence[ContactBody]],
        friction: Friction,
        name: str | None = None,
    ) -> None:
        self.name, self._friction = name, friction
        self.detection = ContactDetection(fields, bodies)
        self.fields, self.bodies = fields, [body for side in bodies for body in side]
        self.taking_second = [body for body in self.bodies if isinstance(body, TakesSecondImpulses)]
        """The bodies that can take second impulses."""
        self._sides = [Bundle(impulses.Side(field.grid.nodes, field.external, field.moves_points)) for field in fields]
        self._second_sides = [Bundle(side._replace(moves_points=False)) for side in self._sides]  # the bodies count theirs
        self._meet_at(self.detection.node)
        self._allowed = np.zeros(0)  # speeds of approach [m/s], (n,)
        self.impulses, self.second = np.zeros((2, 0, 3))
        """On the first side at each node of `detection` in this step [N s], shape (n, 3); and what stopped the approach of the
        velocities mapped again."""
        self.touches = False
        """Anywhere, in this step."""

    @property
    def _takes_second(self) -> bool:
        """Whether all bodies take second impulses now; else none does, since they are equal and opposite."""
        return len(self.taking_second) == len(self.bodies) and all(b.takes_second_impulses for b in self.taking_second)

    # detection

    def detect(self) -> None:
        """Find where the velocity fields touch in a step, after the bodies' mass was mapped to the nodes."""
        self.detection.find()
        n = len(self.detection.node)
        self.touches = domain.any(bool(self.detection.normal.any()))
        self._meet_at(self.detection.node)
        self.impulses, self.second = np.zeros((n, 3)), np.zeros((n, 3))
        self._allowed = np.zeros(n)
        if self.touches:
            impulses.measure_mobility(self._chunks, *self._sides, self._at)

    def _meet_at(self, node: np.ndarray) -> None:
        """Take the nodes of a step."""
        self._by_row = by_row(self.fields[0].grid.rows, node, impulses.CHUNK)
        self._chunks = self._by_row.chunks.n
        self._at = ContactNodes(node, self.detection.normal, np.zeros((2, len(node), 3)), self._by_row.chunks.edges)

    def touching(self) -> Iterator[tuple[ContactBody, np.ndarray]]:
        """The bodies of both velocity fields, each with the nodes at which these touch, shape (n,)."""
        here = np.flatnonzero(self.detection.normal.any(axis=1))
        nodes = domain.of_nodes(self.detection.node[here], self.detection.node[here])
        return ((body, nodes) for body in self.bodies)

    # impulses

    def begin_impulses(self) -> None:
        """The momentum of the nodes was advanced: find what these can move, and how fast they may approach."""
        if not self.touches:
            return
        if any(field.may_be_let_go for field in self.fields):
            impulses.measure_mobility(self._chunks, *self._sides, self._at)
        if self._takes_second:
            self._allow_rebound()

    def _allow_rebound(self) -> None:
        """Let bodies that part as the step begins come back as fast, when their momentum was advanced: their mean approach over
        the step is nothing then, and the impulses do no work. Stopped earlier, they would win energy at each such return. Not
        bodies that respond to impulses themselves: the velocities of their nodes are not those with which their material parts.
        """
        impulses.measure_parting(self._chunks, *self._sides, self._at, self._allowed)

    def resolve(self, anew: bool) -> None:
        """Impulses on the nodes after their momentum was advanced, or `anew` after the bodies responded to these."""
        if not self.touches:
            return
        impulses.resolve(self._chunks, self._friction, anew, *self._sides, self._at, self._allowed, self.impulses)
        if domain.any(bool(self.impulses.any())):
            for field in self.fields:
                field.pressed = True

    def apply_impulses(self, impulse: np.ndarray) -> None:
        """Impulses on the first side and against the second [N s], shape (n, 3), beside those so far."""
        impulses.apply(self._chunks, *self._sides, self._at, impulse, self.impulses)

    def impulse(self) -> np.ndarray:
        """On the first velocity field over this step [N s], shape (3,)."""
        return self._total(self.impulses)

    def of_all(self, impulses: np.ndarray) -> np.ndarray:
        """What its nodes have, shape (n, 3), of those of all processes."""
        return domain.of_nodes(impulses, self._at.node)

    def _total(self, impulses: np.ndarray) -> np.ndarray:
        return self.of_all(impulses).sum(axis=0)

    def works(self, row: int) -> np.ndarray:
        """Of the impulses of this step, as a row of this length that `pellucid.energy.step_work` reads."""
        return self._works(self._sides, self.impulses, row)

    def lag_work(self, fields: Collection[VelocityField]) -> float:
        """See `ContactPairs.lag_work`."""
        total = 0.0
        if not domain.any(bool(self.impulses.any())):
            return total
        for number, (field, side, sign) in enumerate(zip(self.fields, self._sides, SIGNS, strict=True)):
            if field in fields:
                sums = np.zeros((self._chunks, 1))
                impulse_works.sum_lag_works(self._chunks, side, number, self._at, self.impulses, field.small_mass, sums)
                total += sign * float(ordered_sum(domain.of_chunks(sums, self._by_row.of_row))[0])
        return total

    # the same on what was mapped again

    def stop_straining(self) -> None:
        """Stop the approach of the velocities that strain the points."""
        if self.touches:
            impulses.stop_straining(self._chunks, self._friction, *self._sides, self._at, self.second)

    def begin_second(self) -> bool:
        """Add what second impulses change to the second increments of both fields; whether there are any, which all bodies
        take."""
        if not (self.touches and self._takes_second and domain.any(bool(self.second.any()))):
            return False
        for field, mobility, sign in zip(self.fields, self._at.mobility, SIGNS, strict=True):
            field.add_second_increments(self._at.node, sign * mobility * self.second)
        return True

    def second_impulse(self) -> np.ndarray:
        """The sum of these impulses on the first velocity field [N s], shape (3,)."""
        return self._total(self.second)

    def second_works(self, row: int) -> np.ndarray:
        """Of these impulses on constrained nodes alone; see `works`."""
        return self._works(self._second_sides, self.second, row)

    def _works(self, sides: Sequence[Bundle], given: np.ndarray, row: int) -> np.ndarray:
        if not domain.any(bool(given.any())):
            return np.zeros(row)
        works = np.zeros((self._chunks, row))
        impulse_works.sum_works(self._chunks, *sides, self._at, given, works)
        return ordered_sum(domain.of_chunks(works, self._by_row.of_row))
