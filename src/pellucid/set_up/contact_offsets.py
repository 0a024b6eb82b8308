"""Lines for the user about the distances at which membranes come into contact."""

from pellucid.bodies.membranes.model import MembraneCase
from pellucid.case import Case


def contact_offsets(case: Case) -> list[str]:
    """Return a line of text for each membrane that may be in contact with other bodies or walls: the distance from its
    surface at which contact starts, and the reason for this distance."""
    if case.grid_or_none is None or not (case.wall or len({body.field for body in case.body}) > 1):
        return []
    return [_line(body) for body in case.body if isinstance(body, MembraneCase)]


def _line(body: MembraneCase) -> str:
    why = "half the thickness" if body.contact_offset is None else "`contact_offset`"
    offset = "" if body.contact_offset is None else f"; the thickness is {body.thickness:.4g} m"
    return f"contact: faces of membrane {body.name} are {body.contact_reach:.4g} m from `surface` on both sides ({why}{offset})"
