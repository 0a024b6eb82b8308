"""Contact on the nodes of the grid: between fluids and membranes or solids, between fluids, and for bodies without a usable
surface.

Sequence in a step: `detect`, then `apply_impulses`. For velocities that are mapped from the points again: `stop_straining`
and `apply_second_impulses`.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.contact import impulses
from pellucid.contact.contact_body import ContactBody, ContactResponse, TakesSecondImpulses, WarnsOfContact
from pellucid.contact.detection import SIGNS, ContactDetection
from pellucid.contact.impulses import ContactNodes, Friction
from pellucid.energy import CONTACT, FIRST_LOAD, StepWork, no_work, row_length, step_work, total_work
from pellucid.grid.chunks import by_row
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.part import StepPart

SWEEPS = 4  # number of sweeps over the pairs, which may share nodes
MOST_RESPONSES = 32  # largest number of responses of bodies with their own equation of motion in a step
TOLERANCE = 1e-3  # relative change of the impulses that ends the iteration


class ContactPair:
    """Contact between two velocity fields, with impulses on the nodes of the grid that both fields share.

    friction: law of friction between the fields.

    Attributes
    ----------
    name : str, optional
        Name of the impulse on the first field for probes.
    fields, bodies
        Both velocity fields, and the bodies of both.
    impulses, second : ndarray, shape (n, 3)
        Impulses of this step on the first field at the nodes of `detection` [N s]. `second`: impulses that stop the approach
        of the velocities mapped from the points again.
    touches : bool
        True if the fields are in contact at any node in this step.
    """

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
        self.second_bodies = [body for body in self.bodies if isinstance(body, TakesSecondImpulses)]
        self._sides = [Bundle(impulses.Side(field.grid.nodes, field.external, field.moves_points)) for field in fields]
        self._second_sides = [Bundle(side._replace(moves_points=False)) for side in self._sides]  # bodies count these works
        self._begin()

    def detect(self) -> None:
        """Find the contact nodes of a step and their mobility. Call after mapping the mass to the nodes."""
        self.detection.find()
        self._begin()
        if self.touches:
            impulses.measure_mobility(self._chunks, *self._sides, self._at)

    def _begin(self) -> None:
        node, normal = self.detection.node, self.detection.normal
        self._by_row = by_row(self.fields[0].grid.rows, node, impulses.CHUNK)
        self._chunks = self._by_row.chunks.n
        self._at = ContactNodes(node, normal, np.zeros((2, len(node), 3)), self._by_row.chunks.edges)
        self._allowed = np.zeros(len(node))  # speeds of approach [m/s]
        self.impulses, self.second = np.zeros((2, len(node), 3))
        self.touches = domain.any(bool(normal.any()))

    def touching(self) -> Iterator[tuple[ContactBody, np.ndarray]]:
        """Yield the bodies of both fields, each with the nodes at which the fields touch, shape (n,)."""
        here = self.detection.node[self.detection.normal.any(axis=1)]
        nodes = domain.of_nodes(here, here)
        return ((body, nodes) for body in self.bodies)

    @property
    def _takes_second(self) -> bool:
        """True if all bodies accept second impulses in this step. Second impulses on both fields are equal and opposite, so
        either all bodies receive second impulses or none."""
        return len(self.second_bodies) == len(self.bodies) and all(body.takes_second_impulses() for body in self.second_bodies)

    def begin_impulses(self) -> None:
        """Update the mobility of nodes that walls released, and compute the approach velocity that may remain at each node
        after the impulses.

        Bodies that separate at the start of the step may approach at the same speed at the end of the step: their mean
        approach velocity over the step is then zero, and the impulses do no work. If impulses stopped such bodies
        completely, the bodies would gain energy at each return, for example water at rest on soft soil. Bodies with their
        own response are stopped completely, because their material separates at other velocities than their nodes.
        """
        if not self.touches:
            return
        if any(field.may_be_let_go for field in self.fields):
            impulses.measure_mobility(self._chunks, *self._sides, self._at)
        if self._takes_second:
            impulses.measure_parting(self._chunks, *self._sides, self._at, self._allowed)

    def resolve(self, anew: bool) -> None:
        """Apply the impulses that stop the approach of the nodes.

        anew: True to recompute the impulses of this step after bodies have responded to the previous ones.
        """
        if not self.touches:
            return
        impulses.resolve(self._chunks, self._friction, anew, *self._sides, self._at, self._allowed, self.impulses)
        if domain.any(bool(self.impulses.any())):
            for field in self.fields:
                field.pressed = True

    def apply_impulses(self, impulse: np.ndarray) -> None:
        """Apply impulses to the first field and their opposites to the second field [N s], shape (n, 3)."""
        impulses.apply(self._chunks, *self._sides, self._at, impulse, self.impulses)

    def gather(self, values: np.ndarray) -> np.ndarray:
        """Gather values at the contact nodes, shape (n, 3), from all processes: the value of each node comes from the
        process that owns it."""
        return domain.of_nodes(values, self._at.node)

    def sum_works(self, row: int) -> np.ndarray:
        """Return the work of the impulses of this step in the channels of the energy balance [J], a row of length `row`,
        see `pellucid.energy.step_work`."""
        return self._sum_works(self._sides, self.impulses, row)

    def lag_work(self, fields: Collection[VelocityField]) -> float:
        """Return the contribution of this pair to `ContactPairs.lag_work` [J]. fields: velocity fields whose nodes are
        included."""
        total = 0.0
        if not domain.any(bool(self.impulses.any())):
            return total
        for number, (field, side, sign) in enumerate(zip(self.fields, self._sides, SIGNS, strict=True)):
            if field in fields:
                sums = np.zeros((self._chunks, 1))
                impulses.sum_lag_works(self._chunks, side, number, self._at, self.impulses, field.momentum.small_mass, sums)
                total += sign * float(ordered_sum(domain.of_chunks(sums, self._by_row.of_row))[0])
        return total

    def stop_straining(self) -> None:
        """Stop the approach of the strain velocities (nodal velocities that strain the points) at the contact nodes; add
        the impulses [N s] to the attribute `second`, the impulses of the second velocity increments of the step."""
        if self.touches:
            impulses.stop_straining(self._chunks, self._friction, *self._sides, self._at, self.second)

    def begin_second(self) -> bool:
        """Add the velocity increments of the second impulses (`second`) to the nodes of both fields.

        Return True if there are second impulses and all bodies accept them; otherwise nothing is added.
        """
        if not (self.touches and self._takes_second and domain.any(bool(self.second.any()))):
            return False
        for field, mobility, sign in zip(self.fields, self._at.mobility, SIGNS, strict=True):
            field.second.add(self._at.node, sign * mobility * self.second)
        return True

    def sum_second_works(self, row: int) -> np.ndarray:
        """Return the work of the second impulses on constrained nodes only [J], as a row of length `row`; see `sum_works`."""
        return self._sum_works(self._second_sides, self.second, row)

    def _sum_works(self, sides: Sequence[Bundle], given: np.ndarray, row: int) -> np.ndarray:
        if not domain.any(bool(given.any())):
            return np.zeros(row)
        works = np.zeros((self._chunks, row))
        impulses.sum_works(self._chunks, *sides, self._at, given, works)
        return ordered_sum(domain.of_chunks(works, self._by_row.of_row))


class ContactWork(NamedTuple):
    """Work of the contact impulses of all pairs in a step (`work`), and the impulse on the first field of each named
    contact [N s], shape (3,), by the name of the contact (`impulses`)."""

    work: StepWork
    impulses: dict[str, np.ndarray]


class ContactPairs(StepPart):
    """All contacts between velocity fields of a simulation, with impulses on the nodes of the grid.

    pairs: the contacts. n_supports, n_loads: numbers of supports and of loads with their own entry in the energy balance.
    strained_again: velocity fields whose points are strained by momentum that is mapped again from the points (MUSL with
    FLIP) and keep no heat.

    Attributes
    ----------
    reasons : sequence of str
        Messages to the user that state why solids or membranes are in contact on the nodes instead of by their surfaces.
    done : ContactWork
        Work and impulses of this step so far.
    lag_work : float
        Work of the impulses of this step on the nodes of some velocity fields, minus their work on the points [J]. The work
        on the points uses the mean of the velocities mapped from the points to the nodes before and after the step.
    """

    def __init__(
        self,
        pairs: Sequence[ContactPair],
        n_supports: int,
        n_loads: int,
        strained_again: Collection[VelocityField] = (),
        reasons: Sequence[str] = (),
    ) -> None:
        self._pairs, self._strained_again, self.reasons = pairs, strained_again, reasons
        self._fields = list({id(field): field for pair in pairs for field in pair.fields}.values())
        self._sweeps = 1 if len(pairs) == 1 else SWEEPS
        self._columns = FIRST_LOAD + n_loads
        self._row = row_length(self._columns, n_supports + 2)  # thin axes and other impulses have rows too
        self.done = ContactWork(no_work(0, 0), {})
        self.lag_work = 0.0

    def __len__(self) -> int:
        return len(self._pairs)

    def find_contact(self) -> None:
        for pair in self._pairs:
            pair.detect()
        for field in self._fields:
            field.await_impulses(pair.detection.node for pair in self._pairs if field in pair.fields and pair.touches)

    def touching(self) -> Iterator[tuple[ContactBody, np.ndarray]]:
        """Yield the bodies of each pair, each with the nodes where its field is in contact with the other field, shape
        (n,)."""
        return (found for pair in self._pairs for found in pair.touching())

    def stop_approach(self) -> None:
        for pair in self._pairs:
            pair.begin_impulses()
        self._sweep(anew=False)
        bodies = {id(body): body for pair in self._pairs if pair.touches for body in pair.bodies}.values()
        responses = [response for body in bodies if (response := body.contact_response) is not None]
        if responses:
            self._iterate(responses)
        for response in responses:
            response.finish()

    def _sweep(self, anew: bool) -> None:
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.resolve(anew)

    def _iterate(self, responses: Sequence[ContactResponse]) -> None:
        """Repeat the responses of bodies that integrate their own equations of motion, and the impulses, until the impulses
        converge.

        Impulses that are only compressive, on bodies that separate or stay together, minimize a convex function. A
        projected gradient method with momentum finds the minimum (Nesterov 1983, Soviet Math. Dokl. 27, 372). The momentum
        is reset when the impulses turn back (O'Donoghue & Candès 2015, Found. Comput. Math. 15, 715, section 3.2).
        """
        last, weight, ahead = self._copy_impulses(), 1.0, 0.0
        for _ in range(MOST_RESPONSES):
            now = self._copy_impulses()
            if ahead > 0.0:
                for pair, new, old in zip(self._pairs, now, last, strict=True):
                    pair.apply_impulses(ahead * (new - old))
            tried = self._copy_impulses()
            for response in responses:
                response.respond()
            self._sweep(anew=True)
            found, tried, before = ([*map(ContactPair.gather, self._pairs, one)] for one in (self._copy_impulses(), tried, now))
            changed = sum(float(np.abs(new - old).sum()) for new, old in zip(found, tried, strict=True))
            if changed <= TOLERANCE * sum(float(np.abs(impulse).sum()) for impulse in found):
                return
            ahead, weight = weight - 1.0, 0.5 + sqrt(0.25 + weight**2)
            ahead /= weight
            if sum(float(((y - x) * (x - z)).sum()) for y, x, z in zip(tried, found, before, strict=True)) > 0.0:
                weight, ahead = 1.0, 0.0  # impulses were taken back along their way
            last = now

    def _copy_impulses(self) -> list[np.ndarray]:
        return [pair.impulses.copy() for pair in self._pairs]

    def after_momentum(self) -> None:
        """Sum the works and impulses of all contact pairs in this step."""
        if not self._pairs:
            return
        total = sum((pair.sum_works(self._row) for pair in self._pairs), np.zeros(self._row))
        named = {pair.name: pair.gather(pair.impulses).sum(axis=0) for pair in self._pairs if pair.name is not None}
        self.done = ContactWork(step_work(total, self._columns), named)

    def correct_strain_velocities(self, dt: float | None) -> None:
        """Compute `lag_work`, then stop the approach of the strain velocities at the contact nodes of all pairs; at the end of
        a step dt [s], also apply the impulses of this correction to bodies that accept them."""
        self.lag_work = sum(pair.lag_work(self._strained_again) for pair in self._pairs)
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.stop_straining()
        if dt is not None:
            self._apply_second_impulses(dt)

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        """Return the first warning of a body whose surface is too coarse at its contact nodes."""
        for body, nodes in self.touching():
            if isinstance(body, WarnsOfContact) and (text := body.contact_warning(nodes)) is not None:
                return {"coarse surface": text}
        return {}

    def work(self) -> StepWork | None:
        return self.done.work if self._pairs else None

    def impulses(self) -> dict[str, np.ndarray]:
        return self.done.impulses

    def _apply_second_impulses(self, dt: float) -> None:
        """Apply the second impulses of a step dt [s] to the bodies of each pair whose bodies all accept them."""
        if not self._pairs:
            return
        for field in self._fields:
            field.begin_second()
        pairs = [pair for pair in self._pairs if pair.begin_second()]
        bodies = {id(body): body for pair in pairs for body in pair.second_bodies}.values()
        second = step_work(sum((pair.sum_second_works(self._row) for pair in pairs), np.zeros(self._row)), self._columns)
        second.works[CONTACT] += sum(body.take_second_impulses(dt) for body in bodies)
        named = dict(self.done.impulses)
        for pair in pairs:
            if pair.name is not None:
                named[pair.name] = named[pair.name] + pair.gather(pair.second).sum(axis=0)
        self.done = ContactWork(total_work([self.done.work, second], len(self.done.work.works)), named)
