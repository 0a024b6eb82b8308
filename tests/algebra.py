"""Conversion between the tensors of `pellucid.tensors`, which are tuples, and matrices of numpy; random rotations; exact
eigenvalues."""

import numpy as np


def matrix(a):
    """Return a symmetric tensor (6-tuple) or a tensor (9-tuple) as a matrix, shape (3, 3)."""
    if len(a) == 6:
        return np.array([[a[0], a[5], a[4]], [a[5], a[1], a[3]], [a[4], a[3], a[2]]])
    return np.array(a).reshape(3, 3)


def symmetric(m):
    """Return a symmetric matrix, shape (3, 3), as a tensor (6-tuple)."""
    return tuple(float(m[i]) for i in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))


def tensor(m):
    """Return a matrix, shape (3, 3), as a tensor (9-tuple)."""
    return tuple(np.asarray(m, dtype=float).ravel().tolist())


def rotation(seed):
    """Return a random rotation matrix, shape (3, 3)."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0.0 else -q


def eigen(a):
    """Return the eigenvalues and eigenvectors of a symmetric matrix in numpy's longest floating point numbers, by Jacobi's
    rotations (Golub & Van Loan 2013, Matrix Computations, 4th ed., section 8.5), which are as accurate for equal
    eigenvalues as for others."""
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
