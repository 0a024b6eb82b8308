"""Data model of gravity that changes in time."""

from collections.abc import Iterator

from pellucid.case.stages import SteadyCase
from pellucid.conditions.amplitude import Amplitude
from pellucid.findings import Finding, Path
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts


class GravityAmplitude(Amplitude, Part):
    """Factor on gravity as a function of time: piecewise linear, constant before the first and after the last time."""

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if the amplitude is given in a case without gravity or with steady states, or with hydrostatic
        fluids if the factor at time 0 is not 1.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        if parts.gravity is not None and not any(parts.gravity):
            yield Finding(path, "the case has no gravity", "Add `gravity`, such as [0, -9.81, 0] m/s^2, or remove this key.")
        if parts.one(SteadyCase) is not None:
            yield Finding(
                path,
                "in steady states gravity increases with the other loads, so it cannot have an amplitude",
                "Remove this key.",
            )
        for other, body in parts.placed(BodyModel):
            if getattr(body, "hydrostatic", None) is not None and self.at(0.0) != 1.0:
                text = f"`hydrostatic` is the equilibrium under full gravity, but its amplitude at time 0 is {self.at(0.0):g}"
                yield Finding((*other, "hydrostatic"), text, "Start the amplitude with 1, or remove this key.")
