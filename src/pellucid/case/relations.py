"""What must hold between the parts of a case: names, places, fields."""

import difflib
from collections.abc import Iterator, Sequence
from math import hypot, inf
from typing import NamedTuple

from pellucid.bodies.models import CLOSE_IT, NEEDS_SPACE, Body, MaterialPointsCase, Membrane
from pellucid.case.lines import Path
from pellucid.case.spec import STEP_MARGIN, OutputCase, Probe, TimeCase
from pellucid.conditions.absorbing import Absorbing
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.pressure import Pressure
from pellucid.conditions.support import BoxRegion, Support
from pellucid.contact.model import Contact
from pellucid.grid.model import GridCase
from pellucid.state import COMPONENT_NAMES, FIELDS

MOST_FRAMES, MOST_ROWS = 100_000, 10_000_000


class Finding(NamedTuple):
    """Something wrong at a place of the case's data."""

    path: Path
    text: str
    remedy: str = ""


class Conditions(NamedTuple):
    """What acts on the bodies from outside; what is wrong in itself is None."""

    supports: Sequence[Support | None]
    motions: Sequence[Motion | None]
    absorbing: Sequence[Absorbing | None]
    pressures: Sequence[Pressure | None]
    contacts: Sequence[Contact | None]


class Disagreement(ValueError):
    """Parts of a case that do not fit together."""

    def __init__(self, findings: list[Finding]) -> None:
        self.findings = findings
        super().__init__("; ".join(f"{'.'.join(map(str, found.path))}: {found.text}" for found in findings))


def findings(
    grid: GridCase | None,
    bodies: Sequence[Body | str | None],
    conditions: Conditions,
    probes: Sequence[Probe | None],
    time: TimeCase | None,
    output: OutputCase | None,
) -> list[Finding]:
    """Everything that does not fit together. A part that is itself wrong is None, or for a body perhaps its name."""
    return [
        *_repeated_names("body", [_name(body) for body in bodies]),
        *_repeated_names("probe", [_name(probe) for probe in probes]),
        *(found for i, body in enumerate(bodies) for found in _body(i, body, grid)),
        *(found for i, body in enumerate(bodies) for found in _cuts(i, body, conditions.supports, grid)),
        *(found for i, body in enumerate(bodies) for found in _outside(i, body, bodies, grid)),
        *(found for i, body in enumerate(bodies) for found in _fixed_step(i, body, grid, time, conditions.motions)),
        *(found for i, support in enumerate(conditions.supports) for found in _support(i, support, grid)),
        *(found for i, motion in enumerate(conditions.motions) for found in _motion(i, motion, bodies)),
        *_repeated_names("motion", _condition_names(conditions)),
        *_repeated_faces(conditions.absorbing),
        *(found for i, face in enumerate(conditions.absorbing) for found in _absorbing(i, face, bodies, conditions.supports)),
        *(found for i, pressure in enumerate(conditions.pressures) for found in _pressure(i, pressure, bodies)),
        *(found for i, contact in enumerate(conditions.contacts) for found in _contact(i, contact, bodies)),
        *_repeated_contacts(conditions.contacts, bodies),
        *_taken_names(conditions),
        *(found for i, probe in enumerate(probes) for found in _probe(i, probe, bodies, conditions)),
        *_instants(time, output),
    ]


def _name(part: Body | Probe | str | None) -> str | None:
    return part if part is None or isinstance(part, str) else part.name


def _repeated_names(kind: str, names: Sequence[str | None]) -> Iterator[Finding]:
    for index, name in enumerate(names):
        if name is not None and name in names[:index]:
            text = f"{kind} number {names.index(name) + 1} has this name already"
            yield Finding((kind, index, "name"), text, "give each its own name")
        if kind == "probe" and name == "time":
            yield Finding((kind, index, "name"), "the first column of the history is called time", "choose another name")


