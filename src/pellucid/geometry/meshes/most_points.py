"""The largest mesh that is made."""

from pellucid.findings import Refusal

MOST_POINTS = 2_000_000
"""Vertices or nodes: surfaces are made in about 3 s then, solids of twelve tetrahedra a cube with about 1 GB."""


def refuse_too_many(points: float) -> None:
    """Raise Refusal for more points than a mesh can have."""
    if not points <= MOST_POINTS:
        text = f"a mesh of about {points:.3g} points, and one has at most {MOST_POINTS:.3g}"
        raise Refusal(text, "make it coarser")
