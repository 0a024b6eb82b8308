"""Static solutions of hyperelastic bodies: elements, kinematics and laws are those of FElupe.

Two formulations: displacements alone, and ("mixed") displacements with a pressure and a volume ratio that are linear in each
element and discontinuous: Hu-Washizu's principle, on 27-node bricks Q2/P1; both scalars are eliminated element by element.
"""

from typing import NamedTuple

import felupe as fem
import numpy as np
from pypardiso import PyPardisoSolver
from scipy.interpolate import RegularGridInterpolator
from scipy.sparse import csr_matrix, diags, triu

YOUNG, POISSON = 3000.0, 0.49
MU = YOUNG / 2 / (1 + POISSON)
LAMBDA = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
KAPPA = YOUNG / 3 / (1 - 2 * POISSON)


class Law(NamedTuple):
    """A neo-Hookean energy in two parts: a law of FElupe in F with its energy at rest, and U(J) with its two derivatives."""

    material: object
    zero: float
    u: object
    du: object
    ddu: object


LAWS = {
    "coupled": Law(
        fem.NeoHookeCompressible(mu=MU, lmbda=0.0),
        1.5 * MU,  # FElupe leaves out the constant: I₁ for I₁ - 3
        lambda j: LAMBDA / 2 * np.log(j) ** 2,
        lambda j: LAMBDA * np.log(j) / j,
        lambda j: LAMBDA * (1 - np.log(j)) / j**2,
    ),
    "decoupled": Law(
        fem.NeoHooke(mu=MU, bulk=0.0),
        0.0,
        lambda j: KAPPA / 2 * (j - 1) ** 2,
        lambda j: KAPPA * (j - 1),
        lambda j: KAPPA * np.ones_like(j),
    ),
}


class Bricks:
    """A box of 27-node bricks between planes at `planes[axis]` [m]; nodes in the order of a tensor product."""

    def __init__(self, planes):
        self.lines = [np.sort(np.concatenate([p, (p[1:] + p[:-1]) / 2])) for p in planes]
        shape = [len(line) for line in self.lines]
        points = np.stack(np.meshgrid(*self.lines, indexing="ij"), -1).reshape(-1, 3)
        number = np.arange(len(points)).reshape(shape)
        first = np.stack(np.meshgrid(*(np.arange(0, n - 1, 2) for n in shape), indexing="ij"), -1).reshape(-1, 3)
        local = (fem.TriQuadraticHexahedron().points + 1).astype(int)
        cells = number[tuple((first[:, None] + local).transpose(2, 0, 1))]
        self.points, self.cells = points, cells
        self.region = fem.RegionTriQuadraticHexahedron(fem.Mesh(points, cells, "hexahedron27"))

    def interpolate(self, other, values):
        """A guess on this mesh from values at the nodes of another one of the same box."""
        table = values.reshape(*(len(line) for line in other.lines), -1)
        return RegularGridInterpolator(other.lines, table)(self.points)


