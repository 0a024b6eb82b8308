"""Supports on faces of the grid that move out of it."""

from collections.abc import Iterator

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.findings import listed
from pellucid.parts.body_model import is_alone


def leading_out(case: Case) -> Iterator[str]:
    """Return a warning for each face whose support would take the points of bodies on the grid past it."""
    grid, parts = case.grid_or_none, parts_of(case)
    led = [body.name for body in case.body if body.moves and not body.owns_nodes(is_alone(body, parts))]
    if grid is None or not led:
        return
    for number, support in enumerate(case.support):
        for face in support.faces():
            axis, velocity = face[0], support.face_velocity(face)
            outward = 0.0 if velocity is None else velocity["xyz".index(axis)] * (1.0 if face.endswith("upper") else -1.0)
            if outward > 0.0 and not case.thin["xyz".index(axis)] and axis not in grid.periodic:
                label = support.label(number)
                yield (
                    f"{label} moves the face {face} out of the grid at {outward:g} m/s: points of {listed(led)} that follow it "
                    f"past the face stop the run; set its velocity along {axis} to 0, or enlarge the grid and lead a solid "
                    "with a [[motion]]"
                )
