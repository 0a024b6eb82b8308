"""Warning about a transfer of velocities that smooths the flow more than its viscosity does.

A transfer without FLIP maps the velocities of the nodes to the points and back in each step. This multiplies a wave exp(ikx)
of nodal velocities by a factor D(k), like the kinematic viscosity

    ν = -ln D / (k² Δt).

For PIC with linear functions -ln D is (kh)²/6, with quadratic B-splines (kh)²/4. For APIC with quadratic B-splines it is 0.024
(kh)⁴: waves of 4, 8 and 16 cells lose 9.5 %, 0.8 % and 0.06 % in a step. APIC with linear functions does not smooth such waves.

At walls on faces of the grid B-splines are folded, and APIC no longer keeps quadratic profiles: in each step the first node
beside the wall loses the momentum β ρ h³ |u''| per unit of area, β = 0.024. In a slow flow between walls at a distance of 2R
the mean velocity R² |u''|/3 is smaller by β h⁴ |u''|/ν Δt, a part of 3 β (h²/ν Δt) (h/R)².
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pellucid.approximants import with_walls
from pellucid.approximants.grid_functions import GridFunction, affine_weights, axis_weights
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.open_faces.columns import ROUNDING, OpenFace
from pellucid.conditions.open_faces.inflow import Inflow
from pellucid.conditions.outflow import Outflow
from pellucid.conditions.support import Support, on_each_face
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import TRANSFERS, Apic, VelocityTransfer
from pellucid.materials.fluid import FluidMaterial
from pellucid.parts.families import GridBody

LEAST_REYNOLDS = 50.0
"""Reynolds number with the viscosity of the transfer, below which it changes how a flow enters and leaves a passage."""
MOST_DRAG = 0.03
"""Part of the mean velocity that a transfer may take at walls without a warning; the error of 8 cells across a channel is as
large."""
CELLS, SAMPLES = 16, 24  # of an axis on which waves are mapped to points and back; positions of points in a cell


def smoothing_warnings(case: Case, on_grid: Mapping[VelocityField, Sequence[GridBody]], dt: float) -> Iterator[str]:
    """Yield a warning for each fluid that is smoothed by the transfer of velocities more than by its own viscosity, so strongly
    that the Reynolds number of its flow is small.

    on_grid: bodies on the grid, by velocity field; dt: first time step [s].
    """
    transfer, models = TRANSFERS[case.time.transfer](case.time.flip_fraction), {body.name: body for body in case.body}
    if transfer.flip == 1.0 or case.grid_or_none is None or sum(not thin for thin in case.thin) < 2:
        return
    for body in (body for bodies in on_grid.values() for body in bodies):
        material = getattr(models[body.name], "material", None)
        if not isinstance(body, PointsOnGrid) or not isinstance(material, FluidMaterial):
            continue
        position, cell = body.stored_array("position"), case.grid.cell
        speed = _speed(case, models[body.name], material.density, position)
        axes = [axis for axis in range(3) if not case.thin[axis]]
        extent = float(np.ptp(position[:, axes], axis=0).min()) / cell
        passage = narrowest_passage(case, body.grid, position)
        cells = min(passage, extent)
        if speed == 0.0 or cells < 1.0:
            continue
        function = max((with_walls(body.functions[axis]) for axis in axes), key=lambda function: function.stencil)
        wave = 2.0 * np.pi / (2.0 * cells)
        viscosity = damping(transfer, function, wave) * (cell / wave) ** 2 / dt
        reynolds = speed * cells * cell / viscosity if viscosity > 0.0 else np.inf
        if reynolds < LEAST_REYNOLDS and viscosity * material.density > material.viscosity:
            where = "narrowest passage to an open face" if passage < extent else "body"
            longer = "" if material.implicit_stress() else ", or `implicit_pressure = true`, whose longer steps smooth less"
            yield (
                f"the transfer `{case.time.transfer}` smooths the flow of body {body.name} like an additional viscosity of "
                f"{viscosity * material.density:.2g} Pa s (viscosity of the fluid: {material.viscosity:.2g} Pa s): across the "
                f"{where}, {cells:.2g} cells wide, the Reynolds number is at most {reynolds:.2g}. "
                f'Set `time.transfer = "flip"` or "blend", or a smaller `grid.cell`{longer}.'
            )
        yield from _slowed(case, body, material, transfer, speed, dt)


def _slowed(
    case: Case, body: PointsOnGrid, material: FluidMaterial, transfer: VelocityTransfer, speed: float, dt: float
) -> Iterator[str]:
    """Yield a warning if the transfer of velocities slows a slow flow between walls on faces of the grid by more than
    MOST_DRAG.

    speed: upper estimate of the speed of the fluid [m/s]; dt: first time step [s].
    """
    own, (width, axis) = material.viscosity / material.density, _channel(case, body.stored_array("position"))
    if own == 0.0 or speed * width * case.grid.cell > LEAST_REYNOLDS * own:
        return
    slower = (
        3.0 * drag_at_walls(transfer, with_walls(body.functions[axis])) * case.grid.cell**2 / (own * dt) / (0.5 * width) ** 2
    )
    if slower > MOST_DRAG:
        implicit = "" if material.implicit_stress() else ", `implicit_pressure = true`, which needs fewer steps,"
        yield (
            f"the transfer `{case.time.transfer}` slows the flow of body {body.name} in each step at walls on faces of the "
            f"grid: in a channel, {width:.2g} cells wide, by about {100 * min(slower, 1.0):.2g} % of the mean velocity. "
            f'Set `time.transfer = "aflip"`{implicit} or a smaller `grid.cell`.'
        )


def _channel(case: Case, position: np.ndarray) -> tuple[float, int]:
    """Return the width [cells] of the narrowest channel between walls on faces of the grid that fluid points at `position`
    [m], shape (n, 3), fill, infinite without walls, and the axis across it. A wall at one end only makes half a channel."""
    faces = [face for one in on_each_face(case.support) if (face := one.face()) is not None and sum(one.axes()) > 1]
    ends = [sum(axis == across for axis, _ in faces) for across in range(3)]
    extent = np.ptp(position, axis=0) / case.grid.cell
    widths = [np.inf if not ends[axis] or case.thin[axis] else float(extent[axis]) * 2 / ends[axis] for axis in range(3)]
    axis = int(np.argmin(widths))
    return widths[axis], axis


def damping(transfer: VelocityTransfer, function: GridFunction, wave: float) -> float:
    """Return -ln D, the part by which the transfer reduces the logarithm of the amplitude of a shear wave in a step.

    function: shape functions along the axis of the wave; wave: wave number times the cell size.
    """
    kept = []
    for u in CELLS // 2 + (np.arange(SAMPLES) + 0.5) / SAMPLES:
        node, w, factors = _weights_at(function, float(u))
        nodal = np.exp(1j * wave * node)
        velocity = w @ nodal
        if isinstance(transfer, Apic):
            velocity = velocity + factors @ nodal * (node - u)
        kept.append(np.sum(w * np.conj(nodal) * velocity).real)
    return -float(np.log(1.0 - (1.0 - transfer.flip) * (1.0 - np.mean(kept))))


def _weights_at(function: GridFunction, u: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the nodes around a point, the values of their shape functions there, and the factors of the affine field, see
    `affine_weights`. u: position of the point [cells]."""
    first, weights, slopes = axis_weights(function, u, CELLS)
    factors = affine_weights(function, first - u, weights, slopes)
    return first + np.arange(len(weights)), np.array(weights), np.array(factors)


