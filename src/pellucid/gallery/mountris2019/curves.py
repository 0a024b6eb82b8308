"""Common metrics of the cases of Mountris et al. 2019: residuals, work of constraints, smallest volume ratios, stiffness
compared with finite elements, force and energy."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.references.solids import indented
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

EXCESS = (
    0.25  # three times what averaged functions keep of the excess of linear tetrahedra in the cube that is pulled, 0.07 to 0.09
)
LEAST_LOST = 0.24  # of the volume about a node, see `least_volume`


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


def work_done(run: Run) -> Metric:
    """Return the metric that compares the strain energy at the end with the work of the prescribed motion minus the heat of the
    damping; their difference is of second order in the load steps."""
    energies = run.summary["energies"]
    given = float(energies["motion_work"] - energies["damping_heat"])
    stored = float(energies["strain"])
    return compared(stored, given, 2e-3, "J", "strain energy; reference: work of the motion minus heat of the damping")


def excess(run: Run, body: Literal["cylinder", "heart"], share: float, reaction: str) -> dict[str, Metric]:
    """Return metrics that compare strain energy and force with finite elements on the same mesh, at a share of the full
    displacement.

    The error is the excess over quadratic tetrahedra relative to the excess of linear tetrahedra. reaction: history column of
    the force. The result is empty for a mesh without reference.
    """
    known = indented(body, run.summary["points"], share)
    row = int(np.argmin(abs(run.history["time"] / run.case.time.end - share)))
    if known is None or abs(run.history["time"][row] / run.case.time.end - share) > 1e-9:
        return {}
    found = {}
    for name, column, (first, second) in (("energy", "strain_energy", known.energy), ("force", reaction, known.force)):
        above = float((abs(run.history[column][row]) - second) / (first - second))
        text = f"{name}: excess over quadratic tetrahedra, relative to the excess of linear tetrahedra"
        found[f"excess_{name}"] = vanishing(above, EXCESS, text)
    return found


def least_volume(run: Run) -> Metric:
    """Return the metric of the smallest volume ratio J (current volume divided by initial volume) at a node at the end.

    Nearly incompressible tissue keeps it near one: ln J = -p/λ with λ = 49 μ. Under the rim of an indenter the pressure is
    unbounded, so the smallest J decreases with mesh refinement: 27-node bricks give 0.91 and 0.88 on two meshes
    (`validation/mountris2019-cylinder`). Twice the loss on the finer mesh is tolerated.
    """
    name, density = run.stored.bodies[0].name, run.stored.bodies[0].density
    ratio = float(density / run.fields(name)["density"].max())
    return Metric(
        ratio, 1.0, abs(ratio - 1.0), LEAST_LOST, "", "smallest volume ratio J at a node; reference: 1 (nearly incompressible)"
    )


def displacement(run: Run, axis: int) -> "NDArray[np.float64]":
    """Return the prescribed displacement along an axis at each row of the history [m]."""
    moves = run.case.motion[0].functions()[axis]
    return np.array([moves(float(time)) for time in run.history["time"]])


def force_and_energy(run: Run, reaction: str, axis: int) -> Figure:
    """Return a figure of the force of the prescribed motion (history column `reaction`) and the strain energy at the
    equilibria, against the prescribed displacement along an axis (0 to 2)."""
    moved = displacement(run, axis)
    figure, (left, right) = new_panels(1, 2, width=10.0, height=4.0)
    left.plot(1e3 * abs(moved), abs(run.history[reaction]), "-o", color=COLOURS[0])
    right.plot(1e3 * abs(moved), 1e3 * run.history["strain_energy"], "-o", color=COLOURS[0])
    label(left, "displacement", "force", "mm", "N")
    label(right, "displacement", "strain energy", "mm", "mJ")
    return figure
