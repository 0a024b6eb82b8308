"""Warnings about supports: different velocities at the same nodes, faces that leave the grid, unconstrained directions."""

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.constrained_nodes import nodes_of, on_those
from pellucid.conditions.support import Support
from pellucid.conditions.wall import why_no_wall
from pellucid.findings import listed
from pellucid.geometry.region import Region, Selectable
from pellucid.grid.model import GridCase
from pellucid.parts.body_model import is_alone, selectable_of
from pellucid.parts.capabilities import NodalSupport
from pellucid.parts.condition import is_driven
from pellucid.parts.support_precedence import find_owners, is_across


class _Numbered(NamedTuple):
    """A support of the case, split so that it acts on at most one face of the grid, with its name for messages."""

    support: Support  # acts on one face or one region
    label: str  # name in messages


def crossing_supports(case: Case) -> Iterator[str]:
    """Yield a warning for each pair of supports that prescribe different velocities at common nodes, so that one has
    precedence over the other."""
    supports = [
        _Numbered(one, support.label(number)) for number, support in enumerate(case.support) for one in support.on_each_face()
    ]
    texts: dict[str, None] = {}
    for one, other in combinations(supports, 2):
        axes = [axis for axis in range(3) if not case.thin[axis] and _differ(one.support, other.support, axis)]
        if axes:
            texts |= dict.fromkeys(_warnings(case, one, other, axes))
    yield from texts


def leading_out(case: Case) -> Iterator[str]:
    """Yield a warning for each face of the grid whose support would move points of bodies out of the grid."""
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
                    f"{label} moves the face {face} out of the grid at {outward:g} m/s: the run stops when points of "
                    f"{listed(led)} "
                    f"follow it out of the grid. Set the velocity of the support along {axis} to 0, or enlarge the grid and "
                    "prescribe the motion of a solid with a [[motion]]."
                )


def _differ(one: Support, other: Support, axis: int) -> bool:
    """Return True if two supports prescribe different velocities along an axis at the same time, and one has precedence over
    the other."""
    if one.until is not None or other.until is not None or not (one.axes()[axis] and other.axes()[axis]):
        return False
    if None not in (one.body, other.body) and one.body != other.body:
        return False
    if one.velocity[axis] == other.velocity[axis]:
        return False
    faces = [support.face() for support in (one, other) if support.face() is not None]
    if len(faces) == 1:  # a region counts on a face along the axis
        return faces[0] is not None and faces[0][0] == axis
    if len(faces) == 2:  # a wall at rest stops a lid at the edge that they share
        across = any(face is not None and face[0] == axis for face in faces)
        return not across and 0.0 not in (one.velocity[axis], other.velocity[axis])
    return True


def _warnings(case: Case, one: _Numbered, other: _Numbered, axes: list[int]) -> Iterator[str]:
    """Yield the warnings about two supports, for nodes of the grid and for nodes of bodies that have their own nodes; axes:
    axes along which both prescribe different velocities."""
    parts, grid = parts_of(case), case.grid_or_none
    if grid is not None and one.support.body is None and other.support.body is None:
        of = Selectable(_common_nodes(grid, one.support, other.support), periods=grid.periods())
        yield from _overruled(one, other, axes, grid, of, "")
    for body in case.body:
        named = [support.body for support in (one.support, other.support) if support.body is not None]
        of_body = selectable_of(body, parts) if body.owns_nodes(is_alone(body, parts)) else None
        if of_body is not None and all(name == body.name for name in named):
            yield from _overruled(one, other, axes, grid, of_body, f" of body {body.name}")