def drag_at_walls(transfer: VelocityTransfer, function: GridFunction) -> float:
    """Return β, the momentum that a transfer with affine fields takes in a step at a wall on a face of the grid, divided by
    ρ h³ |u''|; 0 for others.

    function: shape functions along the normal of the wall.
    """
    if not isinstance(transfer, Apic):
        return 0.0
    profile, mass, momentum = -0.5 * np.arange(CELLS + 2.0) ** 2, 0.0, 0.0
    for u in (np.arange(SAMPLES * CELLS // 2) + 0.5) / SAMPLES:
        node, w, factors = _weights_at(function, float(u))
        affine = factors @ profile[node]
        share = float(np.sum(w[node == 1])) / SAMPLES
        mass, momentum = mass + share, momentum + share * float(w @ profile[node] + affine * (1.0 - u))
    return (1.0 - transfer.flip) * max(0.0, mass * float(profile[1]) - momentum)


def narrowest_passage(case: Case, grid: Grid, position: np.ndarray) -> float:
    """Return the width in cells of the narrowest passage between supports on the widest path from the points at `position`
    [m], shape (n, 3), to the open faces of the grid; infinite without open faces or supports at a passage."""
    from scipy.ndimage import distance_transform_edt, label

    parts, case_grid = parts_of(case), grid.case
    names = {inflow.where for inflow in parts.of(Inflow)} | {face for outflow in parts.of(Outflow) for face in outflow.where}
    index, place = grid.where()
    shape = tuple(len(np.unique(axis)) for axis in np.rint((place - case_grid.lower) / case_grid.cell).T)
    held = np.isin(grid.nodes.constrained[index], _rows_of_walls(case.support))
    walls: np.ndarray = np.any(held, axis=1).reshape(shape)
    if not names or not walls.any():
        return np.inf
    clearance = distance_transform_edt(~walls)
    nodes = np.rint((position - case_grid.lower) / case_grid.cell).astype(int)
    wet = np.zeros(shape, bool)
    wet[tuple(np.minimum(nodes, np.array(shape) - 1).T)] = True
    most = float(clearance.max(where=wet, initial=0.0))
    start = wet & (clearance == most)
    faces = [OpenFace.of(name, case_grid) for name in sorted(names)]
    ends = [(np.abs(face.depth(place)) < ROUNDING * case_grid.cell).reshape(shape) for face in faces]
    steps = np.unique(clearance[(clearance > 0.0) & (clearance <= most)])
    least = most
    for end in ends:
        low, high = -1, len(steps) - 1  # bisection: the largest clearance at which a path connects the fluid and the face
        while low < high:
            middle = (low + high + 1) // 2
            part, _ = label(clearance >= steps[middle])
            joined = np.intersect1d(part[start], part[end])
            low, high = (middle, high) if (joined > 0).any() else (low, middle - 1)
        least = min(least, float(steps[low])) if low >= 0 else least
    return 2.0 * least


def _rows_of_walls(supports: Sequence[Support]) -> list[int]:
    """Return 1 + the numbers of the supports that are walls of a passage: all except planes of symmetry, which constrain a face
    along its normal only."""
    rows = []
    for number, support in enumerate(on_each_face(supports)):
        face, axes = support.face(), support.axes()
        if face is None or not axes[face[0]] or sum(axes) > 1:
            rows.append(number + 1)
    return rows


def _speed(case: Case, model: object, density: float, position: np.ndarray) -> float:
    """Return an upper estimate of the speed of a fluid [m/s], from its velocity at the start, gravity, open faces and moving
    supports; model: model of the body; position: positions of its points [m], shape (n, 3)."""
    parts = parts_of(case)
    flows: list[Inflow | Outflow] = [*parts.of(Inflow), *parts.of(Outflow)]
    pressures = [flow.largest_share() * abs(flow.pressure) for flow in flows if flow.pressure is not None]
    gravity = np.abs(case.gravity) * np.where(case.thin, 0.0, 1.0)
    height = np.ptp(position, axis=0) @ gravity
    speeds = [float(np.linalg.norm(getattr(model, "velocity", np.zeros(3)))), float(np.sqrt(2.0 * height))]
    speeds += [flow.largest_share() * (flow.velocity or 0.0) for flow in flows]
    speeds += [float(np.sqrt(2.0 * sum(pressures) / density))]
    speeds += [float(np.linalg.norm(support.velocity)) for support in case.support]
    return max(speeds)
