"""The state of a body at the start, with the initial fields that add to it."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pellucid.bodies.initial.contract import InitialField
from pellucid.findings import Finding, Path, listed
from pellucid.model import Vector


def initial_velocity(uniform: Vector, fields: Sequence[InitialField], position: np.ndarray) -> np.ndarray:
    """A uniform velocity and the fields that add to it [m/s], shape (n, 3), at positions [m], shape (n, 3)."""
    velocity = np.tile(np.array(uniform), (len(position), 1))
    for field in fields:
        if field.quantity == "velocity":
            velocity += field.at(position)
    return velocity


def add_initial_state(fields: Sequence[InitialField], arrays: Mapping[str, np.ndarray]) -> None:
    """Add the fields of other quantities than the velocity to the arrays of a body's points, in place."""
    for field in fields:
        if field.quantity != "velocity":
            arrays[field.quantity][:] += field.at(arrays["position"])


def initial_problems(fields: Sequence[InitialField], quantities: Sequence[str], path: Path) -> Iterator[Finding]:
    """Initial fields of a state that the points of a body at `path` do not have."""
    for index, field in enumerate(fields):
        if field.quantity not in quantities:
            text = f'kind "{field.kind}" sets `{field.quantity}`, which the points of this body do not have'
            yield Finding((*path, "initial", index), text, f"they have {listed(quantities)}")
