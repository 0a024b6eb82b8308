"""A smooth rigid sphere pressed into a round block: axisymmetric finite elements of FElupe, finite strain.

Biquadratic quadrilaterals, graded towards the contact, coupled neo-Hookean law; nodes of the surface against the sphere by a
penalty. Lengths in radii of the sphere, stresses in Young's moduli.

    python axisymmetric.py > indentation.csv
"""

import sys

import felupe as fem
import numpy as np
from pypardiso import spsolve

from pellucid.references.solids import Layer, force


def hertz(young_modulus: float, poisson_ratio: float, radius: float, depth: float) -> float:
    """Return the force on a rigid sphere in an elastic half-space (Hertz 1882)."""
    return 4.0 / 3.0 * young_modulus / (1.0 - poisson_ratio**2) * radius**0.5 * depth**1.5


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


def indent(thickness, width, poisson, depths, bonded=True, per_contact=10, penalty=100.0):
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
    return np.array(forces)


DEPTHS = np.array([0.0008, 0.0012, 0.0018, 0.0027, 0.004, 0.006, 0.009, 0.0135, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1])

if __name__ == "__main__":
    print(
        "# A rigid sphere of radius 1 on a round block, E = 1, coupled neo-Hookean: axisymmetric.py. Forces over Hertz's force"
    )
    print("thickness,width,poisson,bonded,depth,finite_elements,layer")
    for thickness, width in ((2, 4), (4, 4), (4, 8), (2, 2), (1, 4), (1, 2)):
        for poisson in (0.3, 0.49):
            for bonded in (True, False):
                try:
                    found = indent(float(thickness), float(width), poisson, DEPTHS, bonded)
                except fem.tools.NewtonConvergenceError as error:
                    print(thickness, width, poisson, bonded, error, file=sys.stderr)
                    continue
                for i in (8, 11, 14):
                    depth, alone = DEPTHS[i], hertz(1.0, poisson, 1.0, DEPTHS[i])
                    layer = force(Layer(1.0, poisson, thickness, bonded), 1.0, depth) / alone
                    block = f"{thickness},{width},{poisson},{'bonded' if bonded else 'slips'},{depth:g}"
                    print(f"{block},{found[i] / alone:.4f},{layer:.4f}", flush=True)
