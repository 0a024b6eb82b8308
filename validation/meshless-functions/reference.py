"""References of the beam and of Cook's membrane: finite elements of any order in plane strain, Newton's method.

W = μ/2 (I₁ - 3) - μ ln J + λ/2 (ln J)², dead tractions on the right, the left side held. Elements are graded towards the
corners of the held side, where stresses are singular. Run by hand: python validation/meshless-functions/reference.py; it writes
reference.csv.
"""

import csv
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

HERE = Path(__file__).parent
CLOSE = 1e-7  # of the load


class Problem(NamedTuple):
    """A quadrilateral region, held on its left side, loaded on its right."""

    name: str
    place: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]  # of parameters in [0, 1]
    long: int  # elements along it for one across
    young: float
    poisson: float
    traction: tuple[float, float]
    load_steps: int
    grading: float
    order: int


def beam(s, t):
    """1 by 0.1."""
    return s, 0.1 * (t - 0.5)


def cook(s, t):
    """Cook's membrane."""
    return 48 * s, 44 * s + t * (44 - 28 * s)


PROBLEMS = [
    Problem("beam", beam, 10, 1.2e6, 0.0, (0.0, -2000.0), 4, 1.0, 2),
    Problem("cook-0.3333", cook, 1, 240.565, 1 / 3, (0.0, 6.25), 8, 1.8, 4),
    Problem("cook-0.4999", cook, 1, 240.565, 0.4999, (0.0, 6.25), 16, 1.8, 4),
]


def shapes(order: int, x: float) -> tuple[np.ndarray, np.ndarray]:
    """Lagrange's functions on [-1, 1] and their slopes."""
    powers, coefficients = np.arange(order + 1), np.linalg.inv(np.vander(np.linspace(-1, 1, order + 1), increasing=True))
    slopes = np.concatenate([[0.0], powers[1:] * x ** (powers[1:] - 1)])
    return x**powers @ coefficients, slopes @ coefficients


def graded(n: int, grading: float, both: bool, order: int) -> np.ndarray:
    """Places of nodes of n elements in [0, 1], smaller ones towards 0, or both ends."""
    ends = np.linspace(0, 1, n + 1) ** grading
    if both:
        ends = ends / (ends + (1 - np.linspace(0, 1, n + 1)) ** grading)
    parts = [np.linspace(a, b, order + 1)[:-1] for a, b in pairwise(ends)]
    return np.concatenate([*parts, [1.0]])


def displacement(problem: Problem, across: int) -> np.ndarray:
    """Of the middle of the right side, with so many elements across."""
    p, along = problem.order, problem.long * across
    s, t = np.meshgrid(graded(along, problem.grading, False, p), graded(across, problem.grading, True, p))
    nodes = np.stack(problem.place(s.ravel(), t.ravel()), axis=1)
    number = np.arange(len(nodes)).reshape(p * across + 1, p * along + 1)
    corner = [(j, i) for j in range(across) for i in range(along)]
    elements = np.array([number[p * j : p * j + p + 1, p * i : p * i + p + 1].ravel() for j, i in corner])
    points, weights = np.polynomial.legendre.leggauss(p + 1)
    quadrature = []
    for x, wx in zip(points, weights, strict=True):
        for y, wy in zip(points, weights, strict=True):
            (nx, dx), (ny, dy) = shapes(p, x), shapes(p, y)
            slopes = np.array([np.outer(ny, dx).ravel(), np.outer(dy, nx).ravel()])
            jacobian = np.einsum("an,enj->eja", slopes, nodes[elements])
            gradients = np.einsum("eaj,an->ejn", np.linalg.inv(jacobian), slopes)
            quadrature.append((wx * wy * np.linalg.det(jacobian), gradients))
    load = np.zeros_like(nodes)
    edge_share = sum(w * shapes(p, x)[0] for x, w in zip(points, weights, strict=True)) / 2
    for j in range(across):
        edge = number[p * j : p * j + p + 1, -1]
        load[edge] += np.outer(edge_share * np.linalg.norm(nodes[edge[-1]] - nodes[edge[0]]), problem.traction)
    free = np.ones(nodes.shape, bool)
    free[number[:, 0]] = False
    u, unknown = np.zeros(nodes.size), np.flatnonzero(free)
    dofs = np.stack([2 * elements, 2 * elements + 1], axis=2).reshape(len(elements), -1)
    rows, columns = np.repeat(dofs, dofs.shape[1], axis=1).ravel(), np.tile(dofs, (1, dofs.shape[1])).ravel()
    for step in range(1, problem.load_steps + 1):
        for _ in range(60):
            force, tangent = stiffness(problem, quadrature, u.reshape(-1, 2)[elements])
            rest = (load.ravel() * step / problem.load_steps - np.bincount(dofs.ravel(), force.ravel(), u.size))[unknown]
            if np.linalg.norm(rest) < CLOSE * np.linalg.norm(load):
                break
            matrix = coo_matrix((tangent.ravel(), (rows, columns)), (u.size, u.size)).tocsc()
            u[unknown] += splu(matrix[unknown][:, unknown]).solve(rest)
        else:
            raise RuntimeError(f"{problem.name}, {across} elements: Newton's method does not converge")
    return u.reshape(-1, 2)[number[len(number) // 2, -1]]


def stiffness(problem: Problem, quadrature: list, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces and tangents of elements with displacements u, shape (elements, nodes, 2)."""
    e, nu = problem.young, problem.poisson
    mu, lam, one = e / (2 * (1 + nu)), e * nu / ((1 + nu) * (1 - 2 * nu)), np.eye(2)
    size = u.shape[1] * 2
    force, tangent = np.zeros((len(u), size)), np.zeros((len(u), size, size))
    for weight, gradients in quadrature:
        F = one + np.einsum("eni,ejn->eij", u, gradients)
        inverse, log_j = np.linalg.inv(F), np.log(np.linalg.det(F))
        P = mu * F + (lam * log_j - mu)[:, None, None] * np.swapaxes(inverse, 1, 2)
        force += np.einsum("eij,ejn,e->eni", P, gradients, weight).reshape(len(u), -1)
        g = np.einsum("eji,ejn->eni", inverse, gradients)
        part = mu * np.einsum("enm,ik->enimk", np.einsum("ejn,ejm->enm", gradients, gradients), one)
        part += lam * np.einsum("eni,emk->enimk", g, g) + np.einsum("e,emi,enk->enimk", mu - lam * log_j, g, g)
        tangent += (weight[:, None, None, None, None] * part).reshape(len(u), size, size)
    return force, tangent


def main() -> None:
    """Each on three meshes."""
    found = []
    for problem in PROBLEMS:
        for across in (1, 2, 4) if problem.name == "beam" else (4, 8, 12):
            found.append((problem.name, across, *displacement(problem, across).tolist()))
            print(*found[-1], flush=True)
    with (HERE / "reference.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("problem", "elements across", "x", "y"), *found])


if __name__ == "__main__":
    main()
