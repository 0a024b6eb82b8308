"""The same numbers of the package's interpolations, Loop and radial, on the meshes of `controls.py`."""

from math import pi, sqrt

import numpy as np
from controls import EXACT, gradient_mode, icosphere, jittered

from pellucid.approximants.radial import PolyharmonicModel
from pellucid.bodies.fluid_film.assembly import NodalSums, rows
from pellucid.bodies.fluid_film.balance import Driving, FilmBalance, Led
from pellucid.bodies.fluid_film.forces import Drag, FilmPhysics
from pellucid.bodies.fluid_film.loop_surface import LoopSurface
from pellucid.bodies.fluid_film.radial_surface import RadialSurface
from pellucid.bodies.fluid_film.solvers import SparseSolver
from pellucid.materials.lipid_film import LipidFilm


def film(kind, triangles, places, stiffness=1.0, dilatational=1.0):
    """The balance of a film without drag and bending, and its nodes."""
    if kind == "loop":
        surface = LoopSurface(triangles, len(places))
        x = surface.through(places)
    else:
        surface, x = RadialSurface(triangles, places, PolyharmonicModel()), places
    solver = SparseSolver(surface.nodes, surface.held, places)
    physics = FilmPhysics(1.0, dilatational, 0.0, 0.0, Drag(0.0, 0.0))
    return FilmBalance(surface, LipidFilm(density=1.0, viscosity=1.0, stiffness=stiffness), physics, 1.0, solver), x


def driving(x, tractions=()):
    led = Led(np.zeros(len(x), bool), np.zeros(len(x)), np.zeros_like(x))
    return Driving(list(tractions), [], np.zeros(x.shape, bool), np.zeros_like(x), led, None, None)


def compressed(kind, triangles, places, steps=100):
    """What R(1) is off; midpoint steps, extrapolated from this number and half as many."""
    radii = []
    for number in (steps // 2, steps):
        balance, x = film(kind, triangles, places)
        areas = balance.part_areas(balance.geometry.operators(x))
        mass = areas * (8.0 * pi / areas.sum())
        for _ in range(number):
            x = balance.step(x, balance.geometry.operators(x), mass, 1.0 / number, 0.5, driving(x)).x
        radii.append(np.linalg.norm(balance.geometry.places(x), axis=1).mean())
    return radii[1] + (radii[1] - radii[0]) / 3.0 - EXACT


def gradient_error(kind, triangles, places):
    balance, x = film(kind, triangles, places, stiffness=1e-12)
    o = balance.geometry.operators(x)
    areas = balance.part_areas(o)
    done = balance.step(
        x, o, areas, 1e-9, 0.5, driving(x, [(0, lambda points, after: gradient_mode(points.position, 2, 1.0)[1])])
    )
    wrong = np.einsum("eqmi,emi->eqi", o.value, done.velocity[balance.geometry.nodes]) - gradient_mode(o.position, 2, 1.0)[0]
    w = gradient_mode(o.position, 2, 1.0)[0]
    return sqrt(np.sum(o.area[..., None] * wrong**2) / np.sum(o.area[..., None] * w**2))


def power_error(kind, triangles, places, dilatational=1000.0, degree=4):
    balance, x = film(kind, triangles, places, dilatational=dilatational)
    surface, L = balance.geometry, degree * (degree + 1)
    w = surface.through(gradient_mode(places, degree, dilatational)[0])
    o, sums = surface.operators(x), NodalSums(surface.nodes, len(x), 3)
    squares = [rows(o.strain, o.area[..., None] * np.array([2.0, 2.0, 1.0])), rows(o.dilatation(), dilatational * o.area)]
    power = sum(np.sum(square.factor * sums.rates(square, w) ** 2) for square in squares)
    return power / ((2.0 * (L - 1.0) + dilatational * L) * 4.0 * pi * L / (2 * degree + 1)) - 1.0


def spread(triangles, places):
    """The places after ten sweeps, as films of the package begin, put back on the sphere."""
    surface = LoopSurface(triangles, len(places))
    places = surface.places(surface.smoothed(surface.through(places)))
    return places / np.linalg.norm(places, axis=1)[:, None]


if __name__ == "__main__":
    for name in ("loop", "loop, spread", "radial"):
        kind = name.split(",")[0]
        for rounds in (3, 4):
            triangles, places = icosphere(rounds)
            uneven = jittered(triangles, places, 0.2)
            if "spread" in name:
                places, uneven = spread(triangles, places), spread(triangles, uneven)
            found = [compressed(kind, triangles, places), gradient_error(kind, triangles, places)]
            found += [gradient_error(kind, triangles, uneven), power_error(kind, triangles, places)]
            print(name, len(places), *(f"{value:.2e}" for value in found), flush=True)
