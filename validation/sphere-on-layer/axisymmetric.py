"""A smooth rigid sphere pressed into a round block: axisymmetric finite elements of FElupe, finite strain.

Biquadratic quadrilaterals, graded towards the contact, coupled neo-Hookean law; nodes of the surface against the sphere by a
penalty. Lengths in radii of the sphere, stresses in Young's moduli.

    python axisymmetric.py > indentation.csv
"""

import sys

import felupe as fem
import numpy as np
from pypardiso import spsolve


class RigidSphere(fem.mechanics.ContactRigidBase):
    """Contact of nodes with a smooth rigid sphere of radius 1."""

    def _kinematics(self, dx):
        distance = np.linalg.norm(dx, axis=1)
        normal = dx / distance[:, None]
        across = np.eye(dx.shape[1]) - normal[:, :, None] * normal[:, None, :]
        return distance - 1.0, normal, across / distance[:, None, None]


def graded(fine, reach, end):
    """Planes from 0 to `end`, `fine` apart up to `reach`, then each 1.25 times further than the one before."""
    planes = list(np.arange(0, reach * (1 + 1e-9), fine))
    step = fine
    while planes[-1] + 1.25 * step < end:
        step *= 1.25
        planes.append(planes[-1] + step)
    planes[-1 if end - planes[-1] < 0.5 * step else len(planes) :] = [end]
    return np.array(planes)


def indent(thickness, width, poisson, depths, bonded=True, per_contact=8, penalty=100.0):
    """Forces [E R²] at depths [R] on a block `thickness` high with a free side at `width`."""
    reach = np.sqrt(max(depths))
    down = thickness - graded(reach / per_contact, reach, thickness)[::-1]
    out = graded(reach / per_contact, 1.2 * reach, width)
    grid = fem.Rectangle(n=(len(down), len(out)))
    points = np.column_stack(
        [down[np.rint(grid.x * (len(down) - 1)).astype(int)], out[np.rint(grid.y * (len(out) - 1)).astype(int)]]
    )
    mesh = fem.Mesh(points, grid.cells, "quad").add_midpoints_edges().add_midpoints_faces()
    mesh.add_points([[thickness + 1.0, 0.0]])
    field = fem.FieldContainer([fem.FieldAxisymmetric(fem.RegionBiQuadraticQuad(mesh), dim=2)])
    mu, lam = 0.5 / (1 + poisson), poisson / (1 + poisson) / (1 - 2 * poisson)
    solid = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=lam), field)
    n = mesh.npoints - 1
    top = np.flatnonzero((np.abs(mesh.x[:n] - thickness) < 1e-12) & (mesh.y[:n] < 1.5 * reach))
    sphere = RigidSphere(field, top, n, multiplier=penalty, curvature="trial")
    at, forces = 2 * n, []
    for depth in depths:
        bounds = {
            "bottom": fem.Boundary(field[0], fx=0.0, skip=(0, 0 if bonded else 1)),
            "axis": fem.Boundary(field[0], fy=0.0, skip=(1, 0)),
            "sphere": fem.Boundary(field[0], fx=thickness + 1.0),
        }
        dof0, dof1 = fem.dof.partition(field, bounds)
        ext0 = fem.dof.apply(field, bounds, dof0)
        ext0[np.searchsorted(dof0, at)] = -depth
        ext0[np.searchsorted(dof0, at + 1)] = 0.0
        found = fem.newtonraphson(
            items=[solid, sphere], x0=field, dof0=dof0, dof1=dof1, ext0=ext0, solver=spsolve, verbose=0, maxiter=60, tol=1e-7
        )
        field = found.x
        forces.append(-float(found.fun[at]))
        print(thickness, width, poisson, depth, forces[-1], found.iterations, file=sys.stderr)
    return np.array(forces), n


if __name__ == "__main__":
    d = np.linspace(0.005, 0.1, 20)
    F, n = indent(2.0, 4.0, 0.3, d)
    print(n, F, F / (4 / 3 / (1 - 0.09) * d**1.5))
