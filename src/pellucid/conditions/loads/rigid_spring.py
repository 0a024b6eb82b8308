"""Load: springs and dampers between a rigid body and an anchor."""

from collections.abc import Callable, Iterator, Sequence
from math import sqrt
from typing import ClassVar, Literal

import numpy as np

from pellucid.conditions.loads.rigid_load import NONE, Push, RigidLoad, rigid_of, thin_problems
from pellucid.conditions.prescribed_motion import Rotations, plane_turn_problems
from pellucid.conditions.signals import AlongAxes, Signal
from pellucid.conditions.signals.turns import checked_displacement, displacement_fault
from pellucid.energy import DAMPING_HEAT, Channel
from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Vector, check, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.condition import LoadKind
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart


class AnchorPath(AlongAxes):
    """Displacements of an anchor along the axes; the anchor is fixed along axes that are not given."""


class RigidSpring(RigidLoad):
    """Springs and dampers between a rigid body and an anchor, which is fixed at the initial position of the body or follows
    a given motion.

    Force and torque are -k (u - a) - c (u' - a'), where u is the displacement of the centre of mass along each axis or the
    angle about it, a the displacement or angle of the anchor, k the stiffness, and c the damping coefficient.
    """

    losses: ClassVar[Sequence[Channel]] = (DAMPING_HEAT,)  # heat of the dampers

    channel: ClassVar[str] = "spring_work"
    kind: Literal["rigid-spring"] = "rigid-spring"
    stiffness: Vector = parameter("N/m", "spring stiffness along x, y and z", NONE)
    turning_stiffness: Vector = parameter("N*m/rad", "rotational spring stiffness about x, y and z", NONE)
    damping: Vector = parameter("N*s/m", "damping coefficients along x, y and z", NONE)
    turning_damping: Vector = parameter("N*m*s/rad", "rotational damping coefficients about x, y and z", NONE)
    anchor: AnchorPath = parameter("", "displacement of the anchor as a function of time", AnchorPath())
    anchor_rotation: Rotations = parameter("", "rotation of the anchor as a function of time", Rotations())

    @check
    def _draws(self) -> None:
        for key in ("stiffness", "turning_stiffness", "damping", "turning_damping"):
            if min(getattr(self, key)) < 0.0:
                raise Refusal(f"{key} has {min(getattr(self, key)):g}, but cannot be negative", "use 0 or more")
        if not any((*self.stiffness, *self.turning_stiffness, *self.damping, *self.turning_damping)):
            raise Refusal("this spring has no effect", "give a `stiffness`, a `turning_stiffness`, or a damping")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that is not rigid, components along axes without motion, and motions of the anchor
        that are invalid at the start. path: location of the condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from thin_problems(self.stiffness, self.turning_stiffness, ("stiffness", "turning_stiffness"), path, parts)
        yield from thin_problems(self.damping, self.turning_damping, ("damping", "turning_damping"), path, parts)
        x, y, z = (float(getattr(self.anchor, axis) is not None) for axis in AXES)
        yield from thin_problems((x, y, z), NONE, ("anchor", "anchor_rotation"), path, parts)
        yield from plane_turn_problems(self.anchor_rotation.axes(), (*path, "anchor_rotation"), parts)
        for number, signal in enumerate(self.signals()):
            key, axis = ("anchor", "anchor_rotation")[number // 3], AXES[number % 3]
            if signal is not None and (why := displacement_fault(signal, f"{key} {axis}")):
                yield Finding((*path, key, axis), why)

    def signals(self) -> list[Signal | None]:
        """Return the displacements of the anchor along x, y, z, then its rotations about x, y, z, as functions of time; None
        where not given."""
        return [getattr(of, axis) for of in (self.anchor, self.anchor_rotation) for axis in AXES]

    def anchors(self) -> list[Callable[[float], float]]:
        """Return the displacements [m] of the anchor along x, y, z, then its angles [rad] about x, y, z, as functions of time
        [s]; zero where not given."""
        return [
            (lambda t: 0.0) if signal is None else checked_displacement(signal, f"the anchor of body {self.body}")
            for signal in self.signals()
        ]

    def swing(self, mass: float, inertia: np.ndarray) -> float:
        """Return an upper bound of the oscillation rate of a body on its springs plus the decay rate due to its dampers
        [1/s]; mass: of the body [kg]; inertia: tensor of inertia about the axes of rotation that are free [kg m²], shape
        (k, k)."""
        sizes = np.linalg.eigvalsh(inertia) if len(inertia) else np.zeros(0)
        least = float(sizes[sizes > 1e-10 * sizes.max(initial=0.0)].min(initial=np.inf))
        along = _fastest(self.stiffness, self.damping, mass)
        return max(along, _fastest(self.turning_stiffness, self.turning_damping, least))

    def kind_of_load(self) -> LoadKind:
        return "other" if any((*self.damping, *self.turning_damping)) else "dead"

    def why_not_factored(self) -> Reason | None:
        if self.kind_of_load() == "dead":
            return None
        text = f"the load on body {self.body} has dampers, whose force depends on time"
        return Reason(text, "Remove `damping` and `turning_damping`, which have no effect on an equilibrium.")

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        return ActiveRigidSpring(self, assembly)


def _fastest(stiffness: Vector, damping: Vector, mass: float) -> float:
    return sqrt(max(stiffness) / mass) + max(damping) / mass


class ActiveRigidSpring(StepPart):
    """Applies force and torque of a `RigidSpring` in each step to the rigid body that the spring names."""

    def __init__(self, load: RigidSpring, assembly: Assembly) -> None:
        self._body = assembly.bodies[load.body].body
        self._stiffness = np.array([*load.stiffness, *load.turning_stiffness])
        self._damping = np.array([*load.damping, *load.turning_damping])
        self._anchors = load.anchors()
        self._elastic = assembly.layout.column(Channel(load.channel))
        self._viscous = assembly.layout.column(DAMPING_HEAT)

    def begin(self, time: float, dt: float) -> None:
        """Compute force and torque for the position of the body at the start of the step, and apply both over the step dt
        [s] that begins at `time` [s]."""
        rigid = rigid_of(self._body)
        moved, rates = rigid.moved(), rigid.rates()
        start = np.array([anchor(time) for anchor in self._anchors])
        carried = np.zeros(6)
        if dt > 0.0:
            carried = (np.array([anchor(time + dt) for anchor in self._anchors]) - start) / dt
        rigid.add_load(Push(-self._stiffness * (moved - start), self._elastic))
        if self._damping.any():
            rigid.add_load(Push(-self._damping * (rates - carried), self._elastic, carried, self._viscous))
