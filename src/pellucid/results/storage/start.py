"""The state of an earlier run that a case goes on from, from its last checkpoint or from a frame."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from pellucid.errors import CaseError, Problem, UsageError
from pellucid.results.storage import checkpoint
from pellucid.results.storage.run import Run
from pellucid.results.storage.stored_case import StoredBody
from pellucid.state import of_owner

if TYPE_CHECKING:
    from pellucid.case import Case

State = dict[str, np.ndarray]


def read_start(case: "Case", say: Callable[[str], object]) -> dict[str, State]:
    """Arrays of the bodies that go on, by name and in the order of the numbers of the points; none where a case begins anew.

    Raises `CaseError` naming the key where the earlier run has no such body, state or instant.
    """
    start = case.start
    if start is None:
        return {}
    run = Run(start.path)
    before = [body.name for body in run.stored.bodies]
    names = start.body or [body.name for body in case.body if body.name in before]
    missing = [name for name in names if name not in before]
    if missing or not names:
        text = f"the run in {start.path} has no body {', '.join(missing or (body.name for body in case.body))}"
        raise CaseError(Problem(f"{text}; it has {', '.join(before)}", "start.body"))
    for name in names:
        _same_body(case, name, next(body for body in run.stored.bodies if body.name == name))
    if start.time is not None:
        return {name: _frame(run, name, start.time) for name in names}
    found = checkpoint.read_latest(run.folder.checkpoint, say)
    if found is None:
        remedy = "give the instant of a frame by start.time, or let that run go on until it has one"
        raise CaseError(Problem("has no checkpoint", "start.path", start.path, remedy))
    return {name: _in_order(of_owner(name, found[0])) for name in names}


def _same_body(case: "Case", name: str, before: StoredBody) -> None:
    """Raise `CaseError` where the body was of another kind, material or density."""
    number, body = next((i, body) for i, body in enumerate(case.body) if body.name == name)
    now = {"kind": body.kind, "material.kind": body.material.kind, "material.density": body.material.density}
    then = before.kind, before.material, before.density
    for (key, value), old in zip(now.items(), then, strict=True):
        if value != old:
            text = f"the body goes on from a run in which it had {key} = {old}"
            raise CaseError(Problem(text, f"body.{case.body[number].name}.{key}", value, "let it be as there"))


def _frame(run: Run, name: str, time: float) -> State:
    try:
        fields = run.fields(name, time)
    except UsageError as error:
        raise CaseError(Problem(str(error), "start.time", time)) from None
    if "density" in fields:
        fields.setdefault("volume", fields["mass"] / fields["density"])
    return fields


def _in_order(arrays: State) -> State:
    """Those of points by number, as frames have them; what belongs to the grid is left out, it is found anew."""
    order = np.argsort(arrays["id"])
    kept = {name: array for name, array in arrays.items() if not name.startswith(("slabs/", "index/", "skin/"))}
    return {name: array[order] if "/" not in name and len(array) == len(order) else array for name, array in kept.items()}
