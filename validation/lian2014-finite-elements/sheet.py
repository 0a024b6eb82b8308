"""A membrane of bilinear quadrilaterals, total Lagrangian, 2 x 2 Gauss points: St. Venant-Kirchhoff in plane stress.

A quarter of a square sheet, x, y >= 0, in equal squares; node (i, j) has index i (n + 1) + j. Lengths in m, forces in N.
To see what the integration matters, a share of the stress can be taken at the elements' centres instead. A tension field
relaxes the energy so that nothing is compressed (Pipkin 1986, IMA J. Appl. Math. 36, 85-99), the limit of fine wrinkles.
"""

import numpy as np
from numba import njit


class Sheet:
    """Half side [m], elements along it, thickness [m], material, height [m], fall [m/s], whether its sides are clamped."""

    def __init__(self, half, n, thickness, young, nu, density, height, fall, clamped) -> None:
        self.n, self.h, self.thickness, self.young, self.nu = n, half / n, thickness, young, nu
        line = np.linspace(0.0, half, n + 1)
        self.x = np.array([(a, b, height) for a in line for b in line])
        share = np.ones(n + 1)
        share[[0, -1]] = 0.5
        self.mass = density * thickness * self.h**2 * np.outer(share, share).ravel()
        self.v = np.zeros_like(self.x)
        self.v[:, 2] = -fall
        free = np.ones_like(self.x)  # 0 where a component is held: the planes of symmetry, and the clamped sides
        free[self.x[:, 0] == 0.0, 0] = 0.0
        free[self.x[:, 1] == 0.0, 1] = 0.0
        if clamped:
            free[np.maximum(self.x[:, 0], self.x[:, 1]) > half - 0.5 * self.h] = 0.0
        self.free = free
        self.wave_speed = np.sqrt(young / density / (1.0 - nu**2))

    def forces(self, tension_field, central):
        """Inner forces (nodes, 3) [N] and strain energy [J] of the quarter."""
        force = np.zeros_like(self.x)
        energy = _forces(self.x, force, self.n, self.h, self.thickness, self.young, self.nu, tension_field, central)
        return force, energy


@njit(cache=True)
def _forces(x, force, n, h, thickness, young, nu, tension_field, central):
    a, b = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)
    part = 0.25 * (1.0 - central)
    points = ((a, a, part), (a, b, part), (b, a, part), (b, b, part), (0.5, 0.5, central))
    energy = 0.0
    for i in range(n):
        for j in range(n):
            k = i * (n + 1) + j
            corners = (k, k + n + 1, k + n + 2, k + 1)
            for s, t, share in points:
                if share == 0.0:
                    continue
                volume = share * h * h * thickness
                G = ((-(1 - t) / h, -(1 - s) / h), ((1 - t) / h, -s / h), (t / h, s / h), (-t / h, (1 - s) / h))
                f00 = f10 = f20 = f01 = f11 = f21 = 0.0
                for c in range(4):
                    g, m = G[c], corners[c]
                    f00 += x[m, 0] * g[0]
                    f10 += x[m, 1] * g[0]
                    f20 += x[m, 2] * g[0]
                    f01 += x[m, 0] * g[1]
                    f11 += x[m, 1] * g[1]
                    f21 += x[m, 2] * g[1]
                e11 = 0.5 * (f00 * f00 + f10 * f10 + f20 * f20 - 1.0)
                e22 = 0.5 * (f01 * f01 + f11 * f11 + f21 * f21 - 1.0)
                e12 = 0.5 * (f00 * f01 + f10 * f11 + f20 * f21)
                s11, s22, s12, w = _stress(e11, e22, e12, young, nu, tension_field)
                energy += volume * w
                for c in range(4):
                    g, m = G[c], corners[c]
                    p = volume * (s11 * g[0] + s12 * g[1])
                    q = volume * (s12 * g[0] + s22 * g[1])
                    force[m, 0] -= f00 * p + f01 * q
                    force[m, 1] -= f10 * p + f11 * q
                    force[m, 2] -= f20 * p + f21 * q
    return energy


@njit(cache=True, inline="always")
def _stress(e11, e22, e12, young, nu, tension_field):
    """Second Piola-Kirchhoff stress (11, 22, 12) [Pa] and energy [J/m^3]."""
    if tension_field:
        mean, deviator = 0.5 * (e11 + e22), np.sqrt((0.5 * (e11 - e22)) ** 2 + e12 * e12)
        large, small = mean + deviator, mean - deviator
        if large <= 0.0:
            return 0.0, 0.0, 0.0, 0.0
        if small + nu * large < 0.0:  # wrinkled: uniaxial tension along the larger principal strain
            c = 0.5 * (e11 - e22) / deviator
            d = e12 / deviator
            pull = 0.5 * young * large
            return pull * (1.0 + c), pull * (1.0 - c), pull * d, pull * large
    plane = young / (1.0 - nu * nu)
    s11, s22, s12 = plane * (e11 + nu * e22), plane * (e22 + nu * e11), plane * (1.0 - nu) * e12
    return s11, s22, s12, 0.5 * (s11 * e11 + s22 * e22) + s12 * e12
