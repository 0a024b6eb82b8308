"""Settings of damping in a case file, for bodies with mass: a drag force on each point or node, proportional to its
momentum.
"""

from collections.abc import Iterator

from pydantic import model_validator

from pellucid.findings import Finding, Path
from pellucid.model import parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import is_driven
from pellucid.parts.part import Parts


class DampedModel(BodyModel):
    """Base class of settings of bodies with an optional drag proportional to velocity; `damping_heat` is the energy that the
    drag dissipates.
    """

    damping: float = parameter(
        "1/s",
        "rate c of a mass-proportional drag (force -c m v on a mass m); in steady states it is chosen automatically",
        0.0,
        ge=0,
    )
    damping_until: float | None = parameter("s", "time at which the drag ends; default: never", None, gt=0)

    @model_validator(mode="after")
    def _ends_what_acts(self) -> "DampedModel":
        if self.damping_until is not None and self.damping == 0.0:
            raise ValueError("`damping_until` has no effect without `damping`; set `damping`, the rate of the drag")
        return self

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding (an error of the case) if damping is set for a body that is rigid or whose motion is fully
        prescribed.

        path: path of the body in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        if self.damping > 0.0 and (self.is_rigid or is_driven(self.name, parts)):
            text = f"body {self.name} is {'rigid' if self.is_rigid else 'fully prescribed'}: a drag on its points has no effect"
            yield Finding((*path, "damping"), text, "remove `damping`")
