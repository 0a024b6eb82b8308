"""Pictures of bodies in three dimensions, coloured by a field; what hides others is cut open."""

from typing import TYPE_CHECKING

import numpy as np

from pellucid.results.pictures.instants import evenly
from pellucid.results.pictures.quantities import Fields, limits, meaning, values_of
from pellucid.results.pictures.rendering.axes import coloured, corner_words, scale_bar, show
from pellucid.results.pictures.rendering.camera import Plane, View, camera_for
from pellucid.results.pictures.rendering.drawables import Balls, Drawable, Mesh
from pellucid.results.pictures.rendering.points import ball_radii
from pellucid.results.pictures.rendering.render import render
from pellucid.results.pictures.style import SEQUENTIAL, WIDTH, new_figure, with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run

INSTANTS = 4
COLUMNS = 700  # pixels of a panel
MOST_HEIGHT = 7.5  # of the panels together [inch]
VIEW = View(-50.0, 22.0)
FRONT = (0.0, -1.0, 0.0)
"""The side from which bodies are opened: the eye is there."""

ASIDE = 1e-3  # of the size of what is surrounded
MOST_BALLS = 60_000
"""More points of a body than this are thinned out evenly, the balls grow instead."""


def panels_in_space(run: "Run", quantity: str) -> "Figure":
    """All bodies at some instants, coloured by "speed" or "load"."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import EngFormatter

    bodies = {body.name: body for body in run.stored.bodies}
    chosen = evenly(run.times(run.stored.bodies[0].name), INSTANTS)
    states = [{name: run.fields(name, float(time)) for name in bodies} for time in chosen]
    low, high, extend = limits(
        [values_of(bodies[name], fields, quantity) for state in states for name, fields in state.items()]
    )
    cut = opening([fields["position"] for fields in states[0].values()])
    places = np.concatenate([fields["position"] for state in states for fields in state.values()])
    camera = camera_for(VIEW, places[cut.beyond(places) <= 0.0] if cut else places, COLUMNS, margin=0.06)
    across = min(2, len(chosen))
    down = -(-len(chosen) // across)
    rows, columns = camera.shape
    width = min((WIDTH - 1.0) / across, MOST_HEIGHT / down * columns / rows)  # of a panel [inch]
    figure = new_figure(across * width + 1.0, down * width * rows / columns + 0.1, layout="compressed")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    surfaces = {name: run.cells(name).surface() for name in bodies}
    for axes, time, state in zip(panels, chosen, states, strict=False):
        drawn = [
            _drawable(fields, surfaces[name], coloured(values_of(bodies[name], fields, quantity), (low, high), SEQUENTIAL))
            for name, fields in state.items()
        ]
        show(axes, render(drawn, camera, cut), camera)
        scale_bar(axes, camera)
        corner_words(axes, f"t = {EngFormatter('s', useMathText=False)(float(f'{time:.4g}'))}", "cut open" if cut else "")
    for unused in panels[len(chosen) :]:
        unused.remove()
    scale = ScalarMappable(Normalize(low, high), SEQUENTIAL)
    bar = figure.colorbar(scale, ax=figure.axes, shrink=0.7, pad=0.01, aspect=25, extend=extend)
    bar.set_label(with_unit(*meaning(run.stored.bodies, quantity)))
    bar.outline.set_visible(False)
    return figure


def opening(positions: list[np.ndarray]) -> Plane | None:
    """Where to cut bodies open of which one surrounds another: through the middle of what is surrounded, else nowhere."""
    boxes = [(position.min(axis=0), position.max(axis=0)) for position in positions]
    hidden = [
        inner
        for k, inner in enumerate(boxes)
        if any((outer[0] < inner[0]).all() and (inner[1] < outer[1]).all() for outer in boxes[:k] + boxes[k + 1 :])
    ]
    if not hidden:
        return None
    largest = max(hidden, key=lambda box: float(np.prod(box[1] - box[0])))
    middle = float(0.5 * (largest[0] + largest[1]) @ np.array(FRONT))
    # layers of points often lie in the very middle: a little before it, so that they stay in every picture
    return Plane(FRONT, middle + ASIDE * float((largest[1] - largest[0]).max()))


def _drawable(fields: Fields, surface: np.ndarray, colours: np.ndarray) -> Drawable:
    position, finite = fields["position"], np.nan_to_num(colours)
    if len(surface):
        return Mesh(position, surface, finite, np.zeros(len(position), bool))
    stride = -(-len(position) // MOST_BALLS)
    radii = ball_radii(fields["mass"], fields["density"]) * np.cbrt(stride)
    return Balls(position[::stride], radii[::stride], finite[::stride])
