"""A smooth rigid sphere or cylinder pressed into an elastic block: finite elements, for finite and for small strains.

    python blocks.py           blocks.csv

Nothing is shared with `influence.py` (pressures on a linear layer) or `axisymmetric.py` (FElupe). A sphere of radius 1 presses
into a round block, or a cylinder of radius 1 into a block in plane strain. Elements are biquadratic quadrilaterals, graded
towards the contact, with 3 × 3 Gauss points. The law is the neo-Hookean one of the program, P = μ (F - F⁻ᵀ) + λ ln J F⁻ᵀ, or
linear elasticity with the gap of the undeformed place. Contact is a penalty on the overlap at three Gauss points of each edge.
Newton's method finds the equilibria. Lengths are in radii of the tool, stresses in Young's moduli: forces
are divided by E R², those of a cylinder by E R for a unit of length, with both of its halves. (`cylinders.csv` and
`spheres.csv` have forces divided by E* = E/(1-ν²) instead.) Needs scipy.
"""

import csv
import sys
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

GAUSS, WEIGHT = np.polynomial.legendre.leggauss(3)
PENALTY = 1000.0  # pressure for a unit of overlap
STEP = 0.0025  # depth from one equilibrium to the next


def graded(fine, reach, end):
    """Return coordinates from 0 to `end`, `fine` apart up to `reach`, then with steps that grow by a quarter."""
    planes = list(np.arange(0.0, reach * (1 + 1e-9), fine))
    step = fine
    while planes[-1] + 1.25 * step < end:
        step *= 1.25
        planes.append(planes[-1] + step)
    planes[-1 if end - planes[-1] < 0.5 * step else len(planes) :] = [end]
    return np.array(planes)


def quadratic(s):
    """Return the three quadratic functions on [-1, 1] at s, and their derivatives."""
    return np.array([0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)]), np.array([s - 0.5, -2 * s, s + 0.5])


