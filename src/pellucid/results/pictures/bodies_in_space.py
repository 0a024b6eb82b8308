"""Pictures of bodies in three dimensions, coloured by a field; what hides others is cut open, and solids once more."""

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.instants import evenly
from pellucid.results.pictures.quantities import Fields, limits, meaning, values_of
from pellucid.results.pictures.rendering.axes import coloured, corner_words, scale_bar, show
from pellucid.results.pictures.rendering.camera import Plane, View, camera_for
from pellucid.results.pictures.rendering.creases import Faceted, split_at_creases
from pellucid.results.pictures.rendering.drawables import Balls, Drawable, Mesh
from pellucid.results.pictures.rendering.points import ball_radii
from pellucid.results.pictures.rendering.render import render
from pellucid.results.pictures.rendering.sections import cut_face
from pellucid.results.pictures.style import WIDTH, colour_bar, panels, with_unit

INSTANTS = 4
COLUMNS = 700  # pixels of a panel
MOST_HEIGHT = 7.5  # of the panels together [inch]
VIEW = View(-50.0, 22.0)
FRONT = (0.0, -1.0, 0.0)
"""The side from which bodies are opened: the eye is there."""

ASIDE = 1e-3  # of the size of what is surrounded
IN_FRONT = 0.01  # of the size of the picture, by which membranes are drawn nearer to the eye than solids that they lie on
Box = tuple[np.ndarray, np.ndarray]
"""Lower and upper corner [m], shape (3,) each."""

MOST_BALLS = 60_000
"""More points of a body than this are thinned out evenly, the balls grow instead."""


def panels_in_space(run: Run, quantity: str, halved: bool = False) -> Figure:
    """All bodies at some instants but those that are lines, coloured by "speed", "displacement" or "load".

    What surrounds a body is cut open through the middle of that; where `halved`, all are through that of the largest solid.
    """
    from matplotlib.ticker import EngFormatter

    bodies = {body.name: body for body in run.stored.bodies if not len(run.cells(body.name).lines)}
    chosen = evenly(run.times(next(iter(bodies))), INSTANTS)
    states = [{name: run.fields(name, float(time)) for name in bodies} for time in chosen]
    start = {name: fields["position"] for name, fields in states[0].items()}
    shown = [
        {name: values_of(bodies[name], fields, quantity, start[name]) for name, fields in state.items()} for state in states
    ]
    limited = limits([values for state in shown for values in state.values()])
    cells = {name: run.cells(name) for name in bodies}
    solids = [position for name, position in start.items() if len(cells[name].tetrahedra)]
    cut = opening(list(start.values()))
    if halved and solids:
        cut = through_the_middle([bounding_box(position) for position in solids])
    places = np.concatenate([fields["position"] for state in states for fields in state.values()])
    camera = camera_for(VIEW, places[cut.beyond(places) <= 0.0] if cut else places, COLUMNS, margin=0.06)
    across = min(2, len(chosen))
    down = -(-len(chosen) // across)
    rows, columns = camera.shape
    width = min((WIDTH - 1.0) / across, MOST_HEIGHT / down * columns / rows)  # of a panel [inch]
    size = across * width + 1.0, down * width * rows / columns + 0.1
    figure, subplots = panels(len(chosen), across, *size, layout="compressed")
    surfaces = {name: faceted(of_body, start[name]) for name, of_body in cells.items()}
    nearer = IN_FRONT * float(np.ptp(places, axis=0).max()) * VIEW.axes()[2]
    for axes, time, state, values in zip(subplots, chosen, states, shown, strict=True):
        drawn: list[Drawable] = []
        for name, fields in state.items():
            colours = np.nan_to_num(coloured(values[name], limited[:2], limited.palette))
            lies_on = len(solids) > 0 and len(cells[name].tetrahedra) == 0 and len(surfaces[name].triangles) > 0
            drawn.append(_drawable(fields, surfaces[name], colours, nearer if lies_on else 0.0 * nearer))
            if cut and len(cells[name].tetrahedra):
                drawn.append(cut_face(fields["position"], cells[name].tetrahedra, colours, cut))
        show(axes, render(drawn, camera, cut), camera)
        scale_bar(axes, camera)
        corner_words(axes, f"t = {EngFormatter('s', useMathText=False)(float(f'{time:.4g}'))}", "cut open" if cut else "")
    colour_bar(figure, with_unit(*meaning(run.stored.bodies, quantity)), limited, limited.palette)
    return figure


def is_open_in_front(run: Run) -> bool:
    """Whether all solids lie at the front of the grid, as at a plane of symmetry: they are open there without a cut."""
    grid = run.stored.grid
    names = [body.name for body in run.stored.bodies if len(run.cells(body.name).tetrahedra)]
    fronts = np.array([run.fields(name, 0.0)["position"][:, 1].min() for name in names])
    return grid is not None and bool(np.all(abs(fronts - grid.lower[1]) < ASIDE * grid.cell))


def opening(positions: list[np.ndarray]) -> Plane | None:
    """Where to cut bodies open of which one surrounds another: through the middle of what is surrounded, else nowhere."""
    boxes = [bounding_box(position) for position in positions]
    hidden = [
        inner
        for k, inner in enumerate(boxes)
        if any((outer[0] < inner[0]).all() and (inner[1] < outer[1]).all() for outer in boxes[:k] + boxes[k + 1 :])
    ]
    return through_the_middle(hidden) if hidden else None


def through_the_middle(boxes: list[Box]) -> Plane:
    """The plane through the middle of the largest of some boxes; its front goes."""
    largest = max(boxes, key=lambda box: float(np.prod(box[1] - box[0])))
    middle = float(0.5 * (largest[0] + largest[1]) @ np.array(FRONT))
    # layers of points often lie in the very middle: a little before it, so that they stay in every picture
    return Plane(FRONT, middle + ASIDE * float((largest[1] - largest[0]).max()))


def faceted(cells: Cells, position: np.ndarray) -> Faceted:
    """The surface that shows a body; solids have sharp edges where they do at the start, membranes are smooth all over."""
    triangles = cells.surface()
    if len(cells.tetrahedra):
        return split_at_creases(position, triangles)
    return Faceted(triangles, np.arange(len(position)))


def _drawable(fields: Fields, surface: Faceted, colours: np.ndarray, nearer: np.ndarray) -> Drawable:
    position, shown = fields["position"] + nearer, surface.vertex
    if len(surface.triangles):
        return Mesh(position[shown], surface.triangles, colours[shown], np.zeros(len(shown), bool))
    there = fields["mass"] > 0.0  # the others have left the grid
    position, colours = position[there], colours[there]
    stride = max(-(-len(position) // MOST_BALLS), 1)
    radii = ball_radii(fields["mass"][there], fields["density"][there]) * np.cbrt(stride)
    return Balls(position[::stride], radii[::stride], colours[::stride])
