"""Metrics and figures of stretched and compressed cubes of Mountris et al. 2019: between clamps, compared with second-order
finite elements, and between smooth plates, compared with the exact uniform strain."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.references import Array, finite_elements
from pellucid.references.solids import BONDED_CUBE, AtRest, Stretched, stretched
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Axes, Figure, Run, label, new_panels


def form_of(run: Run) -> Literal["coupled", "decoupled"]:
    """Return the form of the neo-Hookean energy of a run. Raises ValueError for another law, which has no reference here."""
    kind = run.stored.bodies[0].material
    if kind not in ("neo-hookean", "decoupled-neo-hookean"):
        raise ValueError(f'the references require neo-Hookean tissue, not tissue of kind "{kind}"')
    return "coupled" if kind == "neo-hookean" else "decoupled"


def elasticity(run: Run) -> tuple[float, float]:
    """Return Young's modulus [Pa] and Poisson's ratio of the first body."""
    material = run.case.body[0].material.model_dump()
    return material["young_modulus"], material["poisson_ratio"]


def residuals(run: Run, tolerance: float = 1e-12) -> dict[str, Metric]:
    """Return the metrics of the errors of the prescribed displacement [m], at the nodes and between them; the paper has 1e-17
    at the nodes. tolerance: largest allowed error [m]."""
    found = {}
    for place, where in (("nodes", "at the nodes of prescribed faces"), ("between", "between these nodes")):
        value = float(run.summary[f"ebc_residual_{place}"])
        found[f"ebc_residual_{place}"] = vanishing(value, tolerance, f"error of the prescribed displacement {where}", "m")
    return found


def displacement(run: Run, axis: int) -> "NDArray[np.float64]":
    """Return the prescribed displacement along an axis at each row of the history [m]."""
    moves = run.case.motion[0].functions()[axis]
    return np.array([moves(float(time)) for time in run.history["time"]])


EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]  # corners of a tetrahedron

CLAMPED_METRICS = ("strain_energy", "reaction_z", "pressure_scatter", "ebc_residual_nodes", "ebc_residual_between")


def at(run: Run, distance: float) -> tuple[float, float]:
    """Return the strain energy [J] and the force along z on the upper face [N] at the equilibrium in which the distance of the
    plates has grown by `distance` [m]. Raises ValueError if no such equilibrium was computed."""
    moved = displacement(run, 2)
    row = int(np.argmin(abs(moved - distance)))
    if abs(moved[row] - distance) > 1e-6 * abs(distance):
        raise ValueError(
            f"no equilibrium was computed at a displacement of {distance:g} m; set steady.load_steps so that a load step has it"
        )
    return float(run.history["strain_energy"][row]), float(run.history["reaction_z"][row])


def of_mesh(run: Run, share: float, exponent: float) -> float:
    """Return the largest allowed relative error of a solution with averaged maximum-entropy functions on the mesh of a run:
    `share` at 5 500 nodes, scaled with the power `exponent` of the node spacing."""
    nodes = run.summary["points"]
    return float(share * (5500.0 / nodes) ** (exponent / 3.0))


def metrics_at(run: Run, distance: float, off: float) -> dict[str, Metric]:
    """Return the metrics by name: strain energy and force when the distance of the plates has grown by `distance` [m], scatter
    of the pressure at the end, errors of the prescribed displacements.

    off: largest allowed relative error of the method on this mesh, to which the error of the reference is added.
    """
    known = BONDED_CUBE[form_of(run), distance]
    energy, force = at(run, distance)
    return {
        "strain_energy": _compared(energy, known.energy, off + known.energy_error, "J"),
        "reaction_z": _compared(force, known.reaction, off + known.reaction_error, "N"),
        "pressure_scatter": _scatter(run),
        **residuals(run),
    }


def known_at(run: Run, distance: float) -> AtRest:
    """Return the finite-element solution of the cube for a displacement `distance` of the upper plate relative to the lower
    plate [m]."""
    return BONDED_CUBE[form_of(run), distance]


def beside_known(axes: Axes, run: Run, values: Array, places: Sequence[float], known: Sequence[float]) -> None:
    """Draw values at the equilibria of a run, shape (rows,), against the displacement of the upper plate.

    For comparison, finite-element values `known` at displacements `places` [m] are drawn, each with the relative difference of
    the run from it as text.
    """
    moved = abs(displacement(run, 2))
    axes.plot(1e3 * moved, values, "-o", color=COLOURS[0], markersize=4, label="meshless solid")
    at = 1e3 * abs(np.array(places))
    axes.plot(at, known, "s", color="black", fillstyle="none", markersize=11, label="finite elements")
    for place, value in zip(at, known, strict=True):
        row = int(np.argmin(abs(1e3 * moved - place)))
        if abs(1e3 * moved[row] - place) < 1e-6 * place:  # at an equilibrium: nothing is known between them
            off = f"{100.0 * (values[row] / value - 1.0):+.2f} %"
            axes.annotate(off, (place, value), (10, -14), textcoords="offset points", fontsize=9)
    axes.margins(x=0.2)
    axes.legend(loc="upper left", labelspacing=0.8)


def _compared(value: float, known: float, tolerance: float, unit: str) -> Metric:
    return compared(value, known, tolerance, unit, "reference: quadratic finite elements")


def _scatter(run: Run) -> Metric:
    """Return the metric of the scatter of the pressure (oscillation from node to node).

    The scatter is the RMS difference between a node in the inner half and the mean of its neighbours, divided by the pressure
    range. A checkerboard of two alternating values has a scatter of one. For a smooth field the scatter decreases with the
    square of the spacing.
    """
    name = run.case.body[0].name
    start, pressure = run.fields(name, 0.0)["position"], run.fields(name)["pressure"]
    edge = float(np.ptp(start[:, 2]))
    middle = 0.5 * (start.min(axis=0) + start.max(axis=0))
    pairs = np.unique(np.sort(run.cells(name).tetrahedra[:, EDGES].reshape(-1, 2)), axis=0)
    count, total = np.zeros(len(start)), np.zeros(len(start))
    for one, other in (pairs.T, pairs.T[::-1]):
        np.add.at(total, one, pressure[other])
        np.add.at(count, one, 1.0)
    inner = (abs(start - middle) < 0.26 * edge).all(axis=1)
    off = (pressure - total / count)[inner]
    scatter = float(np.sqrt(np.mean(off**2)) / np.ptp(pressure[inner]))
    return vanishing(
        scatter, 0.1, "rms difference between the pressure of a node and the mean of its neighbours, relative to the range"
    )


JUDGED = -0.01  # m: beyond, the sides pass the plates, and finite elements without contact have a limit less and less
KNOWN = (JUDGED, -0.02)

COMPRESSION_CAPTIONS = {
    "cube_compression": "Force on the top and strain energy against its displacement. Squares: finite elements, with "
    "the error of the run."
}


def compression_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: strain energy and force at a displacement of a tenth of the edge, compared with finite
    elements; scatter of the pressure; errors of the prescribed displacements."""
    return metrics_at(run, JUDGED, of_mesh(run, 0.01, 1.0))  # singular edges: first order, as finite elements have nearly


