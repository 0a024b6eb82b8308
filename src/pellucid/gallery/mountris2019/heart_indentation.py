"""Metrics and figures of a heart with two ventricles whose right wall is indented."""

from pellucid.gallery.mountris2019.curves import excess, force_and_energy, least_volume, residuals, work_done
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Figure, Run

METRICS = ("strain_energy", "excess_energy", "excess_force", "least_volume", "ebc_residual_nodes", "ebc_residual_between")
ON_KNOWN_MESHES = ("excess_energy", "excess_force")  # that of the quick variant

CAPTIONS = {
    "heart_indentation": "Force of the hand and strain energy against the displacement of the hand, at the computed equilibria."
}


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: strain energy compared with the work done; strain energy and force compared with finite
    elements; smallest volume ratio (current volume divided by initial volume); errors of the prescribed displacements."""
    beside = excess(run, "heart", 1.0, "push")
    return {"strain_energy": work_done(run), **beside, "least_volume": least_volume(run), **residuals(run)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the force on the indented wall and the strain energy against the displacement."""
    return {"heart_indentation": force_and_energy(run, "push", 0)}
