"""Update of one constant-strain triangle in a step; inlined into the loops over elements.

The strain is relative to the rest shape: F = x_K ⊗ ∇N_K with the gradients ∇N_K at rest, in the axes of the triangle at
rest. The law depends on C = FᵀF in these axes only. The forces on the corners are -V₀ F S ∇N_K, with the second
Piola-Kirchhoff stress S (Belytschko, Liu & Moran 2000, Nonlinear Finite Elements for Continua and Structures, section 4.9).
No rotating frame is needed and no error accumulates. A triangle without compressive stress may be folded flat and turned
over.
"""

from math import inf, sqrt

from pellucid.bodies.membrane_elements.geometry import cross, dot, edges, in_space
from pellucid.grid.points import COLLAPSED, NOT_FINITE, OK
from pellucid.jit import kernel, pointwise
from pellucid.materials.law import energy
from pellucid.materials.membrane import (
    damped_rate,
    plane_diffusivity,
    plane_response,
    plane_wave_speed,
    principal_tension,
    record_loss,
    shape_of,
    smoothed,
    turned_to,
    with_viscosity,
)

NARROWEST = 1e-3  # smallest principal stretch; below it a triangle that can fold counts as this wide, others have collapsed


@pointwise
def gradients(rest, chi, psi):
    """Return the columns of the deformation gradient F = χ ⊗ b₁ + ψ ⊗ b₂ of a triangle with edges χ and ψ.

    rest: b₁ and b₂, the gradients of the second and third shape function at rest.
    """
    b11, b12, b21, b22 = rest
    return (
        (chi[0] * b11 + psi[0] * b21, chi[1] * b11 + psi[1] * b21, chi[2] * b11 + psi[2] * b21),
        (chi[0] * b12 + psi[0] * b22, chi[1] * b12 + psi[1] * b22, chi[2] * b12 + psi[2] * b22),
    )


@pointwise
def between(w, E):
    """Return the product w E w of two symmetric 2 × 2 tensors, given and returned as components (11, 22, 12)."""
    a11, a12 = w[0] * E[0] + w[2] * E[2], w[0] * E[2] + w[2] * E[1]
    a21, a22 = w[2] * E[0] + w[1] * E[2], w[2] * E[2] + w[1] * E[1]
    return a11 * w[0] + a12 * w[2], a21 * w[2] + a22 * w[1], a11 * w[2] + a12 * w[1]


@pointwise
def _stretches(C, normal):
    """Return the principal stretches of a triangle, at least NARROWEST. C: right Cauchy-Green tensor (11, 22, 12); normal:
    cross product of the columns of the deformation gradient, whose length is the ratio of areas."""
    difference = 0.5 * (C[0] - C[1])
    square = 0.5 * (C[0] + C[1]) + sqrt(difference * difference + C[2] * C[2])
    major = max(sqrt(square), NARROWEST)
    return major, max(sqrt(dot(normal, normal)) / major, NARROWEST)


@kernel(inline=True)
def triangle_energy(surface, x, e):
    """Return the strain energy of triangle e [J] for its present shape. surface: data of `StrainedElements`; x: nodal positions
    [m], shape (n, 3).
    """
    rest = _rest_of(surface.rest, e - surface.n_quads)
    chi, psi = edges(x, surface.corners, e)
    f1, f2 = gradients(rest, chi, psi)
    C = (dot(f1, f1), dot(f2, f2), dot(f1, f2))
    major, minor = _stretches(C, cross(f1, f2))
    return _volume_of(rest, surface.thickness) * energy(surface.law, shape_of(surface.law, C, major, minor))


