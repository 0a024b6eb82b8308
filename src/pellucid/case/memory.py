"""Memory estimate and memory check of a case. A case that does not fit this machine is still valid for another machine."""

import os
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from pellucid.errors import CaseError, Problem
from pellucid.grid.lattice import NodeFlags, Nodes, layers_of
from pellucid.grid.nodal_fields import bytes_of
from pellucid.grid.viscous_rows import ViscousRows

if TYPE_CHECKING:
    from pellucid.case.spec import Case

NODE_BYTES = bytes_of(Nodes) + bytes_of(NodeFlags) + np.dtype(np.int64).itemsize  # and an entry in a list of nodes
MODE_BYTES = 3 * 6 * 8  # of the eigenvectors' components for three velocities, with implicit pressure
PROGRAM_BYTES = 300 * 2**20  # the program, its libraries and kernels
POINT_BYTES = 450  # position, velocity, state of the law, and the second copy that sorting writes to


def check_memory(case: "Case") -> None:
    """Raise CaseError if the estimated memory of a case (grid nodes, points, tables of shape functions) exceeds the physical
    memory. The error states the cell size, or the number of points, that would fit."""
    there, needed = physical_memory(), memory_estimate(case)
    nodes, points = n_nodes(case), n_points(case)
    tables = table_bytes(case)
    if there is None or needed <= there:
        return
    arrays, room = needed - PROGRAM_BYTES, max(there - PROGRAM_BYTES, 1.0)
    if tables > 0.5 * arrays:
        text = f"the case requires about {needed / 2**30:.3g} GiB of memory, mainly for shape functions at quadrature points"
        remedy = "Use a coarser mesh, fewer points_per_cell, or an approximant with fewer nodes in its support."
        raise CaseError(Problem(f"{text}, but this machine has {there / 2**30:.3g} GiB", "body", remedy=remedy))
    if case.grid_or_none is None:
        text = f"the case has {points:.3g} points and requires about {needed / 2**30:.3g} GiB of memory"
        raise CaseError(Problem(f"{text}, but this machine has {there / 2**30:.3g} GiB", "body", remedy="Use fewer points."))
    fits = case.grid.cell * (arrays / room) ** (1.0 / (3 - sum(case.grid.thin())))
    whole = (
        f"the case has {nodes:.3g} grid nodes and {points:.3g} points and requires about {needed / 2**30:.3g} GiB of "
        f"memory, but this machine has {there / 2**30:.3g} GiB"
    )
    if fits > max(case.grid.upper[axis] - case.grid.lower[axis] for axis, thin in enumerate(case.grid.thin()) if not thin):
        _blame_points(case, whole, room)
    remedy = f"Set grid.cell above {fits:.2g} m, or use a machine with more memory."
    raise CaseError(Problem(whole, "grid.cell", case.grid.cell, remedy))


def _blame_points(case: "Case", text: str, room: float) -> None:
    """Raise CaseError with the remedy to use fewer points per cell, if fewer points in the largest body can reduce the
    memory to `room` [bytes]; otherwise return. text: statement of the needed memory."""
    counts = [body.with_others(case.body).n_points(case.grid_or_none) for body in case.body]
    largest = max(range(len(counts)), key=counts.__getitem__)
    body = case.body[largest]
    in_cell = getattr(body, "points_per_cell", None)
    if in_cell is None:
        return
    one_in_cell = body.model_copy(update={"points_per_cell": 1}).with_others(case.body).n_points(case.grid_or_none)
    left = room - NODE_BYTES * n_nodes(case) - POINT_BYTES * (sum(counts) - counts[largest]) - table_bytes(case)
    fit = left / (POINT_BYTES * one_in_cell)
    if fit >= 1.0:
        remedy = f"Set points_per_cell to at most {fit:.2g} in total, or use a machine with more memory."
        raise CaseError(Problem(text, f"body.{body.name}.points_per_cell", in_cell, remedy))


def memory_estimate(case: "Case") -> float:
    """Return the memory that a run of the case needs [bytes]: program, grid nodes, points, and tables of shape functions; see
    `validation/memory`."""
    arrays = NODE_BYTES * n_nodes(case) + POINT_BYTES * n_points(case) + table_bytes(case)
    return PROGRAM_BYTES + arrays + viscous_bytes(case)


def viscous_bytes(case: "Case") -> float:
    """Return the memory of the linear systems of implicit viscosity and pressure [bytes], which cases with fluids that use
    these options need in addition to the grid."""
    stresses = {body.field: stress for body in case.body if (stress := body.implicit_stress) is not None}
    each = sum(bytes_of(ViscousRows) + (MODE_BYTES if stress.stiffness > 0.0 else 0) for stress in stresses.values())
    return each * n_nodes(case) / len({body.nodes_of for body in case.body})


def table_bytes(case: "Case") -> float:
    """Return the memory of the tables of shape functions at quadrature points [bytes]."""
    return sum(body.table_bytes() for body in case.body)


def n_nodes(case: "Case") -> float:
    """Return the number of stored nodes: nodes of the grid times number of velocity fields (sets of nodal velocities; bodies in
    different fields can come into contact)."""
    if case.grid_or_none is None:
        return 0.0
    axes = zip(case.grid.counts(), case.grid.thin(), case.grid.is_periodic(), strict=True)
    return len({body.nodes_of for body in case.body}) * prod(float(layers_of(*axis)) for axis in axes)


def n_points(case: "Case") -> float:
    """Return the number of points of all bodies, estimated from the volumes of their shapes; the error is at most about one
    layer of points at the surfaces."""
    return sum(body.with_others(case.body).n_points(case.grid_or_none) for body in case.body)


def physical_memory() -> int | None:
    """Return the physical memory of this machine [bytes]; None if the operating system does not report this number."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None