def _body(index: int, body: Body | str | None, grid: GridCase | None) -> Iterator[Finding]:
    if body is None or isinstance(body, str) or grid is None:
        return
    for key, text, remedy in body.grid_problems(grid):
        yield Finding(("body", index, key), text, remedy)
    path = ("body", index, body.place)
    lower, upper = body.bounds()
    ends = zip("xyz", lower, upper, grid.lower, grid.extent_upper(), grid.thin(), strict=True)
    for axis, low, high, grid_low, grid_high, thin in ends:
        if thin:
            continue
        slack = 1e-9 * (grid_high - grid_low)
        reach = f"along {axis} the body reaches from {low:g} to {high:g} m"
        if high <= low and body.place == "shape":
            yield Finding(path, f"{reach}: it has no extent there", "let the upper end lie above the lower one")
            continue
        cut = body.cut_at if isinstance(body, MaterialPointsCase) else ()
        low_free, high_free = f"{axis}-lower" not in cut, f"{axis}-upper" not in cut
        if (low_free and low < grid_low - slack) or (high_free and high > grid_high + slack):
            text = f"{reach}, outside the grid: {grid_low:g} to {grid_high:g} m"
            yield Finding(path, text, "move or shrink the body, or enlarge grid.lower and grid.upper")
        elif low >= grid_high or high <= grid_low:
            yield Finding(path, f"{reach}: `cut_at` leaves nothing of it", "move the body, or the grid")


def _cuts(index: int, body: Body | str | None, supports: Sequence[Support | None], grid: GridCase | None) -> Iterator[Finding]:
    """Planes of symmetry that nothing holds, or that the body does not reach."""
    if not isinstance(body, MaterialPointsCase) or None in supports or grid is None:
        return
    bounds, walls = body.bounds(), (grid.lower, grid.extent_upper())
    for item, face in enumerate(body.cut_at):
        axis, end = "xyz".index(face[0]), int(face.endswith("upper"))
        short = (bounds[end][axis] - walls[end][axis]) * (1.0 if end else -1.0)
        if short < -1e-9 * grid.cell:
            text = f"the shape ends {-short:.4g} m before the face {face}, which does not cut it"
            yield Finding(("body", index, "cut_at", item), text, "leave this face out, or move the shape or the grid")
            continue
        holding = [s for s in supports if s is not None and s.where == face and s.axes()[axis]]
        if not holding or any(holding[-1].velocity):
            text = f"no support at rest holds the face {face} along its normal: it is no plane of symmetry"
            yield Finding(("body", index, "cut_at", item), text, f'add a [[support]] with where = "{face}" and fix = "normal"')


def _outside(
    index: int, body: Body | str | None, bodies: Sequence[Body | str | None], grid: GridCase | None
) -> Iterator[Finding]:
    """Names of bodies that another lies outside of."""
    if not isinstance(body, MaterialPointsCase):
        return
    names = [name for name in map(_name, bodies) if name is not None]
    for item, name in enumerate(body.outside):
        path = ("body", index, "outside", item)
        if name == body.name:
            yield Finding(path, "a body cannot lie outside itself", "leave this name out")
        elif name in body.outside[:item]:
            yield Finding(path, "is named twice", "leave this name out")
        elif name not in names:
            if len(names) == len(bodies):  # else a body without a readable name may be the one meant
                others = [other for other in names if other != body.name]
                yield Finding(path, f"no body has this name; the others are {listed(others) or 'none'}", hint(name, others))
        else:
            other = next(other for other in bodies if _name(other) == name)
            if isinstance(other, Membrane) and grid is not None and any(grid.thin()):
                yield Finding(path, f"the inside of a surface {NEEDS_SPACE}", "leave this name out, or enlarge the grid")
            elif isinstance(other, MaterialPointsCase) and body.name in other.outside and bodies.index(other) < index:
                text = f"{name} lies outside {body.name} too: where they overlap there would be neither"
                yield Finding(path, text, "leave one of the two out")
            elif isinstance(other, Membrane) and not other.surface.closed:
                text = f"the surface of membrane {name} is open: it has no inside that could be left out"
                yield Finding(path, text, f"name bodies of material points and closed membranes; {CLOSE_IT}")


def _fixed_step(
    index: int, body: Body | str | None, grid: GridCase | None, time: TimeCase | None, motions: Sequence[Motion | None]
) -> Iterator[Finding]:
    """A fixed step that cannot be stable even at the start, with signals that cross more than a cell in it."""
    if body is None or isinstance(body, str) or grid is None or time is None or _moves_rigidly(body, grid, motions):
        return
    if body.kind == "membrane-elements":
        return  # its elements bound its step, not the cells: the clock sees them
    material, h = body.material, grid.cell
    speed, spread = material.signals(h)
    wrong = list(body.material.problems()) if isinstance(body, MaterialPointsCase) else []
    for key, text, remedy in wrong:
        yield Finding(("body", index, "material", key), text, remedy)
    if wrong:
        return
    crossing = h / (speed + hypot(*body.velocity)) if speed or any(body.velocity) else inf
    limit = min(crossing, h * h / (2.0 * spread) if spread else inf)
    if time.step is not None and time.step > limit * (1.0 + STEP_MARGIN):
        fastest = speed + hypot(*body.velocity)
        reason = f"in body {body.name} signals move at {fastest:.4g} m/s through cells of {h:g} m"
        yield Finding(
            ("time", "step"),
            f"above {limit:.3g} s, the largest stable step at the start: {reason}",
            "make time.step smaller, or leave it out and let time.courant choose",
        )


