"""Between the tuples of `pellucid.tensors` and matrices."""

import numpy as np


def matrix(a):
    """A 6-tuple or 9-tuple as a matrix."""
    if len(a) == 6:
        return np.array([[a[0], a[5], a[4]], [a[5], a[1], a[3]], [a[4], a[3], a[2]]])
    return np.array(a).reshape(3, 3)


def symmetric(m):
    """A symmetric matrix as a 6-tuple."""
    return tuple(float(m[i]) for i in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))


def tensor(m):
    """A matrix as a 9-tuple."""
    return tuple(np.asarray(m, dtype=float).ravel().tolist())


def rotation(seed):
    """A rotation at random."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0.0 else -q


def eigen(a):
    """Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations (Golub & Van Loan 2013, Matrix Computations,
    4th ed., section 8.5) with all digits of numpy's longest numbers: as exact for equal eigenvalues as for others."""
    a, Q = np.array(a, np.longdouble), np.eye(3, dtype=np.longdouble)
    for _ in range(12):
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if a[i, j] != 0.0:
                d, off = a[j, j] - a[i, i], 2.0 * a[i, j]
                t = off / (d + np.copysign(np.hypot(d, off), d))
                c = 1.0 / np.sqrt(1.0 + t * t)
                turn = np.eye(3, dtype=np.longdouble)
                turn[[i, j], [i, j]], turn[i, j], turn[j, i] = c, c * t, -c * t
                a, Q = turn.T @ a @ turn, Q @ turn
    return np.diag(a), Q
