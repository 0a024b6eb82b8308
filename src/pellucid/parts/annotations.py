"""Types that models of conditions and bodies annotate. A run needs what these stand for, reading a case does not."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pellucid.parts.assembly import AssembledBody, Assembly
    from pellucid.parts.body import Body
    from pellucid.parts.placement import Placement
else:
    AssembledBody = Assembly = Body = Placement = object

__all__ = ["AssembledBody", "Assembly", "Body", "Placement"]
