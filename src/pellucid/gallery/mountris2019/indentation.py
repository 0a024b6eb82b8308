"""Metrics and figures of indented bodies: a cylinder, by half its height, and a heart, at the wall of the right ventricle."""

from typing import Literal

from pellucid.gallery.mountris2019.curves import excess, force_and_energy, least_volume, residuals, work_done
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Figure, Run

METRICS = ("strain_energy", "excess_energy", "excess_force", "least_volume", "ebc_residual_nodes", "ebc_residual_between")
ON_KNOWN_MESHES = ("excess_energy", "excess_force")  # that of the quick variant

PUSHED: dict[str, tuple[Literal["cylinder", "heart"], float, str, int]] = {
    "cylinder": ("cylinder", 0.5, "reaction_z", 2),
    "heart": ("heart", 1.0, "push", 0),
}
"""For each body by its name: table of finite elements, share of the displacement at which these are known, column of the force
in the history, and axis of the indentation."""

CAPTIONS = {
    "cylinder_indentation": "Force of the indenter and strain energy against the indentation depth, at the computed "
    "equilibria.",
    "heart_indentation": "Force of the hand and strain energy against the displacement of the hand, at the computed "
    "equilibria.",
}


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: strain energy compared with the work done; strain energy and force compared with finite
    elements; smallest volume ratio (current volume divided by initial volume); errors of the prescribed displacements."""
    name, share, force, _ = PUSHED[run.case.body[0].name]
    beside = excess(run, name, share, force)
    return {"strain_energy": work_done(run), **beside, "least_volume": least_volume(run), **residuals(run)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the force on the indented face and the strain energy against the displacement."""
    name, _, force, axis = PUSHED[run.case.body[0].name]
    return {f"{name}_indentation": force_and_energy(run, force, axis)}
