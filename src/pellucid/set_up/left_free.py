"""Warnings about degrees of freedom that are free although the user may expect them to be constrained."""

from collections.abc import Iterator

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.wall import why_no_wall
from pellucid.findings import listed
from pellucid.parts.condition import is_driven


def free_turns(case: Case) -> Iterator[str]:
    """Yield a warning for each rigid body whose translation is fully prescribed, but whose motions have neither the key
    `rotation` nor `hold_rotation`."""
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
                    f"the motion of the rigid body {body.name} does not prescribe its rotation; [steady] constrains the "
                    f"rotation about {listed(about)}. Add hold_rotation = [{turns}] to motion {motions[-1].name} to state this."
                )
            elif about:
                yield (
                    f"the motion of the rigid body {body.name} prescribes its translation along all axes, but not its "
                    "rotation: it "
                    f"rotates freely about {listed(about)}. Add hold_rotation = [{turns}] to motion {motions[-1].name} "
                    "to prevent "
                    f"the rotation, or hold_rotation = [] to allow it."
                )


def passed_walls(case: Case) -> Iterator[str]:
    """Yield a warning for each plane wall that names no bodies and does not act on all bodies."""
    parts = parts_of(case)
    for number, wall in enumerate(case.wall):
        passing = [body.name for body in case.body if why_no_wall(body) and not is_driven(body.name, parts)]
        if passing and not wall.bodies:
            holds = ", ".join(f'"{body.name}"' for body in wall.touching(case.body))
            name = f"wall {wall.name or number + 1}"
            kinds = "material points, meshless solids and membranes of elements"
            yield (
                f"{name} does not act on {listed(passing)}: walls act on {kinds}; other bodies pass through them. Use a "
                "support on "
                f"a face of the grid or a constrained body instead of the wall. If these bodies are meant to pass, list the "
                f"others: bodies = [{holds}]"
            )
