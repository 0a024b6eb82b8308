"""Update of one membrane point in a step: rotation of its frame, and rate of deformation and stress in the frame.

Branches only select between numbers, so that loops over points are vectorized.
"""

from math import nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.lattice import Lattice
from pellucid.grid.points import PointArrays, Slabs
from pellucid.jit import pointwise
from pellucid.materials.damage import DamageRecord, upright


class MembraneArrays(NamedTuple):
    """State arrays of n membrane points, in addition to mass, volume and stress in space: frame, in-plane deformation and
    stress in the frame, strain energy.
    """

    frame: np.ndarray  # (n, 9) tangents t₁, t₂ and normal of each point
    in_plane: np.ndarray  # (n, 4) in-plane deformation in the frame, in the form of the law
    plane_stress: np.ndarray  # (n, 3) σ'₁₁, σ'₂₂, σ'₁₂ in the frame [Pa]
    strain_energy: np.ndarray  # (n,) work of the stress [J/kg]


class StrainedMembrane(NamedTuple):
    """Data of n membrane points for the kernels that update their strains and stresses: points, triangles, velocity gradients,
    material and damage laws, and state.
    """

    lattice: Lattice  # cells of the grid
    points: PointArrays  # positions, velocities, masses, volumes, stresses
    slabs: Slabs  # layers of grid cells by which the points are sorted
    index: Any  # storage order of the points, as in `MappedPoints`
    fans: Any  # the triangles around each point, see `Fans`
    gradient: np.ndarray  # (n, 9) velocity gradients [1/s]
    law: Any  # material law in plane stress
    state: MembraneArrays  # frames, in-plane deformations and stresses, energies
    thickness: float  # thickness at rest [m]
    damage: Any  # damage law
    record: DamageRecord  # damage of the points


@pointwise
def in_frame(L, frame):
    """Return the rate of deformation in the plane of a fixed frame [1/s], components 11, 22, 12, for the velocity gradient L
    [1/s]. frame: tangents t₁, t₂ and normal, nine numbers.
    """
    tx, ty, tz, sx, sy, sz = frame[0], frame[1], frame[2], frame[3], frame[4], frame[5]
    ax, ay, az = L[0] * tx + L[1] * ty + L[2] * tz, L[3] * tx + L[4] * ty + L[5] * tz, L[6] * tx + L[7] * ty + L[8] * tz
    bx, by, bz = L[0] * sx + L[1] * sy + L[2] * sz, L[3] * sx + L[4] * sy + L[5] * sz, L[6] * sx + L[7] * sy + L[8] * sz
    across = 0.5 * (tx * bx + ty * by + tz * bz + sx * ax + sy * ay + sz * az)
    return tx * ax + ty * ay + tz * az, sx * bx + sy * by + sz * bz, across


@pointwise
def turned(damage, total, frame):
    """Return the new first tangent and normal of a point, and the cosine of the angle between the old and the new normal.

    damage: damage law; total: sum of the normals of the triangles around the point; frame: the old tangents and normal.
    """
    ux, uy, uz, _, _, _, mx, my, mz = frame
    nx, ny, nz = total
    length = sqrt(nx * nx + ny * ny + nz * nz)
    if not upright(damage, length):  # every triangle turned over
        nx, ny, nz, length = -mx, -my, -mz, 1.0
    inverse = 1.0 / length if length > 0.0 else nan
    nx, ny, nz = nx * inverse, ny * inverse, nz * inverse
    # turn the first tangent with the normal: S a = a - (m + n) (n·a)/(1 + c) of a across m
    c = mx * nx + my * ny + mz * nz
    along = (nx * ux + ny * uy + nz * uz) / (1.0 + c if c > -1.0 else 1.0)
    tx, ty, tz = ux - along * (mx + nx), uy - along * (my + ny), uz - along * (mz + nz)
    # keep it in the plane and of unit length
    off = tx * nx + ty * ny + tz * nz
    tx, ty, tz = tx - off * nx, ty - off * ny, tz - off * nz
    inverse = 1.0 / sqrt(tx * tx + ty * ty + tz * tz)
    return (tx * inverse, ty * inverse, tz * inverse), (nx, ny, nz), c


@pointwise
def spun(L, before, tangent, normal, dt):
    """Return the frame with a new normal and first tangent, rotated by the spin about the normal over a step dt [s], and
    the rate of deformation in this frame [1/s], components 11, 22, 12.

    L: velocity gradient [1/s]; before: rate of deformation in the old frame [1/s]; tangent, normal: first tangent and
    normal from `turned`.
    """
    tx, ty, tz = tangent
    nx, ny, nz = normal
    sx, sy, sz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
    Ltx, Lty, Ltz = (
        L[0] * tx + L[1] * ty + L[2] * tz,
        L[3] * tx + L[4] * ty + L[5] * tz,
        L[6] * tx + L[7] * ty + L[8] * tz,
    )
    Lsx, Lsy, Lsz = (
        L[0] * sx + L[1] * sy + L[2] * sz,
        L[3] * sx + L[4] * sy + L[5] * sz,
        L[6] * sx + L[7] * sy + L[8] * sz,
    )
    sLt, tLs = sx * Ltx + sy * Lty + sz * Ltz, tx * Lsx + ty * Lsy + tz * Lsz
    # spin about the normal, as a rotation of the tangents (Cayley)
    a = 0.25 * dt * (sLt - tLs)
    inverse = 1.0 / (1.0 + a * a)
    cosine, sine = (1.0 - a * a) * inverse, 2.0 * a * inverse
    # the stretching is the mean of those in the frames before and after the normal turns: in the second alone, a normal that
    # swings would stretch the membrane by dt times the square of its rate
    D11 = 0.5 * (before[0] + tx * Ltx + ty * Lty + tz * Ltz)
    D22 = 0.5 * (before[1] + sx * Lsx + sy * Lsy + sz * Lsz)
    D12 = 0.5 * (before[2] + 0.5 * (sLt + tLs))
    tx, ty, tz, sx, sy, sz = (
        cosine * tx + sine * sx,
        cosine * ty + sine * sy,
        cosine * tz + sine * sz,
        cosine * sx - sine * tx,
        cosine * sy - sine * ty,
        cosine * sz - sine * tz,
    )
    # the stretching in the turned frame
    E11 = cosine * cosine * D11 + sine * sine * D22 + 2.0 * sine * cosine * D12
    E22 = sine * sine * D11 + cosine * cosine * D22 - 2.0 * sine * cosine * D12
    E12 = sine * cosine * (D22 - D11) + (cosine * cosine - sine * sine) * D12
    return (tx, ty, tz, sx, sy, sz, nx, ny, nz), (E11, E22, E12)


@pointwise
def in_space(s, frame):
    """Return the stress in space, components xx, yy, zz, yz, xz, xy, from its components 11, 22, 12 in the frame (t₁, t₂,
    normal).
    """
    s11, s22, s12 = s
    tx, ty, tz, sx, sy, sz, _, _, _ = frame
    return (
        s11 * tx * tx + s22 * sx * sx + 2.0 * s12 * tx * sx,
        s11 * ty * ty + s22 * sy * sy + 2.0 * s12 * ty * sy,
        s11 * tz * tz + s22 * sz * sz + 2.0 * s12 * tz * sz,
        s11 * ty * tz + s22 * sy * sz + s12 * (ty * sz + tz * sy),
        s11 * tx * tz + s22 * sx * sz + s12 * (tx * sz + tz * sx),
        s11 * tx * ty + s22 * sx * sy + s12 * (tx * sy + ty * sx),
    )