class Block:
    """A block on a bonded base from x = 0 (axis or plane of symmetry) to its width; its side is free."""

    def __init__(self, thickness, width, poisson_ratio, most, is_round, finite=True, per_contact=12, penalty=PENALTY):
        self.thickness, self.nu, self.finite, self.is_round = thickness, poisson_ratio, finite, is_round
        self.penalty = penalty
        reach = np.sqrt(2.0 * most)
        x = graded(reach / per_contact, 1.05 * reach, width)
        y = thickness - graded(reach / per_contact, reach, thickness)[::-1]
        xs, ys = (np.sort(np.concatenate([each, 0.5 * (each[1:] + each[:-1])])) for each in (x, y))
        node = np.arange(len(xs) * len(ys)).reshape(len(ys), len(xs))
        self.place = np.stack(np.broadcast_arrays(xs, ys[:, None]), -1).reshape(-1, 2)
        corners = [(j, i) for j in range(0, len(ys) - 2, 2) for i in range(0, len(xs) - 2, 2)]
        self.cells = np.array([node[j : j + 3, i : i + 3].ravel() for j, i in corners])
        self.edges = np.array([node[-1, i : i + 3] for i in range(0, len(xs) - 2, 2) if xs[i] < 1.05 * reach])
        fixed = np.zeros((len(self.place), 2), bool)
        fixed[node[0]] = True
        fixed[node[:, 0], 0] = True
        self.free = np.flatnonzero(~fixed.ravel())
        self.u = np.zeros_like(self.place)
        self._prepare()

    def _prepare(self):
        values, slopes, weights = [], [], []
        for a, of_a in zip(GAUSS, WEIGHT, strict=True):
            for b, of_b in zip(GAUSS, WEIGHT, strict=True):
                (up, d_up), (along, d_along) = quadratic(a), quadratic(b)
                values.append(np.outer(up, along).ravel())
                slopes.append(np.stack([np.outer(up, d_along).ravel(), np.outer(d_up, along).ravel()], -1))
                weights.append(of_a * of_b)
        values, slopes = np.array(values), np.array(slopes)
        corners = self.place[self.cells]
        jacobian = np.einsum("cnd,gne->cgde", corners, slopes)
        gradient = np.einsum("gne,cged->cgnd", slopes, np.linalg.inv(jacobian))
        self.volume = np.linalg.det(jacobian) * weights
        c, g, n, _ = gradient.shape
        self.strain = np.zeros((c, g, n, 2, 3, 3))  # of F by the displacement of a node along x or y
        for i in range(2):
            self.strain[:, :, :, i, i, :2] = gradient
        radius = np.einsum("gn,cn->cg", values, corners[..., 0])
        if self.is_round:
            self.strain[:, :, :, 0, 2, 2] = values / radius[..., None]
            self.volume *= 2 * np.pi * radius
        self.strain = self.strain.reshape(c, g, 2 * n, 9)
        self.dofs = (2 * self.cells[:, :, None] + np.arange(2)).reshape(c, -1)
        self.shape = np.array([quadratic(s)[0] for s in GAUSS])
        begun = self.place[self.edges]
        self.begun = np.einsum("gn,end->egd", self.shape, begun)
        self.length = 0.5 * (begun[:, 2, 0] - begun[:, 0, 0])[:, None] * WEIGHT
        if self.is_round:
            self.length = self.length * 2 * np.pi * self.begun[..., 0]
        self.edge_dofs = (2 * self.edges[:, :, None] + np.arange(2)).reshape(len(self.edges), -1)

    def _stress(self, F):
        """Return P and its derivative by F."""
        mu, lam = 0.5 / (1 + self.nu), self.nu / (1 + self.nu) / (1 - 2 * self.nu)
        one = np.eye(3)
        if not self.finite:
            e = 0.5 * (F + F.swapaxes(-1, -2)) - one
            stress = 2 * mu * e + lam * np.trace(e, axis1=-2, axis2=-1)[..., None, None] * one
            stiff = mu * (np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one))
            return stress, np.broadcast_to(stiff + lam * np.einsum("ij,kl->ijkl", one, one), (*F.shape[:2], 3, 3, 3, 3))
        inverse = np.linalg.inv(F)
        turned, growth = inverse.swapaxes(-1, -2), np.log(np.linalg.det(F))[..., None, None]
        stress = mu * (F - turned) + lam * growth * turned
        stiff = (mu - lam * growth)[..., None, None] * np.einsum("cgjk,cgli->cgijkl", inverse, inverse)
        stiff += mu * np.einsum("ik,jl->ijkl", one, one) + lam * np.einsum("cgij,cgkl->cgijkl", turned, turned)
        return stress, stiff

    def _contact(self, depth):
        """Return gaps at the Gauss points of the edges, their directions and the curvature of these."""
        place = self.begun + np.einsum("gn,end->egd", self.shape, self.u[self.edges])
        if self.finite:
            away = place - (0.0, self.thickness - depth + 1.0)
            distance = np.linalg.norm(away, axis=-1)
            return distance - 1.0, away / distance[..., None], 1.0 / distance
        x = self.begun[..., 0]
        lower = self.thickness - depth + 1.0 - np.sqrt(np.maximum(1.0 - x * x, 0.0))
        return lower - place[..., 1], np.broadcast_to((0.0, -1.0), place.shape), np.zeros_like(x)

    def press(self, depth):
        """Find the equilibrium at a depth from that of the depth before; return force and radius of contact."""
        n, one = self.u.size, np.eye(2)
        for _ in range(80):
            c, g = self.volume.shape
            of_cells = self.u[self.cells].reshape(c, -1)
            stress, stiff = self._stress(np.eye(3) + np.einsum("ck,cgkx->cgx", of_cells, self.strain).reshape(c, g, 3, 3))
            inner = np.einsum("cg,cgx,cgkx->ck", self.volume, stress.reshape(c, g, 9), self.strain, optimize=True)
            scaled = np.einsum("cg,cgxy,cgky->cgkx", self.volume, stiff.reshape(c, g, 9, 9), self.strain, optimize=True)
            matrix = np.einsum("cgkx,cglx->ckl", self.strain, scaled, optimize=True)
            gap, way, curved = self._contact(depth)
            touches = gap < 0
            press = self.penalty * np.where(touches, -gap, 0.0) * self.length
            pushed = -np.einsum("eg,egd,gn->end", press, way, self.shape)
            across = one - way[..., :, None] * way[..., None, :]
            hard = (
                self.penalty * (touches * self.length)[..., None, None] * (one - across)
                - (press * curved)[..., None, None] * across
            )
            of_edges = np.einsum("egij,gn,gm->enimj", hard, self.shape, self.shape)
            residual = np.bincount(self.dofs.ravel(), inner.ravel(), n) + np.bincount(self.edge_dofs.ravel(), pushed.ravel(), n)
            rows = np.concatenate([np.repeat(self.dofs, 18, 1).ravel(), np.repeat(self.edge_dofs, 6, 1).ravel()])
            columns = np.concatenate([np.tile(self.dofs, (1, 18)).ravel(), np.tile(self.edge_dofs, (1, 6)).ravel()])
            values = np.concatenate([matrix.ravel(), of_edges.ravel()])
            whole = sparse.csc_array((values, (rows, columns)), shape=(n, n))[self.free][:, self.free]
            change = np.zeros(n)
            change[self.free] = splu(sparse.csc_matrix(whole)).solve(-residual[self.free])
            change *= min(1.0, STEP / np.abs(change).max())
            self.u += change.reshape(-1, 2)
            if np.abs(change).max() < 1e-9:
                force = (1.0 if self.is_round else 2.0) * pushed[..., 1].sum()
                ends = (self.begun + np.einsum("gn,end->egd", self.shape, self.u[self.edges]))[..., 0]
                return force, float(ends[touches].max())
        raise ArithmeticError(f"no equilibrium at a depth of {depth:g}")


