"""A heart of two ventricles whose right wall is pushed in."""

from pellucid.gallery.mountris2019.curves import excess, force_and_energy, least_volume, residuals, work_done
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run

METRICS = ("strain_energy", "excess_energy", "excess_force", "least_volume", "ebc_residual_nodes", "ebc_residual_between")
ON_KNOWN_MESHES = ("excess_energy", "excess_force")  # that of the quick variant

CAPTIONS = {"heart_indentation": "Force of the hand and strain energy against its displacement, at the equilibria."}


def metrics(run: Run) -> dict[str, Metric]:
    """Work, energy and force beside finite elements, the least volume, and how far the field is from what is prescribed."""
    beside = excess(run, "heart", 1.0, "push")
    return {"strain_energy": work_done(run), **beside, "least_volume": least_volume(run), **residuals(run)}


def figures(run: Run) -> dict[str, Figure]:
    """Force and energy against the displacement."""
    return {"heart_indentation": force_and_energy(run, "push", 0)}
