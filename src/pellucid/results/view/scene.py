"""Scene of the browser view: selected times, points and fields of every body, limited to the size of a page."""

import zlib
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.results.pictures.bodies_in_space import Box, faceted, opening
from pellucid.results.pictures.camera import View
from pellucid.results.pictures.drawables import Faceted, ball_radii
from pellucid.results.pictures.quantities import VIEW, Limits, limits, there
from pellucid.results.pictures.style import COLOURS, pretty
from pellucid.results.pictures.surroundings import SEEN as SEEN_WALL
from pellucid.results.pictures.surroundings import around, fan_of, polygon_of, way_into_box
from pellucid.results.storage.probes import scalar
from pellucid.results.storage.run import Run
from pellucid.results.storage.run_folder import StoredWall
from pellucid.state import FIELDS

MOST_POINTS = 200_000
"""Largest number of points of all bodies together. If there are more, points of the largest bodies are omitted at random;
the result files contain all points."""
MOST_INSTANTS = 250
MOST_FIELDS = 8
SEEN = 0.2, 99.8
"""Percentiles of the positions that the window includes; single points may fly far away."""
FIRST = ("velocity", "displacement", "stress", "pressure", "damage", "areal_density", "concentration", "density", "thickness")
WALL_COLOUR = "#b4b8c0"
WORDS = {"velocity": "speed", "stress": "von Mises stress"}
FRONTS = (View(0.0, 0.0), View(-90.0, 0.0), View(-90.0, 90.0))
"""Views of a plane problem, by the axis normal to the plane."""


Fields = dict[str, np.ndarray]


class Actor:
    """A body in the interactive view: the selection of its points, and their fields at any time.

    name: name of the body. most: largest number of points to show. If points are omitted, the view shows the selected
    points without the surface or lines of the body. The selection is random, but the same in every page, because a regular
    selection from a lattice would show stripes.
    """

    def __init__(self, run: Run, name: str, most: int) -> None:
        self.name, self._run = name, run
        start = run.fields(name, float(run.times(name)[0]))
        self.total = len(start["position"])
        self._chosen = np.arange(self.total)
        if most < self.total:
            self._chosen = np.sort(np.random.default_rng(0).choice(self.total, most, replace=False))
        self.start = start["position"][self._chosen]
        self.cells = run.cells(name) if most >= self.total else Cells()
        self.surface = faceted(self.cells, self.start)
        self.radius = float(_radius(run, start) * np.cbrt(self.total / len(self._chosen)))

    @property
    def kind(self) -> str:
        """Representation of the body in the view: "surface", "lines" or "points"."""
        return "surface" if len(self.surface.triangles) else "lines" if len(self.cells.lines) else "points"

    def at(self, time: float) -> Fields:
        """Return the stored fields of the shown points, by name, at the frame nearest to a time [s]."""
        return {name: values[self._chosen] for name, values in self._run.fields(self.name, time).items()}

    def in_box(self, position: np.ndarray) -> np.ndarray:
        """Return positions of the points, shape (n, 3) [m], moved into the box of the grid if the grid is periodic."""
        return position + way_into_box(position, self.cells, self._run.stored.grid)

    def shown(self, fields: Fields) -> Fields:
        """Return the scalar fields that the view offers as colours, by name, shape (n,): scalars, lengths of vectors, von Mises
        stresses, and the displacement since the start [m]. fields: result of `at`."""
        found = {"displacement": np.linalg.norm(fields["position"] - self.start, axis=1)}
        for name, values in fields.items():
            if name not in UNSEEN and (values.ndim == 1 or values.shape[1] in (3, 6)):
                found[name] = scalar(values, names=FIELDS[name].names if name in FIELDS else ())
        return {name: values.astype(np.float32) for name, values in found.items()}


