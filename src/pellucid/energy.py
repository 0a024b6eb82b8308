"""The books of a run: where mass, momentum and energy are and what came from outside."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

OUTSIDE = {"gravity": 1.0, "support": 1.0, "load": 1.0, "motion": 1.0, "contact": 1.0, "absorbed": -1.0, "impact_heat": -1.0}
"""Energy that comes in, and with a minus what goes out."""

COLUMNS = {
    "load": "load_work",
    "motion": "motion_work",
    "contact": "contact_work",
    "absorbed": "absorbed_energy",
    "impact_heat": "impact_heat",
}


class EnergyBudget:
    """Energies and momentum after each step, against what external forces did.

    The error of the energy has two causes that are kept apart: `transfer`, kinetic energy lost or won when velocities go
    between points and grid (walls included), and `time_integration`, the work of internal forces on the grid that the
    points' stored energy does not show. Both are of the method and vanish under refinement.
    """

    ACCUMULATED = (*OUTSIDE, "transfer", "time_integration", "artificial_heat")

    def __init__(self, bodies: Sequence[Any], gravity: Sequence[float], works: Sequence[str] = ()) -> None:
        self.gravity = np.array(gravity)
        self.works = works  # which of COLUMNS this run has
        self.kinetic, self.stored = self._totals(bodies)
        self.initial = {"kinetic": self.kinetic, "stored": self.stored, "mass": self._mass(bodies)}
        self.initial_momentum = self._momentum(bodies)
        self.impulse = np.zeros(3)
        self.sums = dict.fromkeys(self.ACCUMULATED, 0.0)
        self.support_impulses: list[list[float]] = []
        self.motion_impulses: dict[str, list[float]] = {}
        self.contact_impulses: dict[str, list[float]] = {}
        self.energy_scale = self.kinetic
        self.momentum_scale = sum(body.sums["speed"] for body in bodies)

    def record(self, bodies: Sequence[Any], work: Any, constraints: Any, contact: Any, dt: float) -> None:
        """Book a step; `work` is the StepWork of the nodes, `constraints` the ConstraintWork of the points, `contact` the
        ContactWork of the fields."""
        kinetic, stored = self._totals(bodies)
        done = {
            "gravity": work.gravity,
            "support": work.support,
            "load": work.load,
            "motion": work.grip + constraints.work,
            "contact": contact.work,
            "absorbed": work.absorbed,
            "impact_heat": work.grip_loss + constraints.loss,
        }
        for name, amount in done.items():
            self.sums[name] += amount
        external = sum(OUTSIDE[name] * amount for name, amount in done.items())
        self.sums["transfer"] += kinetic - self.kinetic - (work.internal + external)
        self.sums["time_integration"] += stored - self.stored + work.internal
        self.sums["artificial_heat"] += dt * sum(body.sums["heating"] for body in bodies)
        self.kinetic, self.stored = kinetic, stored
        self._record_impulses(work, constraints, contact, dt)
        exchanged = abs(stored - self.initial["stored"]) + sum(abs(self.sums[name]) for name in OUTSIDE)
        self.energy_scale = max(self.energy_scale, kinetic + exchanged)
        speed = sum(body.sums["speed"] for body in bodies)
        self.momentum_scale = max(self.momentum_scale, speed, float(np.abs(self.impulse).max()))

    def _record_impulses(self, work: Any, constraints: Any, contact: Any, dt: float) -> None:
        self.impulse += work.impulses.sum(axis=0) + dt * work.mass * self.gravity + work.absorbed_impulse + work.load_impulse
        so_far = self.support_impulses or [[0.0, 0.0, 0.0]] * len(work.impulses)
        self.support_impulses = (np.array(so_far) + work.impulses).tolist()
        for name, impulse in contact.impulses.items():
            self.contact_impulses[name] = (np.array(self.contact_impulses.get(name, (0.0, 0.0, 0.0))) + impulse).tolist()
        for name, impulse in constraints.impulses.items():
            self.impulse += impulse
            self.motion_impulses[name] = (np.array(self.motion_impulses.get(name, (0.0, 0.0, 0.0))) + impulse).tolist()

    def reactions(self, support_names: Sequence[str | None]) -> dict[str, np.ndarray]:
        """Impulses so far [N s], shape (3,), of motions, and of the supports and contacts that have a name.

        Those of supports of one name add up.
        """
        known = {**self.motion_impulses, **self.contact_impulses}
        result = {name: np.array(impulse) for name, impulse in known.items()}
        for name, impulse in zip(support_names, self.support_impulses, strict=False):
            if name is not None:
                result[name] = result.get(name, np.zeros(3)) + np.array(impulse)
        return result

    def energies(self, bodies: Sequence[Any]) -> dict[str, float]:
        """The ledger [J]: kinetic, internal and strain energy; energy that damage took, where there can be any; works from
        outside; energy that absorbing faces and inelastic impact on driven points took; heat of the artificial viscosity, which
        is part of the internal energy; the two errors of the method."""
        parts = {"internal": 0.0, "strain": 0.0}
        for body in bodies:
            parts[body.energy_kind] += body.sums["stored"]
            if "hourglass" in body.sums:
                parts["strain"] -= body.sums["hourglass"]
                parts["hourglass"] = parts.get("hourglass", 0.0) + body.sums["hourglass"]
            if "dissipated" in body.sums:  # part of the work of the stress that cannot be had back
                parts["strain"] -= body.sums["dissipated"]
                parts["dissipated"] = parts.get("dissipated", 0.0) + body.sums["dissipated"]
        return {
            "kinetic": self.kinetic,
            **parts,
            "gravity_work": self.sums["gravity"],
            "support_work": self.sums["support"],
            **{column: self.sums[name] for name, column in COLUMNS.items() if name in self.works},
            "artificial_heat": self.sums["artificial_heat"],
            "transfer_error": self.sums["transfer"],
            "time_integration_error": self.sums["time_integration"],
        }

    def energy_error(self) -> float:
        """Energy that no book explains, relative to the largest energy that moved so far."""
        change = self.kinetic - self.initial["kinetic"] + self.stored - self.initial["stored"]
        error = change - sum(sign * self.sums[name] for name, sign in OUTSIDE.items())
        return float(error / self.energy_scale) if self.energy_scale > 0.0 else 0.0

    def conservation(self, bodies: Sequence[Any]) -> dict[str, float]:
        """Relative errors of mass, momentum (by Σ m|v|) and energy."""
        lost = np.abs(self._momentum(bodies) - self.initial_momentum - self.impulse).max()
        return {
            "mass": abs(self._mass(bodies) - self.initial["mass"]) / self.initial["mass"],
            "momentum": float(lost / self.momentum_scale) if self.momentum_scale > 0.0 else 0.0,
            "energy": self.energy_error(),
        }

    def state_numbers(self) -> dict[str, Any]:
        """What a checkpoint keeps."""
        return {
            "kinetic": self.kinetic,
            "stored": self.stored,
            "initial": self.initial,
            "initial_momentum": self.initial_momentum.tolist(),
            "impulse": self.impulse.tolist(),
            "sums": self.sums,
            "support_impulses": self.support_impulses,
            "motion_impulses": self.motion_impulses,
            "contact_impulses": self.contact_impulses,
            "energy_scale": self.energy_scale,
            "momentum_scale": self.momentum_scale,
        }

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Go on from a checkpoint."""
        self.kinetic, self.stored = numbers["kinetic"], numbers["stored"]
        self.initial, self.sums = dict(numbers["initial"]), dict(numbers["sums"])
        self.initial_momentum, self.impulse = np.array(numbers["initial_momentum"]), np.array(numbers["impulse"])
        self.support_impulses = [list(impulse) for impulse in numbers["support_impulses"]]
        self.motion_impulses = dict(numbers["motion_impulses"])
        self.contact_impulses = dict(numbers["contact_impulses"])
        self.energy_scale, self.momentum_scale = numbers["energy_scale"], numbers["momentum_scale"]

    @staticmethod
    def _totals(bodies: Sequence[Any]) -> tuple[float, float]:
        return sum(body.sums["kinetic"] for body in bodies), sum(body.sums["stored"] for body in bodies)

    @staticmethod
    def _momentum(bodies: Sequence[Any]) -> np.ndarray:
        return np.asarray(sum(body.momentum() for body in bodies))

    @staticmethod
    def _mass(bodies: Sequence[Any]) -> float:
        return float(sum(body.points.mass.sum() for body in bodies))