def _overruled(
    one: _Numbered, other: _Numbered, axes: list[int], grid: GridCase | None, of: Selectable, whose: str
) -> Iterator[str]:
    pair = [on_those(numbered.support, nodes_of(numbered.support, grid, of)) for numbered in (one, other)]
    owner = find_owners(pair, len(of.position), may_leave=bool(whose))
    both = pair[0].nodes & pair[1].nodes
    for axis in axes:
        for loser, winner in ((0, 1), (1, 0)):
            nodes = np.flatnonzero(both & (owner[:, axis] == winner + 1))
            if len(nodes):
                labels = (one.label, other.label)
                place = ", ".join(f"{value:.4g}" for value in of.position[nodes[0]])
                count = f"1 node{whose}" if len(nodes) == 1 else f"{len(nodes)} nodes{whose}"
                yield _text(labels[loser], pair[loser], labels[winner], pair[winner], axis, f"{count}, first at ({place}) m")


def _text(loser: str, overruled: NodalSupport, winner: str, counts: NodalSupport, axis: int, where: str) -> str:
    name, slow, fast = "xyz"[axis], overruled.velocity[axis], counts.velocity[axis]
    text = f"{loser} prescribes {slow:g} m/s along {name}, but {winner} {fast:g} m/s, at {where}"
    if is_across(counts, axis):
        return (
            f"{text}; {winner} is applied to these nodes, because it closes a face of the grid. End the region of {loser} "
            f"one cell before this face, or set the same velocity along {name} for both supports."
        )
    why = (
        "is later in the case"
        if counts.face is None
        else "is slower"
        if abs(slow) != abs(fast)
        else "has the later face in xyz"
    )
    remedy = "Separate their regions" if counts.face is None else f'Remove "{name}" from `fix` of one of the two'
    return f"{text}; {winner} is applied to these nodes, because it {why}. {remedy}, or set the same velocity along {name}."


def _common_nodes(grid: GridCase, *supports: Support) -> np.ndarray:
    """Return positions of grid nodes that include all nodes common to the supports [m], shape (n, 3)."""
    lower, upper = np.array(grid.lower), np.array(grid.extent_upper())
    first, last = (
        np.zeros(3, np.int64),
        np.array([0 if thin else n for thin, n in zip(grid.thin(), grid.counts(), strict=True)]),
    )
    for support in supports:
        region, face = support.region(), support.face()
        if face is not None:
            axis, end = face
            first[axis] = last[axis] = last[axis] if end and first[axis] < last[axis] else first[axis]
        elif isinstance(region, Region) and region.shape is not None and not grid.periodic:
            low, high = region.shape.geometry().bounds()
            active = ~np.array(grid.thin())
            cells = (np.maximum(low, lower) - lower) / grid.cell, (np.minimum(high, upper) - lower) / grid.cell
            first[active] = np.maximum(first, np.floor(cells[0]).astype(np.int64))[active]
            last[active] = np.minimum(last, np.ceil(cells[1]).astype(np.int64))[active]
    if (last < first).any():
        return np.zeros((0, 3))
    ranges = [np.arange(low, high + 1) for low, high in zip(first, last, strict=True)]
    return np.stack([index.ravel() for index in np.meshgrid(*ranges, indexing="ij")], axis=1) * grid.cell + lower


def free_turns(case: Case) -> Iterator[str]:
    """Yield a warning for each rigid body whose translation is fully prescribed, or found in a steady analysis, but whose
    motions have neither the key `rotation` nor `hold_rotation`."""
    parts = parts_of(case)
    for body in case.body:
        motions = [motion for motion in case.motion if motion.body == body.name]
        said = any(motion.turns_about() or motion.hold_rotation is not None for motion in motions)
        if body.is_rigid and (case.steady is not None or is_driven(body.name, parts)) and not said:
            thin = case.thin
            about = [axis for d, axis in enumerate("xyz") if not any(thin[other] for other in range(3) if other != d)]
            turns = ", ".join(f'"{axis}"' for axis in about)
            if about and case.steady is not None:
                where = f"motion {motions[-1].name}" if motions else f"a [[motion]] of body {body.name}"
                yield (
                    f"no motion of the rigid body {body.name} prescribes its rotation; [steady] constrains the "
                    f"rotation about {listed(about)}. Add hold_rotation = [{turns}] to {where} to state this."
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
