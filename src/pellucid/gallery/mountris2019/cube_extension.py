"""Metrics and figures of a cube between clamps, stretched by half its edge."""

import numpy as np

from pellucid.gallery.exact_curves import compared
from pellucid.gallery.mountris2019.clamped_cube import METRICS as SHARED
from pellucid.gallery.mountris2019.clamped_cube import beside_known, known_at, metrics_at, of_mesh
from pellucid.gallery.mountris2019.curves import form_of
from pellucid.references import Array, finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

DISTANCE = 0.05

METRICS = (*SHARED, "bulge")

CAPTIONS = {
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


def metrics(run: Run) -> dict[str, Metric]:
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


def figures(run: Run) -> dict[str, Figure]:
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
