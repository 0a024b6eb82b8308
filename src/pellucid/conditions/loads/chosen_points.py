"""Selection of the points of a body on which a load acts."""

from collections.abc import Iterator

import numpy as np

from pellucid.findings import Finding, Path, refuse
from pellucid.geometry.region import Where, chosen_nodes, faults
from pellucid.parts.annotations import AssembledBody
from pellucid.parts.body_model import BodyModel, selectable_of
from pellucid.parts.part import Parts


def chosen_problems(where: Where, name: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding if a region (`where`, at `path` in the case) contains none of the nodes of the body named `name`;
    bodies whose nodes are known only when they are built are not checked."""
    body = parts.named(BodyModel, name)
    if body is not None and (start := selectable_of(body, parts)) is not None:
        yield from faults(where, start, (*path, "where"), name, parts.active_axes)


def chosen_points(where: Where, member: AssembledBody, path: Path) -> np.ndarray:
    """Return a mask of the points of a built body in the region `where` of a load, by number of the point, shape (n,).

    path: path of the region in the case. Raises CaseError if there is no point in it.
    """
    start, body = member.selectable(), member.body
    refuse(faults(where, start, (*path, "where"), body.name, member.active_axes))
    chosen = np.zeros(body.n_points, bool)
    chosen[body.stored_array("id")[chosen_nodes(where, start, member.active_axes)]] = True
    return chosen
