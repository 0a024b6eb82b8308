"""Passes over the nodes of a velocity field by all threads: their momentum equation, and the works of a step.

node: a list of nodes, or `ALL` of them; awaiting: flags of the nodes that await impulses of contact, or `NOWHERE`.
"""

from pellucid.grid.momentum import add_separate_forces_chunk, advance_chunk, sum_loads_chunk
from pellucid.grid.nodal_works import count_works_chunk, sum_strain_lag_chunk
from pellucid.grid.projection import project_chunk
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for


@kernel(inner=True)
def _advance_chunk(chunk, field, dt, small, flip, counted, node, awaiting):
    advance_chunk(chunk, field, dt, small, flip)
    if counted:
        count_works_chunk(chunk, 0, node, awaiting, field, dt, small)


@kernel()
def advance(chunks, field, dt, small, flip, counted, node, awaiting):
    """The momentum equation of all nodes; where `counted`, their works too, while the nodes are at hand."""
    if len(field.separate_forces) > 0:
        parallel_for(add_separate_forces_chunk, chunks, field)
    if len(field.load) > 0:  # by themselves: loops over the channels within the momentum equation would slow down all nodes
        parallel_for(sum_loads_chunk, chunks, field)
    parallel_for(_advance_chunk, chunks, field, dt, small, flip, counted, node, awaiting)


@kernel()
def count_works(chunks, first, node, awaiting, field, dt, small):
    """Works of the step and impulses on nodes, in rows from the first on; see `NodalMomentum.works`."""
    parallel_for(count_works_chunk, chunks, first, node, awaiting, field, dt, small)


@kernel(inner=True)
def _project_chunk(chunk, field, advanced, counted, node, awaiting, dt, small, sums):
    project_chunk(chunk, field, advanced)
    if counted:
        sum_strain_lag_chunk(chunk, 0, node, awaiting, field, dt, small, sums)


@kernel()
def project(chunks, field, advanced, counted, node, awaiting, dt, small, sums):
    """Velocities p/m of the mapped momentum, with supports, into `strain_velocity`; where `counted`, the lag of work too.

    advanced: whether the momentum was, of the mass that the nodes have.
    """
    parallel_for(_project_chunk, chunks, field, advanced, counted, node, awaiting, dt, small, sums)


@kernel()
def sum_strain_lag(chunks, first, node, awaiting, field, dt, small, sums):
    """See `NodalMomentum.strain_lag_work`; a sum for each chunk, in rows from the first on."""
    parallel_for(sum_strain_lag_chunk, chunks, first, node, awaiting, field, dt, small, sums)
