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
