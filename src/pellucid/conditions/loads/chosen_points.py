"""The points of a body that a load acts on."""

from collections.abc import Iterator

import numpy as np

from pellucid.findings import Finding, Path, refuse
from pellucid.geometry.region import Where, chosen_nodes, faults
from pellucid.parts.annotations import AssembledBody
from pellucid.parts.body_model import BodyModel, selectable_of
from pellucid.parts.part import Parts


def chosen_problems(where: Where, name: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """That a region of the load at a path has none of the nodes of the body of this name, where these are known already."""
    body = parts.named(BodyModel, name)
    if body is not None and (start := selectable_of(body, parts)) is not None:
        yield from faults(where, start, (*path, "where"), name, parts.active_axes)


def chosen_points(where: Where, member: AssembledBody, path: Path) -> np.ndarray:
    """Whether a point of a body that is built is in the region of the load at a path, by the numbers of the points, shape (n,).

    Raises CaseError where none is.
    """
    start, body = member.selectable(), member.body
    refuse(faults(where, start, (*path, "where"), body.name, member.active_axes))
    chosen = np.zeros(body.n_points, bool)
    chosen[body.stored_array("id")[chosen_nodes(where, start, member.active_axes)]] = True
    return chosen
