"""Straining of membrane points: gradients from the grid, frames from the moved triangles, plane stress from the law.

Source: Gan et al. 2011, section 2.1, with the misprints put right: strains are summed in the point's frame, and the frame
also takes the spin about its normal, without which a sheet that turns in its own plane would leave its stress behind.

Damage that follows a mean of the strain needs the strains of all points before the stress of any: `stretch` and `respond` are
the two halves of `strain`. A failed point keeps its strain, frame and volume: they mean nothing where the material is torn.
"""

from math import sqrt

from numpy import intp, uintp

from pellucid.bodies.membrane_points.point import failed, in_frame, responded, turned
from pellucid.grid.points import HEATING, OK, POWER, RATE, STORED, place_of
from pellucid.grid.stencil import gather, gather_gradient, stencil
from pellucid.grid.transfer import placed
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.materials.damage import driving_strain, has_failed
from pellucid.materials.membrane import stretched

CHUNK = 1024  # triangles that a thread takes at a time


@kernel(inner=True)
def _gather_slab(s, mapped, gradient, dt, move):
    functions, lattice, nodes, index = mapped.functions, mapped.lattice, mapped.nodes, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    left_slab = first_fault = at_fault = 0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, x, p)
        L, new = gather_gradient(about, lattice, nodes.strain_velocity), gather(about, lattice, nodes.velocity)
        for d in range(9):
            gradient[p, d] = L[d]
        if move:
            fault, beyond = placed(lattice, x, p, dt * new[0], dt * new[1], dt * new[2], lowest, highest)
            left_slab |= beyond
            if fault != OK and first_fault == OK:
                first_fault = fault
                at_fault = intp(p)  # type: ignore[assignment]
    slabs.left_slab[s] = left_slab
    slabs.fault[s, 0] = first_fault
    slabs.fault[s, 1] = at_fault


@kernel()
def gather_gradients(n, mapped, gradient, dt, move):
    """Velocity gradients into `gradient`, shape (points, 9); where `move`, new positions."""
    parallel_for(_gather_slab, n, mapped, gradient, dt, move)


@kernel(inner=True)
def _find_normals_chunk(chunk, position, fans):
    triangles, normals = fans.triangles, fans.normals
    for k in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(triangles))):
        p, q, r = uintp(triangles[k, 0]), uintp(triangles[k, 1]), uintp(triangles[k, 2])
        x, y, z = position[p, 0], position[p, 1], position[p, 2]
        ax, ay, az = position[q, 0] - x, position[q, 1] - y, position[q, 2] - z
        bx, by, bz = position[r, 0] - x, position[r, 1] - y, position[r, 2] - z
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        twice = sqrt(cx * cx + cy * cy + cz * cz)
        normals[k, 0], normals[k, 1], normals[k, 2], normals[k, 3] = cx / twice, cy / twice, cz / twice, 0.5 * twice


@kernel()
def find_normals(chunks, position, fans):
    """Normals and areas of the triangles of a surface; chunks: of CHUNK triangles."""
    parallel_for(_find_normals_chunk, chunks, position, fans)


@kernel(inner=True)
def _strain_slab(s, surface, dt):
    slabs, index, fans, gradient = surface.slabs, surface.index, surface.fans, surface.gradient
    law, state, damage, record = surface.law, surface.state, surface.damage, surface.record
    frame, shape = state.frame, state.in_plane
    stored = power = rate = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if has_failed(damage, record, p):
            energy, signal, fault = failed(surface, p)
            new_power = 0.0
        else:
            Q, c, share, D = turned(damage, fans, frame, gradient[p], dt, p)
            F = stretched(law, (shape[p, 0], shape[p, 1], shape[p, 2], shape[p, 3]), D, dt)
            for d in range(4):
                shape[p, d] = F[d]
            for d in range(9):
                frame[p, d] = Q[d]
            energy, new_power, signal, fault = responded(surface, p, F, Q, c, share, D, dt, driving_strain(damage, law, F))
        stored += energy
        power += new_power
        rate = max(rate, signal)
        if fault != OK and slabs.fault[s, 0] == OK:
            slabs.fault[s, 0] = fault
            slabs.fault[s, 1] = p
    slabs.sums[s, STORED] = stored
    slabs.sums[s, HEATING] = 0.0
    slabs.sums[s, POWER] = power
    slabs.sums[s, RATE] = rate


