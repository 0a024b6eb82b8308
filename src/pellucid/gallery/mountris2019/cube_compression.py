"""Metrics and figures of a cube between clamps, compressed to half its height."""

from pellucid.gallery.mountris2019.clamped_cube import METRICS, beside_known, known_at, metrics_at, of_mesh
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Figure, Run, label, new_panels

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]

JUDGED = -0.01  # m: beyond, the sides pass the plates, and finite elements without contact have a limit less and less
KNOWN = (JUDGED, -0.02)

CAPTIONS = {
    "cube_compression": "Force on the top and strain energy against its displacement. Squares: finite elements, with "
    "the error of the run."
}


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: strain energy and force at a displacement of a tenth of the edge, compared with finite
    elements; scatter of the pressure; errors of the prescribed displacements."""
    return metrics_at(run, JUDGED, of_mesh(run, 0.01, 1.0))  # singular edges: first order, as finite elements have nearly


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the force on the upper plate and the strain energy against its displacement."""
    figure, (left, right) = new_panels(1, 2, width=10.0, height=4.0)
    known = [known_at(run, distance) for distance in KNOWN]
    beside_known(left, run, -run.history["reaction_z"], KNOWN, [-state.reaction for state in known])
    beside_known(right, run, run.history["strain_energy"], KNOWN, [state.energy for state in known])
    label(left, "displacement of the top, down", "force", "mm", "N")
    label(right, "displacement of the top, down", "strain energy", "mm", "J")
    return {"cube_compression": figure}