class WallActor:
    """A plane wall in the interactive view, clipped to a box and shown as a surface, or as a line in a plane problem. The
    wall moves as a whole and has no fields."""

    radius = 0.0

    def __init__(
        self, wall: StoredWall, box: tuple[np.ndarray, np.ndarray], across: int | None, times: Sequence[float]
    ) -> None:
        """Compute the outline of the wall at the first time at which it intersects the box.

        box: lower and upper corner [m]. across: axis (0 to 2) normal to a plane problem; None in space. times: times that are
        shown [s].
        """
        self.name, self._wall, self.start = wall.name, wall, np.zeros((0, 3))
        for time in times:
            if not len(self.start):
                self.start = polygon_of(wall, time, *box) - self._way(time)
        self.cells, self.surface = Cells(), Faceted(fan_of(len(self.start)), np.arange(len(self.start)))
        if across is not None and len(self.start):
            along = np.cross(wall.normal, np.eye(3)[across])
            ends = self.start[[int(np.argmin(self.start @ along)), int(np.argmax(self.start @ along))]]
            ends[:, across] = 0.5 * (box[0] + box[1])[across]
            self.start, self.cells = ends, Cells(lines=np.array([(0, 1)]))
            self.surface = Faceted(np.zeros((0, 3), np.int64), np.arange(2))

    @property
    def kind(self) -> str:
        return "lines" if len(self.cells.lines) else "surface"

    def places(self, time: float) -> np.ndarray:
        """Return the corners of the drawn part of the wall at a time [s], shape (n, 3) [m]."""
        return np.asarray(self.start + self._way(time))

    def _way(self, time: float) -> np.ndarray:
        return np.asarray(time * float(self._wall.velocity @ self._wall.normal) * self._wall.normal)


def _radius(run: Run, start: Fields) -> float:
    """Return the radius of the balls or discs that show the points of a body [m]. start: the fields of the first frame.

    A ball has the volume of a point. In a plane problem the radius of a disc is GAPLESS times the radius of a disc with the
    area of a point. For the nodes of a fluid film the radius follows from the extent of the film and the number of nodes.
    """
    grid = run.stored.grid
    if "density" not in start or not (kept := there(start)).any():  # nodes of a film
        return float(0.5 * np.ptp(start["position"], axis=0).max() / np.sqrt(len(start["position"])))
    ball = float(np.median(ball_radii(start["mass"][kept], start["density"][kept])))
    if grid is None or not any(grid.thin()):
        return ball
    return GAPLESS * float(np.sqrt(4.0 / 3.0 * ball**3 / grid.slice_thickness()))


class Pack:
    """Writer of a sequence of compressed arrays, for the interactive view. An array with a `key` is stored as the
    difference from the previous array with this key; an array without a key as differences between consecutive numbers.

    Arrays are quantized to few bits, stored as differences, their bytes transposed, and deflated together. The reader is
    viewer/src/data.js.
    """

    def __init__(self) -> None:
        self._deflate = zlib.compressobj(6)
        self._parts: list[bytes] = []
        self._last: dict[object, np.ndarray] = {}

    def add(self, values: np.ndarray, key: object = None) -> None:
        """Append an array of unsigned integers of one, two or four bytes. key: name of a sequence of similar arrays to
        which the array belongs, such as positions at successive times."""
        flat = np.ascontiguousarray(values).ravel()
        before = self._last.get(key)
        if before is None:
            before = np.concatenate([np.zeros(1, flat.dtype), flat[:-1]]) if flat.size else flat
        if key is not None:
            self._last[key] = flat
        difference = (flat - before).view(flat.dtype.str.replace("u", "i"))  # round the end of the numbers: nothing is lost
        folded = ((difference << 1) ^ (difference >> (8 * flat.itemsize - 1))).view(flat.dtype)  # small ones, of either sign
        self._parts.append(self._deflate.compress(folded.view(np.uint8).reshape(-1, flat.itemsize).T.tobytes()))

    def forget(self) -> None:
        """Discard the previous array of every key, so that the next array with the key is stored in full."""
        self._last.clear()

    def close(self) -> bytes:
        """Finish the compression and return the data of all arrays in zlib's format."""
        return b"".join([*self._parts, self._deflate.flush()])


