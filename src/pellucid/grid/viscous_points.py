"""Viscous stresses and forces of points from nodal velocities, for `pellucid.grid.implicit_viscosity`."""

from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import with_fields
from pellucid.grid.particle_to_grid import InternalForce, InternalForceRead
from pellucid.grid.passes.gifts import BySquare, by_slope, giving
from pellucid.grid.passes.points_pass import Declaration, Found, at_point, gathered, pass_points
from pellucid.grid.points import OK, POWER, MappedPoints, place_of
from pellucid.grid.stencil import gather_gradient
from pellucid.jit import point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.tensors import IDENTITY, double_dot, symmetric_part


class Read(NamedTuple):
    """Input of the loops of implicit viscosity at one point, or the arrays of all points: position and volume."""

    position: Any  # [m]
    volume: Any  # [m³]


class Kept(NamedTuple):
    """Output of the loop `straining_by_viscosity` at one point, or the array of all points: the viscous stress."""

    stress: Any  # viscous stress [Pa]


class StressByViscosity(NamedTuple):
    """Operation at each point: computes the viscous stress σ = 2μD + λ tr(D) I from the strain rate D of the nodal velocity."""

    mu: float  # μ [Pa s]
    lam: float  # λ [Pa s]


@point_function(gathered, StressByViscosity)
def _gradient(rule, about, lattice, nodes, p, known):
    return gather_gradient(about, lattice, nodes.velocity)


@point_function(at_point, StressByViscosity)
def _stress(task, lattice, dt, p, known, g):
    D, two_mu = symmetric_part(g), 2.0 * task.mu
    bulk = task.lam * (D[0] + D[1] + D[2])
    stress = (two_mu * D[0] + bulk, two_mu * D[1] + bulk, two_mu * D[2] + bulk, two_mu * D[3], two_mu * D[4], two_mu * D[5])
    return Found(Kept(stress), (p.volume * double_dot(stress, D),), 0.0, float(OK))


def straining_by_viscosity(
    mapped: MappedPoints, mu: float, lam: float, stress: np.ndarray, velocity: np.ndarray, force: np.ndarray
) -> Bundle:
    """Build the loop that computes the viscous stresses of the points of a body with the viscosities μ and λ [Pa s], and maps
    their forces to the nodes.

    stress: output [Pa], shape (points, 6). velocity: nodal velocities [m/s], in rows of four numbers, shape (4 nodes,).
    force: nodal rows to which the viscous forces are added [N]. Fills the column POWER of the sums over points with Σ V σ:D
    [W]. mapped: the points.
    """
    points = mapped.points
    nodes = with_fields(mapped.nodes, {"velocities": velocity, "forces": force})
    gives = by_slope(InternalForce(), InternalForceRead(points.volume, stress, ()), force)
    declared = Declaration(gathers=IDENTITY, sums=(POWER,))
    read, kept = Read(points.position, points.volume), Kept(stress)
    return pass_points(StressByViscosity(mu, lam), declared, mapped._replace(nodes=nodes), read, kept, gives)


def diagonal_by_viscosity(mapped: MappedPoints, mu: float, lam: float, into: np.ndarray) -> Bundle:
    """Build the loop that adds the diagonal of the viscous operator of a body's points, Σ V (μ |∇N|² + (μ+λ) (∂N/∂x_d)²) along
    each axis d [kg/s], to the nodal rows `into`, shape (4 nodes,).

    mu, lam: viscosities μ and λ [Pa s].
    """
    return giving(mapped, BySquare(mapped.points.volume, mu, 2.0 * mu + lam, into))


@parallel_loop()
def add_stress(s, mapped, viscous):
    """Add the viscous stresses `viscous` [Pa], shape (points, 6), to the stresses of the points of slab s (see `Slabs`);
    mapped: the points (`MappedPoints`)."""
    stress, slabs, index = mapped.points.stress, mapped.slabs, mapped.index
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        for k in range(6):
            stress[p, k] += viscous[p, k]