@kernel()
def strain(n, surface, dt):
    """Frames, shapes, volumes and stresses of the points whose gradients and positions are new."""
    parallel_for(_strain_slab, n, surface, dt)


@kernel(inner=True)
def _stretch_slab(s, surface, number, torn, local, kinematics, dt):
    slabs, index, fans, gradient = surface.slabs, surface.index, surface.fans, surface.gradient
    law, state, damage, record = surface.law, surface.state, surface.damage, surface.record
    frame, shape = state.frame, state.in_plane
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        F = (shape[p, 0], shape[p, 1], shape[p, 2], shape[p, 3])
        opening = 0.0
        if has_failed(damage, record, p):
            E11, E22, E12 = in_frame(gradient[p], frame[p])
            if driving_strain(damage, law, F) > damage.failure_strain:
                torn[p, 0] += dt * E11
                torn[p, 1] += dt * E22
                torn[p, 2] += dt * E12
                half = 0.5 * (torn[p, 0] - torn[p, 1])
                opening = 0.5 * (torn[p, 0] + torn[p, 1]) + sqrt(half * half + torn[p, 2] * torn[p, 2])
        else:
            Q, c, share, D = turned(damage, fans, frame, gradient[p], dt, p)
            F = stretched(law, F, D, dt)
            for d in range(4):
                shape[p, d] = F[d]
            for d in range(9):
                frame[p, d] = Q[d]
            for d in range(3):
                kinematics[p, d] = D[d]
            kinematics[p, 3], kinematics[p, 4] = c, share
        local[number[p]] = driving_strain(damage, law, F) + opening


@kernel()
def stretch(n, surface, number, torn, local, kinematics, dt):
    """Frames and shapes of the points; the strains that drive damage into `local`, shape (points,), by number.

    A point that tore by its own strain counts with what it has opened since too, which `torn`, shape (points, 3), sums up in
    its frame: the opening of a crack is the same on any grid, its strain is not. A point that failed for its neighbours'
    strain alone counts with its strain at failure, or failure would spread without end. `kinematics`, shape (points, 5),
    takes along to `respond`: stretching, turn of the normal, share of area.
    """
    parallel_for(_stretch_slab, n, surface, number, torn, local, kinematics, dt)


@kernel(inner=True)
def _respond_slab(s, surface, number, mean, kinematics, dt):
    slabs, index, state, damage, record = surface.slabs, surface.index, surface.state, surface.damage, surface.record
    frame, shape = state.frame, state.in_plane
    stored = power = rate = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if has_failed(damage, record, p):
            energy, signal, fault = failed(surface, p)
            new_power = 0.0
        else:
            F, k, t = (shape[p, 0], shape[p, 1], shape[p, 2], shape[p, 3]), kinematics[p], frame[p]
            Q = (t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8])
            energy, new_power, signal, fault = responded(surface, p, F, Q, k[3], k[4], (k[0], k[1], k[2]), dt, mean[number[p]])
        stored += energy
        power += new_power
        rate = max(rate, signal)
        if fault != OK and slabs.fault[s, 0] == OK:
            slabs.fault[s, 0] = fault
            slabs.fault[s, 1] = p
    slabs.sums[s, STORED] = stored
    slabs.sums[s, HEATING] = 0.0
    slabs.sums[s, POWER] = power
    slabs.sums[s, RATE] = rate


@kernel()
def respond(n, surface, number, mean, kinematics, dt):
    """Volumes and stresses after `stretch`, with damage by the strains `mean`, shape (points,), by number."""
    parallel_for(_respond_slab, n, surface, number, mean, kinematics, dt)
