"""Upper limit of the size of generated meshes."""

from abc import abstractmethod

from pellucid.findings import Refusal
from pellucid.model import Model, check

MOST_POINTS = 2_000_000
"""Largest number of vertices or nodes. Surfaces of this size take about 3 s, solids with twelve tetrahedra per cube about 1 GB.
"""


def refuse_too_many(points: float) -> None:
    """Raise Refusal if the number of points exceeds the limit for generated meshes."""
    if not points <= MOST_POINTS:
        text = f"the mesh would have about {points:.3g} points, but at most {MOST_POINTS:.3g} are allowed"
        raise Refusal(text, "make the mesh coarser")


class Countable(Model):
    """A generated surface or mesh of a case; its number of points is checked before it is generated."""

    @check
    def _can_be_held(self) -> None:
        refuse_too_many(self.expected_points())

    @abstractmethod
    def expected_points(self) -> float:
        """Return the approximate number of vertices or nodes, without generating the mesh."""
