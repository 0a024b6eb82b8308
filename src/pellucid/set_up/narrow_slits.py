"""Warnings about slits in solids of material points that are too narrow: both sides contribute to the same nodes, so that
they cannot separate or slide."""

from collections.abc import Iterator
from collections.abc import Set as AbstractSet

import numpy as np

from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.case import Case
from pellucid.contact.approaching_parts import (
    ASIDE,
    NARROW,
    PARALLEL,
    describe_gap,
    find_near,
    find_slit,
    select_facing,
)
from pellucid.set_up.hard_bodies import hard_bodies


def narrow_slits(case: Case, going_on: AbstractSet[str] = frozenset()) -> Iterator[str]:
    """Yield a warning for each deforming body of material points with a slit so narrow that both of its sides contribute to
    the same nodes.

    going_on: names of the bodies that continue from an earlier run; they are not checked.

    """
    grid = case.grid
    hard = {body.name for body in hard_bodies(case)}
    x, y, z = (not thin for thin in grid.thin())
    for model in case.body:
        if not isinstance(model, SeededBody) or model.material.flows or model.name in hard | going_on:
            continue
        if model.shape.geometry().is_convex and not model.outside and not any(grid.is_periodic()):
            continue
        place, area = model.with_others(case.body).boundary(grid, hard=False)
        normal, periods = area / np.linalg.norm(area, axis=1, keepdims=True), np.array(grid.periods())
        one, other = find_near(place, float(np.hypot(NARROW, ASIDE)) * grid.cell, np.array(grid.lower, float), periods)
        facing, _ = select_facing(place, normal, one, other, grid.cell, periods, PARALLEL)
        filled = np.zeros(len(facing.middle), bool)
        for body in case.body:
            if body is not model and not body.is_surface and len(filled):
                filled |= body.with_others(case.body).contains(facing.middle, (x, y, z), grid.periods())
        slit = find_slit(facing, ~filled, grid.cell)
        if slit is not None:
            yield describe_gap(model.name, slit, grid.cell, at_start=True)
