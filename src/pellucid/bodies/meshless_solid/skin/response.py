"""Response of the surface of a solid to velocity increments from contact at grid nodes.

Increments Δv_I of grid nodes I are mapped to the points k of the surface and to the nodes a of the body; the resulting
velocities of the points are mapped back to the nodes of the grid (symbols as in `skin`, with the grid functions N_I and masses
m):

    Δv_a = Σ_I K_Ia Δv_I / m_a,  m_I Δv'_I = Σ_a K_Ia Δv_a,  K_Ia = Σ_k N_I(x_k) m_k S_ka .

Contact applies this repeatedly in a step, always at the same few nodes, so K is computed once, for these nodes only.
"""

import numpy as np
from numpy import uintp
from scipy import sparse

from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.contact.detection import allocate_numbers, mark_stencils
from pellucid.grid.lattice import Nodes
from pellucid.grid.stencil import functions_at, node_at, stencil_of
from pellucid.jit import kernel


@kernel()
def _list_weights(mapped, slot, near, listed, first, column, weight):
    """List the surface points whose grid functions are not zero at some of the grid nodes in contact, as a sparse matrix: point
    numbers into `listed`, starts of their entries into `first`, and numbers of the grid nodes and weights into `column` and
    `weight`. Returns the number of points.

    mapped: data of the surface points for transfers to the grid; slot: number of each of the grid nodes in contact in the
    result, negative for other nodes; near: for each first node of a stencil (the nodes with non-zero functions at a point) 0 if
    the stencil contains no node in contact.
    """
    functions, lattice, x = mapped.functions, mapped.lattice, mapped.points.position
    n = entries = 0
    for p in range(len(x)):
        start, numbers = functions_at(functions, lattice, (x[p, 0], x[p, 1], x[p, 2]))
        if near[uintp(start)] == 0:
            continue
        about = stencil_of(functions, start, numbers)
        wx, wy, wz = about.wx, about.wy, about.wz
        listed[n], first[n] = p, entries
        n += 1
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0:
                        column[entries], weight[entries] = e, wx[a] * wy[b] * wz[c]
                        entries += 1
    first[n] = entries
    return n


class SkinResponse:
    """Computes the velocity changes of grid nodes that follow from contact impulses on a meshless body: increments at the
    grid nodes are mapped to the nodes of the body through the surface points, and the resulting velocities are mapped back
    (equations: see `pellucid.bodies.meshless_solid.skin.response`).

    surface: coupling of the surface points to the grid; mass: masses of the surface points [kg], shape (m,); values: shape
    functions S_ka of the n nodes at the surface points, shape (m, n); inertia: masses of the nodes [kg], shape (n,);
    prescribed: 0 for free components, shape (n, 3).
    """

    def __init__(
        self, surface: GridCoupling, mass: np.ndarray, values: sparse.csr_array, inertia: np.ndarray, prescribed: np.ndarray
    ) -> None:
        self._surface, self._mass, self._values = surface, mass, values
        self._inertia, self._prescribed = inertia, prescribed
        grid, m = surface.velocity_field.grid, len(mass)
        self._nodes: Nodes = grid.nodes
        self._reach = tuple(function.stencil for function in surface.functions)
        self._lattice = grid.lattice
        self._slot, self._near = allocate_numbers(grid.n_nodes)
        most = m * int(np.prod(self._reach))
        self._listed, self._first = np.empty(m, np.int64), np.empty(m + 1, np.int64)
        self._column, self._weight = np.empty(most, np.int64), np.empty(most)

    def begin(self, at: np.ndarray) -> None:
        """Compute the matrix Σ_k N_I(x_k) m_k S_ka that maps velocity increments of the grid nodes I = `at` in contact,
        shape (k,), to impulses on the nodes a of the body, through surface points x_k with masses m_k; N: functions of the
        grid, S: functions of the body. Called in each step after the momentum of the grid nodes was advanced."""
        K = self._matrix(at)
        used, column = np.unique(K.indices, return_inverse=True)
        self._from_body = sparse.csr_array((K.data, column, K.indptr), shape=(len(at), len(used)))
        self._to_body = sparse.csr_array(self._from_body.T)
        self._mobility = (self._prescribed[used] == 0) / self._inertia[used, None]
        nodes, self._at = self._nodes, at
        self._trial = nodes.velocity[at] - nodes.velocity_increment[at]
        self._share = (nodes.constrained[at] == 0) / nodes.mass[at, None]

    def _matrix(self, at: np.ndarray) -> sparse.csr_array:
        mark_stencils(at, self._slot, self._near, self._reach, self._lattice, True)
        to = self._listed, self._first, self._column, self._weight
        n = _list_weights(self._surface.mapped, self._slot, self._near, *to)
        mark_stencils(at, self._slot, self._near, self._reach, self._lattice, False)
        listed, first = self._listed[:n], self._first[: n + 1]
        given = self._weight[: first[n]] * np.repeat(self._mass[listed], np.diff(first))
        points = sparse.csr_array((given, self._column[: first[n]], first), shape=(n, len(at)))
        return sparse.csr_array(sparse.csr_array(points.T) @ self._values[listed])

    def give(self) -> None:
        """Set the velocities of the grid nodes in contact to the response of the body to all velocity increments from contact
        in this step.
        """
        nodes, at = self._nodes, self._at
        of_body = self._mobility * (self._to_body @ nodes.velocity_increment[at])
        nodes.velocity[at] = self._trial + self._share * (self._from_body @ of_body)
