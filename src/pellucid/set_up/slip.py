"""Warnings about fluids with implicit viscosity that slip along bodies, because the viscous stress is solved for before the
contact with these bodies."""

from collections.abc import Iterator

from pellucid.case import Case
from pellucid.findings import listed
from pellucid.materials.contract import PointMaterial
from pellucid.parts.body_model import BodyModel
from pellucid.step.limit import spread_in_cells


def slipped_past(case: Case) -> Iterator[str]:
    """Yield a warning for each fluid with implicit viscosity in contact with rigid bodies or with moving bodies of other
    velocity fields: viscosity is solved before this contact, so that the fluid slips along these bodies if the time steps
    are long."""
    for fluid in case.body:
        material = getattr(fluid, "material", None)
        if not fluid.solves_viscosity or not isinstance(material, PointMaterial):
            continue
        mu, lam = material.implicit_viscosities() or (0.0, 0.0)
        step = spread_in_cells(case.grid.cell, (2.0 * mu + lam) / material.density).step
        after = [other.name for other in case.body if _acts_after(other, fluid)]
        if after:
            text = f"the implicit viscosity of body {fluid.name} is solved before the contact with {listed(after)}"
            remedy = (
                f"Set a shorter `time.step`, or place {listed(after)} in the velocity field of {fluid.name} and prescribe a "
                "[[motion]]"
            )
            yield f"{text}: with time steps much longer than {step:.2g} s the fluid slips along these bodies. {remedy}."


def _acts_after(other: BodyModel, fluid: BodyModel) -> bool:
    return other is not fluid and other.moves and (other.is_rigid or other.field != fluid.field)
