"""Types for the annotations of condition and body models. Other modules import this one only for type checks, not to read a
case."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pellucid.parts.assembly import AssembledBody, Assembly
    from pellucid.parts.body import Body, Placement
else:
    AssembledBody = Assembly = Body = Placement = object

__all__ = ["AssembledBody", "Assembly", "Body", "Placement"]
