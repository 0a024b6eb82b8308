"""Domain of a diffusing field: a line or a closed surface, with its nodes."""

from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from pellucid.geometry.choice import Choice
from pellucid.geometry.surfaces.surface import Surface
from pellucid.model import Model, parameter


class Line(Model):
    """An interval of the x-axis with equally spaced nodes, including one at each end."""

    lower: float = parameter("m", "x of the lower end of the line")
    upper: float = parameter("m", "x of the upper end of the line")
    nodes: int = parameter("", "number of nodes", ge=3, le=1_000_000)
    at_lower: float | None = parameter("", "fixed concentration at the lower end; default: no flux", None)
    at_upper: float | None = parameter("", "fixed concentration at the upper end; default: no flux", None)

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        if self.upper <= self.lower:
            raise ValueError(f"the line extends from {self.lower:g} to {self.upper:g} m: set `upper` above `lower`")
        return self

    def places(self) -> np.ndarray:
        """Return the positions of the nodes along x [m], shape (n,)."""
        return np.linspace(self.lower, self.upper, self.nodes)


class Domain(Choice):
    """A line or a closed surface with the nodes on which a field diffuses."""

    what: ClassVar[str] = "a domain"

    line: Line | None = None
    surface: Surface | None = None

    def positions(self) -> np.ndarray:
        """Return the positions of the nodes [m], shape (n, 3)."""
        if self.line is None:
            return np.asarray(self.chosen().triangulate().vertices)
        x = self.line.places()
        return np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)

    @property
    def dimension(self) -> int:
        """Return the dimension of the domain: 1 for a line, 2 for a surface."""
        return 1 if self.line is not None else 2
