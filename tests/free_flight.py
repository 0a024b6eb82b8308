"""A fake simulation of bodies in free flight, small and exact, with the interface that the results read."""

from types import ModuleType, SimpleNamespace
from typing import ClassVar

import numpy as np

from pellucid.case import Case, loads
from pellucid.contact.pairs import ContactPairs
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.errors import RunStopped
from pellucid.geometry.meshes.cells import Cells
from pellucid.step.limit import NO_LIMIT, StepLimit
from pellucid.step.part import StepParts

CASE = """
schema = 1
title = "Free flight"
source = "of our own"
description = "Points fly <freely>."
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.5
[time]
end = 1.0
step = 0.03
[[body]]
name = "gas"
kind = "material-points"
shape = { box = { lower = [0.5, 0.5, 0], upper = [1.5, 1.5, 0] } }
points_per_cell = [5, 4, 1]
material = { kind = "fluid", density = 1.0, pressure = 1.0, eos = { kind = "ideal-gas", gamma = 1.4 } }
velocity = [1, 0, 0]
[[body]]
name = "block"
kind = "material-points"
shape = { box = { lower = [2.5, 0.5, 0], upper = [3.0, 1.5, 0] } }
points_per_cell = [4, 4, 1]
material = { kind = "linear-elastic", density = 1000, young_modulus = 1e3, poisson_ratio = 0.3 }
[[probe]]
name = "front"
body = "gas"
quantity = "position"
component = "x"
reduce = "max"
[output]
history = 0.1
frames = 0.25
checkpoint = 1000
"""


def free_flight(**settings: object) -> Case:
    return loads(CASE).with_settings(settings)


class FakeBody:
    constant_fields = ("id", "mass")

    def __init__(self, name: str, fluid: bool, lower: tuple[float, float], points: int, speed: float) -> None:
        generator = np.random.default_rng(len(name))
        self.name, self.fluid, self.n_points, self.n_told = name, fluid, points, points
        self.position = np.column_stack([generator.random((points, 2)) + lower, np.full(points, 0.25)])
        self.velocity = np.zeros((points, 3))
        self.velocity[:, 0] = speed * (1.0 + 0.1 * generator.random(points))

    def cells(self) -> Cells:
        return Cells.of_points(self.n_points)

    def facts(self) -> dict[str, float]:
        return {}

    def frame(self) -> dict[str, np.ndarray]:
        x = self.position[:, 0]
        fields = {
            "position": self.position,
            "velocity": self.velocity,
            "density": 1.0 + x,
            "pressure": np.sin(x),
            "stress": np.outer(x, np.arange(1.0, 7.0)),
            "mass": np.full(self.n_points, 0.5),
            "id": np.arange(self.n_points),
        }
        return fields | ({"internal_energy": np.cos(x)} if self.fluid else {})

    def field(self, name: str) -> np.ndarray:
        return self.frame()[name]

    stored_field = field


class FakeBudget:
    """Balance of a `FakeSimulation`."""

    is_complete = True
    inflow: ClassVar[dict[str, float]] = {}
    outflow: ClassVar[dict[str, float]] = {}

    def __init__(self, simulation: "FakeSimulation") -> None:
        self._simulation = simulation

    def energies(self) -> dict[str, float]:
        kinetic = sum(0.25 * float((body.velocity**2).sum()) for body in self._simulation.bodies)
        return {"kinetic": kinetic, "internal": 3.0 - 0.1 * self._simulation.time, "strain": 0.1 * self._simulation.time}

    def reactions(self) -> dict[str, np.ndarray]:
        return {}

    def angular_reactions(self) -> dict[str, np.ndarray]:
        return {}

    def conservation(self) -> dict[str, float]:
        return {"mass": 0.0, "momentum": 1e-16, "energy": 1e-4 * self._simulation.time}


class FakeClock:
    """Clock of a `FakeSimulation`, as the loop over the steps reads it."""

    is_last_try, missed = False, None

    def __init__(self, simulation: "FakeSimulation") -> None:
        self._simulation = simulation

    def finished(self, until: float | None) -> bool:
        end = self._simulation.case.time.end
        return self._simulation.time >= min(end, until or end)


class FakeSimulation:
    """Simulation in which points move with constant velocities. If `breaks_at` is set, the run stops with an error in that
    step."""

    breaks_at: int | None = None
    place: ClassVar[dict[str, object]] = {}

    def __init__(self, case: Case, threads: int | None = None, start: object = None) -> None:
        self.case, self.threads = case, threads or 1
        self.bodies = [FakeBody("gas", True, (0.5, 0.5), 80, 1.0), FakeBody("block", False, (2.5, 0.5), 32, 0.0)]
        self.time, self.n_steps, self.dt = 0.0, 0, 0.0
        self.budget, self.parts = FakeBudget(self), StepParts([ContactPairs([], 0, 0, []), SurfacePairs([])])
        self.begun, self.clock = False, FakeClock(self)
        self.thread_choice = SimpleNamespace(before_step=lambda: None, after_step=lambda: None)

    def facts(self) -> dict:
        return {}

    def step_limit(self) -> tuple[StepLimit, str]:
        return NO_LIMIT, ""

    def settle(self, *arguments) -> None:
        pass

    def show(self, progress) -> None:
        pass

    def step(self) -> None:
        self.begun = True
        if self.breaks_at == self.n_steps:
            raise RunStopped("point 7 of gas is lost", body="gas", point=np.int64(7), **self.place)
        end = self.case.time.end
        self.dt = min(self.case.time.step, end - self.time)
        for body in self.bodies:
            body.position = body.position + self.dt * body.velocity
        self.time = self.time + self.dt if self.dt == self.case.time.step else end
        self.n_steps += 1

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {f"{body.name}/{name}": getattr(body, name) for body in self.bodies for name in ("position", "velocity")}

    def state_numbers(self) -> dict[str, object]:
        return {"time": self.time, "n_steps": self.n_steps, "dt": self.dt}

    def restore(self, arrays, numbers) -> None:
        for body in self.bodies:
            body.position, body.velocity = arrays[f"{body.name}/position"], arrays[f"{body.name}/velocity"]
        self.time, self.n_steps, self.dt, self.begun = numbers["time"], numbers["n_steps"], numbers["dt"], True

    def momentum(self) -> np.ndarray:
        return sum(0.5 * body.velocity.sum(axis=0) for body in self.bodies)


def fake_module() -> ModuleType:
    """Return a module that replaces `pellucid.simulation.simulation` if runs are to use the fake simulation."""
    module = ModuleType("pellucid.simulation.simulation")
    module.Simulation = FakeSimulation
    return module
