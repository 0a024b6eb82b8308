"""Nodes with small mass. In an explicit step, internal forces would give such nodes excessive velocities; these forces must
therefore not strain points."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import AFFINE
from pellucid.parts.body import Body

if TYPE_CHECKING:
    from pellucid.case import Case

SIZES = "mass", "volume"
SMALL_MASS = 1e-4
"""Nodal mass, relative to the mass of the lightest point, below which the internal forces of a node do not strain points.
It applies to transfers in which points keep their velocity and add the mean increment of their nodes."""


def small_masses(
    case: "Case", bodies: Sequence[Body], fields: Mapping[VelocityField, Sequence[Body]]
) -> dict[VelocityField, float]:
    """Return, for each velocity field, a small nodal mass [kg]. On nodes with less mass, internal forces would cause
    excessive velocities, so these forces are left out of the velocities that strain the points; fields: velocity fields
    with their bodies on the grid."""
    arrays = {body: {name: body.stored_array(name) for name in SIZES if name in body.arrays} for body in bodies}
    small = small_mass(arrays.values())
    if case.time.transfer not in AFFINE or case.grid.functions != "trilinear":
        return dict.fromkeys(fields, small)
    return {
        field: max(small, small_mass_of_affine((arrays[body] for body in members), field.grid, case.time.courant))
        for field, members in fields.items()
    }


def small_mass(bodies: Iterable[Mapping[str, np.ndarray]]) -> float:
    """Return the nodal mass [kg], the same for all velocity fields, below which the internal forces of a node are left out
    of the velocities that strain the points; bodies: the arrays of all bodies of a case, by name."""
    return SMALL_MASS * min(_lightest(arrays["mass"]) for arrays in bodies)


def small_mass_of_affine(bodies: Iterable[Mapping[str, np.ndarray]], grid: Grid, courant: float) -> float:
    """Return the nodal mass [kg], for a velocity field with APIC and linear functions, below which the internal forces of a
    node are left out of the velocities that strain the points; bodies: the arrays of the bodies of the field, by name;
    courant: Courant number of the steps; grid: the grid of the field.

    The affine fields of the points that contribute to a node of small mass return the velocity increments of the node to
    the node, so that the node oscillates like a free mass. Consider a face of a body with n points of mass m along the edge
    of a cell, where the outermost points reach beyond the last node by the fraction ξ of a cell. The node beyond has the
    mass n² ξ m and the stiffness (2n/3)² m c²/h², with the wave speed c and the cell size h. Steps C h/c with the Courant
    number C are stable for ξ above C²/9. In 2-D the mass is n ξ m, the stiffness (2n/3) m c²/h², and the limit of ξ is
    C²/6. The limit used is twice as large.
    """
    dimension = 3 - sum(grid.thin)
    found = [0.0]
    for arrays in bodies:
        mass, volume = arrays["mass"], arrays.get("volume")
        there = mass > 0.0
        if volume is not None and (volume[there] > 0.0).all() and there.any():
            along = (grid.cell_volume / float(np.median(volume[there]))) ** (1.0 / dimension)
            found.append(0.5 * courant**2 * (2.0 / 3.0 * along) ** (dimension - 1) * _lightest(mass))
    return max(found)


def _lightest(mass: np.ndarray) -> float:
    """Return the smallest of the masses of points, shape (n,) [kg], without points that left in an earlier run and have no
    mass."""
    return float(np.min(mass, where=mass > 0.0, initial=np.inf))
