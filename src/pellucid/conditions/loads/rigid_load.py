"""Base of loads on rigid bodies as a whole."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pellucid.conditions.led_turns import plane_turn_problems
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Finding, Path
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Vector
from pellucid.parts.annotations import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.conditions.rigid.body import RigidBody


NONE = (0.0, 0.0, 0.0)


class RigidLoad(LoadModel):
    """A load on a rigid body as a whole."""

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or is not rigid (arguments as in `Part.problems`)."""
        yield from super().problems(path, parts)
        body = parts.named(BodyModel, self.body)
        if body is not None and not body.is_rigid:
            text = f"body {self.body} is not rigid: a {self.kind} acts on rigid bodies only"
            yield Finding((*path, "body"), text, 'set `rigid = true` for the body, or use kind = "body-force" or "point-load"')


def thin_problems(along: Vector, about: Vector, keys: tuple[str, str], path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings about nonzero force or torque components for which bodies cannot move in plane or one-dimensional
    problems. along: components along x, y and z; about: components about them; keys: keys of these two vectors in the
    case; path, parts: as in `Part.problems`."""
    for axis, component, counts in zip(AXES, along, parts.active_axes, strict=True):
        if component and not counts:
            text = f"the grid is one cell thick along {axis}: nothing moves along this axis"
            yield Finding((*path, keys[0]), text, f"set its {axis} component to 0, or enlarge the grid along it")
    axes = {axis for axis, component in zip(AXES, about, strict=True) if component}
    yield from plane_turn_problems(axes, (*path, keys[1]), parts)


def rigid_of(body: Body) -> "RigidBody":
    """Return the object that moves a body as a rigid body; it is available when loads begin to act, i.e. in the first step.
    Raises ValueError for a body that is not rigid."""
    from pellucid.conditions.rigid.body import RigidBody

    if not isinstance(body.constraint, RigidBody):
        raise ValueError(f"body {body.name} is not rigid")
    return body.constraint
