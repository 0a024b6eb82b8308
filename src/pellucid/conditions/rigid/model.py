"""Rigid bodies: the condition for the key `rigid` of a body."""

from collections.abc import Sequence
from typing import ClassVar

from pellucid.conditions.loads.rigid_spring import RigidSpring
from pellucid.conditions.prescribed_motion import Motion
from pellucid.energy import IMPACT_HEAT, Channel
from pellucid.model import parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.condition import Condition
from pellucid.step.part import StepPart


class Rigid(Condition):
    """Condition that gives the points of a body one rigid motion, free or prescribed."""

    # energy lost by points when they take the velocity of the rigid body
    losses: ClassVar[Sequence[Channel]] = (IMPACT_HEAT,)

    body: str = parameter("", "name of the body")
    motions: tuple[Motion, ...] = parameter("", "prescribed motions of the body", ())
    springs: tuple[RigidSpring, ...] = parameter("", "springs that act on the body", ())

    @classmethod
    def activate(cls, conditions: Sequence["Rigid"], assembly: Assembly) -> Sequence[StepPart]:
        from pellucid.conditions.rigid.body import RigidBodies, RigidBody

        bodies: list[RigidBody] = []
        for rigid in conditions:
            bodies.append(RigidBody(assembly.bodies[rigid.body], assembly, rigid.motions, rigid.springs, bodies))
        return [RigidBodies(bodies, assembly.layout.n_columns)] if bodies else []