def _moves_rigidly(body: Body, grid: GridCase, motions: Sequence[Motion | None]) -> bool:
    """Whether a solid has no waves: a rigid body, or one that follows a motion as a whole."""
    if body.kind != "material-points":
        return False
    free = {axis for axis, thin in enumerate(grid.thin()) if not thin}
    own = (motion for motion in motions if motion is not None and motion.body == body.name and motion.part is None)
    return body.rigid or any(free <= motion.axes() for motion in own)


def _support(index: int, support: Support | None, grid: GridCase | None) -> Iterator[Finding]:
    if support is None or grid is None or not isinstance(support.where, BoxRegion):
        return
    lower, upper = support.where.box.bounds()
    ends = zip("xyz", lower, upper, grid.lower, grid.extent_upper(), grid.thin(), strict=True)
    for axis, low, high, grid_low, grid_high, thin in ends:
        if thin:
            continue
        if high < low or high < grid_low or low > grid_high:
            box, nodes = f"{low:g} to {high:g} m", f"{grid_low:g} to {grid_high:g} m"
            text = f"the box holds no node: {axis} from {box}, the grid's from {nodes}"
            yield Finding(("support", index, "where", "box"), text, "let the box overlap the grid")


def _named_body(path: Path, name: str, bodies: Sequence[Body | str | None]) -> Iterator[Finding | Body]:
    """The body of this name, nothing where it is wrong in itself, or the finding that there is none."""
    names = [known for known in map(_name, bodies) if known is not None]
    for body in bodies:
        if _name(body) == name and body is not None and not isinstance(body, str):
            yield body
    if name not in names and len(names) == len(bodies):  # else a body without a readable name may be the one meant
        yield Finding(path, f"no body has this name; there are {listed(names)}", hint(name, names))


def _motion(index: int, motion: Motion | None, bodies: Sequence[Body | str | None]) -> Iterator[Finding]:
    if motion is None:
        return
    for body in _named_body(("motion", index, "body"), motion.body, bodies):
        if isinstance(body, Finding):
            yield body
        elif getattr(body, "rigid", False):
            text = f"body {motion.body} is rigid: its points cannot follow a motion as well"
            yield Finding(
                ("motion", index, "body"), text, "leave `rigid = true` out: a body that follows a motion as a whole is rigid"
            )


def _absorbing(
    index: int, absorbing: Absorbing | None, bodies: Sequence[Body | str | None], supports: Sequence[Support | None]
) -> Iterator[Finding]:
    if absorbing is None:
        return
    for body in _named_body(("absorbing", index, "body"), absorbing.body, bodies):
        if isinstance(body, Finding):
            yield body
        elif body.kind != "material-points":
            text = f"body {absorbing.body} is a membrane; its waves run along it, not to a face"
            yield Finding(("absorbing", index, "body"), text, "name a body of material-points")
    for support in supports:
        if support is not None and support.where in absorbing.where:
            text = f"a support holds the face {support.where}: what is held absorbs nothing"
            yield Finding(("absorbing", index, "where"), text, "take the face out of one of the two")


def _repeated_faces(absorbing: Sequence[Absorbing | None]) -> Iterator[Finding]:
    seen: set[str] = set()
    for index, condition in enumerate(absorbing):
        for face in condition.where if condition is not None else ():
            if face in seen:
                text = f"the face {face} stands here a second time: it would absorb twice as much as arrives"
                yield Finding(("absorbing", index, "where"), text, "name each face once, with the body that fills it")
            seen.add(face)


def _pressure(index: int, pressure: Pressure | None, bodies: Sequence[Body | str | None]) -> Iterator[Finding]:
    if pressure is None:
        return
    for body in _named_body(("pressure", index, "body"), pressure.body, bodies):
        if isinstance(body, Finding):
            yield body
        elif not isinstance(body, Membrane):
            text = f"body {pressure.body} is no membrane: it has no normal to push along"
            yield Finding(("pressure", index, "body"), text, "name a body of kind membrane-points or membrane-elements")


