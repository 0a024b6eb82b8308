"""Metrics of a sheet that falls on a sphere, compared with our own finite elements, which also carry no compression."""

from pellucid.gallery.lian2014.sphere_on_membrane import beside_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("centre_deviation", "corner_deviation", "hourglass")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the heights of the middle and a corner of the sheet from finite
    elements during the run, and largest hourglass energy."""
    columns = {
        "centre_deviation": ("centre_z", "the middle of the sheet"),
        "corner_deviation": ("corner_z", "a corner of the sheet"),
    }
    return beside_elements(run, "membrane_on_sphere", columns, "relaxed_")
