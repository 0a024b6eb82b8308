"""Parallel loops over the nodes of a velocity field: momentum update, and works of a step.

Common arguments: n, number of chunks; chunks, the nodes (`ChunkedNodes`); awaiting, flags of the nodes that await contact
impulses, or `NOWHERE`; small, see `NodalMomentum`.
"""

from pellucid.grid.momentum import add_separate_forces_chunk, advance_chunk, sum_loads_chunk
from pellucid.grid.nodal_works import count_works_chunk, sum_strain_lag_chunk
from pellucid.grid.projection import project_chunk
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_for, parallel_loop


@kernel(inner=True)
def _advance_chunk(chunk, field, dt, small, flip, counted, chunks, awaiting):
    advance_chunk(chunk, field, dt, small, flip)
    if counted:
        count_works_chunk(chunk, 0, chunks, awaiting, field, dt, small)


@kernel()
def advance(n, field, dt, small, flip, counted, chunks, awaiting):
    """Advance the momentum of the nodes in n chunks (`chunks`, see `ChunkedNodes`) over a step dt [s]; if `counted`, also
    compute the works of forces on them while their data is in the cache.

    field: see `AdvancedNodes`; small, flip: `small_mass` and `flip` of `NodalMomentum`; awaiting: flags of the nodes that
    await contact impulses, whose works are not computed yet; empty if there are none.
    """
    if len(field.separate_forces) > 0:
        parallel_for(add_separate_forces_chunk, n, field)
    if len(field.load) > 0:  # by themselves: loops over the channels within the momentum equation would slow down all nodes
        parallel_for(sum_loads_chunk, n, field)
    parallel_for(_advance_chunk, n, field, dt, small, flip, counted, chunks, awaiting)


@kernel()
def count_works(n, first, chunks, awaiting, field, dt, small):
    """Compute the works of forces in the step dt [s] and the impulses on the nodes of n chunks (`chunks`, see
    `ChunkedNodes`), a row of `field.work` for each chunk, from row `first` on; see `NodalMomentum.works`.

    field: see `AdvancedNodes`; awaiting: flags of nodes to skip, which await contact impulses; empty to skip none; small:
    `small_mass` of `NodalMomentum`.
    """
    parallel_for(count_works_chunk, n, first, chunks, awaiting, field, dt, small)


@parallel_loop()
def project(chunk, field, advanced, counted, chunks, awaiting, dt, small, sums):
    """Compute `strain_velocity` for a chunk of nodes: the velocities p/m from the momentum p mapped to the nodes and their
    mass m, corrected by supports and driven points (points with a prescribed motion). If `counted`, also compute the work
    of `NodalMomentum.strain_lag_work` for the nodes of the chunk in `chunks` (`ChunkedNodes`), into a row of `sums` [J].

    field: see `AdvancedNodes`; advanced: True if the momentum has been advanced with the present nodal masses; dt: step
    [s]; awaiting: flags of nodes to skip in the work, which await contact impulses; small: `small_mass` of `NodalMomentum`.
    """
    project_chunk(chunk, field, advanced)
    if counted:
        sum_strain_lag_chunk(chunk, 0, chunks, awaiting, field, dt, small, sums)


@kernel()
def sum_strain_lag(n, first, chunks, awaiting, field, dt, small, sums):
    """Compute the work returned by `NodalMomentum.strain_lag_work` in a step dt [s] for n chunks of nodes (`chunks`, see
    `ChunkedNodes`), into rows of `sums` [J] from row `first` on.

    field: see `AdvancedNodes`; awaiting: flags of nodes to skip, which await contact impulses; empty to skip none; small:
    `small_mass` of `NodalMomentum`.
    """
    parallel_for(sum_strain_lag_chunk, n, first, chunks, awaiting, field, dt, small, sums)
