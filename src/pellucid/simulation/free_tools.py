"""Rigid bodies on which forces act in a search for equilibria: their places are unknowns of the search.

A rigid body in contact with bodies that deform is in equilibrium if its loads balance the contact forces along the axes along
which it is free. Its unknowns are the displacements along these axes; rotations are held. Contact at fixed geometry
(`pellucid.contact.frozen`) and springs of the body resist them. Before the first contact nothing does: the body then first
moves along its load until it touches another body.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.frozen import ContactSprings
from pellucid.energy import CONTACT
from pellucid.parts.body import Body
from pellucid.parts.constraint import PlacedBySearch, ToolLoads

HALVINGS = 20  # of the last stride towards another body, in which the tool comes to touch it


class FreeTool:
    """A rigid body in a search for equilibria, of which some translations are free.

    body: the body; constraint: its motion; surface: its contact surface.
    """

    def __init__(self, body: Body, constraint: PlacedBySearch, surface: ContactSurface) -> None:
        self.body, self._constraint, self.surface = body, constraint, surface
        self.free = constraint.seek()
        """Mask of the axes along which the search finds the place, shape (3,)."""
        self._before = self._now = ToolLoads({}, np.zeros(3))  # loads at the last and at the present equilibrium
        self._pushed_before = np.zeros(3)
        self.pushed = np.zeros(3)
        """Sum of the contact forces of the last trial [N], shape (3,)."""
        self.position = constraint.displacement()
        """Displacement from which the search starts [m], shape (3,): that at the last equilibrium, or where the body first
        touches another one."""
        self.tried = self.position.copy()
        """Displacement in the last trial [m], shape (3,)."""
        self._left = self.position.copy()  # displacement at the last equilibrium, with the prescribed motion of the step
        # velocities of the surface by the prescribed motion [m/s], and step of the time of the loads [s]
        self._velocity, self._dt = surface.velocity.copy(), 1.0

    # loads

    def share_gravity(self, share: float) -> None:
        """Set the fraction of gravity that acts on the body."""
        self._constraint.share_gravity(share)

    def take_loads(self) -> None:
        """Take the loads that conditions have added as those of the equilibrium that is sought."""
        self._now = self._constraint.loads()

    @property
    def residual(self) -> np.ndarray:
        """Force that is not balanced along the free axes [N], shape (3,)."""
        return np.where(self.free, self._now.force + self.pushed, 0.0)

    @property
    def size(self) -> float:
        """Sum of the norms of loads, contact forces and forces of springs since the start along the free axes [N]."""
        every = self._now.force, self.pushed, self.stiffness * self.tried
        return float(sum(np.sqrt(np.sum(np.where(self.free, force, 0.0) ** 2)) for force in every))

    @property
    def stiffness(self) -> np.ndarray:
        """Stiffness of the springs of the body along the axes [N/m], shape (3,)."""
        return self._now.stiffness

    # place

    def leave(self) -> None:
        """Take the loads that conditions have added, and the present contact forces, as those of the last equilibrium."""
        self._before, self._pushed_before = self._constraint.loads(), self.pushed

    def begin(self, dt: float) -> None:
        """Start the search from the place after the prescribed motion of a step dt [s]."""
        self.position = self._constraint.displacement()
        self.tried, self._left, self._dt = self.position.copy(), self.position.copy(), dt
        self._velocity = self.surface.velocity.copy()

    def start_from(self, displacement: np.ndarray) -> None:
        """Let the search start from a place where the body begins to touch another one: a displacement [m], shape (3,)."""
        self.place(displacement)
        self.position = displacement.copy()
        self.place(displacement)

    @property
    def approached(self) -> np.ndarray:
        """Displacement before the first contact in this step, from where the prescribed motion left the body [m], (3,)."""
        return self.position - self._left

    def place(self, displacement: np.ndarray) -> None:
        """Move the body to a displacement since the start [m], shape (3,). Friction uses the displacement since the last
        equilibrium, or since the first contact."""
        self.tried = displacement.copy()
        self._constraint.displace(displacement)
        self.surface.velocity[...] = self._velocity + (displacement - self.position) / self._dt
        self.surface.begin()

    def add_work(self, works: np.ndarray) -> None:
        """Add the work that loads and contact forces did along the free axes since the last equilibrium, by the trapezoidal
        rule, to an array of works [J].

        On the way to the first contact nothing resists a body without springs, so that its load was zero there.
        """
        start = self._left if self.stiffness.any() else self.position
        moved = np.where(self.free, self.tried - start, 0.0)
        for column in {*self._before.forces, *self._now.forces}:
            ends = [loads.forces.get(column, np.zeros(3)) for loads in (self._before, self._now)]
            works[column] += 0.5 * float(np.sum((ends[0] + ends[1]) * moved))
        works[CONTACT] += 0.5 * float(np.sum((self._pushed_before + self.pushed) * moved))


def approach(
    tools: Sequence[FreeTool],
    stride: float,
    farthest: float,
    renew: Callable[[], None],
    presses: Callable[[FreeTool], bool],
) -> FreeTool | None:
    """Move rigid bodies that touch nothing along their loads until they touch another body, so that the search can start.
    Returns a body that touches none, None if all do or need not.

    stride: largest displacement between two detections of contact [m]; farthest: displacement at which a body is lost [m];
    renew: function that computes the loads; presses: function that detects contact and returns whether there is pressure on a
    body.
    """
    for tool in tools:
        renew()
        load = tool.residual - np.where(tool.free, tool.pushed, 0.0)
        size = float(np.sqrt(np.sum(load * load)))
        if size == 0.0 or presses(tool):
            continue
        springs = float(np.sum(tool.stiffness * load * load)) / size**2  # along the load
        reach = size / springs if springs > 0.0 else farthest
        start, way, gone = tool.position.copy(), load / size, 0.0
        while gone < reach:
            further = min(gone + stride, reach)
            tool.place(start + further * way)
            if presses(tool):
                break
            gone = further
        else:
            if springs > 0.0:
                tool.start_from(start + reach * way)
                continue
            tool.place(start)
            return tool
        touches = further
        for _ in range(HALVINGS):
            middle = 0.5 * (gone + touches)
            tool.place(start + middle * way)
            gone, touches = (gone, middle) if presses(tool) else (middle, touches)
        tool.start_from(start + touches * way)
    return None


def coupling_to(springs: Sequence[ContactSprings], axis: int, n: int) -> np.ndarray:
    """Return the forces on the n nodes of a body that a unit displacement of a tool along an axis causes by the springs of
    contact between both [N/m], shape (n, 3)."""
    total = np.zeros((n, 3))
    for shares, normal, across, along in springs:
        force = (across - along)[:, None] * normal * normal[:, axis : axis + 1]
        force[:, axis] += along
        total += shares.T @ force
    return total


def stiffness_of(springs: Sequence[ContactSprings]) -> np.ndarray:
    """Return the stiffness of a tool against displacements along the axes by springs of contact [N/m], shape (3, 3)."""
    total = np.zeros((3, 3))
    for _, normal, across, along in springs:
        for i in range(3):
            for j in range(3):
                total[i, j] += np.sum((across - along) * normal[:, i] * normal[:, j])
        total += np.sum(along) * np.eye(3)
    return total
