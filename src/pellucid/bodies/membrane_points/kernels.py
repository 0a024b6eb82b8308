"""Straining of membrane points: gradients from the grid, frames from the moved triangles, plane stress from the law.

Source: Gan et al. 2011, section 2.1, with two corrections. Strains are summed in the frame of the point. The frame also
rotates with the spin about its normal; otherwise the stress would not follow a sheet that rotates in its own plane. Damage
that depends on a mean strain requires the strains of all points before any stress is computed; `stretch` and `respond` are
the two halves of `strain` for this case. A failed point keeps its strain, frame and volume, which have no meaning in torn
material.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.bodies.membrane_points.blocks import (
    BAD,
    BEARS,
    COLUMNS,
    FASTEST,
    GRADIENT,
    SHARE,
    STRAIN,
    STRETCHING,
    SUMS,
    fault_in,
    fetch_shapes,
    fetch_stresses,
    keep_shapes,
    keep_stresses,
    respond_to_shapes,
    turn_and_stretch,
    weaken_points,
)
from pellucid.bodies.membrane_points.point import in_frame
from pellucid.grid.passes.blocks import add_columns, largest_of_column
from pellucid.grid.passes.points_pass import Declaration, Found, at_point, pass_points
from pellucid.grid.points import HEATING, OK, POWER, RATE, STORED, MappedPoints, NoCells, place_of
from pellucid.grid.straining import MOTION_LIKE, AtPosition, GatherMotion
from pellucid.jit import point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.columns import BLOCK, WIDTH, put, take
from pellucid.jit.loops import parallel_loop
from pellucid.jit.memory import numbers, zeros
from pellucid.jit.rows import cross, vector_at_point, with_last
from pellucid.jit.vector import LANES, load, store, total
from pellucid.tensors import IDENTITY, ZERO_VECTOR

CHUNK = 1024  # triangles that a thread processes at a time


@parallel_loop()
def find_normals(chunk, position, fans):
    """Compute the normals and areas of the triangles of a surface; a chunk has CHUNK triangles. position: positions of the
    points [m], shape (n, 3); fans: the triangles, which store the results (`Fans`).
    """
    triangles, normals = fans.triangles, fans.normals
    for k in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(triangles))):
        x = vector_at_point(position, uintp(triangles[k, 0]))
        a = vector_at_point(position, uintp(triangles[k, 1])) - x
        b = vector_at_point(position, uintp(triangles[k, 2])) - x
        vector_area = cross(a, b)
        twice = sqrt(total(vector_area * vector_area))
        store(normals, 4 * k, with_last(vector_area / twice, 0.5 * twice))


@pointwise
def _sum_up(c, start, n, surface, s, sums):
    """Add the sums over a block of n points to `sums`, the sums (energy, power) of slab s (a layer of grid cells), and record
    the first fault in the slab.

    c: work array with the values of the points; start: first point of the block; surface: a `StrainedMembrane`.
    """
    slabs = surface.slabs
    add_columns(c, BAD, n, sums, 0, SUMS)
    largest_of_column(c, FASTEST, n, sums, SUMS)
    if slabs.fault[s, 0] == OK and total(load(sums, 0)) > 0.0:
        for q in range(n):
            fault = fault_in(c, q)
            if fault != OK and slabs.fault[s, 0] == OK:
                slabs.fault[s, 0] = fault
                slabs.fault[s, 1] = place_of(surface.index, start + q)


@pointwise
def _keep_sums(slabs, s, sums):
    slabs.sums[s, STORED] = total(load(sums, LANES))
    slabs.sums[s, HEATING] = 0.0
    slabs.sums[s, POWER] = total(load(sums, 2 * LANES))
    top = 0.0
    for lane in range(LANES):
        top = max(top, sums[SUMS * LANES + lane])
    slabs.sums[s, RATE] = top


@parallel_loop()
def strain(s, surface, dt):
    """Update frames, in-plane deformations, volumes and stresses of the points of slab s (a layer of grid cells) from the new
    velocity gradients and positions, over a step dt [s]. surface: a `StrainedMembrane`.
    """
    slabs, law, lattice, thickness = surface.slabs, surface.law, surface.lattice, surface.thickness
    if slabs.first[s] == slabs.first[s + 1]:
        return
    c, sums = numbers(WIDTH * COLUMNS), zeros((SUMS + 1) * LANES)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch_shapes(surface, start, n, c)
        turn_and_stretch(surface, dt, start, n, c, True)
        fetch_stresses(surface, start, n, c)
        weaken_points(surface, start, n, c)
        respond_to_shapes(law, lattice, thickness, dt, n, c)
        keep_shapes(surface, start, n, c)
        keep_stresses(surface, dt, start, n, c)
        _sum_up(c, start, n, surface, s, sums)
    _keep_sums(slabs, s, sums)


@parallel_loop()
def stretch(s, surface, number, torn, local, kinematics, dt):
    """Update frames and deformations of the points of slab s (a layer of grid cells) over a step dt [s], and write the strains
    that drive damage to `local`, shape (points,), in the order of point numbers.

    surface: a `StrainedMembrane`; number: numbers of the points in storage order. The strain of a point that failed by its own
    strain also includes its opening since then, which `torn`, shape (points, 3), accumulates in the frame of the point: the
    opening of a crack does not depend on the grid, but its strain does. For a point that failed only because of the strain of
    its neighbours, the strain at failure is used; otherwise failure would spread without limit. `kinematics`, shape (points,
    5), contains data for `respond`: rate of deformation, cosine of the rotation of the normal, share of area.
    """
    slabs, index, damage, frame = surface.slabs, surface.index, surface.damage, surface.state.frame
    if slabs.first[s] == slabs.first[s + 1]:
        return
    c = numbers(WIDTH * COLUMNS)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch_shapes(surface, start, n, c)
        turn_and_stretch(surface, dt, start, n, c, False)
        keep_shapes(surface, start, n, c)
        for q in range(n):
            p = place_of(index, start + q)
            strain, opening = c[uintp(q + STRAIN * WIDTH)], 0.0
            if c[uintp(q + BEARS * WIDTH)] > 0.0:
                D, cosine = take((ZERO_VECTOR, 0.0), c, q + STRETCHING * WIDTH)
                kinematics[p, 0], kinematics[p, 1], kinematics[p, 2], kinematics[p, 3] = D[0], D[1], D[2], cosine
                kinematics[p, 4] = c[uintp(q + SHARE * WIDTH)]
            elif strain > damage.failure_strain:
                E11, E22, E12 = in_frame(take(IDENTITY, c, q + GRADIENT * WIDTH), frame[p])
                torn[p, 0] += dt * E11
                torn[p, 1] += dt * E22
                torn[p, 2] += dt * E12
                half = 0.5 * (torn[p, 0] - torn[p, 1])
                opening = 0.5 * (torn[p, 0] + torn[p, 1]) + sqrt(half * half + torn[p, 2] * torn[p, 2])
            local[number[p]] = strain + opening


@parallel_loop()
def respond(s, surface, number, mean, kinematics, dt):
    """Update damage, volumes and stresses of the points of slab s (a layer of grid cells) over a step dt [s], after `stretch`
    updated frames and deformations.

    surface: a `StrainedMembrane`; number: numbers of the points in storage order; mean: nonlocal strains that drive damage,
    shape (points,), by point number; kinematics: data of each point from `stretch`, shape (points, 5).
    """
    slabs, index, law, lattice, thickness = surface.slabs, surface.index, surface.law, surface.lattice, surface.thickness
    if slabs.first[s] == slabs.first[s + 1]:
        return
    c, sums = numbers(WIDTH * COLUMNS), zeros((SUMS + 1) * LANES)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch_shapes(surface, start, n, c)
        for q in range(n):
            p = place_of(index, start + q)
            k = kinematics[p]
            put(c, q + STRETCHING * WIDTH, (k[0], k[1], k[2], k[3], mean[number[p]]))
            put(c, q + SHARE * WIDTH, k[4])
        fetch_stresses(surface, start, n, c)
        weaken_points(surface, start, n, c)
        respond_to_shapes(law, lattice, thickness, dt, n, c)
        keep_stresses(surface, dt, start, n, c)
        _sum_up(c, start, n, surface, s, sums)
    _keep_sums(slabs, s, sums)


class Read(NamedTuple):
    """Data that the loop which gathers velocity gradients reads: the position of one point, or the array of all positions."""

    position: Any  # [m]


class Kept(NamedTuple):
    """Data that the loop which gathers velocity gradients writes: new position and velocity gradient of one point, or the
    arrays for all points.
    """

    position: Any  # new position [m]
    gradient: Any  # velocity gradient [1/s]


class GatherGradient(NamedTuple):
    """Task of the loop: keep the velocity gradients that `GatherMotion` gathers, and compute new positions if points move."""

    moving: float  # 1 if the points move, else 0


@point_function(at_point, GatherGradient)
def _move(task, lattice, dt, p, known, g):
    (x, y, z), (L, u), step = p.position, g, task.moving * dt
    return Found(Kept((x + step * u[0], y + step * u[1], z + step * u[2]), L), (), 0.0, 0.0)


def gathering_gradients(mapped: MappedPoints, gradient: np.ndarray, moving: bool) -> Bundle:
    """Build the loop over the points of a membrane that writes their velocity gradients to `gradient`, shape (points, 9) [1/s],
    and moves them if `moving`."""
    declared = Declaration(
        gathers=MOTION_LIKE, rule=GatherMotion(NoCells(), 0.0), rule_reads=AtPosition(ZERO_VECTOR), places=True
    )
    position = mapped.points.position
    return pass_points(GatherGradient(float(moving)), declared, mapped, Read(position), Kept(position, gradient))
