"""Bodies that start closer to each other than the contact distance: detection, and messages for the user."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.contact.surface_pairs import SurfacePairs

if TYPE_CHECKING:
    from pellucid.case import Case

REPORTED = 1e-3  # cells: depth from which an overlap is reported


class OverlappingStart(NamedTuple):
    """An overlap at the start of a run between two bodies, a body and a wall, or parts of one body: names, depth and
    contact distance [m], and the message for the user."""

    between: tuple[str, ...]
    """Names of both, each with its kind ("body", "wall"); a single name for parts of one body."""
    depth: float
    """Largest depth of the overlap [m]."""
    distance: float
    """Distance between the given surfaces at which contact acts: the sum of both contact offsets [m]."""

    @property
    def text(self) -> str:
        """Message about the overlap for the user."""
        depth = f"{self.depth:.4g} m"
        if len(self.between) == 1:
            return (
                f"parts of {self.between[0]} start up to {depth} closer to each other than twice the contact offset, "
                f"{self.distance:.4g} m (`contact_offset`, default: half of the thickness): this overlap exerts no "
                "force on a point until the point has separated once. To have contact act from the start, move the parts "
                f"away from each other by {depth}, or set a smaller `contact_offset`."
            )
        one, other = self.between
        if self.distance > 0.0:
            limit = f"{self.distance:.4g} m (`contact_offset` of each membrane, default: half of the thickness)"
            where = f"start {depth} closer to each other than the contact distance of {limit}"
            remedy = f"move one of the two away by {depth}"
            if self.depth < self.distance:
                remedy += ", or set a smaller `contact_offset`"
        else:
            where, remedy = f"overlap by {depth} at the start", f"move one of the two away by {depth}"
        return (
            f"{one} and {other} {where}: this overlap exerts no force until they have separated once, so contact starts "
            f"{depth} late. To have contact act from the start, {remedy}."
        )

    def facts(self) -> dict[str, Any]:
        """Return the data of the overlap for the summary of the run, by name."""
        return {"between": list(self.between), "depth": self.depth, "distance": self.distance}


def find_start_overlaps(
    pairs: SurfacePairs, case: "Case", going_on: Mapping[str, Mapping[str, np.ndarray]]
) -> list[OverlappingStart]:
    """Return the overlaps between contact surfaces at the start of a run that are larger than rounding errors.

    pairs: contacts of surfaces; going_on: arrays of the bodies that start in the state of an earlier run, by body, see
    `SurfacePairs.go_on`.
    """
    pairs.go_on(going_on)
    if not len(pairs):
        return []
    found = [OverlappingStart(pair.between, depth, pair.distance) for pair, depth in pairs.find_start_overlaps()]
    return [overlap for overlap in found if overlap.depth > REPORTED * case.grid.cell]