def _contact(index: int, contact: Contact | None, bodies: Sequence[Body | str | None]) -> Iterator[Finding]:
    if contact is None:
        return
    found = [list(_named_body(("contact", index, "between"), name, bodies)) for name in contact.between]
    yield from (item for items in found for item in items if isinstance(item, Finding))
    fields = {item.field for items in found for item in items if not isinstance(item, Finding)}
    if all(items and not isinstance(items[0], Finding) for items in found) and len(fields) == 1:
        text = f"both bodies belong to the velocity field `{fields.pop()}` and move together: they never touch"
        yield Finding(("contact", index, "between"), text, "give one of them another `field`")


def _repeated_contacts(contacts: Sequence[Contact | None], bodies: Sequence[Body | str | None]) -> Iterator[Finding]:
    fields = {body.name: body.field for body in bodies if body is not None and not isinstance(body, str)}
    seen: dict[frozenset[str], int] = {}
    for index, contact in enumerate(contacts):
        if contact is None or not all(name in fields for name in contact.between):
            continue
        first = seen.setdefault(frozenset(fields[name] for name in contact.between), index)
        if first != index:
            text = f"contact number {first + 1} is between the same velocity fields"
            yield Finding(("contact", index, "between"), text, "keep one of the two")


def _taken_names(conditions: Conditions) -> Iterator[Finding]:
    """Contacts named like another condition: a probe of that name could not tell which is meant."""
    parts = (("support", conditions.supports), ("motion", conditions.motions), ("contact", conditions.contacts))
    first: dict[str, tuple[str, int]] = {}
    for kind, several in parts:
        for index, part in enumerate(several):
            if part is None or part.name is None:
                continue
            other, number = first.setdefault(part.name, (kind, index))
            if kind == "contact" and (other, number) != (kind, index):
                text = f"{other} number {number + 1} has this name already"
                yield Finding(("contact", index, "name"), text, "give each its own name")


def _condition_names(conditions: Conditions) -> list[str | None]:
    return [None if motion is None else motion.name for motion in conditions.motions]


def _probe(index: int, probe: Probe | None, bodies: Sequence[Body | str | None], conditions: Conditions) -> Iterator[Finding]:
    if probe is None:
        return
    choices: Sequence[str]
    if probe.body is None:
        parts = (*conditions.motions, *conditions.supports, *conditions.contacts)
        names = [part.name for part in parts if part is not None and part.name]
        if probe.condition not in names and None not in parts:
            text = f"no support, motion or contact has this name; there are {listed(names) or 'none with a name'}"
            yield Finding(("probe", index, "condition"), text, hint(probe.condition or "", names) or "give it a `name`")
        choices = COMPONENT_NAMES[3]
    else:
        found = list(_named_body(("probe", index, "body"), probe.body, bodies))
        yield from (item for item in found if isinstance(item, Finding))
        if found and isinstance(found[0], Finding):
            return
        fields = list(FIELDS) if not found else list(found[0].probed)  # type: ignore[union-attr]
        if probe.quantity not in fields:
            text = f"body {probe.body} has no such field; it has {listed(fields)}"
            yield Finding(("probe", index, "quantity"), text, hint(probe.quantity, fields))
            return
        choices = FIELDS[probe.quantity].names
    if probe.component is not None and probe.component not in choices:
        text = f"{probe.quantity} has {f'the components {listed(choices)}' if choices else 'no components'}"
        yield Finding(("probe", index, "component"), text, "" if choices else "leave `component` out")


def _instants(time: TimeCase | None, output: OutputCase | None) -> Iterator[Finding]:
    """More instants than anyone can want: their places in the files are laid out when the run begins."""
    if time is None or output is None:
        return
    for key, most, what in (("history", MOST_ROWS, "rows of history.csv"), ("frames", MOST_FRAMES, "frames of the fields")):
        interval = getattr(output, key)
        if interval is not None and time.end / interval > most * (1.0 + 1e-5):  # so that the remedy, rounded, is enough
            text = f"{time.end / interval:.3g} {what} until time.end = {time.end:g} s; a run writes at most {most:,}".replace(
                ",", " "
            )
            yield Finding(("output", key), text, f"use {time.end / most:g} s or more, or leave it out")


def listed(names: Sequence[str]) -> str:
    """Names for a sentence."""
    return ", ".join(names)


def hint(name: str, choices: Sequence[str]) -> str:
    """ "did you mean ..." where one of the choices is close, else empty."""
    close = difflib.get_close_matches(name.lower(), {choice.lower(): choice for choice in choices}, 1)
    found = [choice for choice in choices if close and choice.lower() == close[0]]
    return f"did you mean `{found[0]}`?" if found else ""
