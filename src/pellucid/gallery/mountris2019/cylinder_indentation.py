"""Metrics and figures of a cylinder indented by half its height."""

from pellucid.gallery.mountris2019.curves import excess, force_and_energy, least_volume, residuals, work_done
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Figure, Run

METRICS = ("strain_energy", "excess_energy", "excess_force", "least_volume", "ebc_residual_nodes", "ebc_residual_between")
ON_KNOWN_MESHES = ("excess_energy", "excess_force")  # that of the quick variant

CAPTIONS = {
    "cylinder_indentation": "Force of the indenter and strain energy against the indentation depth, at the computed equilibria."
}


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: strain energy compared with the work done; strain energy and force compared with finite
    elements; smallest volume ratio (current volume divided by initial volume); errors of the prescribed displacements."""
    beside = excess(run, "cylinder", 0.5, "reaction_z")
    return {"strain_energy": work_done(run), **beside, "least_volume": least_volume(run), **residuals(run)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the force on the indented face and the strain energy against the displacement."""
    return {"cylinder_indentation": force_and_energy(run, "reaction_z", 2)}
