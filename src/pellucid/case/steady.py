"""Steady states, as the user describes them."""

from collections.abc import Iterator

from pellucid.findings import Finding, Path
from pellucid.model import parameter
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.part import Part, Parts


class SteadyCase(Part):
    """States of rest under loads, by dynamic relaxation.

    Time is that of the loads alone: they grow from time 0 to `time.end` in load steps, and results are those of the
    equilibria. Inertia and damping serve the way there and have no part in these.
    """

    load_steps: int = parameter("", "number of equilibria, at equal intervals of the time of the loads", 1, ge=1, le=100_000)
    loading: int | None = parameter(
        "",
        "steps of the relaxation in which the loads grow smoothly to those of a load step; without it so many that shear waves "
        "cross the body sixteen times while all loads grow, and 800 in all at least",
        None,
        ge=1,
    )
    tolerance: float = parameter(
        "", "estimated error of the displacements at which a state counts as steady, of the largest of them", 1e-6, gt=0, le=0.1
    )
    courant: float = parameter("", "fraction of the largest stable step of the relaxation", 0.8, gt=0, le=1)
    mass_scaling: bool = parameter("", "whether inertia is scaled so that all nodes allow the same step", False)
    most_steps: int = parameter("", "steps of the relaxation of a load step before the run stops itself", 100_000, ge=100)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Bodies that cannot come to rest so, or do not begin at rest."""
        for other, body in parts.placed(BodyModel):
            initial = getattr(body, "initial", None)
            velocity = any(getattr(body, "velocity", ()))
            if body.moves and (velocity or initial):
                key = "velocity" if velocity else "initial"
                yield Finding((*other, key), "a steady state begins at rest", "leave it out")
            if fault := body.why_not_relaxed(is_alone(body, parts)):
                yield Finding((*other, *fault.path), f"[steady]: {fault.text}", fault.remedy)
            elif self.mass_scaling and (not body.scales_inertia or parts.grid is not None):
                text = "on a grid, contact needs the masses" if body.scales_inertia else f'kind "{body.kind}" keeps its masses'
                yield Finding((*path, "mass_scaling"), text, "leave it out")
