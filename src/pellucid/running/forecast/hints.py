"""Hints to the user: settings that would make the time step of a case much larger."""

from math import isfinite

from pellucid.case import Case
from pellucid.materials.contract import PointMaterial
from pellucid.running.forecast.steps import limit_of_model
from pellucid.step.limit import NO_LIMIT

WORTHWHILE = 5.0
"""Smallest ratio of the time steps at which the hint is given: a step with implicit viscosity costs two to four times as
much."""


def implicit_viscosity(case: "Case") -> str | None:
    """Return a text that suggests implicit viscosity if only viscosity limits the time step of the case, else None."""
    if case.grid_or_none is None or case.steady is not None or case.time.scheme == "usf":
        return None
    changed, names = [], []
    for body in case.body:
        material = getattr(body, "material", None)
        other = material.with_implicit_viscosity() if isinstance(material, PointMaterial) else None
        names += [] if other is None else [body.name]
        changed.append(body if other is None else body.model_copy(update={"material": other}))
    limit = limit_of_model(case) if names else NO_LIMIT
    if limit.cause != "viscous":
        return None
    without = limit_of_model(case.model_copy(update={"body": tuple(changed)}))
    if not isfinite(without.step) or without.step < WORTHWHILE * limit.step:
        return None
    keys = " and ".join(f"body.{name}.material.implicit_viscosity" for name in names)
    longer = f"would allow time steps {without.step / limit.step:.2g} times as long, at two to four times the cost per step"
    return f"hint: {keys} = true {longer}"
