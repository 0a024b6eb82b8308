"""Pictures of bodies in three dimensions, coloured by a field.

A picture can be cut open: the material in front of a plane is not drawn, so that the inside is visible."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.triangulation import bounding_box, vertex_normals
from pellucid.results.pictures.camera import INK, Camera, Plane, camera_for, coloured, corner_words, scale_bar, show
from pellucid.results.pictures.drawables import Balls, Drawable, Faceted, Mesh, ball_radii, split_at_creases
from pellucid.results.pictures.quantities import (
    BY_BODY,
    NORMAL_VELOCITY,
    Fields,
    Look,
    colours_of,
    explain,
    limits_of,
    there,
    values_of,
)
from pellucid.results.pictures.render import cut_face, render, rim
from pellucid.results.pictures.style import Axes, Figure, Run, instant
from pellucid.results.pictures.surroundings import (
    around,
    cells_with_images,
    in_box,
    meshes_of_walls,
    places_unmoved,
    with_images,
    with_mirrored,
)

COLUMNS = 700  # pixels of a panel
GREY, FAILED = (0.77, 0.78, 0.82), (0.92, 0.10, 0.09)
"""Colours of points without a value, and of failed points."""
Direction = tuple[float, float, float]
FRONT: Direction = (0.0, -1.0, 0.0)
"""Direction towards the viewer, from which bodies are cut open."""

ASIDE = 1e-3  # of the size of what is surrounded
AT_REST = 1e-2  # of the fastest motion of the figure: what is slower has no arrows
RIM = 3.0  # pixels: how wide the section of a membrane is drawn
IN_FRONT = 0.01  # of the size of the picture, by which membranes are drawn nearer to the eye than what they lie on
Box = tuple[np.ndarray, np.ndarray]
"""Lower and upper corner of a bounding box [m], shape (3,) each."""

MOST_BALLS = 60_000
"""Largest number of balls of a body; of more points, an evenly spaced subset is drawn with larger balls."""


class SpaceStage:
    """Object that draws bodies in space from one direction, with the same scales in all pictures of a figure (a `Stage`).

    Bodies that are lines are not drawn. If a body surrounds another, the picture shows only the material behind a plane
    through the middle of the surrounded body, unless the look sets the cut plane. look: settings of the picture. times:
    times of all pictures [s], from which the scales follow.
    """

    def __init__(self, run: Run, look: Look, times: np.ndarray) -> None:
        shown = [body for body in run.stored.bodies if body.name in (look.names or {body.name})]
        self._run, self._look = run, look
        self._bodies = {body.name: body for body in shown if not len(run.cells(body.name).lines)}
        begun = {name: self._fields(name, 0.0) for name in self._bodies}
        self._start = {name: fields["position"] for name, fields in begun.items()}
        self._first = {name: places_unmoved(fields) for name, fields in begun.items()}
        halves = {name: len(place) // 2 ** len(look.mirrors) for name, place in self._start.items()}
        self._cells = {name: cells_with_images(run.cells(name), n, look.mirrors) for name, n in halves.items()}
        flows = look.arrows or look.quantity == NORMAL_VELOCITY
        self._flowing = {name: cells.surface() for name, cells in self._cells.items() if flows}
        fields = [{name: self._fields(name, float(time)) for name in self._bodies} for time in times]
        values = [self._values(name, of_body) for state in fields for name, of_body in state.items()]
        self._colours = limits_of(values, look)
        self._solids = [position for name, position in self._start.items() if len(self._cells[name].tetrahedra)]
        self._cut = look.cut or opening(list(self._start.values()))
        if look.halved and self._solids:
            self._cut = through_the_middle([bounding_box(position) for position in self._solids])
        places = np.concatenate([of_body["position"][there(of_body)] for state in fields for of_body in state.values()])
        kept = places[self._cut.beyond(places) <= 0.0] if self._cut else places
        self._walls = with_mirrored(run.stored.walls, look.mirrors)
        self._box = around(*bounding_box(places))
        walls = [mesh.vertices for time in times for mesh in self._meshes_of_walls(float(time))]
        on_paper = np.concatenate([kept if len(kept) else places, *walls])
        self._camera = camera_for(look.view, on_paper, COLUMNS, margin=0.06)
        self._surfaces = {name: faceted(of_body, self._start[name]) for name, of_body in self._cells.items()}
        surfaces = [name for name, triangles in self._flowing.items() if len(triangles) and look.arrows]
        self._arrowed = {name: spread(self._start[name]) for name in surfaces}
        self._fastest = max((_fastest(state[name]) for state in fields for name in surfaces), default=0.0)
        self._nearer = IN_FRONT * float(np.ptp(places, axis=0).max()) * look.view.axes()[2]

    @property
    def ratio(self) -> float:
        """Ratio of height to width of the picture."""
        rows, columns = self._camera.shape
        return rows / columns

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """Draw the frame nearest to `time` [s] on axes. width: not used (the picture has a fixed number of pixels)."""
        drawn: list[Drawable] = []
        skins: list[Mesh] = []
        state = {name: self._fields(name, time) for name in self._bodies}
        for name, cells in self._cells.items():
            fields = state[name]
            colours = self._colours_of(name, fields)
            covers = len(cells.tetrahedra) == 0 and len(self._surfaces[name].triangles) > 0
            lies_on = covers and (len(self._solids) > 0 or not self._cut)
            drawn.append(_drawable(fields, self._surfaces[name], colours, self._nearer if lies_on else 0.0 * self._nearer))
            if covers and isinstance(drawn[-1], Mesh):
                skins.append(drawn[-1])
            if self._cut and len(cells.tetrahedra):
                drawn.append(cut_face(fields["position"], cells.tetrahedra, colours, self._cut))
        if self._cut:
            drawn += self._rims(drawn, skins, self._cut)
        drawn += self._meshes_of_walls(time)
        show(axes, render(drawn, self._camera, self._cut), self._camera)
        scale_bar(axes, self._camera)
        self._draw_arrows(axes, {name: state[name] for name in self._arrowed})
        corner_words(axes, instant(time), "cut open" if self._cut else "")

    def _meshes_of_walls(self, time: float) -> list[Mesh]:
        return meshes_of_walls(self._walls, time, self._box, self._look.view.axes()[2])

    def _rims(self, drawn: Sequence[Drawable], skins: Sequence[Mesh], cut: Plane) -> list[Mesh]:
        """Build a ribbon along the edge of each membrane at the cut plane. The ribbons are moved towards the eye, so that
        points drawn as balls, which protrude from the cut plane, do not hide them.

        drawn: all objects of the picture. skins: surfaces of the membranes. cut: the cut plane.
        """
        reach = max((float(balls.radii.max(initial=0.0)) for balls in drawn if isinstance(balls, Balls)), default=0.0)
        nearer = 1.01 * reach * self._look.view.axes()[2]
        ribbons = (rim(skin, cut, RIM / self._camera.scale) for skin in skins)
        return [ribbon._replace(vertices=ribbon.vertices + nearer) for ribbon in ribbons]

    def _draw_arrows(self, axes: Axes, surfaces: dict[str, Fields]) -> None:
        fastest = max(map(_fastest, surfaces.values()), default=0.0)
        for name, fields in surfaces.items() if fastest > AT_REST * self._fastest else ():
            flow = self._flowing[name], fields["velocity"], self._arrowed[name], fastest
            draw_arrows(axes, self._camera, fields["position"], *flow)

    def bar(self, figure: Figure) -> None:
        """Draw the colour bar of the shown quantity, or a legend if each body has its own colour."""
        explain(figure, list(self._bodies.values()), self._look, self._colours)

    def _fields(self, name: str, time: float) -> Fields:
        fields = in_box(self._run.fields(name, time), partial(self._run.cells, name), self._run.stored.grid)
        return with_images(fields, self._look.mirrors)

    def _colours_of(self, name: str, fields: Fields) -> np.ndarray:
        """Return the RGB colours, shape (n, 3), of the points of the body `name` from its fields; grey where a point has no
        value."""
        from matplotlib.colors import to_rgb

        if self._look.quantity == BY_BODY:
            return np.tile(to_rgb(colours_of(self._bodies)[name]), (len(fields["position"]), 1))
        colours = coloured(self._values(name, fields), self._colours[:2], self._colours.palette)
        colours[np.isnan(colours).any(axis=1)] = GREY
        return colours

    def _values(self, name: str, fields: Fields) -> np.ndarray:
        if self._look.quantity == NORMAL_VELOCITY and len(triangles := self._flowing[name]):
            normal = vertex_normals(fields["position"], triangles)
            fields = {**fields, NORMAL_VELOCITY: np.einsum("ni,ni->n", fields["velocity"], normal)}
        return values_of(self._bodies[name], fields, self._look, self._first[name])


def _fastest(fields: Fields) -> float:
    return float(np.linalg.norm(fields["velocity"], axis=1).max())


def is_open_in_front(run: Run) -> bool:
    """Return True if all solids touch the face of the grid towards the viewer (lowest y), for example at a plane of
    symmetry. The inside of the solids is then visible without a cut."""
    grid = run.stored.grid
    names = [body.name for body in run.stored.bodies if len(run.cells(body.name).tetrahedra)]
    fronts = np.array([run.fields(name, 0.0)["position"][:, 1].min() for name in names])
    return grid is not None and bool(np.all(abs(fronts - grid.lower[1]) < ASIDE * grid.cell))


def opening(positions: list[np.ndarray]) -> Plane | None:
    """Return the cut plane through the middle of the largest body that another body surrounds, judged by bounding boxes; None
    if no body is surrounded. positions: of the points of each body [m], shape (n, 3)."""
    boxes = [bounding_box(position) for position in positions]
    hidden = [
        inner
        for k, inner in enumerate(boxes)
        if any((outer[0] < inner[0]).all() and (inner[1] < outer[1]).all() for outer in boxes[:k] + boxes[k + 1 :])
    ]
    return through_the_middle(hidden) if hidden else None


def through_the_middle(boxes: list[Box], front: Direction = FRONT) -> Plane:
    """Return the cut plane with normal `front` through the centre of the largest bounding box. The material in front of the
    plane, on the side of the normal, is not drawn."""
    largest = max(boxes, key=lambda box: float(np.prod(box[1] - box[0])))
    middle = float(0.5 * (largest[0] + largest[1]) @ np.array(front))
    # layers of points often lie in the very middle: a little before it, so that they stay in every picture
    return Plane(front, middle + ASIDE * float((largest[1] - largest[0]).max()))


def faceted(cells: Cells, position: np.ndarray) -> Faceted:
    """Return the triangles of the surface of a body for shading; empty for a body of points without cells.

    The surface of a solid is split at edges that are sharp in the initial configuration; membranes are shaded smoothly.
    position: initial positions [m], shape (n, 3).
    """
    triangles = cells.surface()
    if len(cells.tetrahedra):
        return split_at_creases(position, triangles)
    return Faceted(triangles, np.arange(len(position)))


def _drawable(fields: Fields, surface: Faceted, colours: np.ndarray, nearer: np.ndarray) -> Drawable:
    position, shown = fields["position"] + nearer, surface.vertex
    if len(surface.triangles):
        failed = fields["failed"] > 0 if "failed" in fields else np.zeros(len(position), bool)
        return Mesh(position[shown], surface.triangles, colours[shown], failed[shown], FAILED)
    kept = there(fields)
    position, colours = position[kept], colours[kept]
    stride = max(-(-len(position) // MOST_BALLS), 1)
    radii = ball_radii(fields["mass"][kept], fields["density"][kept]) * np.cbrt(stride)
    return Balls(position[::stride], radii[::stride], colours[::stride])


APART = 0.09  # distance of arrows, of the largest side of the surface at the start
LONGEST = 0.1  # of the picture's width, of an arrow
FACING = 0.25  # share of the normal towards the eye: nearer to the rim arrows would be seen end on


def spread(position: np.ndarray) -> np.ndarray:
    """Select nodes of a surface at which arrows are drawn, about 0.09 times its largest extent apart; return their indices in
    ascending order. position: positions of all nodes [m], shape (n, 3)."""
    low = position.min(axis=0)
    side = APART * float((position.max(axis=0) - low).max())
    return np.asarray(np.sort(np.unique(((position - low) / side).astype(np.int64), axis=0, return_index=True)[1]))


def draw_arrows(
    axes: Axes,
    camera: Camera,
    position: np.ndarray,
    triangles: np.ndarray,
    velocity: np.ndarray,
    some: np.ndarray,
    fastest: float,
) -> None:
    """Draw the velocity tangential to a surface as arrows at the nodes with the indices `some`.

    Arrows of nodes that face away from the eye are omitted. position [m] and velocity [m/s]: arrays for all nodes, shape
    (n, 3). triangles: node indices, shape (m, 3). fastest: speed of the longest arrow [m/s].
    """
    normal = vertex_normals(position, triangles)
    along = velocity - np.einsum("ni,ni->n", velocity, normal)[:, None] * normal
    some = some[normal[some] @ camera.axes[2] > FACING]
    across, upward = camera.axes[:2]
    length = LONGEST * float((camera.high - camera.low)[0]) / fastest
    x, y, u, v = (values[some] @ axis for values in (position, along) for axis in (across, upward))
    flow = x, y, length * u, length * v
    axes.quiver(*flow, angles="xy", scale_units="xy", scale=1.0, width=0.004, color=INK, zorder=3)
