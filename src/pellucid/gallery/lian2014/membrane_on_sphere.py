"""The sheet on the sphere against finite elements of our own, which bear no compression either."""

from pellucid.case import load
from pellucid.gallery.lian2014 import shapes
from pellucid.gallery.lian2014.curves import Curve, curves_of, deviations, figure_of
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.rendering.camera import View

VIEW = View(-55.0, 14.0)
INSTANTS = (1e-4, 2.6e-4, 4e-4, 5e-4)

CAPTIONS = {
    "curves": "Middle and corner of the sheet beside finite elements that bear no compression; dotted those of 0.5 mm that "
    "do, a mean over sheets that differ by a trace of noise.",
    "shapes": "The sheet wraps itself round the sphere, which is drawn as a ball of its volume.",
}

METRICS = ("centre_deviation", "corner_deviation", "hourglass")


def metrics(run: Run) -> dict[str, Metric]:
    """Largest deviations over the run."""
    if not finite_elements.same_problem(run.case, load("lian2014/membrane-on-sphere")):
        raise ValueError("the finite elements are for the paper's sheet and sphere")
    return deviations(run, _curves())


def figures(run: Run) -> dict[str, Figure]:
    """Curves beside the finite elements, and pictures."""
    return {"curves": figure_of(run, _curves()), "shapes": shapes.panels(run, VIEW, INSTANTS)}


def films(run: Run) -> dict[str, Animation]:
    """The sheet as it falls and wraps itself round the sphere."""
    return {"draping": shapes.film(run, VIEW)}


def _curves() -> tuple[Curve, ...]:
    names = {"centre_z": "the sheet's middle", "corner_z": "a corner of the sheet"}
    return curves_of("membrane_on_sphere", names, "relaxed_", "fine_", "with compression")
