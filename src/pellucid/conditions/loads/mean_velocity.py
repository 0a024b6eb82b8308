"""Load: a body force along a periodic axis that maintains the mean velocity of a fluid."""

from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np

from pellucid.conditions.loads.contract import LoadModel
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.findings import Finding, Path
from pellucid.model import name_parameter, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart


class MeanVelocity(ChangesInTime, LoadModel):
    """A body force that controls the mean velocity U of bodies, total momentum over total mass, to a target U*.

    The acceleration is a = 2 (U* - U)/τ + ∫ (U* - U)/τ² dt, with the time constant τ. The integral converges to the
    acceleration that balances the resistance of the walls, i.e. ρ a equals the pressure drop per length Δp/L, and U
    converges to U*. The effect of a new resistance on U decays within a few τ.
    """

    kind: Literal["mean-velocity"] = "mean-velocity"
    channel = "driving_work"

    name: str | None = name_parameter("name of the load, for probes of its force (quantity `reaction`)", None)
    others: tuple[str, ...] = parameter(
        "", "further bodies with the same acceleration; the mean velocity is taken over all of these bodies", ()
    )
    axis: Literal["x", "y", "z"] = parameter("", "direction: a periodic axis of the grid")
    velocity: float = parameter("m/s", "mean velocity; `rise` and `amplitude` change it in time")
    response: float = parameter("s", "response time τ of the controller, at least several time steps", gt=0)

    def bodies(self) -> tuple[str, ...]:
        """Return the names of all controlled bodies."""
        return self.body, *self.others

    def reaction(self) -> str | None:
        return self.name

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        return Controller(self, assembly)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about bodies that do not exist or have no inertia, an axis along which walls constrain the fluid,
        and two controllers of one body. path: location of the condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from parts.no_grid((*path, "axis"), "it drives a flow along a periodic axis of a grid")
        if parts.grid is not None and self.axis not in parts.grid.periodic:
            text = f"the grid is not periodic along {self.axis}: faces stop the flow, and the force would grow"
            yield Finding((*path, "axis"), text, f'add periodic = ["{self.axis}"] to the grid, or use a "body-force"')
        for number, name in enumerate(self.bodies()):
            here = (*path, "body") if number == 0 else (*path, "others", number - 1)
            if number > 0:
                yield from parts.unknown(BodyModel, here, name)
            body = parts.named(BodyModel, name)
            if name in self.bodies()[:number]:
                yield Finding(here, f"body {name} is named twice", "remove one of them")
            elif body is not None and body.is_rigid:
                yield Finding(
                    here,
                    f"body {name} is rigid: this load cannot drive rigid bodies",
                    "remove it; use a load of kind rigid-force instead",
                )
            elif number > 0 and body is not None and not body.moves:
                yield Finding(here, f"body {name} does not move: it has no inertia", "remove it")
            for place, other in parts.placed(MeanVelocity):
                if place < path and other.axis == self.axis and name in other.bodies():
                    text = f"load number {int(place[1]) + 1} already drives body {name} along {self.axis}"
                    yield Finding(here, text, "remove it from one of the two")


class Controller(StepPart):
    """Applies the body force of a `MeanVelocity` in a run. Its state between steps is the integral of the control law, ∫ (U*
    - U)/τ² dt [m/s²], with the mean velocity U, its target U* and the response time τ."""

    def __init__(self, load: MeanVelocity, assembly: Assembly) -> None:
        self._load, self._integral = load, 0.0
        self._bodies = [assembly.bodies[name].body for name in load.bodies()]
        self._add = [assembly.forces_on(name, load.channel) for name in load.bodies()]
        self._along = np.eye(3)["xyz".index(load.axis)]
        self._impulse = np.zeros(3)
        self._kept_mass = [body.mass for body in self._bodies]

    def _mass(self) -> float:
        """Return the mass of all bodies [kg]; it is recomputed for bodies that gain or lose points."""
        found = zip(self._bodies, self._kept_mass, strict=True)
        return sum(kept if "mass" in body.constant_fields else body.mass for body, kept in found)

    def begin(self, time: float, dt: float) -> None:
        """Apply the controlling force for the step dt [s] from `time` [s]; it is zero if dt is 0."""
        self._impulse = np.zeros(3)
        if dt == 0.0:
            return
        load, mass = self._load, self._mass()
        momentum = sum(float(body.totals.momentum @ self._along) for body in self._bodies)
        lacking = load.share(time) * load.velocity - momentum / mass
        self._integral += dt * lacking / load.response**2
        # in steps that are longer than half the response it gives all that is lacking at once, and no more
        acceleration = (min(2.0 / load.response, 1.0 / dt) * lacking + self._integral) * self._along
        self._impulse = dt * mass * acceleration
        for body, add in zip(self._bodies, self._add, strict=True):
            add(body.arrays["mass"][:, None] * acceleration)

    def impulses(self) -> Mapping[str, np.ndarray]:
        return {} if self._load.name is None else {self._load.name: self._impulse}

    def state_numbers(self) -> dict[str, Any]:
        return {"integral": self._integral}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._integral = float(numbers["integral"])
