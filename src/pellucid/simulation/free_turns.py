"""About which axes the bodies of a case turn freely: their angular momentum is constant as long as nothing pushes them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pellucid.conditions.contact import Contact
from pellucid.conditions.enclosed.model import Enclosed
from pellucid.conditions.rigid.model import Rigid
from pellucid.conditions.support import Support
from pellucid.conditions.surface_tension.model import SurfaceTension

if TYPE_CHECKING:
    from pellucid.case import Case

INTERNAL = (Contact, Enclosed, Rigid, Support, SurfaceTension)
"""Conditions between bodies, and supports, whose impulses show whether they push: other conditions may turn bodies."""


def free_turns(case: "Case") -> Sequence[int]:
    """The axes about which the angular momentum of a case is constant unless supports or gravity push a body."""
    acting = [base for base, several in case.conditions().items() if several and not issubclass(base, INTERNAL)]
    if acting or case.steady is not None or any(body.has_own_step or not body.moves for body in case.body):
        return []
    bound = [thin or period > 0.0 for thin, period in zip(case.thin, case.periods, strict=True)]
    return [axis for axis in range(3) if not any(bound[other] for other in range(3) if other != axis)]
