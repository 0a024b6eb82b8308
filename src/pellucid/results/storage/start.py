"""Initial state of a case from an earlier run: from its last checkpoint or from a frame."""

import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.errors import CaseError, PellucidError, Problem, UsageError
from pellucid.results.storage import checkpoint
from pellucid.results.storage.files import OutputError
from pellucid.results.storage.identity import told
from pellucid.results.storage.run import Run
from pellucid.state import of_owner

if TYPE_CHECKING:
    from pellucid.case import Case

State = dict[str, np.ndarray]


def read_start(case: "Case", say: Callable[[str], object]) -> dict[str, State]:
    """Return the arrays of the bodies that continue an earlier run, by name, with points in the order of their numbers.

    say: function that shows a message to the user. The result is empty if the case does not continue a run. Raises `CaseError`
    with the key if the earlier run has no such body, state or time.
    """
    start = case.start
    if start is None:
        return {}
    run = Run(start.path)
    tables = _stored_tables(run)
    before = list(tables)
    names = start.body or [body.name for body in case.body if body.name in before]
    missing = [name for name in names if name not in before]
    if missing or not names:
        text = f"the run in {start.path} has no body {', '.join(missing or (body.name for body in case.body))}"
        raise CaseError(Problem(f"{text}; available: {', '.join(before)}", "start.body"))
    problems = [text for name in names for text in _contradictions(case, name, tables[name], start.path)]
    if problems:
        raise CaseError(problems)
    _check_thickness(case, run)
    for name in names:
        body = _of_name(case, name)
        if not body.strained_from_place and not _same(_data(body)[body.place], tables[name].get(body.place)):
            say(
                f"body {name} keeps its position in {start.path}; its `{body.place}`, which differs from this run, has no "
                "effect"
            )
    if start.time is not None:
        return {name: _frame(run, name, start.time) for name in names}
    try:
        found = checkpoint.read_latest(run.folder.checkpoint, say)
    except OutputError as error:
        raise CaseError(Problem(str(error), "start.path", start.path, "Set start.time to use a frame instead.")) from None
    if found is None:
        remedy = "Set start.time to use a frame instead, or continue the earlier run until it writes a checkpoint."
        raise CaseError(Problem("the run has no checkpoint", "start.path", start.path, remedy))
    return {name: _in_order(of_owner(name, found[0])) for name in names}


def _stored_tables(run: Run) -> dict[str, dict[str, Any]]:
    """Return the tables of the bodies in the case of the earlier run, by name of the body. Raises `CaseError` if that case
    cannot be read."""
    try:
        bodies = run.stored.bodies
        data = tomllib.loads(run.folder.case.read_text(encoding="utf-8"))
    except (PellucidError, OSError, ValueError) as error:
        lines = [line for line in str(error).splitlines() if not line.endswith(":")]  # without "3 errors in FILE:"
        text = f"the case of this run cannot be read: {lines[0]}"
        raise CaseError(Problem(text, "start.path", str(run.out), f"Correct {run.folder.case}, or set another run.")) from None
    return {body.name: table for body, table in zip(bodies, data["body"], strict=True)}


def _contradictions(case: "Case", name: str, before: Mapping[str, Any], folder: str) -> Iterator[Problem]:
    """Yield a problem for each difference between the body `name` in the case and in the earlier run that it continues:
    kind, material, and values of the continued state.

    before: table of the body in the case of the earlier run. folder: folder of the earlier run, for the text.
    """
    body = _of_name(case, name)
    now = _data(body)
    for key in ("kind", "material.kind", "material.density"):
        if not _same(_at(now, key), _at(before, key)):
            text = f"differs from the earlier run, in which the body had {key} = {_at(before, key)}"
            yield Problem(text, f"body.{name}.{key}", _at(now, key), "Set the value of the earlier run.")
    for key in (*body.start_only, *([body.place] if body.strained_from_place else [])):
        value, then = _at(now, key), _at(before, key)
        if not _same(value, then) and not _is_default(body, key):
            text = f"the body starts with its state in {folder}, where the value was {told(then)}"
            remedy = (
                "Set the value of the earlier run."
                if key == body.place
                else f"Remove this key, or remove {name} from start.body."
            )
            yield Problem(f"has no effect: {text}", f"body.{name}.{key}", value, remedy)


def _check_thickness(case: "Case", run: Run) -> None:
    """Raise `CaseError` if the thin axes or the slice thickness of the grid differ from the earlier run."""
    grid, before = case.grid_or_none, run.stored.grid
    if grid is None or before is None or not (any(grid.thin()) or any(before.thin())):
        return
    now, then = [(g.thin(), g.slice_thickness() if any(g.thin()) else None) for g in (grid, before)]
    if now != then:
        text = f"the grid of the earlier run is {_slice(*then)}, but this grid is {_slice(*now)}"
        raise CaseError(
            Problem(text, "grid.thickness", grid.thickness, "Use the thin axes and the thickness of the earlier run.")
        )


def _slice(thin: tuple[bool, bool, bool], thickness: float | None) -> str:
    axes = " and ".join(axis for axis, is_thin in zip("xyz", thin, strict=True) if is_thin)
    return f"{thickness:g} m thick along {axes}" if thickness is not None else "without a thin axis"


def _of_name(case: "Case", name: str) -> Any:
    return next(body for body in case.body if body.name == name)


def _data(body: Any) -> dict[str, Any]:
    return dict(body.model_dump(mode="json", by_alias=True, exclude_none=True))


def _at(table: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key of a table of the case; None if the table has no such key."""
    value: Any = table
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return value


def _is_default(body: Any, key: str) -> bool:
    """Return True if a body has the default value at a dotted key, or has no such key."""
    *way, last = key.split(".")
    for part in way:
        body = getattr(body, part, None)
    field = type(body).model_fields.get(last) if body is not None else None
    return field is None or getattr(body, last) == field.get_default(call_default_factory=True)


def _same(now: Any, then: Any) -> bool:
    """Return True if two values of a case are equal; files (values with the key `path`) are compared by content."""
    if isinstance(now, Mapping) and isinstance(then, Mapping):
        return now.keys() == then.keys() and all(
            _same_file(now[key], then[key]) if key == "path" else _same(now[key], then[key]) for key in now
        )
    if isinstance(now, list) and isinstance(then, list):
        return len(now) == len(then) and all(map(_same, now, then))
    return bool(now == then) or (now == [] and then is None)


def _same_file(now: str, then: str) -> bool:
    with suppress(OSError):
        return now == then or Path(now).read_bytes() == Path(then).read_bytes()
    return False


def _frame(run: Run, name: str, time: float) -> State:
    try:
        fields = dict(run.fields(name, time))
    except (UsageError, OutputError) as error:
        raise CaseError(Problem(str(error), "start.time", time)) from None
    if "density" in fields:
        mass = fields["mass"]  # points that left the grid have neither mass nor volume
        fields.setdefault("volume", np.divide(mass, fields["density"], out=np.zeros_like(mass), where=mass > 0.0))
    return fields


def _in_order(arrays: State) -> State:
    """Return the arrays of a body with its points sorted by number, as in frames. Search structures, such as the index of
    points by grid cell, are omitted, because they are computed again."""
    order = np.argsort(arrays["id"][:])
    kept = {name: array[:] for name, array in arrays.items() if not name.startswith(("slabs/", "index/", "skin/"))}
    return {name: array[order] if "/" not in name and len(array) == len(order) else array for name, array in kept.items()}
