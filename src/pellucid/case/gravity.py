"""Gravity that changes in time, as the user describes it."""

from collections.abc import Iterator

from pellucid.case.stages import SteadyCase
from pellucid.conditions.amplitude import Amplitude
from pellucid.findings import Finding, Path
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts


class GravityAmplitude(Amplitude, Part):
    """The share of gravity that acts, as a function of time: straight lines between instants, constant before and behind."""

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Report missing gravity, steady states, and fluids that start at rest under another share."""
        if parts.gravity is not None and not any(parts.gravity):
            yield Finding(path, "the case has no gravity", "Add `gravity`, such as [0, -9.81, 0] m/s^2, or remove this key.")
        if parts.one(SteadyCase) is not None:
            yield Finding(path, "in steady states gravity increases with the other loads", "Remove this key.")
        for other, body in parts.placed(BodyModel):
            if getattr(body, "hydrostatic", None) is not None and self.at(0.0) != 1.0:
                text = f"`hydrostatic` is the equilibrium under full gravity, but its amplitude at time 0 is {self.at(0.0):g}"
                yield Finding((*other, "hydrostatic"), text, "Start the amplitude with 1, or remove this key.")
