"""Common metrics of a cube between clamps, stretched or compressed: comparison with second-order finite elements."""

from collections.abc import Sequence

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.gallery.mountris2019.curves import displacement, form_of, residuals
from pellucid.references import Array
from pellucid.references.solids import BONDED_CUBE, AtRest
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Axes, Run

EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]  # corners of a tetrahedron

METRICS = ("strain_energy", "reaction_z", "pressure_scatter", "ebc_residual_nodes", "ebc_residual_between")


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