def places(position: np.ndarray, there: np.ndarray, low: np.ndarray, span: np.ndarray) -> np.ndarray:
    """Return quantized positions, shape (3, n): numbers of steps (integers) from the corner `low` of a box with the sides
    `span` [m], shape (3,) each.

    position: positions [m], shape (n, 3). there: mask of the points that exist, shape (n,); all other points get the value
    GONE.
    """
    sides = np.where(span > 0.0, span, 1.0)
    steps = np.where(there[:, None], (position - low) / sides, 0.0)
    found = np.rint(np.clip(steps, 0.0, 1.0) * LEVELS).astype(np.uint16)
    found[~there] = GONE
    return np.ascontiguousarray(found.T)


def shades(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the values of a field, shape (n,), quantized to one byte each: 0 at the limit `low`, SHADES at the limit
    `high`; values beyond the limits are clipped. NaN becomes SHADES + 1."""
    known = np.isfinite(values)
    found = np.rint(np.clip((np.where(known, values, low) - low) / (high - low), 0.0, 1.0) * SHADES)
    found[~known] = SHADES + 1
    return found.astype(np.uint8)


class Scene(NamedTuple):
    """Contents of the interactive view in a page: metadata as JSON values (`told`), which describe the bodies and times,
    and the compressed arrays of all bodies (`packed`)."""

    told: dict[str, Any]
    packed: bytes


class _Instant(NamedTuple):
    """A body at one time: positions [m], shape (n, 3), masks of the points inside the grid (`there`) and of the points of a
    membrane that have failed and carry no stress (`failed`), and scalar fields by name (`shown`)."""

    position: np.ndarray
    there: np.ndarray
    failed: np.ndarray
    shown: Fields


def scene_of(run: Run, budget: int) -> Scene | None:
    """Select times, points and fields of a run for the interactive view, so that the packed data have at most `budget` bytes
    (at least two times are kept); None for a run in one dimension."""
    bodies = run.stored.bodies
    if sum(run.stored.thin) > 1:
        return None
    sizes = [len(run.fields(body.name, names=("position",))["position"]) for body in bodies]
    actors = [Actor(run, body.name, most) for body, most in zip(bodies, shares(sizes), strict=True)]
    if np.count_nonzero(_sides(actors) == 0.0) > 1:  # nodes of a line
        return None
    times = run.times(bodies[0].name)
    most = min(MOST_INSTANTS, len(times))
    count = min(3, most)  # which tell how much room an instant takes
    while True:
        chosen = times[np.unique(np.linspace(0, len(times) - 1, count).astype(int))]
        scene = _scene(run, actors, chosen, len(times))
        fitting = int(0.95 * budget * count / len(scene.packed))
        if len(scene.packed) > budget and count > 2:
            most = count - 1
            count = max(2, min(fitting, most))
        elif min(fitting, most) > 1.1 * count:
            count = min(fitting, most)
        else:
            return scene


def shares(sizes: list[int]) -> list[int]:
    """Return the number of points that the view shows of each body; sizes: number of points that each body has. Small
    bodies are shown completely; large bodies share the remaining points equally."""
    left, found = MOST_POINTS, [0] * len(sizes)
    ascending = sorted(range(len(sizes)), key=sizes.__getitem__)
    for number, k in enumerate(ascending):
        found[k] = min(sizes[k], left // (len(sizes) - number))
        left -= found[k]
    return found


def _scene(run: Run, actors: list[Actor], times: np.ndarray, recorded: int) -> Scene:
    states = [[_instant(actor, float(time)) for actor in actors] for time in times]
    varying = _fields(states, {"velocity"} if run.stored.steady else set())
    fields = dict(list(varying.items())[:MOST_FIELDS])
    boxes = [bounding_box(actor.start) for actor in actors]
    hidden = [actor.kind == "points" and _surrounds_all(boxes, k) for k, actor in enumerate(actors)]
    shown = [k for k, of_body in enumerate(hidden) if not of_body]
    across = _across(run, actors)
    cut = opening([np.stack(boxes[k]) for k in shown]) if across is None else None
    axes = (VIEW if across is None else FRONTS[across]).axes()
    pack = Pack()
    bodies = []
    for k, actor in enumerate(actors):
        of_body = _packed(pack, actor, [instants[k] for instants in states], fields)
        bodies.append({**of_body, "colour": COLOURS[k % len(COLOURS)], "hidden": hidden[k]})
    box = around(*bounding_box(np.concatenate([at.position[at.there] for instants in states for at in instants])))
    for wall in run.stored.walls:
        drawn = WallActor(wall, box, across, times.tolist())
        if len(drawn.start):
            of_wall = _packed(pack, drawn, [_of_wall(drawn, float(time)) for time in times], fields)
            bodies.append(
                {**of_wall, "colour": WALL_COLOUR, "hidden": across is None and float(wall.normal @ axes[2]) < SEEN_WALL}
            )
    told = {
        "title": run.stored.title,
        "times": times.tolist(),
        "notes": _notes(actors, len(times), recorded, list(varying)[MOST_FIELDS:]),
        "flat": across is not None,
        "axes": axes.tolist(),
        "window": _window([instants[k] for instants in states for k in shown], axes),
        "cut": None if cut is None else [1, -cut.offset],
        "fields": [_told(name, colours, states) for name, colours in fields.items()],
        "bodies": bodies,
    }
    return Scene(told, pack.close())


def _of_wall(wall: WallActor, time: float) -> _Instant:
    places = wall.places(time)
    return _Instant(places, np.ones(len(places), bool), np.zeros(len(places), bool), {})


def _packed(pack: Pack, actor: Actor | WallActor, instants: list[_Instant], fields: dict[str, Limits]) -> dict[str, Any]:
    """Add the arrays of a body to the pack, in the order that viewer/src/data.js requires, and return the metadata with which
    that program reads them.

    instants: the body at each time. fields: limits of the colours of each field.
    """
    low, high = bounding_box(np.concatenate([at.position[at.there] for at in instants]))
    cells = {"vertex": actor.surface.vertex, "triangles": actor.surface.triangles}
    cells |= {"lines": actor.cells.lines, "tetrahedra": actor.cells.tetrahedra}
    for corners in cells.values():
        pack.add(corners.astype(np.uint32).T)
    for at in instants:
        pack.add(places(at.position, at.there, low, high - low), "position")
    known = [name for name in fields if name in instants[0].shown]
    for name in known:
        for at in instants:
            pack.add(shades(at.shown[name], fields[name].low, fields[name].high), name)
    failed = any(bool(at.failed.any()) for at in instants)
    for at in instants if failed else ():
        pack.add(at.failed.astype(np.uint8), "failed")
    pack.forget()
    return {
        "name": actor.name,
        "kind": actor.kind,
        "points": len(actor.start),
        "radius": actor.radius,
        "low": low.tolist(),
        "span": (high - low).tolist(),
        "cells": {name: list(corners.shape) for name, corners in cells.items()},
        "fields": list(map(list(fields).index, known)),
        "failed": failed,
    }


def _window(instants: list[_Instant], axes: np.ndarray) -> dict[str, list[float]]:
    """Return the box around the points at all times, without outliers (`low`, `high` [m]), and its extent to the right and
    upwards from its centre (`reach` [m]). axes: directions to the right, upwards and towards the eye, shape (3, 3)."""
    positions = [at.position[at.there] for at in instants]
    positions = [position for position in positions if len(position)]
    ends = np.array([np.percentile(position, SEEN, axis=0) for position in positions])
    low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
    far = [np.percentile(abs((position - 0.5 * (low + high)) @ axes[:2].T), SEEN[1], axis=0) for position in positions]
    return {"low": low.tolist(), "high": high.tolist(), "reach": np.max(far, axis=0).tolist()}


def _instant(actor: Actor, time: float) -> _Instant:
    fields = actor.at(time)
    failed = fields["failed"] > 0 if "failed" in fields else np.zeros(len(fields["position"]), bool)
    return _Instant(actor.in_box(fields["position"]), there(fields), failed, actor.shown(fields))


def _fields(states: list[list[_Instant]], without: set[str]) -> dict[str, Limits]:
    """Return the limits of the colours of the fields to show, by name, in order of preference; fields that are uniform at all
    times are omitted.

    states: for each time, the bodies. without: names of fields not to show.
    """
    names = {name for instants in states for at in instants for name in at.shown} - without
    ordered = sorted(names, key=lambda name: (FIRST.index(name) if name in FIRST else len(FIRST), name))
    found: dict[str, Limits] = {}
    for name in ordered:
        values = [at.shown[name][at.there] for instants in states for at in instants if name in at.shown]
        together = np.concatenate(values)
        together = together[np.isfinite(together)]
        if together.size and np.ptp(together) > 1e-6 * np.abs(together).max():
            found[name] = limits([together])
    return found


def _told(name: str, colours: Limits, states: list[list[_Instant]]) -> dict[str, Any]:
    values = np.concatenate([at.shown[name][at.there] for instants in states for at in instants if name in at.shown])
    values = values[np.isfinite(values)]
    unit = FIELDS["position" if name == "displacement" else name].unit
    ends = {"low": colours.low, "high": colours.high, "least": float(values.min()), "most": float(values.max())}
    return {"word": _word(name), "unit": "" if unit == "1" else pretty(unit), "palette": colours.palette, **ends}


def _word(name: str) -> str:
    return WORDS.get(name, name.replace("_", " "))


def _surrounds_all(boxes: list[Box], k: int) -> bool:
    """Return True if the bounding box of body `k` contains the bounding boxes of all other bodies, at least two, so that
    the body would hide them."""
    others = boxes[:k] + boxes[k + 1 :]
    return len(others) > 1 and all((boxes[k][0] <= low).all() and (high <= boxes[k][1]).all() for low, high in others)


def _across(run: Run, actors: list[Actor]) -> int | None:
    """Return the axis normal to the plane that contains all bodies; None in space."""
    if any(run.stored.thin):
        return run.stored.thin.index(True)
    sides = _sides(actors)
    return int(np.argmin(sides)) if sides.min() == 0.0 else None


def _sides(actors: list[Actor]) -> np.ndarray:
    """Return the edge lengths of the bounding box of all bodies at the start [m], shape (3,)."""
    return np.ptp(np.concatenate([actor.start for actor in actors]), axis=0)


def _notes(actors: list[Actor], instants: int, recorded: int, left_out: list[str]) -> list[str]:
    """Return notes for the user about the parts of the run that the view does not show. instants, recorded: numbers of shown
    and of recorded frames; left_out: fields that are not offered as colours."""
    notes = []
    for actor in actors:
        if len(actor.start) < actor.total:
            counts = f"{len(actor.start):,} of {actor.total:,}".replace(",", "\u202f")
            notes.append(f"{counts} points of {actor.name} are shown, chosen at random, without cells")
    if instants < recorded:
        notes.append(f"{instants} of {recorded} recorded frames are shown")
    if left_out:
        notes.append(f"Not available as colours: {', '.join(map(_word, left_out))}")
    return notes


GAPLESS = 1.3
"""Factor on the radius of discs in a plane problem, relative to discs of the points' area, so that no gaps are visible."""
UNSEEN = frozenset(("id", "position", "start", "mass", "volume", "driven", "prescribed", "angle", "failed", "in_plane"))
"""Fields that are not offered as colours; failed points have a colour of their own."""


LEVELS = 8191
"""Number of quantization steps of positions along each side of a body's box: about an eighth of a pixel if the box fills
the window."""
GONE = 65535
"""Value that replaces each coordinate of a point that has left the grid."""
SHADES = 254
"""Number of quantization steps between the limits of a field; the next value represents NaN."""
