"""Films of bodies that are closed surfaces in space: their density, or how fast they move along the normal, and the flow in
them."""

from collections.abc import Sequence

import numpy as np

from pellucid.geometry.meshes.triangulation import vertex_normals
from pellucid.results.pictures.annotations import Axes, Figure, Run
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.instants import evenly
from pellucid.results.pictures.quantities import VIEW, Fields, limits
from pellucid.results.pictures.rendering.axes import INK, coloured, scale_bar, show
from pellucid.results.pictures.rendering.camera import camera_for
from pellucid.results.pictures.rendering.drawables import Mesh
from pellucid.results.pictures.rendering.render import render
from pellucid.results.pictures.stage import film_of
from pellucid.results.pictures.style import colour_bar, with_unit
from pellucid.state import FIELDS

PICTURES = 60  # of a film
COLUMNS = 460  # pixels of a picture
APART = 0.09  # distance of arrows, of the largest side of the surface at the start
LONGEST = 0.1  # of the picture's width, of an arrow
FACING = 0.25  # share of the normal towards the eye: nearer to the rim arrows would be seen end on
AT_REST = 1e-2  # of the fastest motion of the film: what is slower is not drawn


class _Stage:
    """Surfaces drawn at one instant after the other, to the same scales."""

    def __init__(self, run: Run, names: Sequence[str], times: np.ndarray) -> None:
        self._run, self._names = run, names
        self._triangles = {name: run.cells(name).triangles for name in names}
        states = [self._state(float(time)) for time in times]
        together = [fields for state in states for fields in state.values()]
        self._has_density = all("areal_density" in fields for fields in together)
        self.colours = limits([self._values(name, fields) for state in states for name, fields in state.items()])
        self.camera = camera_for(VIEW, np.concatenate([fields["position"] for fields in together]), COLUMNS, margin=0.08)
        self._arrowed = {name: _spread(states[0][name]["position"]) for name in names}
        self._fastest = max(_fastest(fields) for fields in together)

    @property
    def ratio(self) -> float:
        """Height over width."""
        rows, columns = self.camera.shape
        return rows / columns

    def bar(self, figure: Figure) -> None:
        """What the colours mean."""
        name = "density in the surface" if self._has_density else "normal velocity"
        word = with_unit(name, FIELDS["areal_density" if self._has_density else "velocity"].unit)
        colour_bar(figure, word, self.colours, self.colours.palette, shrink=0.8)

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """The surfaces at an instant [s], with arrows of the part of their velocity that lies in them."""
        state, limited = self._state(time), self.colours
        meshes = []
        for name, fields in state.items():
            place, colours = fields["position"], coloured(self._values(name, fields), limited[:2], limited.palette)
            meshes.append(Mesh(place, self._triangles[name], colours, np.zeros(len(place), bool)))
        show(axes, render(meshes, self.camera), self.camera)
        scale_bar(axes, self.camera)
        fastest = max(map(_fastest, state.values()))
        if fastest > AT_REST * self._fastest:
            for name, fields in state.items():
                self._arrows(axes, name, fields, fastest)
        axes.set_title(f"t = {time:.4g} s, fastest {fastest:.3g} m/s")

    def _state(self, time: float) -> dict[str, Fields]:
        return {name: self._run.fields(name, time) for name in self._names}

    def _normals(self, name: str, fields: Fields) -> np.ndarray:
        return vertex_normals(fields["position"], self._triangles[name])

    def _values(self, name: str, fields: Fields) -> np.ndarray:
        if self._has_density:
            return fields["areal_density"]
        return np.asarray(np.einsum("ni,ni->n", fields["velocity"], self._normals(name, fields)))

    def _arrows(self, axes: Axes, name: str, fields: Fields, fastest: float) -> None:
        normal, velocity = self._normals(name, fields), fields["velocity"]
        along = velocity - np.einsum("ni,ni->n", velocity, normal)[:, None] * normal
        some = self._arrowed[name]
        some = some[normal[some] @ self.camera.axes[2] > FACING]
        across, upward = self.camera.axes[:2]
        width = float((self.camera.high - self.camera.low)[0])
        x, y, u, v = (values[some] @ axis for values in (fields["position"], along) for axis in (across, upward))
        length = LONGEST * width / fastest
        axes.quiver(x, y, length * u, length * v, angles="xy", scale_units="xy", scale=1.0, width=0.004, color=INK, zorder=3)


def film_of_surfaces(run: Run, names: Sequence[str]) -> Animation:
    """Bodies that are closed surfaces in space, coloured by their density, those without one by their velocity along the
    normal; with arrows of the flow in them."""
    times = evenly(run.times(names[0]), PICTURES)
    return film_of(_Stage(run, names, times), times.tolist())


def _fastest(fields: Fields) -> float:
    return float(np.linalg.norm(fields["velocity"], axis=1).max())


def _spread(position: np.ndarray) -> np.ndarray:
    """Numbers of nodes about as far apart as arrows are to be."""
    low = position.min(axis=0)
    side = APART * float((position.max(axis=0) - low).max())
    return np.asarray(np.sort(np.unique(((position - low) / side).astype(np.int64), axis=0, return_index=True)[1]))
