"""Selection of a shape in a case by one key. To add a shape, define its class in a module of `shapes` and add a field with its
key to `Shape`."""

from typing import ClassVar

from pellucid.geometry.choice import Choice
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.rotation import Rotated, Rotations, rotate_parameter
from pellucid.geometry.shapes.solids import Box, Cushion, Cylinder, Pipe, Shell, Sphere
from pellucid.geometry.surfaces.surface import Inside


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
