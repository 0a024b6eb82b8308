"""Access to the films of vesicle cases, their loads, and metrics of their conserved quantities."""

import numpy as np

from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.conditions.loads.film_pressure import FilmPressure
from pellucid.gallery.exact_curves import vanishing
from pellucid.geometry.meshes.enclosure import Ellipsoid, ellipse_of, enclosed_volume
from pellucid.geometry.surfaces.film_shapes import Ellipse, Spheroid
from pellucid.geometry.surfaces.triangles import Icosphere
from pellucid.materials.lipid_film import LipidFilm
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

INSIDE, MASS = 5e-3, 1e-12  # largest relative changes that a film in a fluid may have


def films_of(run: Run) -> list[FluidFilmCase]:
    """Return the data models of all fluid films in the case of a run."""
    return [body for body in run.case.body if isinstance(body, FluidFilmCase)]


def film_of(run: Run) -> FluidFilmCase:
    """Return the data model of the fluid film in the case of a run. Raises ValueError unless there is exactly one film."""
    (film,) = films_of(run)
    return film


def lipid_of(film: FluidFilmCase) -> LipidFilm:
    """Return the lipid material of a fluid film. Raises TypeError for any other kind of material, since there is no exact
    solution for it."""
    if not isinstance(film.material, LipidFilm):
        raise TypeError(
            'the exact solution applies only to a material of kind "lipid-film", '
            f'but {film.name} is of kind "{film.material.kind}"'
        )
    return film.material


def radius_of(film: FluidFilmCase) -> float:
    """Return the initial radius [m] of a circle or sphere. Raises TypeError for another shape."""
    shape = film.shape.surface.chosen() if film.shape.surface else film.shape.chosen()
    if not isinstance(shape, Ellipse | Spheroid | Icosphere):
        raise TypeError(f"the exact solution applies only to a circle or sphere, but {film.name} is neither")
    return shape.radius


def pressures_of(run: Run) -> list[FilmPressure]:
    """Return the data models of the pressure loads on fluid films in the case of a run."""
    return [load for load in run.case.load if isinstance(load, FilmPressure)]


def shapes_of(run: Run, name: str) -> list[Ellipsoid]:
    """Return for each stored frame the ellipse (semi-axes and directions) that has the same second moments per area as the
    region inside the closed film `name` in the plane."""
    return [ellipse_of(run.fields(name, float(time))["position"][:, :2]) for time in run.times(name)]


def enclosed_area(run: Run, name: str, time: float) -> float:
    """Return the area [m²] enclosed by the film `name` in the plane, i.e. by the polygon through its nodes, in the stored
    frame nearest to a time [s]."""
    x, y = run.fields(name, time)["position"][:, :2].T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def kept(run: Run, name: str) -> dict[str, Metric]:
    """Return the metrics of conservation of a closed film: largest relative changes of the enclosed `area` of a curve or
    `volume` of a surface, and of the film's mass, `film_mass`."""
    times = [float(time) for time in run.times(name)]
    triangles = run.triangles(name)
    inside = "volume" if len(triangles) else "area"
    measures = np.array(
        [
            enclosed_volume(run.fields(name, time)["position"], triangles) if len(triangles) else enclosed_area(run, name, time)
            for time in times
        ]
    )
    masses = np.array([run.fields(name, time)["mass"].sum() for time in times])
    swollen, lost = (float(np.abs(values / values[0] - 1.0).max()) for values in (measures, masses))
    return {
        inside: vanishing(swollen, INSIDE, f"largest relative change of the {inside} inside the film"),
        "film_mass": vanishing(lost, MASS, "largest relative change of the mass of the film"),
    }