def indent(thickness, width, poisson_ratio, depths, is_round, **more):
    """Return forces and radii of contact at depths in ascending order."""
    block, found = Block(thickness, width, poisson_ratio, max(depths), is_round, **more), []
    for depth in np.union1d(np.arange(STEP, max(depths), STEP), [0.2 * STEP, 0.4 * STEP, *depths]).round(9):
        pressed = block.press(depth)
        if np.isclose(depths, depth).any():
            found.append(pressed)
    return found


CASES = [  # tool, thickness, width, Poisson's ratio, strains
    ("sphere", 1.0, 2.0, 0.3, "finite"),
    ("sphere", 1.0, 1.2, 0.3, "finite"),
    ("sphere", 2.0, 2.0, 0.3, "finite"),
    ("sphere", 1.0, 2.0, 0.3, "small"),
    ("cylinder", 1.0, 2.0, 0.3, "finite"),
    ("cylinder", 1.0, 1.2, 0.3, "finite"),
    ("cylinder", 2.0, 4.0, 0.3, "finite"),
    ("cylinder", 1.0, 2.0, 0.45, "finite"),
    ("cylinder", 1.0, 2.0, 0.3, "small"),
    ("cylinder", 2.0, 4.0, 0.3, "small"),
]


def main():
    import influence

    depths, rows = (0.05, 0.1), []
    for tool, thickness, width, nu, strains in CASES:
        found = indent(thickness, width, nu, depths, tool == "sphere", finite=strains == "finite")
        for depth, (force, contact) in zip(depths, found, strict=True):
            rings = influence.of_rings if tool == "sphere" else influence.of_strips
            layer = influence.press(rings, depth, (thickness, nu, True))[0] / (1.0 - nu**2)
            row = (tool, thickness, width, nu, strains, depth, f"{force:.5g}", f"{contact:.4f}", f"{force / layer:.4f}")
            print(*row, flush=True)
            rows.append(row)
    columns = ["tool", "thickness", "width", "poisson_ratio", "strains", "depth", "force", "contact", "over_layer"]
    with (Path(__file__).parent / "blocks.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])


def checks():
    """Print the effect of the mesh and of the penalty."""
    for tool, strains in (("cylinder", "finite"), ("sphere", "finite"), ("cylinder", "small")):
        for per_contact, penalty in ((6, 1000.0), (12, 1000.0), (24, 1000.0), (12, 250.0)):
            more = {"finite": strains == "finite", "per_contact": per_contact, "penalty": penalty}
            found = indent(1.0, 2.0, 0.3, (0.05, 0.1), tool == "sphere", **more)
            print(tool, strains, per_contact, penalty, *(f"{force:.6f}" for force, _ in found), flush=True)


if __name__ == "__main__":
    checks() if sys.argv[1:] == ["checks"] else main()