def compression_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the force on the upper plate and the strain energy against its displacement."""
    figure, (left, right) = new_panels(1, 2, width=10.0, height=4.0)
    known = [known_at(run, distance) for distance in KNOWN]
    beside_known(left, run, -run.history["reaction_z"], KNOWN, [-state.reaction for state in known])
    beside_known(right, run, run.history["strain_energy"], KNOWN, [state.energy for state in known])
    label(left, "displacement of the top, down", "force", "mm", "N")
    label(right, "displacement of the top, down", "strain energy", "mm", "J")
    return {"cube_compression": figure}


DISTANCE = 0.05

EXTENSION_METRICS = (*CLAMPED_METRICS, "bulge")

EXTENSION_CAPTIONS = {
    "cube_extension": "Displacement of the free sides (points: run, lines: finite elements); force on the top with its error."
}


def _lines(run: Run) -> dict[str, tuple[Array, Array]]:
    """Return initial heights [m], shape (n,), and displacements at the end [m], shape (n, 3), of the nodes on the middle line
    of a free face ("face") and on a free edge ("edge")."""
    name = run.case.body[0].name
    start = run.fields(name, 0.0)["position"]
    moved = run.fields(name)["position"] - start
    lower, upper = start.min(axis=0), start.max(axis=0)
    on_face = abs(start[:, 0] - upper[0]) < 1e-9
    across = {"face": 0.5 * (lower[1] + upper[1]), "edge": upper[1]}
    found = {}
    for line, y in across.items():
        nodes = np.flatnonzero(on_face & (abs(start[:, 1] - y) < 1e-9))
        nodes = nodes[np.argsort(start[nodes, 2])]
        found[line] = start[nodes, 2] - lower[2], moved[nodes]
    return found


def _known_line(run: Run, line: str, height: Array) -> Array:
    """Return the transverse displacement [m] by finite elements at initial heights [m] on a line: the middle line of a free
    face (line = "face") or a free edge ("edge"); the upper half mirrors the lower one."""
    table, edge = finite_elements.read("cube_bulge"), 0.1
    return np.asarray(np.interp(np.minimum(height, edge - height), table["z"], table[f"{form_of(run)}_{line}_x"]))


def extension_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: strain energy, force, and transverse displacement of the free sides at half height, compared
    with finite elements; scatter of the pressure; errors of the prescribed displacements."""
    # displacements are of second order, energies and forces feel the singular edges of the clamps
    height, moved = _lines(run)["face"]
    bulge = float(np.interp(0.05, height, moved[:, 0]))
    known = float(_known_line(run, "face", np.array([0.05]))[0])
    shape = compared(
        bulge, known, of_mesh(run, 0.01, 2.0), "m", "displacement of the free sides; reference: quadratic finite elements"
    )
    return {**metrics_at(run, DISTANCE, of_mesh(run, 0.01, 1.5)), "bulge": shape}


