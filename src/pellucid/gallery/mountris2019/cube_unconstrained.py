"""Metrics and figures of a cube between smooth plates, compared with the exact uniform strain."""

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.gallery.mountris2019.curves import elasticity, form_of, residuals
from pellucid.references import Array
from pellucid.references.solids import Stretched, stretched
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"cube_unconstrained": "Displacements of the nodes against the exact ones, and their errors."}

METRICS = ("nrmse", "strain_energy", "reaction_z", "ebc_residual_nodes", "ebc_residual_between")


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


def metrics(run: Run) -> dict[str, Metric]:
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


def figures(run: Run) -> dict[str, Figure]:
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
