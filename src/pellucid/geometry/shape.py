"""Selection of a shape in a case by one key. To add a shape, define its class in its own file and add a field with its key to
`Shape`."""

from typing import ClassVar

from pellucid.geometry.choice import Choice
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.cushion import Cushion
from pellucid.geometry.shapes.hollow import Pipe, Shell
from pellucid.geometry.shapes.rotated import Rotated
from pellucid.geometry.shapes.rotation import Rotations, rotate_parameter
from pellucid.geometry.shapes.solids import Box, Cylinder, Sphere
from pellucid.geometry.surfaces.inside import Inside


class Shape(Choice):
    """A table with exactly one key, which selects the shape."""

    what: ClassVar[str] = "a shape"
    beside: ClassVar[tuple[str, ...]] = ("rotate",)

    box: Box | None = None
    sphere: Sphere | None = None
    cylinder: Cylinder | None = None
    shell: Shell | None = None
    pipe: Pipe | None = None
    inside: Inside | None = None
    cushion: Cushion | None = None
    rotate: Rotations = rotate_parameter("the shape")

    def geometry(self) -> Geometry:
        """Return the selected shape, rotated if `rotate` is given."""
        geometry: Geometry = self.chosen()
        return geometry if self.rotate is None else Rotated(shape=geometry, rotate=self.rotate)
