"""The fastest point of a simulation, which shows where an unstable run diverges."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from pellucid.parts.body import Body, in_metres


def fastest_point(bodies: Iterable[Body]) -> tuple[str, dict[str, Any]]:
    """Return a description of the fastest point of the bodies, and its data for `RunStopped` (body, number of the point,
    position [m]); both empty if nothing moves. A point whose velocity is not finite counts as fastest."""
    found: tuple[float, Body, int] | None = None
    for body in bodies:
        speed = np.linalg.norm(body.stored_field("velocity"), axis=1)
        speed[np.isnan(speed)] = np.inf
        p = int(np.argmax(speed))
        if speed[p] > (found[0] if found else 0.0):
            found = float(speed[p]), body, p
    if found is None:
        return "", {}
    speed, body, p = found
    point, position = int(body.stored_field("id")[p]), body.stored_field("position")[p]
    words = f"fastest point: number {point} of body `{body.name}` at {in_metres(position)}, {speed:.4g} m/s"
    return words, {"body": body.name, "point": point, "position": position.tolist()}
