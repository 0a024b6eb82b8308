"""Bodies of a case that do not deform."""

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import is_driven


def hard_bodies(case: Case) -> list[BodyModel]:
    """Return the bodies that are rigid or whose motion is fully prescribed, each as a model with access to the other
    bodies of the case."""
    parts = parts_of(case)
    return [body.with_others(case.body) for body in case.body if body.is_rigid or is_driven(body.name, parts)]
