"""Settling before the clock starts, as the user describes it."""

from collections.abc import Iterator

from pellucid.case.steady import SteadyCase
from pellucid.conditions.support import Support
from pellucid.findings import Finding, Path
from pellucid.model import parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts


class SettleCase(Part):
    """Settling: before the clock starts, bodies come to rest in equilibrium with what acts at time 0.

    They move by their own equations, and lose all velocity whenever their kinetic energy passes a peak. Time stands still for
    loads and motions.
    """

    share: float = parameter(
        "",
        "kinetic energy that bodies no longer pass when they count as settled, of the largest energy that moved on the way",
        1e-8,
        gt=0,
        le=0.1,
    )
    most_steps: int = parameter("", "steps of the settling before the run stops itself", 100_000, ge=10)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Steady states, bodies without inertia or not at rest, supports that move."""
        if parts.one(SteadyCase) is not None:
            yield Finding(path, "[steady] brings bodies to rest by itself", "leave one of the two out")
        for other, body in parts.placed(BodyModel):
            if not body.moves or body.has_own_step:
                yield Finding((*other, "kind"), f'[settle]: kind "{body.kind}" does not move by inertia', "leave [settle] out")
            for key in ("velocity", "angular_velocity", "velocity_wave"):
                value = getattr(body, key, None)
                if value is not None and (not isinstance(value, tuple) or any(value)):
                    yield Finding((*other, key), "[settle] takes all velocity from the bodies", "leave it out")
            for number, initial in enumerate(getattr(body, "initial", None) or ()):
                if initial.kind == "velocity-gradient":
                    text = "[settle] takes all velocity from the bodies"
                    yield Finding((*other, "initial", number, "kind"), text, "leave it out")
        for other, support in parts.placed(Support):
            if any(support.velocity):
                text = "[settle] holds the time of motions, but not a support that moves"
                yield Finding((*other, "velocity"), text, "hold the nodes at rest, and move the body by a [[motion]]")