def extension_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the deformed free sides, and the force on the upper plate against its displacement."""
    figure, (left, right) = new_panels(1, 2, width=10.0, height=4.0)
    heights = np.linspace(0.0, 0.1, 200)
    names = {"face": "middle of a face", "edge": "edge of the cube"}
    for colour, marker, (line, (height, moved)) in zip(COLOURS, "os", _lines(run).items(), strict=False):
        left.plot(1e3 * _known_line(run, line, heights), 1e3 * heights, color=colour, linewidth=1.5)
        left.plot(1e3 * moved[:, 0], 1e3 * height, marker, color=colour, markerfacecolor="white", label=names[line])
    left.plot([], [], color="#555", linewidth=1.5, label="finite elements")
    label(left, "displacement across", "height at rest", "mm", "mm")
    left.legend(loc="center right")
    beside_known(right, run, run.history["reaction_z"], [DISTANCE], [known_at(run, DISTANCE).reaction])
    label(right, "displacement of the top", "force on the top", "mm", "N")
    return {"cube_extension": figure}


FREE_CAPTIONS = {"cube_unconstrained": "Displacements of the nodes against the exact ones, and their errors."}

FREE_METRICS = ("nrmse", "strain_energy", "reaction_z", "ebc_residual_nodes", "ebc_residual_between")


def _exact(run: Run) -> "tuple[Stretched, float, float]":
    """Return the exact homogeneous state of the cube at the end of a run, its initial edge [m] and its stretch along z."""
    body, motion = run.case.body[0], run.case.motion[0]
    edge = float(np.ptp(run.fields(body.name, 0.0)["position"][:, 2]))
    along = 1.0 + motion.functions()[2](run.case.time.end) / edge
    return stretched(form_of(run), *elasticity(run), along), edge, along


def _displacements(run: Run) -> tuple[Array, Array]:
    """Return the computed displacements of the nodes at the end and the exact ones [m], each of shape (n, 3)."""
    cube, _, along = _exact(run)
    name = run.case.body[0].name
    start = run.fields(name, 0.0)["position"]
    return run.fields(name)["position"] - start, start * (np.array([cube.lateral, cube.lateral, along]) - 1.0)


def free_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: root mean square error of the displacements, strain energy, force on the upper face, errors
    of the prescribed displacements."""
    cube, edge, _ = _exact(run)
    found, exact = _displacements(run)
    error = float(np.sqrt(np.mean((found - exact) ** 2)) / np.ptp(exact))
    energy = cube.energy * edge**3
    stored = float(run.summary["energies"]["strain"])
    force, pulled = float(run.history["reaction_z"][-1]), cube.stress * edge**2
    tight = 1e-6  # linear fields are in the span of the functions, and consistent gradients integrate them exactly
    return {
        "nrmse": vanishing(error, tight, "root mean square error of the displacements, relative to their range"),
        "strain_energy": compared(stored, energy, tight, "J", "strain energy; reference: exact, uniform strain"),
        "reaction_z": compared(force, pulled, tight, "N", "force of the top on the cube; reference: exact, uniform stress"),
        **residuals(run),
    }


def free_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the computed displacements of the nodes against the exact ones, and their
    differences."""
    found, exact = _displacements(run)
    figure, (left, right) = new_panels(1, 2, width=10.0, height=4.0)
    for axis, name in enumerate("xyz"):
        left.plot(1e3 * exact[:, axis], 1e3 * found[:, axis], "o", markersize=3, color=COLOURS[axis], label=name)
        off = np.maximum(abs(found - exact)[:, axis], 1e-18)
        right.semilogy(1e3 * exact[:, axis], off, "o", markersize=3, color=COLOURS[axis], label=name)
    ends = 1e3 * np.array([exact.min(), exact.max()])
    left.plot(ends, ends, color="black", linewidth=0.8)
    label(left, "exact displacement", "displacement", "mm", "mm", legend=True)
    label(right, "exact displacement", "difference", "mm", "m")
    return {"cube_unconstrained": figure}


CASES = {
    "cube-compression": SimpleNamespace(
        METRICS=CLAMPED_METRICS, CAPTIONS=COMPRESSION_CAPTIONS, metrics=compression_metrics, figures=compression_figures
    ),
    "cube-extension": SimpleNamespace(
        METRICS=EXTENSION_METRICS, CAPTIONS=EXTENSION_CAPTIONS, metrics=extension_metrics, figures=extension_figures
    ),
    "cube-unconstrained": SimpleNamespace(
        METRICS=FREE_METRICS, CAPTIONS=FREE_CAPTIONS, metrics=free_metrics, figures=free_figures
    ),
}
"""Metrics, captions and figures of each case, by its name without the group."""
