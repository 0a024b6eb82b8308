"""Common metrics of the two cases of a sheet and a sphere: comparison with our own finite elements, hourglass energy."""

from collections.abc import Mapping

from pellucid.gallery.exact_curves import deviations, vanishing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

CELL = 0.001
"""Cell size of the paper [m]."""

TOLERANCE, LEAST_TOLERANCE = 0.10, 0.05
"""Tolerances relative to the largest change: at the paper's cell size, and at half of it and below."""

HOURGLASS = 0.01
"""Largest hourglass energy, as a fraction of the initial kinetic energy."""


def tolerance_of(run: Run) -> float:
    """Return the largest allowed relative deviation of the curves of a run; it is proportional to the cell size of its grid."""
    return max(LEAST_TOLERANCE, TOLERANCE * run.case.grid.cell / CELL)


def beside_elements(run: Run, table: str, columns: Mapping[str, tuple[str, str]], known: str = "") -> dict[str, Metric]:
    """Return the metrics of `deviations`, with the arguments of that function, and of the largest hourglass energy (energy
    stored in zero-energy modes of the elements) relative to the initial kinetic energy."""
    share = float(run.history["hourglass_energy"].max() / run.history["kinetic_energy"][0])
    text = "largest hourglass energy, relative to the initial kinetic energy"
    return {
        **deviations(run, table, columns, tolerance_of(run), known),
        "hourglass": vanishing(share, HOURGLASS, text),
    }
