"""What happens to one membrane point in a step: its frame, its stress, its damage; inlined into the loops over points."""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.grid.lattice import Lattice
from pellucid.grid.points import FOLDED, INVERTED, NOT_FINITE, OK, PointArrays, Slabs
from pellucid.jit import kernel
from pellucid.materials.damage import DamageRecord, dissipate, upright, weaken
from pellucid.materials.membrane import plane_diffusivity, plane_response, plane_wave_speed
from pellucid.tensors import end_stress_power


class MembraneArrays(NamedTuple):
    """State of membrane points beside mass, volume and stress."""

    frame: np.ndarray  # (n, 9) rows t₁, t₂, normal
    in_plane: np.ndarray  # (n, 4) shape in the frame, the law's own
    plane_stress: np.ndarray  # (n, 3) σ'₁₁, σ'₂₂, σ'₁₂ in the frame [Pa]
    strain_energy: np.ndarray  # (n,) work of the stress [J/kg]


class StrainedMembrane(NamedTuple):
    """Membrane points and what strains them, as kernels take them."""

    lattice: Lattice
    points: PointArrays
    slabs: Slabs
    index: Any  # as in `MappedPoints`
    fans: Any  # the triangles about each point
    gradient: np.ndarray  # (n, 9) of the velocity [1/s]
    law: Any
    state: MembraneArrays
    thickness: float  # [m]
    damage: Any
    record: DamageRecord


@kernel(inline=True)
def in_frame(L, frame):
    """Stretching, components 11, 22, 12 in a frame that stays."""
    tx, ty, tz, sx, sy, sz = frame[0], frame[1], frame[2], frame[3], frame[4], frame[5]
    ax, ay, az = L[0] * tx + L[1] * ty + L[2] * tz, L[3] * tx + L[4] * ty + L[5] * tz, L[6] * tx + L[7] * ty + L[8] * tz
    bx, by, bz = L[0] * sx + L[1] * sy + L[2] * sz, L[3] * sx + L[4] * sy + L[5] * sz, L[6] * sx + L[7] * sy + L[8] * sz
    across = 0.5 * (tx * bx + ty * by + tz * bz + sx * ax + sy * ay + sz * az)
    return tx * ax + ty * ay + tz * az, sx * bx + sy * by + sz * bz, across


@kernel(inline=True)
def turned(damage, fans, frame, L, dt, p):
    """Frame of point p and its old normal's cosine with the new, share of area, stretching in the frame."""
    # the stretching is the mean of those in the frames before and after the normal turns: in the second alone, a normal that
    # swings would stretch the membrane by dt times the square of its rate
    before = in_frame(L, frame[p])
    # normal and share of area, from the triangles about the point
    mx, my, mz = frame[p, 6], frame[p, 7], frame[p, 8]
    nx = ny = nz = share = 0.0
    normals = fans.normals
    for t in range(fans.start[p], fans.start[p + 1]):
        k = uintp(fans.triangle[t])
        cx, cy, cz = normals[k, 0], normals[k, 1], normals[k, 2]
        share += normals[k, 3]
        if upright(damage, cx * mx + cy * my + cz * mz):
            nx += cx
            ny += cy
            nz += cz
    share *= 1.0 / 3.0
    length = sqrt(nx * nx + ny * ny + nz * nz)
    if not upright(damage, length):  # every triangle turned over
        nx, ny, nz, length = -mx, -my, -mz, 1.0
    nx, ny, nz = nx / length, ny / length, nz / length
    # turn the first tangent with the normal: S a = c a + w × a + w (w·a)/(1 + c)
    ux, uy, uz = frame[p, 0], frame[p, 1], frame[p, 2]
    c = mx * nx + my * ny + mz * nz
    wx, wy, wz = my * nz - mz * ny, mz * nx - mx * nz, mx * ny - my * nx
    along = (wx * ux + wy * uy + wz * uz) / (1.0 + c)
    tx = c * ux + wy * uz - wz * uy + wx * along
    ty = c * uy + wz * ux - wx * uz + wy * along
    tz = c * uz + wx * uy - wy * ux + wz * along
    # keep it in the plane and of unit length
    off = tx * nx + ty * ny + tz * nz
    tx, ty, tz = tx - off * nx, ty - off * ny, tz - off * nz
    length = sqrt(tx * tx + ty * ty + tz * tz)
    tx, ty, tz = tx / length, ty / length, tz / length
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
    # spin about the normal, as a rotation of the tangents (Cayley)
    a = 0.25 * dt * (sx * Ltx + sy * Lty + sz * Ltz - tx * Lsx - ty * Lsy - tz * Lsz)
    cosine, sine = (1.0 - a * a) / (1.0 + a * a), 2.0 * a / (1.0 + a * a)
    B11, B22, B12 = before
    D11 = 0.5 * (B11 + tx * Ltx + ty * Lty + tz * Ltz)
    D22 = 0.5 * (B22 + sx * Lsx + sy * Lsy + sz * Lsz)
    D12 = 0.5 * (B12 + 0.5 * (tx * Lsx + ty * Lsy + tz * Lsz + sx * Ltx + sy * Lty + sz * Ltz))
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
    return (tx, ty, tz, sx, sy, sz, nx, ny, nz), c, share, (E11, E22, E12)


