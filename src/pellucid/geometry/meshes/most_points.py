"""The largest mesh that is made."""

from abc import abstractmethod

from pellucid.findings import Refusal
from pellucid.model import Model, check

MOST_POINTS = 2_000_000
"""Vertices or nodes: surfaces are made in about 3 s then, solids of twelve tetrahedra a cube with about 1 GB."""


def refuse_too_many(points: float) -> None:
    """Raise Refusal for more points than a mesh can have."""
    if not points <= MOST_POINTS:
        text = f"a mesh of about {points:.3g} points, and one has at most {MOST_POINTS:.3g}"
        raise Refusal(text, "make it coarser")


class Countable(Model):
    """A surface or a mesh of a case, whose number of points is known, and limited, before any are made."""

    @check
    def _can_be_held(self) -> None:
        refuse_too_many(self.expected_points())

    @abstractmethod
    def expected_points(self) -> float:
        """About how many vertices or nodes it has, found without making them."""
