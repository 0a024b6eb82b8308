"""Degrees of freedom that a case leaves free although its user may expect them to be constrained."""

from collections.abc import Iterator

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.findings import listed
from pellucid.parts.condition import is_driven


def free_turns(case: Case) -> Iterator[str]:
    """Warnings about rigid bodies whose motions prescribe all of the way and say nothing of the rotation."""
    parts = parts_of(case)
    for body in case.body:
        motions = [motion for motion in case.motion if motion.body == body.name]
        said = any(motion.turns_about() or motion.hold_rotation is not None for motion in motions)
        if body.is_rigid and is_driven(body.name, parts) and not said:
            thin = case.thin
            about = [axis for d, axis in enumerate("xyz") if not any(thin[other] for other in range(3) if other != d)]
            turns = ", ".join(f'"{axis}"' for axis in about)
            if about and case.steady is not None:
                yield (
                    f"body {body.name} is rigid, and its motion does not prescribe its rotation: [steady] holds it against "
                    f"rotation about {listed(about)}; add hold_rotation = [{turns}] to motion {motions[-1].name} to state this"
                )
            elif about:
                yield (
                    f"body {body.name} is rigid, its motion prescribes its way along all axes, and it turns freely about "
                    f"{listed(about)}: add hold_rotation = [{turns}] to motion {motions[-1].name} to hold it, or "
                    f"hold_rotation = [] where it is to turn"
                )


def passed_walls(case: Case) -> Iterator[str]:
    """Warnings about walls that name no bodies and do not hold all of them."""
    parts = parts_of(case)
    for number, wall in enumerate(case.wall):
        passing = [body.name for body in case.body if body.why_no_wall() and not is_driven(body.name, parts)]
        if passing and not wall.bodies:
            holds = ", ".join(f'"{body.name}"' for body in wall.touching(case.body))
            name = f"wall {wall.name or number + 1}"
            kinds = "material points, meshless solids and membranes of elements"
            yield (
                f"{name} does not hold {listed(passing)}: {kinds} touch walls, others pass through them; use a support on a "
                f"face of the grid or a held body instead of the wall, or, where they are to pass, name in `bodies` what it "
                f"holds: bodies = [{holds}]"
            )