@kernel(inline=True)
def strain_triangle(surface, x, v, e, dt):
    """Update stress and energy of triangle e after a step dt [s]. Returns its strain energy [J], half its largest
    eigenfrequency [1/s], and a fault code.

    surface: data of `StrainedElements`; x, v: nodal positions [m] and velocities [m/s], shape (n, 3).
    """
    corners, n_quads, law = surface.corners, surface.n_quads, surface.law
    initial, rests, state = surface.thickness, surface.rest, surface.state
    half = 0.5 * dt
    b11, b12, b21, b22 = rest = _rest_of(rests, e - n_quads)
    (chi, psi), (chi_rate, psi_rate) = edges(x, corners, e), edges(v, corners, e)
    f1, f2 = gradients(rest, chi, psi)
    C = (dot(f1, f1), dot(f2, f2), dot(f1, f2))
    normal = cross(f1, f2)
    major, minor = _stretches(C, normal)
    shape = shape_of(law, C, major, minor)
    s11, s22, s12, ratio = plane_response(law, shape)
    at_rest = _volume_of(rest, initial)
    volume = at_rest * major * minor * ratio
    # the rate of Green's strain over the step, from the gradients at its middle
    r1, r2 = gradients(rest, chi_rate, psi_rate)
    m1 = (f1[0] - half * r1[0], f1[1] - half * r1[1], f1[2] - half * r1[2])
    m2 = (f2[0] - half * r2[0], f2[1] - half * r2[1], f2[2] - half * r2[2])
    E11, E22, E12 = dot(m1, r1), dot(m2, r2), 0.5 * (dot(m1, r2) + dot(m2, r1))
    # D = U⁻¹ Ė U⁻¹ and S = V/V₀ U⁻¹ σ U⁻¹, with D and σ turned back to the axes at rest
    w = w11, w22, w12 = turned_to(C[0], C[1], C[2], 1.0 / major, 1.0 / minor)
    D = between(w, (E11, E22, E12))
    s11, s22, s12 = with_viscosity(law, (s11, s22, s12), D, ratio)
    record_loss(law, state.dissipated_energy, e, D, ratio, dt * volume)
    a11, a12, a21, a22 = w11 * s11 + w12 * s12, w11 * s12 + w12 * s22, w12 * s11 + w22 * s12, w12 * s12 + w22 * s22
    share = volume / at_rest
    S11, S22, S12 = share * (a11 * w11 + a12 * w12), share * (a21 * w12 + a22 * w22), share * (a11 * w12 + a12 * w22)
    old = state.plane_stress
    state.strain_energy[e] += (
        half * at_rest * ((old[e, 0] + S11) * E11 + (old[e, 1] + S22) * E22 + (old[e, 2] + S12) * (dot(m1, r2) + dot(m2, r1)))
    )
    old[e, 0], old[e, 1], old[e, 2] = S11, S22, S12
    state.thickness[e], state.volume[e] = initial * ratio, volume
    # waves cross what is folded as fast as when it is smoothed out
    long, wide = smoothed(law, shape, major, minor)
    g11, g22, g12 = turned_to(C[0], C[1], C[2], 1.0 / (long * long), 1.0 / (wide * wide))
    b31, b32 = b11 + b21, b12 + b22
    bound = 0.75 * (
        g11 * (b11 * b11 + b21 * b21 + b31 * b31)
        + g22 * (b12 * b12 + b22 * b22 + b32 * b32)
        + 2.0 * g12 * (b11 * b12 + b21 * b22 + b31 * b32)
    )
    m = state.element_mass[e]
    wave = plane_wave_speed(law, shape, m / volume)
    signal = sqrt(bound * (wave * wave + principal_tension(s11, s22, s12) * volume / m))
    signal = damped_rate(law, signal, bound * plane_diffusivity(law, shape, m / volume))
    turn = cross(m1, m2)
    h1 = (f1[0] - dt * r1[0], f1[1] - dt * r1[1], f1[2] - dt * r1[2])
    h2 = (f2[0] - dt * r2[0], f2[1] - dt * r2[1], f2[2] - dt * r2[2])
    over = dot(turn, normal) <= 0.0 or dot(turn, cross(h1, h2)) <= 0.0 or minor <= NARROWEST
    wrong = OK
    if (over and wide <= minor) or ratio <= 0.0:  # what is smoothed out may be folded over
        wrong = COLLAPSED
    elif not abs(S11 + S22 + S12 + signal + volume) < inf:
        wrong = NOT_FINITE
    return state.strain_energy[e], signal, wrong


@kernel(inline=True)
def triangle_forces(surface, x, forces, e):
    """Write the forces of stress on the corners of triangle e [N] to forces[e]. surface: data of `StrainedElements`; x: nodal
    positions [m], shape (n, 3).
    """
    corners, n_quads = surface.corners, surface.n_quads
    initial, rests, state = surface.thickness, surface.rest, surface.state
    b11, b12, b21, b22 = rest = _rest_of(rests, e - n_quads)
    chi, psi = edges(x, corners, e)
    f1, f2 = gradients(rest, chi, psi)
    V = _volume_of(rest, initial)
    S11, S22, S12 = state.plane_stress[e, 0], state.plane_stress[e, 1], state.plane_stress[e, 2]
    p1, p2 = V * (S11 * b11 + S12 * b12), V * (S12 * b11 + S22 * b12)
    q1, q2 = V * (S11 * b21 + S12 * b22), V * (S12 * b21 + S22 * b22)
    for d in range(3):
        X, Y = f1[d] * p1 + f2[d] * p2, f1[d] * q1 + f2[d] * q2
        forces[e, 0, d] = X + Y
        forces[e, 1, d] = -X
        forces[e, 2, d] = -Y


@kernel(inline=True)
def press_triangle(surface, x, forces, e, pressure):
    """Write the forces ∫ p N_K n dA of a pressure p [Pa] at the corners K of triangle e [N] to forces[e]. surface: data of
    `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    chi, psi = edges(x, surface.corners, e)
    whole = cross(chi, psi)
    for d in range(3):
        share = pressure * whole[d] / 6.0
        forces[e, 0, d] = forces[e, 1, d] = forces[e, 2, d] = share


@kernel(inline=True)
def triangle_stress(surface, x, stress, e):
    """Write the Cauchy stress of triangle e, components xx, yy, zz, yz, xz, xy [Pa], to stress[e]. surface: data of
    `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    corners, n_quads = surface.corners, surface.n_quads
    initial, rests, state = surface.thickness, surface.rest, surface.state
    rest = _rest_of(rests, e - n_quads)
    chi, psi = edges(x, corners, e)
    t, u = gradients(rest, chi, psi)
    share = _volume_of(rest, initial) / state.volume[e]
    S = state.plane_stress
    whole = in_space((share * S[e, 0], share * S[e, 1], share * S[e, 2]), t, u)
    for d in range(6):
        stress[e, d] = whole[d]


@pointwise
def _rest_of(rests, t):
    return rests[t, 0], rests[t, 1], rests[t, 2], rests[t, 3]


@pointwise
def _volume_of(rest, thickness):
    """Return the volume of a triangle at rest [m³]. rest: gradients of its second and third shape function at rest [1/m];
    thickness: at rest [m].
    """
    return 0.5 * thickness / abs(rest[0] * rest[3] - rest[1] * rest[2])
