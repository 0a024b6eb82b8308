"""Essential conditions by forces: for functions that do not take prescribed values at the nodes.

After the free update, impulses λ_i at the places x_i with a prescribed value go to the nodes by their functions there, so that
the field takes it:

    Σ_j V_ij λ_j = v̄_i - Σ_a p_a(x_i) v_a,  V_ij = Σ_a p_a(x_i) p_a(x_j)/m_a,  m_a Δv_a = Σ_i p_a(x_i) λ_i .

With the whole of V that is EBCIEM, with its rows lumped SEBCIEM (Joldes, Chowdhury, Wittek & Miller 2017, Eng. Anal. Bound.
Elem. 80, 94). v̄ also takes back what the field lacks of the prescribed displacement: with lumped rows over some steps.
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, onenormest, splu

from pellucid.bodies.meshless_solid.prescribed import PrescribedField

LARGEST_CONDITION = 1e10  # of V, above which forces are mostly round-off

Solve = Callable[[np.ndarray], np.ndarray]


class ForceCorrection:
    """The impulses that make the field take the prescribed displacement at the prescribed nodes.

    values: functions at all nodes, shape (n, n); position [m], shape (n, 3), and mass [kg], shape (n,), as the body keeps them.
    Raises ValueError where the functions at two places are nearly the same.
    """

    def __init__(
        self, prescribed: PrescribedField, values: sparse.csr_array, position: np.ndarray, mass: np.ndarray, lumped: bool
    ) -> None:
        self._prescribed, self._position, self._mass = prescribed, position, mass
        self._values, self._number = values[prescribed.nodes], prescribed.number[prescribed.nodes]
        self._sums = np.asarray(self._values.sum(axis=1))[:, None]  # 1 but for rounding
        self._axes: list[tuple[np.ndarray, Solve]] = []
        known: dict[bytes, Solve] = {}
        for axis in range(3):
            places = np.flatnonzero(self._number[:, axis])
            key = places.tobytes()
            if key not in known:
                known[key] = _solver(self._values[places], mass, lumped)
            self._axes.append((places, known[key]))

    def correct(self, velocity: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """What the free velocities [m/s], shape (n, 3), lack at the end of the step dt [s], and the impulses of the supports
        and motions [N s], shape (rows, 3), whose velocities over it are `rows`, of the same shape."""
        number = self._number
        displacement = self._values @ (self._position - self._prescribed.mesh.nodes)
        behind = self._prescribed.at(number) - displacement
        goal = self._prescribed.of_rows(rows, number) + behind / dt
        lacking = goal - self._values @ velocity
        impulse = np.zeros_like(lacking)
        for axis, (places, solve) in enumerate(self._axes):
            if len(places):
                impulse[places, axis] = solve(lacking[places, axis])
        of_rows = np.zeros_like(rows)
        place, along = np.nonzero(number)
        np.add.at(of_rows, (number[place, along] - 1, along), (self._sums * impulse)[place, along])
        return np.asarray((self._values.T @ impulse) / self._mass[:, None]), of_rows


def _solver(values: sparse.csr_array, mass: np.ndarray, lumped: bool) -> Solve:
    """Impulses for the velocities that are lacking."""
    V = sparse.csc_array(values @ sparse.diags_array(1.0 / mass) @ values.T)
    if lumped:
        # sums of absolute values: no eigenvalue of the quotient is above 1, so that the corrections settle
        rows = np.asarray(abs(V).sum(axis=1))
        return lambda lacking: lacking / rows
    if V.shape[0] == 0:
        return lambda lacking: lacking
    try:
        factors = splu(V, options={"SymmetricMode": True}, permc_spec="MMD_AT_PLUS_A")
    except RuntimeError:  # an exact zero on the diagonal
        raise ValueError(_dependent(np.inf)) from None
    condition = _condition(V, factors)
    if not condition < LARGEST_CONDITION:
        raise ValueError(_dependent(condition))
    return lambda lacking: np.asarray(factors.solve(lacking))


def _dependent(condition: float) -> str:
    text = (
        "forces on the prescribed nodes cannot be found: the functions there are nearly dependent, with a condition number of"
    )
    return f"{text} {condition:.2g}, above {LARGEST_CONDITION:.0g}"


def _condition(V: sparse.csc_array, factors: SuperLU) -> float:
    inverse = LinearOperator(V.shape, matvec=factors.solve, rmatvec=factors.solve, matmat=factors.solve, rmatmat=factors.solve)
    return float(abs(V).sum(axis=0).max() * onenormest(inverse))