class Static:
    """The nonlinear equations of a region of FElupe, a law and a formulation."""

    def __init__(self, region, law, mixed=False):
        self.region, self.law, self.mixed, self.cells = region, law, mixed, region.mesh.cells
        self.gradients, self.weights = region.dhdX, region.dV
        self.umat = fem.NearlyIncompressible(law.material, 1.0, lambda j, _: law.du(j), lambda j, _: law.ddu(j))
        if mixed:
            r = region.quadrature.points
            self.modes = np.column_stack([np.ones(len(r)), r]).T
            self.mass_inverse = np.linalg.inv(np.einsum("mq,nq,qc->cmn", self.modes, self.modes, self.weights))
        self.dofs = (3 * self.cells[:, :, None] + np.arange(3)).reshape(len(self.cells), -1)
        self.size, k = 3 * region.mesh.npoints, self.dofs.shape[1]
        self.rows, self.columns = np.repeat(self.dofs, k, axis=1).ravel(), np.tile(self.dofs, (1, k)).ravel()

    def project(self, values):
        """The linear function of each element nearest to values at its points, at these points."""
        moments = np.einsum("mq,qc,qc->cm", self.modes, values, self.weights)
        return np.einsum("mq,cmn,cn->qc", self.modes, self.mass_inverse, moments)

    def state(self, u):
        """F, J, the volume ratio of U and the pressure at all points; None where a point is inverted."""
        values = u.reshape(-1, 3)[self.cells]
        f = np.einsum("cai,aJqc->iJqc", values, self.gradients) + np.eye(3)[:, :, None, None]
        j = np.linalg.det(f.transpose(2, 3, 0, 1))
        ratio = self.project(j) if self.mixed else j
        if j.min() <= 0 or ratio.min() <= 0:
            return None
        pressure = self.project(self.law.du(ratio)) if self.mixed else self.law.du(ratio)
        return f, j, ratio, pressure

    def energy(self, state):
        """Strain energy [J]."""
        f, _, ratio, _ = state
        density = self.law.material.function([f, None])[0] - self.law.zero + self.law.u(ratio)
        return float(np.sum(density * self.weights))

    def forces(self, state):
        """Internal forces at all degrees of freedom [N]."""
        f, _, ratio, pressure = state
        stress = self.umat.gradient([f, pressure, ratio, None])[0]
        local = np.einsum("iJqc,aJqc,qc->cai", stress, self.gradients, self.weights, optimize=True)
        forces = np.bincount(self.dofs.ravel(), local.ravel(), self.size)
        return forces

    def stiffness(self, state, chunk=100):
        """The tangent of the forces, sparse."""
        f, _, ratio, pressure = state
        points, nodes = len(self.weights), self.cells.shape[1]
        n, k = self.dofs.shape
        blocks = np.empty((n, k, k))
        for start in range(0, n, chunk):
            part = slice(start, min(start + chunk, n))
            hessian = self.umat.hessian([f[..., part], pressure[..., part], ratio[..., part], None])
            weights, count = self.weights[:, part], part.stop - part.start
            gradients = np.zeros((count, points, 3, 3, nodes, 3))  # element, point, i, J, node, component
            for i in range(3):
                gradients[:, :, i, :, :, i] = self.gradients[..., part].transpose(3, 2, 1, 0)
            gradients = gradients.reshape(count, points, 9, k)
            tangent = np.ascontiguousarray((hessian[0] * weights).transpose(5, 4, 0, 1, 2, 3)).reshape(count, points, 9, 9)
            volume = np.ascontiguousarray(hessian[1].transpose(3, 2, 0, 1)).reshape(count, points, 1, 9) @ gradients
            volume = volume[:, :, 0]  # δJ
            right = (tangent @ gradients).reshape(count, 9 * points, k)
            block = gradients.reshape(count, 9 * points, k).transpose(0, 2, 1) @ right
            curvature = self.law.ddu(ratio[:, part]) * weights
            if self.mixed:
                moments = np.einsum("mq,cqd,qc->cmd", self.modes, volume, weights, optimize=True)
                ratios = self.mass_inverse[part] @ moments
                middle = np.einsum("mq,nq,qc->cmn", self.modes, self.modes, curvature, optimize=True)
                block += ratios.transpose(0, 2, 1) @ middle @ ratios
            else:
                block += volume.transpose(0, 2, 1) @ (volume * curvature.T[:, :, None])
            blocks[part] = block
        matrix = csr_matrix((blocks.ravel(), (self.rows, self.columns)), (self.size, self.size))
        return matrix


def minimize(static, u, fixed, tolerance=1e-9, most=60):
    """The displacements of least energy with those of `fixed` degrees of freedom kept, from a guess; and Newton's steps.

    Newton's method with a line search on the energy. Where the tangent is not positive definite a multiple of its diagonal
    is added, so that each step leads downhill.
    """
    free = np.setdiff1d(np.arange(static.size), fixed)
    solver = PyPardisoSolver(mtype=-2)
    state = static.state(u)
    energy, shift = static.energy(state), 0.0
    for iteration in range(most):
        residual = static.forces(state)
        error = np.abs(residual[free]).max() / max(np.abs(residual[fixed]).max(), 1e-9)
        if error < tolerance:
            return u, iteration
        matrix = csr_matrix(triu(static.stiffness(state)[free][:, free]))
        while True:
            shifted = matrix + diags(shift * matrix.diagonal()) if shift else matrix
            step = np.zeros(static.size)
            step[free] = solver.solve(csr_matrix(shifted), -residual[free])
            negative = solver.iparm[22]
            solver.free_memory(everything=False)
            if negative == 0:
                break
            shift = max(4 * shift, 1e-4)
        slope, length = float(residual @ step), 1.0
        while True:
            trial = u + length * step
            new = static.state(trial)
            if new is not None:
                lowered = static.energy(new)
                if lowered <= energy + 1e-4 * length * slope or -slope < 1e-11 * energy:
                    break
            length /= 2
            if length < 1e-8:
                raise FloatingPointError(f"no descent at an error of {error:.1e}")
        u, state, energy = trial, new, lowered
        shift = 0.0 if length == 1.0 and shift < 1e-3 else shift / 4
    raise FloatingPointError(f"no minimum after {most} steps: error {error:.1e}")
