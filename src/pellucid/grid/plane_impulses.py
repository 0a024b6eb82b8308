"""Impulses of planes of symmetry on points whose shape functions they mirror (`pellucid.grid.folding`).

The mass m of a node next to a plane contains the mass M of points beyond the plane, the mirror images of points within the
grid. A change u of the normal velocity of the node changes the momentum of both, with opposite signs along the normal. The
points within the grid therefore gain m u - 2 M u, and the plane exerts -2 M u, in addition to the impulse on the nodes in the
plane. With the share f of FLIP and the velocity v at the end of the step, u = f Δv + (1 - f) v.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy import uintp

from pellucid.energy import StepWork, no_work
from pellucid.grid.folding import Mirrored
from pellucid.grid.points import place_of
from pellucid.grid.stencil import functions_at, number_at, stencil_of
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.part import StepPart


class PointsAtPlanes(NamedTuple):
    """Data from which the impulses of planes on the points of a body are summed."""

    mapped: Bundle  # of `MappedPoints`
    flip: float  # share of FLIP in the velocities of the points


@parallel_loop()
def _sum_impulses(s, points, sums):
    """Compute the impulses of planes on the points of slab s [N s], into row s of `sums`, three numbers for each support;
    points: `PointsAtPlanes`."""
    mapped, flip = points.mapped, points.flip
    lattice, nodes, folding, x = mapped.lattice, mapped.nodes, mapped.lattice.folding, mapped.points.position
    for k in range(sums.shape[1]):
        sums[s, k] = 0.0
    for q in range(mapped.slabs.first[s], mapped.slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        start, found = functions_at(mapped.functions, lattice, (x[p, 0], x[p, 1], x[p, 2]))
        if folding.reaches[uintp(start + folding.shift)] == 0:
            continue
        about = stencil_of(mapped.functions, start, found)
        wx, wy, wz, m = about.wx, about.wy, about.wz, mapped.points.mass[p]
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    beyond = uintp(number_at(about, lattice, a, b, c) + folding.shift)
                    for axis in range(3 if folding.beyond[beyond] else 0):
                        if folding.face[beyond, axis] >= 0:
                            support = nodes.constrained[uintp(folding.face[beyond, axis]), axis]
                            I = uintp(folding.real[beyond])
                            u = flip * nodes.velocity_increment[I, axis] + (1.0 - flip) * nodes.velocity[I, axis]
                            sums[s, 3 * (support - 1) + axis] -= 2.0 * m * wx[a] * wy[b] * wz[c] * u


class Mapped(Protocol):
    """Interface of a body whose points move with the nodes of the grid, as `PlaneImpulses` reads it."""

    n_slabs: int  # number of slabs into which the points are divided
    mapped: Bundle  # the points, bundle of `MappedPoints`
    transfer: VelocityTransfer  # transfer of velocities between points and grid


class PlaneImpulses(StepPart):
    """Impulses of planes of symmetry on the points of the bodies of a velocity field, in addition to those on nodes.

    n_supports: number of supports, whose impulses the works of a step contain; flip: share of FLIP, default that of the
    transfer of each body.
    """

    def __init__(self, bodies: Sequence[Mapped], n_supports: int, flip: float | None = None) -> None:
        self._bodies, self._given = bodies, np.zeros((n_supports + 1, 3))
        self._n_supports = n_supports
        shares = [body.transfer.flip if flip is None else flip for body in bodies]
        self._points = [Bundle(PointsAtPlanes(body.mapped, share)) for body, share in zip(bodies, shares, strict=True)]

    def after_momentum(self) -> None:
        self._given[:] = 0.0
        for body, points in zip(self._bodies, self._points, strict=True):
            sums = np.zeros((body.n_slabs, self._given.size))
            _sum_impulses(body.n_slabs, points, sums)
            self._given += ordered_sum(domain.complete(sums)).reshape(-1, 3)

    def work(self) -> StepWork:
        return no_work(0, self._n_supports)._replace(reactions=self._given)


def plane_impulses(field: VelocityField, bodies: Sequence[Any], n_supports: int) -> list[PlaneImpulses]:
    """Return the impulses of planes of symmetry in a velocity field in a list, or none if the grid mirrors no shape functions.

    bodies: bodies of the field on the grid; n_supports: see `PlaneImpulses`.
    """
    return [PlaneImpulses(bodies, n_supports)] if isinstance(field.grid.lattice.folding, Mirrored) else []