@kernel(inline=True)
def responded(surface, p, F, frame, c, share, D, dt, strain):
    """Stress and volume of a point of shape F, damaged by `strain`; its strain energy, new power, signal rate, fault."""
    lattice, points, law, state, thickness = surface.lattice, surface.points, surface.law, surface.state, surface.thickness
    damage, record = surface.damage, surface.record
    tx, ty, tz, sx, sy, sz, nx, ny, nz = frame
    E11, E22, E12 = D
    v, g = points.velocity, surface.gradient[p]
    left, kept = weaken(damage, record, p, strain)
    s11, s22, s12, ratio = plane_response(law, F)
    s11, s22, s12 = left * s11, left * s22, left * s12
    old = state.plane_stress
    power = 0.5 * ((old[p, 0] + s11) * E11 + (old[p, 1] + s22) * E22) + (old[p, 2] + s12) * E12
    volume = share * thickness * ratio
    density = points.mass[p] / volume
    points.volume[p] = volume
    state.strain_energy[p] += dt * power / density
    dissipate(damage, record, p, state.strain_energy[p], kept)
    old[p, 0], old[p, 1], old[p, 2] = s11, s22, s12
    sig, L = points.stress, (g[0], g[1], g[2], g[3], g[4], g[5], g[6], g[7], g[8])
    sig[p, 0] = s11 * tx * tx + s22 * sx * sx + 2.0 * s12 * tx * sx
    sig[p, 1] = s11 * ty * ty + s22 * sy * sy + 2.0 * s12 * ty * sy
    sig[p, 2] = s11 * tz * tz + s22 * sz * sz + 2.0 * s12 * tz * sz
    sig[p, 3] = s11 * ty * tz + s22 * sy * sz + s12 * (ty * sz + tz * sy)
    sig[p, 4] = s11 * tx * tz + s22 * sx * sz + s12 * (tx * sz + tz * sx)
    sig[p, 5] = s11 * tx * ty + s22 * sx * sy + s12 * (tx * sy + ty * sx)
    new_power = volume * end_stress_power((sig[p, 0], sig[p, 1], sig[p, 2], sig[p, 3], sig[p, 4], sig[p, 5]), L, dt)
    speed = sqrt(v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2])
    wave = plane_wave_speed(law, F, density)
    fault = OK
    if c < -0.999:
        fault = FOLDED
    elif ratio <= 0.0:
        fault = INVERTED
    elif not abs(s11 + s22 + s12 + speed + wave + nx + ny + nz) < inf:
        fault = NOT_FINITE
    h = lattice.inverse_cell
    rate = max(h * (wave + speed), 2.0 * h * h * plane_diffusivity(law, F, density))
    return points.mass[p] * state.strain_energy[p], new_power, rate, fault


@kernel(inline=True)
def failed(surface, p):
    """Strain energy, signal rate and fault of a failed point, which has no stress but moves."""
    lattice, points, law, state = surface.lattice, surface.points, surface.law, surface.state
    v, shape = points.velocity, state.in_plane
    speed = sqrt(v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2])
    F = (shape[p, 0], shape[p, 1], shape[p, 2], shape[p, 3])
    wave = plane_wave_speed(law, F, points.mass[p] / points.volume[p])
    fault = OK if speed < inf else NOT_FINITE
    return points.mass[p] * state.strain_energy[p], lattice.inverse_cell * (wave + speed), fault
