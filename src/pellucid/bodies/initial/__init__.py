"""Initial fields: additions to the uniform initial state of a body, such as a velocity gradient; each kind has its own file.

The kinds that a case can name are listed here: one line each.
"""

from typing import Annotated

from pellucid.bodies.initial.contract import InitialField
from pellucid.bodies.initial.polynomial import Polynomial
from pellucid.bodies.initial.sine_wave import SineWave
from pellucid.bodies.initial.spherical_harmonic import SphericalHarmonic
from pellucid.bodies.initial.velocity_gradient import VelocityGradient
from pellucid.registry import Family, OneOf

INITIAL_FIELDS = Family("initial field", InitialField)
Initial = Annotated[InitialField, OneOf(INITIAL_FIELDS)]
INITIAL_MEANING = "fields added to the initial state"

INITIAL_FIELDS.add(SineWave)
INITIAL_FIELDS.add(Polynomial)
INITIAL_FIELDS.add(SphericalHarmonic)
INITIAL_FIELDS.add(VelocityGradient)
