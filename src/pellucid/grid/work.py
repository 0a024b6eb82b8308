"""Work of the internal forces on the grid, given to the points whose stress did it."""

from pellucid.grid.points import place_of
from pellucid.grid.stencil import gather_gradient, stencil
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.tensors import stress_power

GAINED, KEPT = range(2)  # columns of the sums of a slab


@kernel(inner=True)
def _take_work_slab(s, mapped, energy, sums, dt):
    functions, lattice, nodes, index = mapped.functions, mapped.lattice, mapped.nodes, mapped.index
    points, slabs = mapped.points, mapped.slabs
    sigma = points.stress
    gained = kept = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        L = gather_gradient(stencil(functions, lattice, points.position, p), lattice, nodes.mean_velocity)
        s6 = (sigma[p, 0], sigma[p, 1], sigma[p, 2], sigma[p, 3], sigma[p, 4], sigma[p, 5])
        power = stress_power(s6, L)
        m, heat = points.mass[p], max(mapped.heat[p], 0.0)
        more = dt * points.volume[p] / m * power + heat
        energy[p] += more
        gained += m * more
        kept += m * heat
    sums[s, GAINED] = gained
    sums[s, KEPT] = kept


@kernel()
def take_work(n, mapped, energy, sums, dt):
    """Add to the specific energy of the points of n slabs [J/kg], shape (points,), what was lost of the kinetic energy.

    Over a step dt [s] that is dt V σ:∇v̄, with volume, stress and functions of the forces on the nodes and the mean velocity v̄
    along which these did their work, and the heat of the transfers where it is a loss. sums, shape (slabs, 2): what was gained,
    and the heat in it [J].
    """
    parallel_for(_take_work_slab, n, mapped, energy, sums, dt)
